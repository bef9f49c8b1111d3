"""Captures the output of libraries that decode a file."""

import logging
import os
import sys
import tempfile
from contextlib import contextmanager

__all__ = ["captured_stderr"]

logging.getLogger("tifffile").addHandler(logging.NullHandler())     # prevents output to stderr


@contextmanager
def captured_stderr():
    """Yield a list that holds, when the block has ended, the lines written to file descriptor 2.

    OpenCV, libjpeg and LibRaw write there directly. Output of other threads in the
    meantime is captured too. A process without a standard error captures nothing.
    """
    lines = []
    sys.stderr.flush()
    try:
        saved = os.dup(2)
    except OSError:
        yield lines
        return
    with tempfile.TemporaryFile() as file:
        os.dup2(file.fileno(), 2)
        try:
            yield lines
        finally:
            sys.stderr.flush()
            os.dup2(saved, 2)
            os.close(saved)
            file.seek(0)
            lines += file.read().decode(errors="replace").splitlines()

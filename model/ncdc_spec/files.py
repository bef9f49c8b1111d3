"""Reads and writes files; a file is replaced whole or not at all."""

import errno
import os
import stat
import tempfile
from contextlib import contextmanager
from pathlib import Path

from ncdc_spec.errors import InputError

__all__ = ["check_outputs", "parse_text", "read_bytes", "replace_file", "write_bytes",
           "write_stream", "write_text"]


def read_bytes(path):
    """Content of the file ``path``; raises :class:`InputError` if it cannot be read.

    A device is rejected, since many never end.
    """
    try:
        mode = os.stat(path).st_mode
        if stat.S_ISCHR(mode) or stat.S_ISBLK(mode):
            raise InputError(f"cannot read {path}: it is a device, a file is needed")
        return Path(path).read_bytes()
    except (OSError, ValueError) as error:
        if isinstance(error, InputError):
            raise
        raise InputError(f"cannot read {path}: {_reason(error)}") from error


def parse_text(path, kind, parse):
    """``parse(text)`` of the UTF-8 file ``path``, with or without a byte-order mark.

    Raises
    ------
    InputError
        If the file cannot be read, is no UTF-8, or ``parse`` raises ValueError or RecursionError:
        then it is no ``kind``, such as "points file".
    """
    content = read_bytes(path)
    try:
        return parse(content.decode("utf-8-sig"))
    except UnicodeDecodeError as error:
        raise InputError(f"{path} is no {kind}: byte {error.start} is no UTF-8 text") from error
    except RecursionError as error:
        raise InputError(f"{path} is no {kind}: it is nested too deep") from error
    except InputError:
        raise
    except ValueError as error:
        raise InputError(f"{path} is no {kind}: {error}") from error


def _reason(error):
    return getattr(error, "strerror", None) or error


def _kind(path):
    """Name of what ``path``, links resolved, is if a file cannot replace it; else None."""
    try:
        mode = os.stat(path).st_mode
    except (OSError, ValueError):
        return None
    if stat.S_ISDIR(mode):
        return "a folder"
    return None if stat.S_ISREG(mode) else "no regular file"


def check_outputs(outputs, inputs, streams=()):
    """Reject, before any work, paths that cannot be written or that would replace an input.

    ``streams`` are outputs that may be a device, a pipe or a socket as well.

    Raises
    ------
    InputError
        If an output is a folder or no regular file, is in no folder, may not be written, is given
        twice, or is one of ``inputs``.
    """
    taken = {os.path.realpath(path): f"the input {path}" for path in inputs}
    for path in (*outputs, *streams):
        if kind := _kind(path):
            if kind == "a folder" or path not in streams:
                raise InputError(f"cannot write {path}: it is {kind}")
            continue
        folder = Path(os.path.realpath(path)).parent
        while not folder.exists():
            folder = folder.parent
        try:
            with tempfile.TemporaryFile(dir=folder):
                pass
        except OSError as error:
            raise InputError(f"cannot write {path}: {folder}: {error.strerror}") from error
        real = os.path.realpath(path)
        if real in taken:
            raise InputError(f"the output {path} would replace {taken[real]}")
        taken[real] = f"the output {path}"


@contextmanager
def replace_file(path):
    """Yield a temporary path next to ``path`` that replaces it when the block ends without error.

    The target of a symbolic link is replaced. If the block raises, ``path`` does not change. The
    temporary path has the same suffix, for libraries that choose an encoder by suffix.

    Raises
    ------
    InputError
        If the folder of ``path`` cannot be made or written, or ``path`` is no regular file.
    """
    if kind := _kind(path):
        raise InputError(f"cannot write {path}: it is {kind}")
    path = Path(os.path.realpath(path))
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        handle, name = tempfile.mkstemp(dir=path.parent, prefix=".ncdc-", suffix=path.suffix)
        os.close(handle)
    except OSError as error:
        raise InputError(f"cannot write {path}: {error.strerror}") from error
    temporary = Path(name)
    try:
        yield temporary
        temporary.chmod(0o644)
        os.replace(temporary, path)
    except OSError as error:
        raise InputError(f"cannot write {path}: {error.strerror}") from error
    finally:
        temporary.unlink(missing_ok=True)


def write_bytes(path, content):
    """Replace ``path`` by ``content`` atomically; a file that already holds it is not touched."""
    path = Path(path)
    try:
        same = path.is_file() and path.stat().st_size == len(content)
        if same and path.read_bytes() == content:
            return
    except OSError:
        pass
    with replace_file(path) as temporary:
        temporary.write_bytes(content)


def write_text(path, text):
    """:func:`write_bytes` for text, as UTF-8."""
    write_bytes(path, text.encode())


def write_stream(path, text):
    """:func:`write_text`, but a device or a pipe is written to, not replaced.

    Raises
    ------
    InputError
        If ``path`` cannot be written, or is a pipe without a reader.
    """
    if _kind(path) != "no regular file":
        return write_text(path, text)
    try:
        # A pipe without a reader would wait for ever.
        handle = os.open(path, os.O_WRONLY | os.O_NONBLOCK)
        os.set_blocking(handle, True)
        with open(handle, "wb") as stream:
            stream.write(text.encode())
    except OSError as error:
        reason = "it has no reader" if error.errno == errno.ENXIO else error.strerror
        raise InputError(f"cannot write {path}: {reason}") from error

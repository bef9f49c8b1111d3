"""Reading and writing files: whole or not at all."""

import os
import tempfile
from contextlib import contextmanager
from pathlib import Path

from ncdc_model.errors import InputError

__all__ = ["check_outputs", "read_bytes", "replace_file", "write_bytes", "write_text"]


def read_bytes(path):
    """Content of the file ``path``; raises :class:`InputError` if it cannot be read."""
    try:
        return Path(path).read_bytes()
    except OSError as error:
        raise InputError(f"cannot read {path}: {error.strerror}") from error


def check_outputs(outputs, inputs):
    """Refuse, before any work, paths that cannot be written or that would replace an input.

    Raises
    ------
    InputError
        If an output is a folder, lies below what is no folder or may not be written, is given
        twice, or is one of ``inputs``.
    """
    taken = {os.path.realpath(path): f"the input {path}" for path in inputs}
    for path in outputs:
        if os.path.isdir(path):
            raise InputError(f"cannot write {path}: it is a folder")
        folder = Path(path).absolute().parent
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
    """Yield a temporary path beside ``path`` that replaces it when the block ends well.

    If the block raises, ``path`` is left as it was. The suffix is kept, so that libraries that
    choose an encoder by suffix can write to the temporary path.

    Raises
    ------
    InputError
        If the folder of ``path`` cannot be made or written.
    """
    path = Path(path)
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
    try:
        if Path(path).read_bytes() == content:
            return
    except OSError:
        pass
    with replace_file(path) as temporary:
        temporary.write_bytes(content)


def write_text(path, text):
    """:func:`write_bytes` for text, as UTF-8."""
    write_bytes(path, text.encode())

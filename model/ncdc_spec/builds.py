"""Compiled simulations, cached between runs in one folder per build."""

import fcntl
import hashlib
import os
import shutil
import tempfile
import time
from pathlib import Path

from ncdc_spec.errors import InputError

__all__ = ["builds_folder", "built", "key_of", "without_header"]

MAX_AGE = 14 * 24 * 3600      # seconds since its last use after which a build is removed


def builds_folder():
    """Folder of the builds: ``NCDC_CACHE``, else ``ncdc`` in ``XDG_CACHE_HOME`` or ``~/.cache``."""
    if os.environ.get("NCDC_CACHE"):
        return Path(os.environ["NCDC_CACHE"])
    base = os.environ.get("XDG_CACHE_HOME")
    return (Path(base) if base else Path.home() / ".cache") / "ncdc"


def without_header(verilog):
    """``verilog`` without the comment lines that open it.

    The header of a generated file names versions and hashes; a change of those alone is no
    reason to compile again.
    """
    lines = verilog.splitlines()
    while lines and (not lines[0].strip() or lines[0].lstrip().startswith(("//", "/*", "*"))):
        del lines[0]
    return "\n".join(lines) + "\n"


def key_of(name, *parts):
    """Name of a build's folder: ``name`` and a hash of the strings ``parts``."""
    state = hashlib.sha256()
    for part in parts:
        state.update(f"{len(part)}:".encode() + part.encode())
    return f"{name}-{state.hexdigest()[:20]}"


def built(key, build, whole=lambda folder: True):
    """Folder of the build ``key``; ``build(folder)`` fills it if it is not there, or is there and
    not ``whole(folder)``, as after a power cut.

    Two processes that ask for the same build at once make it once. A build that fails, or is
    interrupted, leaves no files.

    Raises
    ------
    InputError
        If the folder of the builds cannot be written.
    """
    root = builds_folder()
    folder = root / key
    try:
        root.mkdir(parents=True, exist_ok=True)
        lock = open(root / f"{key}.lock", "w")
    except OSError as error:
        raise InputError(f"cannot write the folder of builds {root}: {error.strerror}") from error
    with lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        if folder.is_dir() and not whole(folder):
            shutil.rmtree(folder)
        if not folder.is_dir():
            _remove_old(root)
            temporary = Path(tempfile.mkdtemp(dir=root, prefix=".build-"))
            try:
                build(temporary)
                os.rename(temporary, folder)
            finally:
                shutil.rmtree(temporary, ignore_errors=True)
        os.utime(folder)
    return folder


def _remove_old(root):
    limit = time.time() - MAX_AGE
    for entry in root.iterdir():
        try:
            if entry.is_dir() and entry.stat().st_mtime < limit:
                shutil.rmtree(entry, ignore_errors=True)
        except FileNotFoundError:       # another process has been faster
            pass

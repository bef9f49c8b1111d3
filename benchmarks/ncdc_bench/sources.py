"""Digest of the source files that a cached result depends on: a change invalidates it."""

import ast
import hashlib
from importlib.metadata import version
from importlib.util import find_spec
from pathlib import Path

__all__ = ["source_digest", "source_files"]


def source_files(modules, packages):
    """The files of ``modules`` and of all that they import, directly or not, from ``packages``.

    Imports are read from the text, those within functions too.

    Parameters
    ----------
    modules : sequence of str
    packages : sequence of str
        Names of top-level packages; what is imported from elsewhere is not followed.

    Returns
    -------
    dict of str to Path
        Module name: file, in the order of the names.
    """
    files, open_names = {}, list(modules)
    while open_names:
        name = open_names.pop()
        if name in files:
            continue
        path = _file(name)
        if path is None:           # a function or class, imported from a module
            continue
        files[name] = path
        names = {name.rpartition(".")[0]} | _imported(ast.parse(path.read_bytes()))
        open_names += [other for other in names if other.split(".")[0] in packages]
    return dict(sorted(files.items()))


def source_digest(modules, packages, libraries=()):
    """Hexadecimal digest of :func:`source_files` and of the versions of ``libraries``."""
    state = hashlib.sha256()
    for name, path in source_files(modules, packages).items():
        state.update(f"{name} {hashlib.sha256(path.read_bytes()).hexdigest()}\n".encode())
    for name in libraries:
        state.update(f"{name} {version(name)}\n".encode())
    return state.hexdigest()


def _file(name):
    try:
        spec = find_spec(name)
    except ModuleNotFoundError:
        return None
    return Path(spec.origin) if spec and spec.origin else None


def _imported(tree):
    names = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module:
            names |= {node.module} | {f"{node.module}.{alias.name}" for alias in node.names}
    return names

"""Runs tests on mutants of one module of the golden model, each in a forked process of its own.

``python -m ncdc_bench.mutation.golden_worker`` reads a line of JSON for each mutant from standard
input and writes one with its outcome. Libraries are imported once, before the first fork; the
mutated module, what imports it, and the tests are imported anew for every mutant. No file is
written: the import system takes the mutant's text for the module's.
"""

import contextlib
import gc
import importlib
import importlib.machinery
import importlib.util
import json
import os
import resource
import sys

__all__ = ["outcome", "serve"]

_MEMORY = 6 << 30       # bytes of address space: shifts by a mutated count may ask for any
_PYTEST = ["-x", "-q", "--assert=plain", "--tb=no", "-m", "not regress",
           *(f"-pno:{plugin}" for plugin in ("cacheprovider", "doctest", "junitxml", "pastebin",
                                             "threadexception", "unraisableexception"))]


class _Mutant(importlib.machinery.SourceFileLoader):
    """Loads the text of a mutant in place of a module's file, and finds no other module."""

    def __init__(self, name, path, source):
        super().__init__(name, path)
        self._source = source

    def find_spec(self, name, path=None, target=None):
        """The module's spec, None for other modules: see :class:`importlib.abc.MetaPathFinder`."""
        if name == self.name:
            return importlib.util.spec_from_file_location(name, self.path, loader=self)
        return None

    def get_code(self, fullname):
        """Code of the mutant; no compiled file is read or written."""
        return compile(self._source, self.path, "exec")


def _run(job):
    """Exit code of pytest on ``job``'s tests with its mutant, in this process."""
    import pytest
    if job["module"] in sys.modules:
        raise RuntimeError(f"{job['module']} is imported before its mutant")
    nothing = os.open(os.devnull, os.O_WRONLY)
    for stream in (1, 2):
        os.dup2(nothing, stream)
    for limit, value in ((resource.RLIMIT_CPU, job["seconds"]), (resource.RLIMIT_AS, _MEMORY)):
        resource.setrlimit(limit, (value, value))
    sys.meta_path.insert(0, _Mutant(job["module"], job["path"], job["source"]))
    return int(pytest.main([*_PYTEST, *job["tests"]]))


def outcome(job):
    """What the tests say of a mutant.

    Parameters
    ----------
    job : dict
        ``module``: its name; ``path``: its file; ``source``: the mutant's text; ``tests``: files
        and names of tests, as for pytest; ``seconds``: of a processor that they may take.

    Returns
    -------
    dict
        ``passed``: whether every test passed; ``seconds``: of a processor that they took.
    """
    child = os.fork()
    if not child:
        code = 1
        try:
            code = _run(job)
        finally:
            os._exit(code)
    _, status, usage = os.wait4(child, 0)
    return {"passed": status == 0, "seconds": usage.ru_utime + usage.ru_stime}


def serve(requests, answers):
    """Answer each line of ``requests``; the first one names the libraries to import."""
    for name in json.loads(requests.readline()):
        importlib.import_module(name)
    with open(os.devnull, "w") as nothing, contextlib.redirect_stdout(nothing):
        sys.modules["pytest"].main(["--markers"])       # imports its parts and tests/conftest.py
    gc.collect()
    gc.freeze()             # a collection in a child would copy all pages of the parent
    for line in requests:
        print(json.dumps(outcome(json.loads(line))), file=answers, flush=True)


if __name__ == "__main__":
    os.environ["PYTEST_DISABLE_PLUGIN_AUTOLOAD"] = "1"
    serve(sys.stdin, sys.stdout)

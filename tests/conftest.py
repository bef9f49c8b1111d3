"""What holds for every test: how programs are compiled, how often Python collects garbage,
names and markers."""

import gc
import os
import re
import shutil
import warnings

import pytest
from amaranth.hdl import UnusedElaboratable

# Two test processes share two cores: a second thread of the linear algebra finds none, and waits
# for one at full speed. Read when NumPy is imported, which neither of the above does.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

_LONG = 4 * 3600        # seconds that a test of `make regress` may take

# Texts that stand for themselves in the name of a test, and arguments that never do.
_NAME = re.compile(r"[\w .,:@/+=*()'-]{0,40}")
_MESSAGES = {"message", "sentence", "said", "error", "reason", "shown"}

# Windows are painted without a screen.
os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")

# A netlist is a million objects without a cycle to be found: to look for one after every 700 new
# ones takes a fifth of the time in which it is made.
gc.set_threshold(100_000, 50, 50)

# A component that is rejected is never elaborated.
warnings.simplefilter("ignore", UnusedElaboratable)


def pytest_configure(config):
    from coverage import FOLDER
    if not hasattr(config, "workerinput") and counts_coverage(config):
        shutil.rmtree(FOLDER, ignore_errors=True)


def counts_coverage(config):
    """Whether a run may hold tests that do; another one leaves alone what they have counted."""
    return config.option.markexpr != "not regress"


def pytest_terminal_summary(terminalreporter, config):
    """Print what the simulations that count coverage have reached."""
    from coverage import FOLDER, table
    if counts_coverage(config) and FOLDER.exists():
        terminalreporter.section("coverage of the Verilog")
        for line in table():
            terminalreporter.write_line(line)


def pytest_make_parametrize_id(val, argname):
    """Name an argument whose text is a message, a pattern or long: the text would be its id."""
    if isinstance(val, str) and (argname in _MESSAGES or not _NAME.fullmatch(val)):
        return argname


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(config, items):
    config.stash["markers"] = {mark.name for item in items for mark in item.iter_markers()}
    for item in items:
        if item.get_closest_marker("regress") and not item.get_closest_marker("timeout"):
            item.add_marker(pytest.mark.timeout(_LONG))


@pytest.hookimpl(tryfirst=True)
def pytest_runtest_setup(item):
    """Small frames simulate in a second however they are compiled; millions of clocks are worth
    the four times as long that -O2 takes."""
    many = item.get_closest_marker("regress") and item.get_closest_marker("many_clocks")
    os.environ["NCDC_OPTIMISE"] = "-O2" if many else "-O0"

"""What holds for every test: how programs are compiled, what is kept between runs, and how often
Python collects garbage."""

import gc
import os
import warnings

import pytest
from amaranth.hdl import UnusedElaboratable

# Two test processes share two cores: a second thread of the linear algebra finds none, and waits
# for one at full speed. Read when NumPy is imported, which neither of the above does.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

# Windows are painted without a screen.
os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")

# A netlist is a million objects without a cycle to be found: to look for one after every 700 new
# ones takes a fifth of the time in which it is made.
gc.set_threshold(100_000, 50, 50)

# A component that is refused, or whose Verilog is kept, is never elaborated.
warnings.simplefilter("ignore", UnusedElaboratable)


def pytest_configure():
    """Before any test imports what makes Verilog, and NumPy with it."""
    from kept import keep_verilog
    keep_verilog()


@pytest.hookimpl(tryfirst=True)
def pytest_runtest_setup(item):
    """Small frames simulate in a second however they are compiled; the long runs are worth -O2."""
    os.environ["NCDC_OPTIMISE"] = "-O2" if item.get_closest_marker("regress") else "-O0"

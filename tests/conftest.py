"""What holds for every test: how programs are compiled, what is kept between runs, how often
Python collects garbage, and which tests are longer ones."""

import gc
import json
import os
import shutil
import warnings
from pathlib import Path

import pytest
from amaranth.hdl import UnusedElaboratable

# Two test processes share two cores: a second thread of the linear algebra finds none, and waits
# for one at full speed. Read when NumPy is imported, which neither of the above does.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

_SMALL = 1 << 19        # bytes of the input of a simulation that is kept
_LONG = 4 * 3600        # seconds that a test of `make regress` may take

# Windows are painted without a screen.
os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")

# A netlist is a million objects without a cycle to be found: to look for one after every 700 new
# ones takes a fifth of the time in which it is made.
gc.set_threshold(100_000, 50, 50)

# A component that is refused, or whose Verilog is kept, is never elaborated.
warnings.simplefilter("ignore", UnusedElaboratable)


def pytest_addoption(parser):
    parser.addoption("--cpu-times", metavar="FILE", type=os.path.abspath,
                     help="append the seconds of a processor that each test takes")


def pytest_configure(config):
    """Before any test imports what makes Verilog, and NumPy with it."""
    from coverage import FOLDER
    from kept import keep_verilog
    if not hasattr(config, "workerinput") and counts_coverage(config):
        shutil.rmtree(FOLDER, ignore_errors=True)
    keep_verilog()
    keep_simulations()


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


def keep_simulations():
    """Let what a compiled simulation prints and writes be kept, as far as it is small.

    It follows from the program, whose folder is named by a hash of all that it was made from, from
    its arguments, seeds among them, and from its input files.
    """
    from coverage import keep_coverage
    from kept import kept_folder
    from ncdc_sim import cache_stress, exhaustive, runner
    from ncdc_sim.builds import builds_folder
    from ncdc_sim.system import frame

    def run(command, folder, on_line=lambda line: None):
        program = Path(command[2] if command[0] == "vvp" else command[0])
        files = {path.name: path.read_bytes() for path in sorted(Path(folder).iterdir())}
        if program.parent.parent != builds_folder() or sum(map(len, files.values())) > _SMALL:
            runner.run(command, folder, on_line)
            keep_coverage(folder)
            return
        lines, new = [], []

        def build(kept):
            def listen(line):
                lines.append(line)
                on_line(line)

            runner.run(command, folder, listen)
            new.append(True)
            (kept / "lines").write_text(json.dumps(lines))
            for path in Path(folder).iterdir():
                if path.name not in files or path.read_bytes() != files[path.name]:
                    (kept / f"file-{path.name}").write_bytes(path.read_bytes())

        kept = kept_folder("run", build, program.parent.name, *command[3 if command[0] == "vvp"
                                                                       else 1:],
                           *(f"{name}:{content.hex()}" for name, content in files.items()))
        for line in () if new else json.loads((kept / "lines").read_text()):
            on_line(line)
        for path in () if new else kept.glob("file-*"):
            (Path(folder) / path.name.removeprefix("file-")).write_bytes(path.read_bytes())
        keep_coverage(folder)

    frame.run_program = cache_stress.run = exhaustive.run = run


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(config, items):
    from longer import COLLECTED, LONGER
    config.stash[COLLECTED] = {item.nodeid for item in items}
    for item in items:
        if item.nodeid in LONGER:
            item.add_marker("longer")
        if item.get_closest_marker("regress") and not item.get_closest_marker("timeout"):
            item.add_marker(pytest.mark.timeout(_LONG))


@pytest.hookimpl(wrapper=True, tryfirst=True)
def pytest_runtest_protocol(item, nextitem):
    from longer import cpu_seconds
    before = cpu_seconds()
    done = yield
    if item.config.option.cpu_times:
        with open(item.config.option.cpu_times, "a") as file:
            file.write(f"{cpu_seconds() - before:.2f} {item.nodeid}\n")
    return done


@pytest.hookimpl(tryfirst=True)
def pytest_runtest_setup(item):
    """Small frames simulate in a second however they are compiled; millions of clocks are worth
    the four times as long that -O2 takes."""
    many = item.get_closest_marker("regress") and item.get_closest_marker("many_clocks")
    os.environ["NCDC_OPTIMISE"] = "-O2" if many else "-O0"

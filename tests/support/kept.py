"""What tests need not make again: results kept between runs.

Their key is a hash of all that they follow from. Kept are texts that a tool or a generator makes of
other texts, without chance: the same input, the same versions, the same output. A failure leaves
nothing behind and is found again.
"""

import copyreg
import json
import os
import pickle
import sys
from collections import Counter
from functools import cache, wraps
from importlib.metadata import version
from pathlib import Path
from types import ModuleType

import numpy as np
from amaranth.lib import data

import ncdc_boards
import ncdc_hdl
import ncdc_model
import ncdc_sim
from ncdc_hdl.corrector import Corrector
from ncdc_hdl.export import verilog
from ncdc_hdl.export.verilog import cover
from ncdc_model.training.levenberg import train_levenberg
from ncdc_sim import cocotb_run
from ncdc_sim.builds import built, key_of, without_header
from ncdc_sim.tools import version as version_of
from ncdc_spec.descriptor import Descriptor

__all__ = ["TRAINING", "keep_verilog", "kept_folder", "kept_lists", "kept_result",
           "kept_trainer", "kept_training", "run_cocotb", "sources_of"]

# What a training depends on, besides the sources.
TRAINING = ("numpy", "scipy", "opencv-python-headless")

_ROOMS = (ncdc_hdl, ncdc_model)
_TESTS = Path(__file__).resolve().parents[1]
_calls = Counter()          # kept lists by the test that asked for them
# As it is, a constant with a layout is lost in itself when it is read back.
copyreg.pickle(data.Const, lambda each: (data.Const, (each.shape(), each.as_value().value)))

_untouched = []             # the modules of the rooms, and their attributes before any test


def kept_folder(kind, build, *texts, packages=()):
    """A folder that ``build(folder)`` fills, of this run or of an earlier one.

    Nobody may change it: who wants to, copies it. ``texts`` and the versions of the Python
    ``packages`` must be all that it depends on.
    """
    return built(key_of(kind, *texts, *(f"{name} {version(name)}" for name in packages)), build)


def kept_result(kind, make, *texts, packages=()):
    """The text that ``make()`` returns, likewise."""
    def build(folder):
        (folder / "result").write_text(make())

    return (kept_folder(kind, build, *texts, packages=packages) / "result").read_text()


def kept_training(make, *about):
    """The :class:`Descriptor` that ``make()`` trains, likewise.

    ``about``: what is trained, and how, as numbers and texts. Training takes its chances from a
    seed: the same sources write the same file, which tests of training show.
    """
    def build(folder):
        make().save(folder / "net.toml")

    folder = kept_folder("training", build, repr(about), sources_of(ncdc_model), sys.version,
                         packages=TRAINING)
    return Descriptor.load(folder / "net.toml")


def kept_trainer(**options):
    """The trainer ``lm`` with ``options``, whose networks are kept, and shared by tests.

    It tells again what it told of its progress. A test that has patched the model trains anew.
    """
    def train(problem, neurons, seed=0, progress=None, **more):
        given = options | more
        if _is_patched():
            return train_levenberg(problem, neurons, seed, progress=progress, **given)

        def build(folder):
            told = []
            result = train_levenberg(problem, neurons, seed, **given,
                                     progress=lambda *about: told.append(about))
            (folder / "training").write_bytes(pickle.dumps((result, told)))

        pairs = np.array([problem.u, problem.v, problem.x, problem.y], float)
        folder = kept_folder("trainer", build, pairs.tobytes().hex(), repr(problem.geometry),
                             repr((neurons, seed, sorted(given.items()))), sources_of(ncdc_model),
                             sys.version, packages=TRAINING)
        result, told = pickle.loads((folder / "training").read_bytes())
        for about in told if progress else ():
            progress(*about)
        return result

    return train


def kept_lists(run, about, lists):
    """Let ``run()`` change ``lists``, or arrays; or set them to what the same test had before.

    The same test: the same name with the same parameters, the n-th call of this function in it,
    ``about`` and the text of its file, of ``tests/support`` and of all rooms below the command.
    Chances that ``run()`` takes must be made in the test, from a seed. A test that has patched the
    gateware or the model, and a fixture, whose turn depends on what ran before it, run always.
    """
    name, _, phase = os.environ.get("PYTEST_CURRENT_TEST", "").rpartition(" ")
    if phase != "(call)" or _is_patched():
        return run()
    _calls[name] += 1

    def build(folder):
        run()
        (folder / "lists").write_bytes(pickle.dumps(lists))

    file = _TESTS.parent / name.partition("::")[0]
    folder = kept_folder("lists", build, name, str(_calls[name]), about, file.read_text(),
                         _sources_in(_TESTS / "support"),
                         sources_of(*_ROOMS, ncdc_boards, ncdc_sim), sys.version,
                         packages=("amaranth", "numpy"))
    for each, content in zip(lists, pickle.loads((folder / "lists").read_bytes())):
        each[:] = content


@cache
def sources_of(*packages):
    """The text of all source files of ``packages``, in the order of their names."""
    return _sources_in(*(Path(package.__path__[0]) for package in packages))


@cache
def _sources_in(*folders):
    return "\0".join(f"{path.relative_to(folder)}\0{path.read_text()}" for folder in folders
                     for path in sorted(folder.rglob("*.py")))


def keep_verilog():
    """Let the Verilog of whole correctors be kept, where a test has not patched what makes it.

    To be called before anything else imports :mod:`ncdc_hdl.export.verilog`.
    """
    original = cover.verilog_of

    @wraps(original)
    def verilog_of(corrector, name=cover.TOP):
        # Of other components nobody knows what they follow from; they are small.
        if type(corrector) is not Corrector or _is_patched():
            return original(corrector, name)
        return kept_result(
            "verilog", lambda: original(corrector, name), sources_of(*_ROOMS),
            name, corrector.descriptor.digest, repr(corrector.hardware), sys.version,
            packages=("amaranth", "ncdc"))

    verilog.verilog_of = cover.verilog_of = verilog_of
    modules = {name: module for name, module in sys.modules.items()
               if name.partition(".")[0] in [room.__name__ for room in _ROOMS]}
    _untouched.append((modules, _attributes(modules)))


def run_cocotb(design, bench, simulator, *, descriptor=None, files=None, plusargs=(), **settings):
    """:func:`ncdc_sim.cocotb_run.run_cocotb`, whose log is kept if it passes.

    ``descriptor``: file of the descriptor that the bench needs.
    """
    needed = {} if descriptor is None else {"descriptor": str(descriptor)}
    files = files or {}
    return kept_result(
        "bench", lambda: cocotb_run.run_cocotb(design, bench, simulator, files=files,
                                               plusargs=plusargs, **settings, **needed),
        design.top, without_header(design.verilog), repr(design.open), bench, version_of(simulator),
        json.dumps(settings, sort_keys=True), *(Path(file).read_text() for file in needed.values()),
        *(text for name, content in sorted(files.items()) for text in (name, content.hex())),
        *plusargs,
        sources_of(ncdc_model, ncdc_sim), sys.version, packages=("cocotb", "numpy"))


def _attributes(modules):
    """Every attribute of every one of the ``modules``, and of every class made in them."""
    classes = {f"{value.__module__}.{value.__qualname__}": value for module in modules.values()
               for value in vars(module).values()
               if isinstance(value, type) and value.__module__ in modules}
    return {(name, attribute): value for name, owner in [*modules.items(), *classes.items()]
            for attribute, value in vars(owner).items()
            if not attribute.startswith("__") and not isinstance(value, ModuleType)}


def _is_patched():
    """Whether an attribute is another object than before the tests, as a planted error is."""
    (modules, untouched), = _untouched
    now = _attributes(modules)
    return now.keys() != untouched.keys() or any(now[key] is not untouched[key] for key in now)

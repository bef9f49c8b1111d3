"""Who may import whom: the table of packages, no circles of modules, a model without Amaranth.

Also how long a function may be."""

import ast
import subprocess
import sys
from functools import cache
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]

# Each package, and the folder it lies in.
FOLDERS = {"ncdc_bench": "benchmarks", "ncdc": ".", "ncdc_sim": "sim", "ncdc_soc": "soc",
           "ncdc_boards": "boards", "ncdc_host": "host", "ncdc_hdl": ".", "ncdc_model": "model",
           "ncdc_spec": "model"}
# What the modules of a package may import besides their own: packages, folders of them, modules.
MAY_IMPORT = {
    "ncdc_bench": set(FOLDERS),
    "ncdc": set(FOLDERS) - {"ncdc_bench"},
    "ncdc_sim": {"ncdc_soc", "ncdc_boards", "ncdc_hdl", "ncdc_model", "ncdc_spec"},
    "ncdc_soc": {"ncdc_boards", "ncdc_hdl", "ncdc_spec"},
    # Lenses that show the raw picture, and the test card.
    "ncdc_boards": {"ncdc_hdl", "ncdc_spec", "ncdc_model.raw_lens", "ncdc_model.example.card"},
    # The emulated device corrects pictures; the window calibrates, from any source, and trains.
    "ncdc_host": {"ncdc_spec", "ncdc_model.golden", "ncdc_model.correction", "ncdc_model.images",
                  "ncdc_model.example", "ncdc_model.calibration", "ncdc_model.training",
                  "ncdc_model.compare", "ncdc_model.film", "ncdc_model.pc_camera"},
    # Timing for the planner, lenses for the drivers, and what the test benches compare with.
    "ncdc_hdl": {"ncdc_spec", "ncdc_model.planner.corrector_timing", "ncdc_model.planner.plan",
                 "ncdc_model.evaluate", "ncdc_model.golden.tone", "ncdc_model.correction"},
    "ncdc_model": {"ncdc_spec"},
    "ncdc_spec": set(),
}


def modules():
    """Source text of every module of every package, by its dotted name."""
    found = {}
    for package, folder in FOLDERS.items():
        for path in sorted((ROOT / folder / package).rglob("*.py")):
            parts = path.relative_to(ROOT / folder).with_suffix("").parts
            found[".".join(parts[:-1] if parts[-1] == "__init__" else parts)] = path.read_text()
    return found


@cache
def nodes(text):
    """Imports and functions of a module of this ``text``, wherever in it."""
    return [node for node in ast.walk(ast.parse(text)) if isinstance(node, (
        ast.Import, ast.ImportFrom, ast.FunctionDef, ast.AsyncFunctionDef))]


def imported(text, known):
    """Modules of ``known`` that a module of this ``text`` imports."""
    names = set()
    for node in nodes(text):
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            assert not node.level, "imports name their package"
            parts = {f"{node.module}.{alias.name}" for alias in node.names}
            names |= {part if part in known else node.module for part in parts}
    return {name for name in names if name.partition(".")[0] in MAY_IMPORT}


def allowed(package, other):
    """Whether modules of ``package`` may import the module ``other``."""
    parts = other.split(".")
    names = {".".join(parts[:count]) for count in range(1, len(parts) + 1)}
    return bool(names & (MAY_IMPORT[package] | {package}))


def upward(texts):
    """Imports that the table does not allow, as text."""
    return [f"{name} imports {other}" for name, text in texts.items()
            for other in sorted(imported(text, texts))
            if not allowed(name.partition(".")[0], other)]


def folder(name):
    """The folder of its package that a module lies in, or itself if it lies in none."""
    return ".".join(name.split(".")[:2])


def circle(texts, group=lambda name: name):
    """Modules that import each other in a circle, or an empty list; ``group`` may take several
    modules for one."""
    graph = {}
    for name, text in texts.items():
        others = graph.setdefault(group(name), set())
        others |= {group(other) for other in imported(text, texts)} - {group(name)}
    try:
        TopologicalSorter(graph).prepare()
    except CycleError as error:
        return error.args[1]
    return []


def test_no_package_imports_one_that_stands_on_it():
    texts = modules()
    assert len(texts) > 100 and {name.partition(".")[0] for name in texts} <= MAY_IMPORT.keys()
    assert upward(texts) == []


def test_no_circles():
    assert circle(modules()) == []


def test_no_circles_of_folders():
    assert circle(modules(), folder) == []


@pytest.mark.parametrize("module,planted", [
    ("ncdc_spec.fixed", "from ncdc_hdl.lib import memory"),
    ("ncdc_spec.protocols.gvcp", "from ncdc_model.golden.network import coordinates"),
    ("ncdc_hdl.corrector", "from ncdc_model.golden.network import coordinates"),
    ("ncdc.cli.bench", "import ncdc_bench.commands"),
    ("ncdc_hdl.corrector", "def late():\n    import ncdc_sim.runner"),
    ("ncdc_boards.board", "from ncdc.cli import main")])
def test_a_planted_import_upwards_is_found(module, planted):
    texts = modules()
    texts[module] += f"\n{planted}\n"
    assert [line.partition(" ")[0] for line in upward(texts)] == [module]


def test_a_planted_circle_is_found():
    texts = modules()
    texts["ncdc_spec.errors"] += "\nimport ncdc_spec.descriptor\n"
    assert "ncdc_spec.errors" in circle(texts)


WITHOUT_AMARANTH = """
import importlib, sys

class Hidden:
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] == "amaranth":
            raise ModuleNotFoundError(f"{name} is hidden")

sys.meta_path.insert(0, Hidden())
for name in sys.argv[1:]:
    importlib.import_module(name)
"""


def import_without_amaranth(*names):
    return subprocess.run([sys.executable, "-c", WITHOUT_AMARANTH, *names], cwd=ROOT,
                          capture_output=True, text=True)


@pytest.mark.longer
def test_packages_that_do_without_amaranth():
    """The host's belongs to them from the day on which it is built."""
    names = [name for name in modules()
             if name.partition(".")[0] in ("ncdc_model", "ncdc_host", "ncdc_spec")]
    assert any(name.startswith("ncdc_model.") for name in names)
    done = import_without_amaranth(*names)
    assert not done.returncode, done.stderr


def test_amaranth_is_really_hidden():
    assert "amaranth is hidden" in import_without_amaranth("ncdc_hdl.corrector").stderr


LINES, PARAMETERS = 60, 8


def too_large(texts):
    """Functions of more lines or parameters than allowed, as text."""
    found = []
    for name, text in texts.items():
        for node in nodes(text):
            if isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef)):
                body = node.body[ast.get_docstring(node) is not None:] or node.body
                lines = node.end_lineno - body[0].lineno + 1
                given = node.args
                parameters = [arg.arg for arg in (*given.posonlyargs, *given.args,
                                                  *given.kwonlyargs)
                              if arg.arg not in ("self", "cls")]
                if lines > LINES or len(parameters) > PARAMETERS:
                    found.append(f"{name}.{node.name}: {lines} lines, "
                                 f"{len(parameters)} parameters")
    return found


def test_functions_fit_on_a_screen():
    assert too_large(modules()) == []


def test_large_functions_are_found():
    long = "def long():\n" + "    pass\n" * (LINES + 1)
    loose = "def loose(" + ", ".join(f"p{k}" for k in range(PARAMETERS + 1)) + "):\n    pass\n"
    assert len(too_large({"a": long, "b": loose, "c": "def good(a, b):\n    return a\n"})) == 2

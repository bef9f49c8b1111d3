"""Who may import whom: the table of rooms, no circles of modules, a model without Amaranth; and how
long a function may be."""

import ast
import subprocess
import sys
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]

# Room, in the folder of its own name: the rooms that its modules may import besides itself.
FOLDERS = {"ncdc": ".", "ncdc_sim": "sim", "ncdc_soc": "soc", "ncdc_boards": "boards",
           "ncdc_host": "host", "ncdc_hdl": ".", "ncdc_model": "model"}
MAY_IMPORT = {
    "ncdc": {"ncdc_sim", "ncdc_soc", "ncdc_boards", "ncdc_host", "ncdc_hdl", "ncdc_model"},
    "ncdc_sim": {"ncdc_soc", "ncdc_boards", "ncdc_hdl", "ncdc_model"},
    "ncdc_soc": {"ncdc_boards", "ncdc_hdl", "ncdc_model"},
    "ncdc_boards": {"ncdc_hdl", "ncdc_model"},
    "ncdc_host": {"ncdc_model"},
    "ncdc_hdl": {"ncdc_model"},
    "ncdc_model": set(),
}


def modules():
    """Source text of every module of every room, by its dotted name."""
    found = {}
    for room, folder in FOLDERS.items():
        for path in sorted((ROOT / folder / room).rglob("*.py")):
            parts = path.relative_to(ROOT / folder).with_suffix("").parts
            found[".".join(parts[:-1] if parts[-1] == "__init__" else parts)] = path.read_text()
    return found


def imported(text, known):
    """Modules of ``known`` that a module of this ``text`` imports, wherever in it."""
    names = set()
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            assert not node.level, "imports name their room"
            parts = {f"{node.module}.{alias.name}" for alias in node.names}
            names |= {part if part in known else node.module for part in parts}
    return {name for name in names if name.partition(".")[0] in MAY_IMPORT}


def upward(texts):
    """Imports that the table does not allow, as text."""
    rooms = {name: name.partition(".")[0] for name in texts}
    return [f"{name} imports {other}" for name, text in texts.items()
            for other in sorted(imported(text, texts))
            if other.partition(".")[0] not in MAY_IMPORT[rooms[name]] | {rooms[name]}]


def circle(texts):
    """Modules that import each other in a circle, or an empty list."""
    graph = {name: imported(text, texts) - {name} for name, text in texts.items()}
    try:
        TopologicalSorter(graph).prepare()
    except CycleError as error:
        return error.args[1]
    return []


def test_no_room_imports_one_that_stands_on_it():
    texts = modules()
    assert len(texts) > 100 and {name.partition(".")[0] for name in texts} <= MAY_IMPORT.keys()
    assert upward(texts) == []


def test_no_circles():
    assert circle(modules()) == []


@pytest.mark.parametrize("module,planted", [
    ("ncdc_spec.fixed", "from ncdc_hdl.lib import memory"),
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


def test_rooms_that_do_without_amaranth():
    """The host's belongs to them from the day on which it is built."""
    names = [name for name in modules() if name.partition(".")[0] in ("ncdc_model", "ncdc_host")]
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
        for node in ast.walk(ast.parse(text)):
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

"""The words of the code and of the pages: the field's own terms, and none of a list of others."""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]

FOLDERS = ("ncdc", "ncdc_hdl", "model", "host", "sim", "soc", "boards", "benchmarks", "examples")
SUFFIXES = {".py", ".v", ".vh", ".c", ".h", ".cpp", ".S", ".ld", ".tcl", ".jinja"}

# Words that are not used, and what is written instead. A part of a name between underscores is a
# word too. Upper-case words are meant as they stand, others in any case.
WORDS = {
    "breach breaches": "violation",
    "chance chances": "probability; rng, seed",
    "patience": "timeout",
    "hurry": "time scale",
    "place places": "position, address, area, buffer, slot",
    "told tells": "reported, logged, counted",
    "refuse refuses refused refusing": "rejected; is not supported",
    "kept": "cached, stored",
    "behind": "after, downstream of",
    "beside": "with, next to, alongside",
    "against": "compared with",
    "twin twins": "reference model",
    "room rooms": "space; package",
    "nobody somebody": "no host, no driver, third-party",
    "lights": "LEDs",
    "scan chain": "JTAG",
    "pictures a second": "frames per second",
    "set-up set-ups": "initialisation, configuration; setup (of a flip-flop)",
    "LEAST": "MIN",
    "MOST": "MAX",
}
# Where such words stay: files by a pattern, the text that stays, and why.
EXCEPTIONS = (
    ("*", r"[Pp]laces?[- _]and[- _]routes?|\bin place\b", "standard terms"),
    ("*", r"\bbehind (a|the) router\b", "standard term of networks"),
    ("*", r"\bREFUSED\b|\w*_REFUSED", "name of a flag in the register maps"),
    ("*", r"\w*NCDC_ERROR_ROOM\b|\bncdc_place\b", "names of the C driver"),
    ("ncdc_driver.py", r"\bdef place\b", "name of the Python driver"),
    ("*.md", r"\bcorrector\.place\b|`place`|\btest_rooms\b", "names in the code"),
    ("*", r"\bbeside_camera_clocks_per_pixel\b", "entry of `ncdc plan --json`"),
    ("build*.py", r'"kept"', "entry of `ncdc build --json`"),
    ("commands.md", r"`kept`", "the same"),
    ("*", r"--against", "old spelling of an option, with a warning"),
    ("*/ncdc_host/client/__init__.py", "Refused", "old name of a class, with a warning"),
    ("backprop.py", r"\bpatience\b", "standard term of early stopping"),
    ("*/quartus/*.py", r"\w*lights(_in|_out)?\b", "ports of a file that users have written"),
    ("table.c", r"refused_data", "names of lwIP"),
)


def code():
    """Source files of the packages and of the examples."""
    return [path for folder in FOLDERS for path in sorted((ROOT / folder).rglob("*"))
            if path.suffix in SUFFIXES]


def pages():
    """Pages, and the templates of the generated ones."""
    return [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").rglob("*.md")),
            *(path for folder in FOLDERS for path in sorted((ROOT / folder).rglob("*.md")))]


PATTERNS = [(re.compile(r"(?<![A-Za-z])(?:%s)(?![A-Za-z])" % "|".join(
    [forms] if forms in ("scan chain", "pictures a second") else forms.split()),
    0 if forms.isupper() else re.IGNORECASE), use) for forms, use in WORDS.items()]


def unwanted(path, text):
    """Lines ``file:line: word (what to use)`` of the words in the ``text`` of the file ``path``."""
    for files, pattern, _ in EXCEPTIONS:
        if path.match(files):
            text = re.sub(pattern, lambda match: " " * len(match[0]), text)
    return [f"{path}:{number}: {match[0]} ({use})"
            for number, line in enumerate(text.splitlines(), 1)
            for pattern, use in PATTERNS for match in pattern.finditer(line)]


@pytest.mark.parametrize("files", [code, pages], ids=lambda files: files.__name__)
def test_words(files):
    paths = files()
    assert len(paths) > 20
    found = [line for path in paths
             for line in unwanted(path.relative_to(ROOT), path.read_text(errors="replace"))]
    assert not found, "\n".join(found)


@pytest.mark.parametrize("name,text,word", [
    ("tests/support/hdl/axi_checker.v", "    task breach(input rule);", "breach"),
    ("ncdc/cli/plan.py", "sink_chance = 3", "chance"),
    ("ncdc/cli/plan.py", '"""Beside the camera."""', "Beside"),
    ("ncdc_hdl/system.py", "# Place and route. No place is left.", "place"),
    ("ncdc_hdl/export/drivers/host/ncdc.c", "ncdc_place(device); place(device);", "place"),
    ("host/ncdc_host/client/table.py", "self._patience = 3", "patience"),
    ("model/ncdc_spec/sensors/ov5640.py", "_MOST_LINES = most", "MOST"),
    ("docs/howto/board.md", "One line.\nThe JTAG scan chain.", "scan chain")])
def test_a_planted_word_is_found(name, text, word):
    path = Path(name)
    found = [line.partition(" (")[0] for line in unwanted(path, text)]
    assert found == [f"{name}:{len(text.splitlines())}: {word}"]


def test_parts_of_words_are_not_found():
    assert unwanted(Path("ncdc/cli/plan.py"), "replace, mushroom, at least, at most, untold") == []


def test_exceptions_are_needed():
    """An exception that no file needs any more goes."""
    texts = [(path.relative_to(ROOT), path.read_text(errors="replace"))
             for path in code() + pages()]
    unused = [(files, pattern) for files, pattern, _ in EXCEPTIONS
              if not any(path.match(files) and re.search(pattern, text) for path, text in texts)]
    assert unused == []

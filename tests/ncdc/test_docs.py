"""The documentation: links, quoted commands, files, report names and code that really exist."""

import contextlib
import io
import re
import shlex
import subprocess
import sys
from collections import Counter
from pathlib import Path

import pytest

from ncdc.cli import parser
from ncdc_hdl.export.drivers.page import register_doc
from ncdc_hdl.frontend.backmap import BackMap
from ncdc_hdl.neural.tansig import Tansig
from ncdc_spec.camera_port import KINDS
from ncdc_spec.descriptor import Formats
from ncdc_spec.hardware import Hardware
from ncdc_spec.protocols.page import protocols_doc
from ncdc_spec.registers.register_map import COLOUR_COUNTERS, COUNTERS, registers
from ncdc_spec.registers.system_map import system_registers
from ncdc_spec.registers.system_values import stores_for
from ncdc_spec.tansig import FRACTION_BITS

_STORES = stores_for(Hardware(), 2)
ROOT = Path(__file__).resolve().parents[2]
REFERENCE, EXPLANATION = ROOT / "docs" / "reference", ROOT / "docs" / "explanation"
PAGES = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").glob("**/*.md"))]
SOURCES = ("ncdc", "ncdc_hdl", "host", "model", "sim", "benchmarks", "boards", "tests", "docs")

_FENCE = re.compile(r"^```(\w*)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
_LINK = re.compile(r"\[[^\]]*\]\(([^)\s]+)\)")
_PATH = re.compile(rf"`((?:{'|'.join(SOURCES)})/[\w/.*-]+)`")
_COMMAND = re.compile(r"^ *(?:\$ )?(?:\.venv/bin/)?ncdc (.+)$")


def blocks(page):
    """(language, text) of every code block of a page: fenced, or indented by four spaces."""
    text = page.read_text()
    found = _FENCE.findall(text)
    rest = _FENCE.sub("", text)
    for part in re.split(r"\n\s*\n", rest):
        lines = part.splitlines()
        if lines and all(line.startswith("    ") for line in lines if line):
            found.append(("", "\n".join(line[4:] for line in lines) + "\n"))
    return found


def commands(page):
    """Every command line of ``ncdc`` that the code blocks of a page quote, without ``ncdc``."""
    lines = [line for _, text in blocks(page) for line in text.replace("\\\n", " ").splitlines()]
    return [match[1].partition("  #")[0] for line in lines
            if (match := _COMMAND.match(line)) and "..." not in match[1]
            and not re.match(r"\w+: ", match[1])]


def anchors(page):
    """Anchors of a page's headings, made as GitHub makes them."""
    titles = re.findall(r"^#+ (.*)$", _FENCE.sub("", page.read_text()), re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", title.lower()).replace(" ", "-") for title in titles}


def faults(page):
    """Links of ``page`` to files or headings that are not there."""
    wrong = []
    for link in _LINK.findall(_FENCE.sub("", page.read_text())):
        if re.match(r"\w+:", link):
            continue
        name, _, anchor = link.partition("#")
        target = page.parent / name if name else page
        if not target.exists() or anchor and anchor not in anchors(target):
            wrong.append(link)
    return wrong


def by_name(page):
    return str(page.relative_to(ROOT))


@pytest.mark.parametrize("page", PAGES, ids=by_name)
def test_links_lead_somewhere(page):
    assert faults(page) == []


def test_a_broken_link_is_seen(tmp_path):
    page = tmp_path / "page.md"
    page.write_text("# Some title\n[a](page.md) [b](#some-title) [c](no.md) [d](page.md#none)\n")
    assert faults(page) == ["no.md", "page.md#none"]


@pytest.mark.parametrize("page", PAGES, ids=by_name)
def test_quoted_commands_parse(page, capsys):
    for command in commands(page):
        try:
            parser().parse_args(shlex.split(command))
        except SystemExit as end:
            assert end.code == 0, f"ncdc {command}\n{capsys.readouterr().err}"


def test_commands_are_found_in_the_pages():
    quoted = {command.split()[0] for command in commands(REFERENCE / "commands.md")}
    assert quoted == set(parser()._subparsers._group_actions[0].choices)


@pytest.mark.parametrize("page", PAGES, ids=by_name)
def test_files_named_exist(page):
    missing = [name for name in _PATH.findall(page.read_text()) if not any(ROOT.glob(name))]
    assert missing == []


@pytest.mark.longer
def test_report_names_are_in_the_code():
    page = (REFERENCE / "commands.md").read_text()
    table = page.partition("## Names in reports")[2]
    names = {name for row in re.findall(r"^\| (`[^|]*) \|", table, re.MULTILINE)
             for name in re.findall(r"`(\w+)`", row)}
    code = "".join(path.read_text() for folder in SOURCES[:7]
                   for path in (ROOT / folder).glob("**/*.py"))
    code = code.replace("map_error_{kind}_px", "map_error_float_px map_error_fixed_px")
    # Reports name them as the registers do.
    code += " ".join((*COUNTERS, *COLOUR_COUNTERS)).lower()
    assert len(names) > 40
    assert sorted(name for name in names if not re.search(rf"\b{name}\b", code)) == []


TRAINING_PAGES = {"interpolation.md", "numbers.md"}


@pytest.mark.parametrize("page", [
    pytest.param(page, marks=[pytest.mark.longer] * (page.name in TRAINING_PAGES))
    for page in PAGES if any(language == "python" for language, _ in blocks(page))], ids=by_name)
def test_python_blocks_run(page, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    names = {"__name__": "docs"}
    for language, text in blocks(page):
        if language == "python":
            with contextlib.redirect_stdout(io.StringIO()):
                exec(compile(text, str(page), "exec"), names)


def test_register_page_is_that_of_the_table():
    written = (REFERENCE / "registers.md").read_text()
    assert written == register_doc(8, Formats()), \
        "write it anew: python -m ncdc_hdl.export.drivers.page > docs/reference/registers.md"


def test_protocols_page_is_that_of_the_declarations():
    assert (REFERENCE / "protocols.md").read_text() == protocols_doc(), \
        "write it anew: python -m ncdc_spec.protocols.page > docs/reference/protocols.md"


def test_register_page_is_printed():
    done = subprocess.run([sys.executable, "-m", "ncdc_hdl.export.drivers.page"], check=True,
                          stdout=subprocess.PIPE, text=True)
    assert done.stdout == register_doc(8, Formats())


@pytest.mark.parametrize("neurons", [1, 2, 32])
def test_register_page_gives_every_register_its_offset(neurons):
    table = (*registers(neurons, Formats(), colour=True),
             *system_registers(_STORES, 2592, KINDS, phy=True))
    families = Counter(register.family[0] for register in table)
    offsets = {}
    for offset, name in re.findall(r"^\| (0x[^|]*) \| `(\w+)` \|",
                                   register_doc(neurons, Formats()), re.MULTILINE):
        first, _, step = offset.partition(" + ")
        if name != "VALID_ROWS":
            for j in range(families[name]):
                offsets[name.replace("j", str(j))] = int(first, 16) + j * int(
                    step.removesuffix(" j") or 0)
    assert offsets == {r.name: 4 * r.address for r in table}


def test_latencies_of_the_tan_sigmoids_are_those_of_the_gateware():
    text = (EXPLANATION / "tansig.md").read_text()
    tables = [part for part in text.split("\n\n") if part.startswith("| P |") and "latency" in part]
    assert len(tables) == 3
    for variant, table in zip(("mmhbc", "classic", "table"), tables):
        names, _, *rows = [[cell.strip() for cell in line.strip("|").split("|")]
                           for line in table.splitlines()]
        written = {int(row[0]): int(row[names.index("latency")]) for row in rows}
        assert written == {bits: Tansig(Formats().with_tansig_bits(bits).tansig_design(
            variant)).latency for bits in FRACTION_BITS}


def test_latencies_of_the_front_end_are_those_of_the_gateware():
    table = (EXPLANATION / "frontend.md").read_text().partition("| HN | latency, clocks |")[2]
    written = {int(a): int(b) for a, b in re.findall(r"^\| (\d+) \| (\d+) \|$",
                                                     table.partition("\n\n")[0], re.MULTILINE)}
    assert written == {neurons: BackMap(neurons, Formats()).latency for neurons in (1, 4, 8, 32)}

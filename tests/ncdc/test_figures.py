"""Figures that pages quote by name are those of ``docs/figures.json``."""

import json
import tomllib
from datetime import date
from importlib.metadata import version
from pathlib import Path

import pytest

from ncdc_bench.figures.quote import (
    STORE,
    copies,
    leaves,
    load,
    main,
    pages,
    quoted_leaves,
    quotes,
    rewrite,
    store,
)
from ncdc_bench.figures.unnamed import HISTORY, unnamed
from ncdc_spec.errors import InputError

ROOT = Path(__file__).resolve().parents[2]
REMEDY = "run python -m ncdc_bench.figures.quote, and look at git diff"
CONSTANTS = tomllib.loads(Path(__file__).with_name("page_constants.toml").read_text())
PAGES = [str(path.relative_to(ROOT)) for path in pages(ROOT)]
FIGURES = {"bench": {"worst": 0.2468, "rows": {
    "a": {"name": "a", "size": 12345, "mhz": 100.04}, "b": {"name": "b", "size": 7, "mhz": None}}}}
FORM = "<!--rows=bench.rows | {name} | {size:,} | {mhz:.1f} |-->\n\n"
HEAD = "| name | size | MHz |\n|---|---|---|\n"
TABLE = f"{FORM}{HEAD}| a | 12,345 | 100.0 |\n| b | 7 | - |\n"
CODE = ("<!--rows=bench.rows {name} has {size:>6d}, at {mhz:>5.1f}-->\n\n    $ command\n"
        "    a has  12345, at 100.0\n    other\n    b has      7, at     -\n")


@pytest.fixture(scope="module")
def figures():
    return load(ROOT)


@pytest.fixture(scope="module")
def quoted(figures):
    return {str(page.relative_to(ROOT)): quotes(page.read_text(), figures) for page in pages(ROOT)}


def test_pages_show_the_figures_that_are_stored(quoted):
    wrong = [f"{page}:{quote.line}: {quote.name} is {quote.right}, not {quote.shown}"
             for page, found in quoted.items() for quote in found if quote.shown != quote.right]
    assert sum(map(len, quoted.values())) > 50 and wrong == [], REMEDY


def test_every_stored_figure_is_quoted(figures, quoted):
    groups = json.loads((ROOT / STORE).read_text())
    shown = quoted_leaves([quote for found in quoted.values() for quote in found], figures)
    stored = {name for name in leaves(figures) if "figures" in groups[name[0]]}
    labels = {name for name in stored if isinstance(_value(figures, name), str)}
    assert stored - labels - shown == set(), REMEDY


def _value(figures, name):
    for part in name:
        figures = figures[part]
    return figures


def test_every_group_has_its_command_date_and_version():
    groups = json.loads((ROOT / STORE).read_text())
    assert all(group["command"].startswith("ncdc ") and group["date"]
               and group["version"] for group in groups.values())


@pytest.mark.parametrize("page", PAGES)
def test_no_page_copies_a_figure_without_its_name(page, quoted):
    shown = {text for found in quoted.values() for quote in found if not quote.fields
             for text in quote.shown}
    assert copies((ROOT / page).read_text(), quoted[page], shown) == []


def _constants(page):
    """Numbers of a page that are no measurements."""
    return {number for part in (CONSTANTS["all pages"], CONSTANTS.get(page, {}))
            for numbers in part.values() for number in numbers}


@pytest.mark.parametrize("page", PAGES)
def test_every_measured_number_is_quoted_or_history(page):
    wrong = [(line, number) for line, number in unnamed((ROOT / page).read_text())
             if number not in _constants(page)]
    assert wrong == [], "quote it, write when it was measured, or list it in page_constants.toml"


def test_every_constant_is_on_its_page():
    shown = {page: {number for _, number in unnamed((ROOT / page).read_text())} for page in PAGES}
    shown["all pages"] = set().union(*shown.values())
    absent = {(page, number) for page, reasons in CONSTANTS.items()
              for numbers in reasons.values() for number in numbers
              if number not in shown.get(page, ())}
    assert absent == set()


def test_history_is_of_a_version_and_a_day_that_were():
    found = [match.groups() for page in PAGES
             for match in HISTORY.finditer(" ".join((ROOT / page).read_text().split()))]
    releases = {"0.1", ".".join(version("ncdc").split(".")[:2])}
    assert len(found) > 50 and {release for release, _ in found} <= releases
    assert all(date(2026, 11, 20) <= date.fromisoformat(day) for _, day in found)


@pytest.mark.parametrize("right", ["0.25<!--=bench.worst--> px", "(0.2468<!--=bench.worst-->).",
                                   "0<!--=bench.worst-->", "+0.247<!--=bench.worst-->",
                                   "12,345<!--=bench.rows.a.size--> ALM",
                                   "12345<!--=bench.rows.a.size-->", TABLE, CODE])
def test_a_right_quote_is_accepted(right):
    found = quotes(right, FIGURES)
    assert found and all(quote.shown == quote.right for quote in found)
    assert rewrite(right, FIGURES).strip() == right.strip()


@pytest.mark.parametrize("wrong,right", [
    ("0.24<!--=bench.worst-->", "0.25<!--=bench.worst-->"),
    ("0.2469<!--=bench.worst-->", "0.2468<!--=bench.worst-->"),
    ("1.25<!--=bench.worst--> 3", "0.25<!--=bench.worst--> 3"),
    ("999<!--=bench.rows.a.size-->", "12,345<!--=bench.rows.a.size-->"),
    (TABLE.replace("12,345", "12,346"), TABLE), (TABLE.replace("| 7 |", "| 8 |"), TABLE),
    (TABLE.replace("| b | 7 | - |\n", ""), TABLE), (TABLE + "| c | 9 | 2.0 |\n", TABLE),
    (TABLE.replace("| a |", "| c |"), TABLE),
    (CODE.replace("12345", "12346"), CODE), (CODE.replace("    -", "  9.0"), CODE)])
def test_a_planted_difference_is_found_and_put_right(wrong, right):
    assert any(quote.shown != quote.right for quote in quotes(wrong, FIGURES))
    assert rewrite(wrong, FIGURES).strip() == right.strip()


def test_a_page_keeps_cells_of_its_own():
    form = "<!--rows=bench.rows | * | {size:,} |-->\n\n| name | size |\n|---|---|\n"
    text = form + "| first | 1 |\n| second | 2 |\n"
    assert rewrite(text, FIGURES) == form + "| first | 12,345 |\n| second | 7 |\n"
    with pytest.raises(InputError, match="bench.rows has 2 rows, the page has 1"):
        rewrite(form + "| first | 1 |\n", FIGURES)


@pytest.mark.parametrize("text,message", [
    ("\n1<!--=bench.none-->", "2: no figure is named bench.none"),
    ("word<!--=bench.worst-->", "1: a quote has no number before it"),
    ("1 <!--=bench.worst-->", "1: a quote has no number before it"),
    ("1<!--=bench.rows-->", "1: the figure bench.rows is not a number"),
    ("<!--rows=bench.worst {x:d}-->\n\n1", "1: bench.worst is a number, not a table"),
    ("<!--rows=bench.rows {none:d}-->\n\n1", "1: a row of bench.rows has no none"),
    ("<!--rows=bench.rows {name:d}-->\n\n| a |\n|---|\n| 1 |", "1: Unknown format code"),
    ("<!--rows=bench.rows {size:d-->\n\n| a |\n|---|\n| 1 |", "1: "),
    ("<!--rows=bench.rows | * | {size:d} |-->\n\n| a |\n|---|\n| 1 |\n| 2 |",
     "1: the form has 2 cells, the page has 1"),
    ("<!--rows=bench.rows-->\n\n1", "1: <!--rows=bench.rows--> is not a form of rows"),
    ("<!--rows=bench.rows {size:d}-->\n\nno number", "1: no line below has the form"),
    (CODE.replace("    a has  12345, at 100.0\n", "    a has 12, at 1.0\n    b has 3, at 2.0\n"),
     "1: bench.rows has 2 rows, the page has 3 lines")])
def test_a_wrong_quote_is_an_error(text, message):
    with pytest.raises(InputError) as error:
        rewrite(text, FIGURES)
    assert str(error.value).startswith(message)


def test_a_planted_copy_is_found():
    shown = {"0.2468", "12,345", "373"}
    page = "It is 0.2468 px.\n| 12,345 | 373 |\n"
    assert copies(page, [], shown) == [(1, "0.2468"), (2, "12,345")]
    page = "0.2468<!--=bench.worst-->, 10.2468, 0.24681, 12,345,678\n\n    0.2468\n"
    assert copies(page + TABLE, quotes(page + TABLE, FIGURES), shown) == []


PAST = "Measured with version 0.1, 2026-11-22"
MEASURED = "| size | MHz |\n|---|---|\n| 8 | 62.5 |\n"
PLANTED = [
    ("It reaches 62.5 MHz.", ["62.5 MHz"]), ("A frame takes\n1,234\nms.", ["1,234 ms"]),
    ("65.6, 70 and 78.0 MHz", ["65.6 MHz", "70 MHz", "78.0 MHz"]),
    ("1.2<!--=a.b--> to 3.4 px", ["3.4 px"]), ("- 5 %\n- 6 dB\n", ["5 %", "6 dB"]),
    (MEASURED, ["62.5 MHz"]), ("| error, px | 0.25 |\n|---|---|\n| worst | 0.5 |", ["0.5 px"]),
    ("| what | a |\n|---|---|\n| speed, MHz | 7 |", ["7 MHz"]),
    ("| what | MHz |\n|---|---|\n| a | 80 % |", ["80 %"]),
    ("| | a | MHz |\n|---|---|---|\n| | | 7 |", ["7 MHz"]),
    ("<!--rows=a | * | {mhz:.1f} |-->\n\n" + MEASURED.replace("size", "px"), ["8 px"]),
    ("**7 px**, 8-9 px", ["7 px", "8 px", "9 px"]), ("5 CPU\nseconds", ["5 CPU seconds"]),
    (f"{MEASURED}| 9 | 70 |\n| 10 | 80, {PAST.lower()} |", ["62.5 MHz", "70 MHz"]),
    (f"{PAST}.\n\n7 px", ["7 px"]), (f"{PAST}:\n\n    code\n\n{MEASURED}", ["62.5 MHz"]),
    (f"{PAST}:\n\n{MEASURED}\n7 px", ["7 px"]), (f"- {PAST}, 7 px\n- 8 px", ["8 px"]),
    (f"## A\n\nThis section was {PAST.lower()}.\n\n7 px\n\n## B\n\n8 px", ["8 px"])]


@pytest.mark.parametrize("text,numbers", PLANTED)
def test_a_planted_number_is_found(text, numbers):
    assert [number for _, number in unnamed(text)] == numbers


@pytest.mark.parametrize("text", [
    "0.25<!--=a.b--> px", "8 neurons, 640x480, 2**-3 s, 2^-3 s, version 0.2", "    62.5 MHz",
    "```\n62.5 MHz\n```", f"{PAST}: 62.5 MHz", "Measured\nwith version\n0.1, 2026-11-22: 7 px",
    f"{PAST}:\n\n{MEASURED}", f"{PAST}:\n\n- 5 px\n- 6 px",
    "<!--rows=a | {size:d} | {mhz:.1f} |-->\n\n" + MEASURED,
    "| at 7 MHz | lines |\n|---|---|\n| a | 5 |",
    f"## A\n\nThis section was {PAST.lower()}.\n\n7 px\n\n{MEASURED}"])
def test_what_is_accounted_for_is_accepted(text):
    assert unnamed(text) == []


def test_the_line_of_a_number_is_its_own():
    text = "# A\n\ntext\n5 px,\n6 px\n\n" + MEASURED
    assert unnamed(text) == [(4, "5 px"), (5, "6 px"), (9, "62.5 MHz")]


def test_digits_that_count_are_written_without_an_exponent():
    form = "<!--rows=bench.rows | {name} | {mhz:.3r} |-->\n\n| name | MSE |\n|---|---|\n"
    rows = {name: {"name": name, "mhz": value} for name, value in (
        ("a", 0.00012345), ("b", 9.996), ("c", 123.4), ("d", None))}
    assert rewrite(form + "| a | 1 |\n", {"bench": {"rows": rows}}).splitlines()[-4:] == [
        "| a | 0.000123 |", "| b | 10.0 |", "| c | 123 |", "| d | - |"]


@pytest.fixture
def checkout(tmp_path):
    """A copy of the pages, without figures, and a report."""
    (tmp_path / "docs").mkdir()
    for name in ("README.md", "CONTRIBUTING.md"):
        (tmp_path / name).write_text("No figure.\n")
    (tmp_path / "docs" / "page.md").write_text("Even: 1.00<!--=grid.scene_skip_2.fast_even--> dB\n")
    rows = [{"picture": "scene", "sampling": "skip 2", "interpolation": way, "grid": grid,
             "psnr_db": 30.126, "gain_db": -1.5} for way in ("fast", "gradient")
            for grid in ("even", "uneven")]
    (tmp_path / "grid.json").write_text(json.dumps({"blur_px": 1.0, "rows": rows}))
    return tmp_path


def test_reports_are_stored_as_far_as_they_are_quoted(checkout):
    page, = store(checkout, [checkout / "grid.json"])
    assert page.read_text() == "Even: 30.13<!--=grid.scene_skip_2.fast_even--> dB\n"
    group, = json.loads((checkout / STORE).read_text()).values()
    assert group["figures"] == {"scene_skip_2": {"fast_even": 30.126}}
    assert group["command"] .startswith("ncdc bench grid") and group["date"] and group["version"]
    assert store(checkout, []) == []
    page.write_text("No figure either.\n")
    store(checkout, [])
    assert json.loads((checkout / STORE).read_text()) == {}


def test_reports_of_one_bench_are_joined(checkout):
    (checkout / "docs" / "page.md").write_text(
        "<!--rows=tansig_size | {variant} | {bits:d} |-->\n\n| variant | P |\n|---|---|\n"
        "| none | 0 |\n")
    names = ("max_ulp", "bound_ulp", "latency", "adders", "table_bits", "multipliers", "mse",
             "mse_ideal", "correctly_rounded", "stages", "differences", "alm", "alm_ff", "dsp",
             "m10k")
    for bits in (16, 18):
        row = dict.fromkeys(names, 1) | {"variant": "table", "fraction_bits": bits,
                                         "exhaustive": False}
        (checkout / f"{bits}.json").write_text(json.dumps({"rows": [row]}))
    page, = store(checkout, [checkout / "16.json", checkout / "18.json"])
    assert page.read_text().endswith("|---|---|\n| table | 16 |\n| table | 18 |\n")
    assert set(json.loads((checkout / STORE).read_text())) == {"tansig_size"}


def test_reports_without_rows_are_rows(checkout):
    (checkout / "docs" / "page.md").write_text(
        "<!--rows=evaluate | {neurons:d} | {max:.1f} |-->\n\n| HN | max |\n|---|---|\n| 0 | 0 |\n")
    for neurons in (4, 8):
        errors = {"mse": 1.0, "max": neurons / 2}
        (checkout / f"{neurons}.json").write_text(json.dumps(
            {"hidden_neurons": neurons, "measured_on": "camera", "map_error_fixed_px": errors}))
    page, = store(checkout, [checkout / "8.json", checkout / "4.json"])
    assert page.read_text().endswith("|---|---|\n| 8 | 4.0 |\n| 4 | 2.0 |\n")


def test_a_later_report_changes_the_pages(checkout):
    store(checkout, [checkout / "grid.json"])
    report = (checkout / "grid.json").read_text().replace("30.126", "29.004")
    (checkout / "grid.json").write_text(report)
    page, = store(checkout, [checkout / "grid.json"])
    assert page.read_text().startswith("Even: 29.00<!--")


@pytest.mark.parametrize("text,message", [
    (None, "result.json: No such file or directory"), ("{", "result.json is not JSON"),
    ("[]", "result.json is not a report of demo, train"),
    ('{"rows": []}', "result.json is not a report of demo, train"),
    ('{"blur_px": 1, "rows": [{"picture": "a"}]}',
     "the report of ncdc bench grid tests/data/dots/dot_pattern_06.jpg has no 'sampling'"),
    ('{"rows": [{"max_ulp": 1, "bound_ulp": 2, "exhaustive": false}]}',
     "result.json was not made by ncdc bench tansig --no-synth")])
def test_a_bad_result_changes_nothing(text, message, checkout, monkeypatch, capsys):
    if text is not None:
        (checkout / "result.json").write_text(text)
    monkeypatch.chdir(checkout)
    store(checkout, ["grid.json"])
    before = [(checkout / path).read_text() for path in (STORE, "docs/page.md")]
    (checkout / "grid.json").write_text((checkout / "grid.json").read_text().replace("30", "31"))
    monkeypatch.setattr("ncdc_bench.figures.quote.ROOT", checkout)
    assert main(["grid.json", "result.json"]) == 2
    assert capsys.readouterr().err.startswith(f"quote: {message}")
    assert [(checkout / path).read_text() for path in (STORE, "docs/page.md")] == before


def test_a_page_with_a_wrong_quote_is_named(checkout):
    with pytest.raises(InputError, match=r"docs/page.md:1: no figure is named grid.scene"):
        store(checkout, [])
    assert not (checkout / STORE).exists()

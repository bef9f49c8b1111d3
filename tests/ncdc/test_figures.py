"""Figures that pages quote by name are those of ``docs/figures.json``."""

import json
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
from ncdc_spec.errors import InputError

ROOT = Path(__file__).resolve().parents[2]
REMEDY = "run python -m ncdc_bench.figures.quote, and look at git diff"
# Pages whose numbers have no names yet.
UNNAMED = {"docs/explanation/interpolation.md"}
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
    assert all(group["command"].startswith("ncdc ") and group["date"] and group["version"]
               for group in groups.values())


@pytest.mark.parametrize("page", [path for path in pages(ROOT)
                                  if str(path.relative_to(ROOT)) not in UNNAMED],
                         ids=lambda path: str(path.relative_to(ROOT)))
def test_no_page_copies_a_figure_without_its_name(page, quoted):
    shown = {text for found in quoted.values() for quote in found if not quote.fields
             for text in quote.shown}
    assert copies(page.read_text(), quoted[str(page.relative_to(ROOT))], shown) == []


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


def test_a_later_report_changes_the_pages(checkout):
    store(checkout, [checkout / "grid.json"])
    report = (checkout / "grid.json").read_text().replace("30.126", "29.004")
    (checkout / "grid.json").write_text(report)
    page, = store(checkout, [checkout / "grid.json"])
    assert page.read_text().startswith("Even: 29.00<!--")


@pytest.mark.parametrize("text,message", [
    (None, "result.json: No such file or directory"), ("{", "result.json is not JSON"),
    ("[]", "result.json is not a report of demo, train, simulate"),
    ('{"rows": []}', "result.json is not a report of demo, train, simulate"),
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

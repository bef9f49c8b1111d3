"""``ncdc lot report``, ``show`` and ``compare`` on a lot whose figures are known."""

import html
import json
import re
import sqlite3
import subprocess
import sys
from contextlib import closing

import numpy as np
import pytest
from sqlalchemy import insert

from lots import begun, driven, outcome
from ncdc.cli import main
from ncdc.lot.schema import UNITS
from ncdc.lot.units import Unit
from ncdc.lot.work import Outcome
from ncdc.report.lot import capability, control_limits

_COUNT = 40


def answer(serial, number, shift=0.0):
    """Good figures with some spread; one unit far out, one beyond a limit, one without a network,
    one to look at."""
    rng = np.random.default_rng(int(serial[1:]))
    one = outcome(focal_px=171 + shift + rng.normal(0, .5), max_error_px=.2 + rng.normal(0, .01),
                  roll_deg=rng.normal(0, .3))
    one.figures |= {"U7": {"focal_px": 190.0}, "U8": {"max_error_px": .7}}.get(serial, {})
    one.warnings = ["0.png: </script> is noisy"] if serial == "U9" else []
    return Outcome(error="no photo shows the target") if serial == "U10" else one


@pytest.fixture(scope="module")
def lots(tmp_path_factory):
    """Folder with the lots ``march`` and ``april``, whose lenses are 2 px longer."""
    folder = tmp_path_factory.mktemp("lots")
    for name, shift in (("march", 0.0), ("april", 2.0)):
        (folder / name).mkdir()
        database = begun(folder / name, _COUNT)
        assert len(driven(database, lambda *tag: answer(*tag, shift))[0]) == _COUNT
        database.close()
    return folder


@pytest.fixture
def here(lots, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "march").symlink_to(lots / "march")
    (tmp_path / "april").symlink_to(lots / "april")
    return tmp_path


def test_a_page_has_yield_outliers_and_every_unit(here, capsys):
    assert main(["lot", "report", "march", "-o", "lot.html", "--parquet", "lot.parquet",
                 "--json", "-"]) == 0
    report, page = json.loads(capsys.readouterr().out), (here / "lot.html").read_text()
    assert [report[name] for name in ("units", "pass", "look", "fail")] == [40, 37, 1, 2]
    assert "37 pass (92.5 %), 1 look (2.5 %), 2 fail (5.0 %)." in page
    [text] = re.findall(r'<script type="application/json" id="rows">(.*?)</script>', page,
                        re.DOTALL)
    rows = json.loads(text)
    assert [row[0] for row in rows] == [f"U{k}" for k in range(1, _COUNT + 1)]
    assert rows[8][-1] == ["0.png: </script> is noisy"]
    low, middle, high = report["control_limits"]["focal_px"]
    assert 169 < low < 170.5 < middle < 171.5 < high < 173
    cards = re.search("<h2>Outliers</h2>(.*?)<h2>Worst ten", page, re.DOTALL)[1]
    assert "focal length 190.0 ± 0.1 px, 1" in cards and "px is usual" in cards
    assert "<b>U7</b>" in cards and "<b>U8</b>" in cards and "data:image/jpeg;base64" in cards
    assert re.search("<h2>Worst ten</h2>.*?<b>(U[0-9]+)</b>", page, re.DOTALL)[1] == "U8"
    for cause in ("no network", "largest error of the map", "warning"):
        assert f"<td>{cause}</td>" in page
    from pyarrow import parquet
    table = parquet.read_table(here / "lot.parquet")
    assert table.num_rows == _COUNT and table["focal_px"][6].as_py() == 190.0
    assert table["focal_px_error"][6].as_py() == .1 and table["numpy"][6].as_py() == np.__version__
    assert table["reasons"][9].as_py() == ["no photo shows the target"]


def test_control_limits_do_not_widen_for_bad_units():
    rng = np.random.default_rng(1)
    values = rng.normal(5, 1, 10000)
    values[:500] = 1000
    low, middle, high = control_limits(values)
    assert abs(middle - 5) < .1 and abs(low - 2) < .3 and abs(high - 8) < .4
    assert np.isnan(control_limits(np.array([np.nan]))).all()


def test_a_magnitude_has_an_upper_control_limit_only():
    """Of two normal parts, 99.5 % or more of the units are within it."""
    rng = np.random.default_rng(1)
    values = np.hypot(*rng.normal(0, 1, (2, 20000)))
    low, middle, high = control_limits(values, magnitude=True)
    assert low == -np.inf and abs(middle - 1.177) < .02
    assert .995 < (values < high).mean() < .999
    assert np.isnan(control_limits(np.array([np.nan]), True)).all()


def test_capability_is_that_of_the_units_and_of_the_units_without_the_error():
    rng = np.random.default_rng(1)
    true, error = rng.normal(10, .3, 50000), .4
    values = true + rng.normal(0, error, len(true))
    found = capability(values, np.full(len(true), error), 7.0, 11.5)
    assert np.isclose(found["sigma"], .5, rtol=.01) and np.isclose(found["error"], error)
    assert np.isclose(found["cp"], 4.5 / 3.0, rtol=.01)
    assert np.isclose(found["cpk"], 1.5 / 1.5, rtol=.02)
    assert np.isclose(found["cp_without_error"], 4.5 / 1.8, rtol=.02)
    assert np.isclose(found["cpk_without_error"], 1.5 / .9, rtol=.02)
    one_sided = capability(values, np.full(len(true), np.nan), None, 11.5)
    assert one_sided["cp"] is one_sided["cpk_without_error"] is one_sided["error"] is None
    assert np.isclose(one_sided["cpk"], found["cpk"])
    assert capability(values, np.full(len(true), 2.0), 7.0, 11.5)["cpk_without_error"] is None
    assert capability(values, values, None, None) == capability(values[:1], values[:1], 0, 1) == {}


def test_a_page_has_the_capability_of_limits(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr("ncdc.report.lot.embedded_plot", lambda *_: "")     # seconds each
    database = begun(tmp_path, 20, max_tilt=2.0, min_focal=165.0, max_focal=180.0)
    driven(database, answer)
    database.close()
    assert main(["lot", "report", str(tmp_path), "-o", str(tmp_path / "lot.html"),
                 "--json", "-"]) == 0
    able = json.loads(capsys.readouterr().out)["capability"]
    assert able["focal_px"]["cp"] > .3 and able["focal_px"]["error"] == pytest.approx(.1)
    assert able["tilt_deg"]["cp"] is None and able["tilt_deg"]["cpk"] is None     # no spread
    assert "roll_deg" not in able
    page = (tmp_path / "lot.html").read_text()
    [table] = re.findall("<h2>Capability</h2>.*?</table>", page, re.DOTALL)
    assert "<td>focal length</td>" in table and "<td>roll</td>" not in table
    assert "up to 0." in page                                   # control limit of a magnitude


NAMES = r"$\alpha^$", "cell $5 for $6", "_hidden", "第二工位", "محطة", "<b>one</b>", "a & b", "🏭 3"


@pytest.mark.longer
def test_names_of_stations_are_plain_text_in_any_script(tmp_path):
    """In a process of its own: Matplotlib prints what fonts lack on stderr."""
    database = begun(tmp_path, 0)
    database.add([Unit(f"U{k}", (), name) for k, name in enumerate(NAMES)], "bench")
    driven(database, answer)
    database.close()
    done = subprocess.run([sys.executable, "-W", "error::UserWarning", "-m", "ncdc", "lot",
                           "report", "."], cwd=tmp_path, capture_output=True, text=True)
    assert (done.returncode, done.stderr) == (0, "")
    page = (tmp_path / "lot.html").read_text()
    trend = re.search("<h2>Trend</h2>(.*?)<h2>", page, re.DOTALL)[1]
    shown = [html.unescape(name) for name in re.findall(r"&#9679;</span> (.*?)</span>", trend)]
    assert shown == list(NAMES)
    assert len(set(re.findall(r'style="color: (#\w+)"', trend))) == len(NAMES)


@pytest.mark.parametrize("arguments", [
    "report march -o march/lot.db", "report march --parquet march/lot.db",
    "show march U1 --json march/lot.db", "compare april march --json march/lot.db",
    "export march --json march/lot.db"])
def test_no_output_replaces_the_database(here, capsys, arguments):
    before = (here / "march/lot.db").read_bytes()
    assert main(["lot", *arguments.split()]) == 2
    assert "march/lot.db would replace the input march/lot.db" in capsys.readouterr().err
    assert (here / "march/lot.db").read_bytes() == before


def test_a_damaged_database_is_one_sentence(here, lots, capsys):
    content = bytearray((lots / "april/lot.db").read_bytes())
    with closing(sqlite3.connect(lots / "april/lot.db")) as opened:
        [size] = opened.execute("PRAGMA page_size").fetchone()
        [page] = opened.execute("SELECT rootpage FROM sqlite_master "
                                "WHERE name = 'units'").fetchone()
    content[(page - 1) * size:page * size] = bytes(size)
    (here / "damaged").mkdir()
    (here / "damaged/lot.db").write_bytes(content)
    assert main("lot show damaged U1".split()) == 2
    said = capsys.readouterr().err
    assert said == "ncdc lot: the database failed: database disk image is malformed\n"


def test_a_unit_is_shown_with_its_files(here, capsys):
    assert main(["lot", "show", "march", "U8", "-o", "unit"]) == 0
    said = capsys.readouterr().out
    assert said.startswith("U8: fail\n  largest error of the map: 0.700 px, the maximum is 0.5 px")
    assert "/photos/8.png  sha256 0000" in said and "unit/net.toml" in said
    assert re.search(r"^focal length  .* ± 0\.1 px$", said, re.MULTILINE)
    assert re.search(rf"^NumPy  .* {np.__version__}$", said, re.MULTILINE)
    assert (here / "unit/net.toml").read_text() == "version = 1\n"
    assert (here / "unit/picture.jpg").read_bytes() == b"jpeg"
    assert main(["lot", "show", "march", "U10", "-o", "none"]) == 2
    assert "neither a descriptor nor a picture" in capsys.readouterr().err
    assert main(["lot", "show", "march", "U99"]) == 2
    assert "the lot has no unit U99" in capsys.readouterr().err


def test_two_lots_are_compared(here, capsys):
    assert main(["lot", "compare", "march", "april", "--json", "-"]) == 0
    report = json.loads(capsys.readouterr().out)
    shifts = {row["what"]: row.get("shift") for row in report["rows"]}
    # Of the spread with the outlier in it.
    assert .5 < float(shifts["focal length"]) < 4
    assert shifts["largest error of the map"] == "+0.0"
    assert report["units_in_both"] == _COUNT and report["units_differ"] == []
    assert main(["lot", "compare", "march", "april"]) == 0
    assert "40 units are in both, 0 of them with another verdict" in capsys.readouterr().out


MEASURED = """
import resource, sys, time
from ncdc.cli import main
status = main(["lot", "report", ".", "-o", "lot.html", "--parquet", "lot.parquet"])
print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss, time.process_time())
sys.exit(status)
"""


@pytest.mark.regress
def test_a_report_of_100000_units_is_bounded(tmp_path):
    """A minute of a processor, and 400 MB: the rows are not all in memory."""
    count, database = 100_000, begun(tmp_path, 1)
    driven(database, lambda *tag: outcome())
    row = {name: value for name, value in database.unit("U1").items() if name != "tries"}
    row |= {name: json.dumps(row[name]) for name in ("photos", "photo_hashes", "reasons")}
    noise = np.random.default_rng(1).normal(0, 1, count)
    with database.engine.begin() as connection:
        for first in range(2, count + 1, 10_000):
            connection.execute(insert(UNITS), [
                row | {"serial": f"U{k}", "number": k, "focal_px": 171 + noise[k - 1]}
                for k in range(first, min(first + 10_000, count + 1))])
    database.close()
    done = subprocess.run([sys.executable, "-c", MEASURED], cwd=tmp_path, check=True, text=True,
                          stdout=subprocess.PIPE)
    kilobytes, seconds = map(float, done.stdout.split()[-2:])
    print(f"{kilobytes / 1024:.0f} MB, {seconds:.1f} s")
    assert kilobytes < 400 * 1024 and seconds < 60


def test_a_lot_without_a_network_has_a_report(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    database = begun(tmp_path, 2)
    driven(database, lambda *tag: Outcome(error="no photo shows the target"))
    database.close()
    assert main(["lot", "report", ".", "--json", "-"]) == 0
    report = json.loads(capsys.readouterr().out, parse_constant=pytest.fail)
    assert report["fail"] == 2 and report["control_limits"]["focal_px"] == [None, None, None]


def test_a_lot_without_a_verdict_has_no_report(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    begun(tmp_path).close()
    assert main(["lot", "report", "."]) == 2
    assert "has no unit that was judged" in capsys.readouterr().err
    assert not (tmp_path / "lot.html").exists()

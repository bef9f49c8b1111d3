"""``ncdc lot``: which units there are, limits and verdicts, resuming, deaths of workers."""

import json
import re
import shutil
import time
import zipfile
from contextlib import closing, contextmanager
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest

from cameras import barrel_descriptor
from lots import GOOD, Scripted, begun, driven, outcome, together
from ncdc.cli import main
from ncdc.cli.lot_run import database_at
from ncdc.lot.arrivals import Arrivals
from ncdc.lot.database import INTERRUPTED, Database
from ncdc.lot.figures import FIGURES, LIMITS, judge
from ncdc.lot.identity import IDENTITY, differences, identity
from ncdc.lot.run import SchedulerLost
from ncdc.lot.units import Unit, find_units, local_photos
from ncdc.lot.work import Request, process
from ncdc.station.server import StationPage
from ncdc_bench.lot.units import make_unit, write_photos
from ncdc_model.calibration.detect import detect_points
from ncdc_model.images import read_image
from ncdc_model.training.pipeline import train_camera
from ncdc_model.training.source import load_source
from ncdc_spec.eeprom import unpack
from ncdc_spec.errors import InputError

ROOT = Path(__file__).resolve().parents[2]


def touched(folder, *names):
    for name in names:
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_bytes(name.encode())


@pytest.fixture
def photos(tmp_path):
    """A folder of three units, the last one without photos."""
    touched(tmp_path / "units", "U10/2.png", "U10/10.png", "U10/note.txt", "U9/a.png",
            "U9/points.overlay.png", ".trash/a.png", "notes.txt")
    (tmp_path / "units" / "empty").mkdir()
    return tmp_path / "units"


def names(units):
    return {unit.serial: [photo.rpartition("/")[2] for photo in unit.photos] for unit in units}


def test_units_are_folders(photos):
    units = find_units(str(photos))
    assert names(units) == {"empty": [], "U9": ["a.png"], "U10": ["2.png", "10.png"]}
    assert [unit.serial for unit in units] == ["empty", "U9", "U10"]


def test_units_are_in_an_archive(photos, tmp_path):
    archive = shutil.make_archive(str(tmp_path / "lot"), "zip", photos)
    units = find_units(f"zip://::{archive}")
    assert [unit.serial for unit in units if unit.photos] == ["U9", "U10"]
    with local_photos(units[-1].photos) as paths:
        assert [open(path).read() for path in paths] == ["U10/2.png", "U10/10.png"]


def test_units_are_in_a_csv(photos, tmp_path):
    table = tmp_path / "lot.csv"
    table.write_text("unit,photo,station\nA,units/U9/a.png,S1\nB,units/U10/2.png,S2\n"
                     f"A,{photos}/U10/10.png,S1\n")
    first, second = find_units(str(table))
    assert (first.serial, first.station, second.station) == ("A", "S1", "S2")
    assert [open(path).read() for path in first.photos] == ["U9/a.png", "U10/10.png"]


@pytest.mark.parametrize("text,message", [
    ("serial,photo\nA,a.png\n", "has the columns serial, photo; unit, photo and"),
    ("unit,photo\nA,\n", "line 2 lacks a unit or a photo"),
    ("unit,photo\nA,a,b\n", "line 2 .* more cells than the first line"),
    ("unit,photo\nA,a.png\nB,a.png\nA,a.png\n", "line 4 has a photo of the unit A again, .*/a.png"),
    ("unit,photo\n", "has no unit"),
    ("unit,photo\na/b,a.png\n", "'a/b' has a serial number that is no name"),
    ("unit,photo\n" + "A" * 33 + ",a.png\n", "up to 32 letters"),
    ("unit,photo,station\nA,a," + 64 * "S" + "\n", "the station of the unit A has 64 characters"),
    ("unit,photo,station\nA,a,S\x1b[2J\n", r"the station of the unit A is 'S\\x1b\[2J', which has"),
    ("unit,photo,station\nA,a,S1\nA,b,S2\n", "line 3 has the station 'S2' for the unit A"),
    ("\xff", "cannot read")])
def test_a_bad_csv_is_rejected(tmp_path, text, message):
    (tmp_path / "lot.csv").write_bytes(text.encode("latin-1"))
    with pytest.raises(InputError, match=message):
        find_units(str(tmp_path / "lot.csv"))


@pytest.mark.parametrize("source,message", [
    ("nothing", "there is no such folder"), ("nothing.csv", "No such file"),
    ("nonsense://lot", "cannot read nonsense://lot"), ("zip://::nothing.zip", "cannot read")])
def test_a_source_that_is_not_there_is_rejected(tmp_path, monkeypatch, source, message):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(InputError, match=message):
        find_units(source)


def test_an_archive_without_a_photo_is_an_error_of_the_unit(tmp_path):
    with zipfile.ZipFile(tmp_path / "lot.zip", "w") as archive:
        archive.writestr("A/a.png", b"no picture")
    done = process([f"zip://A/b.png::{tmp_path}/lot.zip"], Request())
    assert "cannot read zip://A/b.png" in done.error
    assert "a.png" in process([f"zip://A/a.png::{tmp_path}/lot.zip"], Request()).error
    assert process([], Request()).error == "the unit has no photo"


@pytest.mark.parametrize("name,value,option,limit", [
    (figure.name, figure.middle + 2 * (GOOD[figure.name] or 1) * sign, option,
     1.5 * (abs(GOOD[figure.name]) or 1))
    for figure in FIGURES for option, sign in ((figure.high, 1), (figure.high, -1)) if option] + [
    (figure.name, GOOD[figure.name] / 2, figure.low, .75 * GOOD[figure.name])
    for figure in FIGURES if figure.low])
def test_each_limit_fails_a_unit_with_its_reason(name, value, option, limit):
    limits = {limit: None for limit in LIMITS} | {option: limit}
    title = next(figure.title for figure in FIGURES if figure.name == name)
    assert judge(GOOD, [], "", limits) == ("pass", "", [])
    verdict, cause, [reason] = judge(GOOD | {name: value}, [], "", limits)
    assert (verdict, cause) == ("fail", title)
    assert reason.startswith(f"{title}: ") and f"imum is {limit:g}" in reason


def test_a_warning_asks_for_a_look_and_no_network_fails():
    assert judge(GOOD, ["noise"], "", LIMITS) == ("look", "warning", ["noise"])
    assert judge({}, [], "no target", LIMITS) == ("fail", "no network", ["no target"])
    assert judge(GOOD | {"max_error_px": float("nan")}, [], "", LIMITS)[0] == "fail"


@pytest.mark.parametrize("value,error,verdict,words", [
    (1.8, .05, "pass", ""),
    (1.8, .3, "look", "tilt of the sensor: 1.80 ± 0.30°, the maximum is 2°: not decided"),
    (2.2, .3, "look", "2.20 ± 0.30°, the maximum is 2°: not decided"),
    (2.2, .05, "fail", "tilt of the sensor: 2.20 ± 0.05°, the maximum is 2°"),
    (0.0, .9, "pass", ""), (0.0, 1.1, "look", "0.00 ± 1.10°, the maximum is 2°: not decided"),
    (0.5, None, "look", "0.50°, which the photos do not determine; the maximum is 2°"),
    (9.0, float("nan"), "look", "9.00°, which the photos do not determine"),
    (None, None, "look", "tilt of the sensor: -, which the photos do not determine")])
def test_a_limit_is_decided_by_value_and_error(value, error, verdict, words):
    """Within the limit, or beyond it, by two standard errors; otherwise a person decides."""
    figures = GOOD | {"tilt_deg": value, "tilt_deg_error": error}
    found, cause, reasons = judge(figures, [], "", LIMITS | {"max_tilt": 2.0})
    assert found == verdict and words in " ".join(reasons)
    assert cause == ("" if verdict == "pass" else "tilt of the sensor")
    assert judge(figures, [], "", LIMITS)[0] == "pass"


@pytest.mark.parametrize("figure,verdicts", [
    ("focal_px", {168.9: "fail", 169.9: "look", 170.1: "look", 170.5: "pass", 172: "pass",
                  174.9: "look", 175.3: "fail"}),
    ("roll_deg", {-1.1: "fail", -1.01: "look", -.5: "pass", .99: "look", 1.1: "fail"}),
    ("aspect", {.98: "fail", .9895: "look", .999: "pass", 1.0105: "look", 1.02: "fail"})])
def test_limits_on_both_sides_are_decided_by_value_and_error(figure, verdicts):
    limits = LIMITS | {"min_focal": 170.0, "max_focal": 175.0, "max_roll": 1.0, "max_aspect": .01}
    errors = {"focal_px_error": .1, "roll_deg_error": .03, "aspect_error": .001}
    for value, verdict in verdicts.items():
        assert judge(GOOD | errors | {figure: value}, [], "", limits)[0] == verdict, value


def test_a_look_is_not_a_fail_and_a_fail_comes_first():
    limits = LIMITS | {"max_tilt": 2.0}
    undecided = GOOD | {"tilt_deg": 1.9}
    assert judge(undecided, ["noise"], "", limits)[:2] == ("look", "tilt of the sensor")
    verdict, cause, reasons = judge(undecided | {"max_error_px": .7}, ["noise"], "", limits)
    assert (verdict, cause) == ("fail", "largest error of the map")
    assert [reason.split(":")[0] for reason in reasons] == [
        "largest error of the map", "tilt of the sensor", "noise"]


def test_a_unit_is_judged_by_the_code_that_is_named(tmp_path, monkeypatch):
    """The digest is that of the content of all modules, however their lines end."""
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setattr("ncdc.lot.identity._PACKAGES", ["judging"])
    (tmp_path / "judging/part").mkdir(parents=True)
    (tmp_path / "judging/__init__.py").touch()
    found = []
    for content in (b"a = 1\n", b"a = 1\r\n", b"a = 42\n"):
        (tmp_path / "judging/part/roll.py").write_bytes(content)
        found.append(identity.__wrapped__())
    (tmp_path / "judging/part/roll.py").rename(tmp_path / "judging/part/tilt.py")
    found.append(identity.__wrapped__())
    assert found[0] == found[1]
    assert len({one["code"] for one in found}) == 3 and found[0].keys() == IDENTITY.keys()
    text = differences(found[2] | {"numpy": "1.0"}, found[0])
    assert text == (f"code of NCDC {found[2]['code']}, here {found[0]['code']}, NumPy 1.0, here "
                    f"{np.__version__}")
    assert differences(found[1], found[0]) == ""


def test_what_was_hashed_is_what_is_measured(tmp_path, monkeypatch):
    write_photos(tmp_path, make_unit(3))
    path = tmp_path / "U0003" / "0.png"

    def late(*_):
        path.write_bytes((tmp_path / "U0003" / "1.png").read_bytes())
        return b""
    monkeypatch.setattr("ncdc.lot.work._first_picture", late)
    done = process([str(path)], Request("dots"))
    assert "0.png has changed since the work on the unit began" in done.error


def test_a_resumed_lot_loses_nothing_and_repeats_nothing(tmp_path):
    seen = []

    def answer(serial, number):
        seen.append(serial)
        if len(seen) in (3, 5):
            raise SchedulerLost
        return outcome()
    database, runs = begun(tmp_path), []
    while database.counts()["pass"] < 6:
        runs.append(driven(database, answer))
        database.close()
        database = begun(tmp_path)
    assert [lost for _, lost in runs] == [True, True, False]
    judged = [one.serial for done, _ in runs for one in done]
    assert judged == ["U1", "U2", "U3", "U4", "U5", "U6"]
    assert [database.unit(f"U{k}")["tries"] for k in range(1, 7)] == [1, 1, 2, 3, 2, 1]
    assert driven(database, answer) == ([], False)


def test_a_killed_driver_leaves_its_units_waiting(tmp_path):
    """Its tries have no end: the next run of its station ends them, not that of another one."""
    database = begun(tmp_path)
    database.start("U2", "bench")
    assert len(driven(database, lambda *tag: outcome())[0]) == 5
    begun(tmp_path, station="other")
    assert driven(database, lambda *tag: outcome())[0] == []
    begun(tmp_path, station="bench")
    assert [one.serial for one in driven(database, lambda *tag: outcome())[0]] == ["U2"]


def test_a_unit_that_ends_its_worker_fails_alone(tmp_path):
    database = begun(tmp_path)
    done, _ = driven(database, lambda serial, number: None if serial == "U3" else outcome(), 3)
    verdicts = {one.serial: one.verdict for one in done}
    assert verdicts == {f"U{k}": "fail" if k == 3 else "pass" for k in range(1, 7)}
    assert "ended its worker 3 times" in database.unit("U3")["reasons"][0]
    assert database.unit("U3")["tries"] == 4 and database.unit("U4")["tries"] == 2


def test_two_stations_share_a_lot(tmp_path):
    """Each works on what the other one has not; the slower one's list is out of date."""
    one, other = begun(tmp_path, 8), begun(tmp_path, 8, station="other")
    seen = []

    def answer(serial, number):
        if not seen:
            seen.append("other")
            seen.extend(done.serial for done in driven(other, lambda *tag: outcome())[0])
        seen.append(serial)
        return outcome()
    mine, lost = driven(one, answer)
    assert not lost and [done.serial for done in mine] == ["U1", "U2"]
    assert seen == ["other", "U3", "U4", "U5", "U6", "U7", "U8", "U1", "U2"]
    assert one.counts()["pass"] == 8 and one.unit("U5")["tries"] == 1


def test_stations_may_begin_a_new_lot_at_once(tmp_path):
    databases = together(lambda number: begun(tmp_path, station=f"station {number}"), 6)
    assert [database.counts()["units"] for database in databases] == [6] * 6

    def arriving(number):
        time.sleep(.02)
        yield Unit(f"V{number}", ())
    together(lambda number: databases[number].add(arriving(number), f"station {number}"), 6)
    assert databases[0].counts()["units"] == 12
    tries = [database.start("U1", f"station {k}") for k, database in enumerate(databases)]
    assert tries == [1, *[None] * 5]


def test_a_verdict_never_changes(tmp_path):
    database = begun(tmp_path, 1)
    first = database.start("U1", "bench")
    assert database.start("U1", "other") is None
    database.end("U1", first, INTERRUPTED)
    second = database.start("U1", "other")
    assert database.save("U1", second, outcome(), ("pass", "", []), 0)
    assert not database.save("U1", first, outcome(), ("fail", "", ["late"]), 0)
    row = database.unit("U1")
    assert (row["verdict"], row["tries"]) == ("pass", 2)
    assert len(row["photo_hashes"][0]) == 64 and row["judged"]
    assert {name: row[name] for name in IDENTITY} == identity()
    assert database.descriptor("U1") == "version = 1\n" and database.picture("U1") == b"jpeg"


def test_a_unit_that_waits_gets_the_photos_that_it_has_now(tmp_path):
    database = begun(tmp_path, 3, "mine")
    options = json.loads(database.fact("request"))
    number = database.start("U1", "mine")
    database.save("U1", number, outcome(), ("pass", "", []), 0)
    later = [Unit(f"U{k}", ("/later.png", "/more.png")) for k in range(1, 4)]
    database.begin(options, later[:2], "mine")
    database.begin(options, later, "other")
    photos = [database.unit(f"U{k}")["photos"] for k in range(1, 4)]
    assert photos == [["/photos/1.png"], ["/later.png", "/more.png"], ["/photos/3.png"]]


def test_a_folder_of_a_lot_may_have_any_name(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    database_at("lot?a=1#%", create=True).close()
    assert [path.name for path in tmp_path.rglob("*.db")] == ["lot.db"]
    assert (tmp_path / "lot?a=1#%" / "lot.db").is_file()


def test_a_password_is_not_shown():
    with pytest.raises(InputError) as error:
        Database("postgresql+psycopg://me:secret@127.0.0.1:1/lot")
    assert "me:***@127.0.0.1" in str(error.value) and "secret" not in str(error.value)


def test_other_options_are_rejected(tmp_path):
    database = begun(tmp_path)
    with pytest.raises(InputError, match="begun with seed 0, this run has None"):
        options = json.loads(database.fact("request"))
        database.begin({name: options[name] for name in options if name != "seed"}, [], "bench")
    with pytest.raises(InputError, match="begun with seed 0, this run has 1"):
        database.begin(json.loads(database.fact("request")) | {"seed": 1}, [], "bench")


@pytest.mark.parametrize("arguments,message", [
    ("nothing", "there is no such folder"),
    ("units --max-error nan", "--max-error is nan"),
    ("units --min-coverage 101", "--min-coverage is 101 %, the maximum is 100"),
    ("units --min-focal 5 --max-focal 4", "--min-focal is 5 px, more than --max-focal"),
    ("units --workers 0", "--workers is 0, the minimum is 1"),
    ("units --timeout 0", "--timeout is 0 s, the limits are 1 and 1000000"),
    ("units --timeout nan", "--timeout is nan s"),
    ("units --station " + 64 * "a", "--station has 64 characters, the limits are 1 and 63"),
    ("units --station \x1b[2J", "--station is '\\x1b[2J', which has characters that are no text"),
    ("units --tls-ca-file ca.pem --scheduler tls://a:1", "belong together, with --scheduler tls://"),
    ("units --tls-ca-file a --tls-cert b --tls-key c", "3 of them are given, with --scheduler N"),
    ("units --scheduler tls://a:1", "--scheduler is tls://a:1, which needs --tls-ca-file"),
    ("units --max-aspect -1", "--max-aspect is -1, 0 or more is needed"),
    ("units --workers 1 --scheduler tcp://a:1", "the scheduler has its own"),
    ("units --target page", "target is 'page'"), ("units --neurons 40", "the limits are 1 and 32"),
    ("units --seed -1", "seed is -1"), ("units --zoom wide", "zoom is 'wide'"),
    ("units --size 10", "size is '10'"),
    ("units -o nonsense://lot", "cannot open the database"), ("units -o note.txt", "cannot write")])
def test_bad_input_is_one_sentence(photos, monkeypatch, capsys, arguments, message):
    monkeypatch.chdir(photos.parent)
    touched(photos.parent, "note.txt")
    before = sorted(photos.parent.rglob("*"))
    assert main(["lot", "run", *arguments.split()]) == 2
    said = capsys.readouterr().err
    assert message in said and said.count("\n") == 1, said
    assert sorted(photos.parent.rglob("*")) == before


def test_the_same_command_goes_on_where_it_was(photos, monkeypatch, capsys):
    """From the command line: the scheduler is lost, then all is judged, then nothing is left."""
    monkeypatch.chdir(photos.parent)
    answers, seen = {"U10": [SchedulerLost]}, []

    def answer(serial, number):
        seen.append(serial)
        if answers.get(serial):
            raise answers[serial].pop()
        return outcome(max_error_px=.7 if serial == "empty" else .2)

    @contextmanager
    def connect(scheduler, count, limit, tls):
        assert (scheduler, count, limit, tls) == (None, 2, 3600, None)
        yield Scripted(answer, 1)
    monkeypatch.setattr("ncdc.lot.workers.connect", connect)
    for status, resumed in ((1, 0), (0, 2), (0, 3)):
        assert main(["lot", "run", "units", "--workers", "2", "--json", "-"]) == status
        said = capsys.readouterr()
        report = json.loads(said.out)
        assert report["units"] == 3 and report["resumed"] == resumed
        assert ("the scheduler has gone after 2 of 3 units" in said.err) == bool(status)
        assert ("empty: fail: largest error of the map: 0.700 px" in said.err) == bool(status)
    assert seen == ["empty", "U9", "U10", "U10"]
    assert main(["lot", "run", "units", "--seed", "1"]) == 2
    assert "the lot was begun with seed 0, this run has 1" in capsys.readouterr().err


def test_the_commands_of_the_guide_run(tmp_path, monkeypatch, capsys):
    """Every line of ncdc, in order; the work itself is scripted."""
    monkeypatch.chdir(tmp_path)
    touched(tmp_path, *(f"{unit}/{photo}.png" for unit in (
        "units/A0017", "units/A0018", "photos/B1", "photos/B2")
        for photo in ("front", "left", "below")))
    barrel_descriptor(hidden_neurons=6).save(tmp_path / "net.toml")
    schedulers = []

    @contextmanager
    def connect(scheduler, count, limit, tls):
        schedulers.append(scheduler)
        yield Scripted(answer, 1)

    def answer(serial, number):
        if serial == "B2":
            raise KeyboardInterrupt             # the station ends while it works on this unit
        return replace(outcome(), descriptor=(tmp_path / "net.toml").read_text())
    monkeypatch.setattr("ncdc.lot.workers.connect", connect)
    guide = (ROOT / "docs" / "howto" / "production_lot.md").read_text()
    lines = re.findall(r"^    ncdc (lot .*)$", guide, re.MULTILINE)
    actions = [line.split()[1] for line in lines]
    assert actions == ["run", "watch", "report", "show", "export", "compare", "run", "run"]
    monkeypatch.setattr("ncdc.cli.lot_watch.StationPage", lambda host, port: StationPage(host, 0))
    monkeypatch.setattr("ncdc.cli.lot_watch.Arrivals",
                        lambda folder, count, settle: Arrivals(folder, count, 0))
    for line in lines:
        if "compare" in line:
            shutil.copytree("lot", "march")
            shutil.copytree("lot", "april")
        if "--scheduler" in line:
            shutil.rmtree("lot")
        assert main(line.split()) == 0, capsys.readouterr().err
    assert schedulers == [None, None, "tcp://10.0.0.5:8786", "tls://10.0.0.5:8786"]
    with closing(database_at("line")) as line:
        assert (line.counts()["units"], line.counts()["pass"]) == (2, 1)
        assert [serial for serial, *_ in line.waiting(suspects=False)] == ["B2"]
    assert unpack((tmp_path / "eeprom/A0017.bin").read_bytes()).serial == "A0017"
    assert (tmp_path / "lot.html").is_file() and (tmp_path / "A0017/net.toml").is_file()


@pytest.mark.parametrize("action", ["report", "show", "compare"])
def test_a_lot_that_is_not_there_is_rejected(tmp_path, monkeypatch, capsys, action):
    monkeypatch.chdir(tmp_path)
    more = {"report": [], "show": ["U1"], "compare": ["other"]}[action]
    assert main(["lot", action, "lot", *more]) == 2
    assert "lot holds no lot: there is no lot/lot.db" in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []


def test_the_work_is_that_of_calibrate_and_train(tmp_path):
    write_photos(tmp_path, make_unit(3))
    path = str(tmp_path / "U0003" / "0.png")
    black = str(tmp_path / "black.png")
    cv2.imwrite(black, np.zeros((300, 400), np.uint8))
    done = process([path, black], Request("dots", neurons=2, bayer="MONO"))
    assert not done.error and len(done.photo_hashes) == 2
    assert any("black.png" in text for text in done.warnings)
    detect_points([("0.png", read_image(path))], "dots").save(tmp_path / "points.json")
    source = load_source(tmp_path / "points.json", bayer="MONO")
    assert done.digest == train_camera(source, 2).descriptor.digest
    assert done.digest and done.figures["photos_used"] == 1 and done.figures["points"] > 300
    shown = cv2.imdecode(np.frombuffer(done.picture, np.uint8), cv2.IMREAD_COLOR)
    assert shown.shape == (300, 400, 3)


def test_an_error_of_the_software_fails_its_unit_alone(tmp_path, monkeypatch):
    write_photos(tmp_path, make_unit(3))
    monkeypatch.setattr("ncdc.lot.work.judged", lambda points: 1 / 0)
    monkeypatch.setattr("ncdc.lot.work.detect_points", lambda images, target: GOOD)
    done = process([str(tmp_path / "U0003" / "0.png")], Request())
    assert "the software failed: AttributeError" in done.error and done.picture


def test_a_serial_number_is_a_name():
    for serial in ("", ".hidden", "a b", "a/b", "ä"):
        with pytest.raises(InputError, match="a serial number that is no name"):
            Unit(serial, ())

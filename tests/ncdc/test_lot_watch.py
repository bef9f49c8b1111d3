"""``ncdc lot watch``: when a unit has arrived, what is judged, and what the page shows."""

import os
import re
import socket
from contextlib import closing, contextmanager, suppress
from dataclasses import replace
from types import SimpleNamespace
from urllib.error import HTTPError
from urllib.request import urlopen

import pytest

from lots import Scripted, begun, driven, outcome, together
from ncdc.cli import main
from ncdc.lot.arrivals import Arrivals
from ncdc.lot.figures import LIMITS
from ncdc.lot.run import SchedulerLost, watch_lot
from ncdc.lot.units import Unit, find_units
from ncdc.lot.work import Request
from ncdc.station.server import StationPage
from ncdc_spec.errors import InputError


class Station:
    """A folder whose units arrive, on a clock that is set by hand."""

    def __init__(self, folder, count=1):
        self.folder, self.now, self.known = folder, 0.0, set()
        self.arrivals = Arrivals(str(folder), count, 2.0, lambda: self.now)

    def after(self, seconds):
        """Serial numbers of the units that have arrived that much later."""
        self.now += seconds
        units = self.arrivals(self.known.intersection)
        self.known |= {unit.serial for unit in units}
        return [unit.serial for unit in units]

    def put(self, name, size=1):
        (self.folder / name).parent.mkdir(exist_ok=True)
        (self.folder / name).write_bytes(bytes(size))


@pytest.fixture
def station(tmp_path):
    return Station(tmp_path)


def test_a_unit_has_arrived_when_its_folder_does_not_change(station):
    station.put("U1/0.png")
    assert station.after(0) == [] and station.arrivals.waiting == {"U1": 1}
    station.put("U1/0.png", 2)                  # it grows
    assert station.after(1.9) == []
    station.put("U1/1.png.part")                # another one is being copied
    assert station.after(1.9) == []
    (station.folder / "U1/1.png.part").rename(station.folder / "U1/1.png")
    assert station.after(1.9) == []
    os.utime(station.folder / "U1/1.png", (1, 1))       # written again, in the same size
    assert station.after(1.9) == []
    assert station.after(1.9) == [] and station.arrivals.waiting == {"U1": 2}
    assert station.after(.2) == ["U1"] and station.arrivals.waiting == {}
    station.put("U1/2.png")
    assert station.after(9) == []


def test_a_unit_has_its_number_of_photos(tmp_path):
    station = Station(tmp_path, count=3)
    station.put("U1/0.png"), station.put("U1/1.png"), station.put("U1/note.txt")
    assert [station.after(9), station.after(9)] == [[], []]
    assert station.arrivals.waiting == {"U1": 2}
    station.put("U1/2.png")
    assert [station.after(1), station.after(2)] == [[], ["U1"]]


def test_a_folder_that_is_renamed_is_whole(station):
    station.put(".U1/0.png")
    assert station.after(9) == [] and station.arrivals.waiting == {}
    (station.folder / ".U1").rename(station.folder / "U1")
    assert [station.after(0), station.after(2)] == [[], ["U1"]]


def test_the_units_are_those_of_lot_run(station):
    station.put("U10/10.png"), station.put("U10/2.png"), station.put("U9/0.overlay.png")
    station.put("U9/a.png"), station.put("note.png")
    station.arrivals(station.known.intersection)
    station.now = 9.0
    assert station.arrivals(station.known.intersection) == find_units(str(station.folder))


def test_units_that_are_known_are_not_looked_at(station):
    """After a restart, and on a folder that two stations watch."""
    station.put("U1/0.png"), station.put("U2/0.png")
    station.known = {"U2"}
    assert [station.after(0), station.after(2)] == [[], ["U1"]]


def test_a_folder_that_is_no_unit_does_not_stop_the_others(station):
    station.put("<script>/0.png"), station.put("U1/0.png")
    assert [station.after(0), station.after(2)] == [[], ["U1"]]
    [sentence] = station.arrivals.problems.values()
    assert "'<script>' has a serial number that is no name" in sentence
    station.folder.rename(moved := station.folder.with_name("moved"))
    assert station.after(1) == []
    assert "No such file or directory" in station.arrivals.problems[str(station.folder)]
    moved.rename(station.folder)
    station.put("U2/0.png")
    assert [station.after(0), station.after(2)] == [[], ["U2"]]
    with pytest.raises(InputError, match="cannot read .*nothing: No such file"):
        Arrivals(str(station.folder / "nothing"))


class Slow(Scripted):
    """Workers whose answer comes at the second look."""
    looks = 0

    def finished(self, seconds=None):
        self.looks += 1
        return super().finished() if self.looks % 2 == 0 else []


def watched(database, batches, answer, kind=Scripted):
    """The units that a station judges until all ``batches`` have arrived and are judged."""
    batches = iter(batches)
    done, workers = [], kind(answer)

    def arrivals(known):
        units = next(batches, None)
        if units is None and not len(workers):
            raise KeyboardInterrupt
        return [Unit(serial, (f"/photos/{serial}.png",)) for serial in units or ()]
    with suppress(KeyboardInterrupt):
        for one in watch_lot(database, workers, Request("dots", neurons=6), LIMITS, "bench",
                             arrivals):
            done.append(one.serial)
    return done


@pytest.fixture(autouse=True)
def no_pause(monkeypatch):
    monkeypatch.setattr("ncdc.lot.run._LOOK", 0)


def test_units_are_judged_as_they_arrive(tmp_path):
    """Each once, those of other stations not at all; what waited before the start is first."""
    database = begun(tmp_path, 1)
    database.add([Unit("V1", ("/v.png",))], "other")
    batches = [[], ["U2", "U3"], [], ["U4", "U2"], ["V1"], []]
    assert watched(database, batches, lambda *tag: outcome()) == ["U1", "U2", "U3", "U4"]
    assert database.unit("V1")["verdict"] is None
    assert database.known(["U4", "V1", "U9"]) == {"U4", "V1"}
    assert watched(database, [["U1"], []], lambda *tag: pytest.fail(str(tag))) == []
    assert [database.unit(f"U{k}")["tries"] for k in range(1, 5)] == [1] * 4


def test_a_station_that_was_killed_goes_on(tmp_path):
    database = begun(tmp_path, 2)
    database.start("U1", "bench")               # then it was killed
    database = begun(tmp_path, 2)
    assert watched(database, [["U3"], []], lambda *tag: outcome()) == ["U1", "U2", "U3"]
    assert [database.unit(f"U{k}")["tries"] for k in range(1, 4)] == [2, 1, 1]


def test_a_station_that_ends_leaves_its_units_waiting(tmp_path):
    database = begun(tmp_path, 2)

    def answer(serial, number):
        raise SchedulerLost
    with pytest.raises(SchedulerLost):
        watched(database, [[], []], answer)
    assert watched(database, [[]], lambda *tag: outcome()) == ["U1", "U2"]


def test_a_unit_that_ends_its_worker_fails_alone(tmp_path):
    """Units that arrive in between go first; U2 was on the same worker."""
    database, seen = begun(tmp_path, 2), []

    def answer(serial, number):
        seen.append(serial)
        return None if serial == "U1" else outcome()
    batches = [[], ["U3"], [], [], [], [], []]
    assert sorted(watched(database, batches, answer)) == ["U1", "U2", "U3"]
    assert seen == ["U1", "U3", "U1", "U1", "U2"]


def test_a_suspect_unit_runs_alone(tmp_path):
    """What arrives while it runs waits, and is not lost with its worker."""
    database = begun(tmp_path, 1)
    batches = [[], [], ["U2"], [], [], ["U3"], [], [], [], [], []]
    done = watched(database, batches, lambda serial, _: None if serial == "U1" else outcome(),
                   Slow)
    assert sorted(done) == ["U1", "U2", "U3"]
    assert [database.unit(f"U{k}")["tries"] for k in (1, 2, 3)] == [4, 1, 1]
    assert "ended its worker 3 times" in database.unit("U1")["reasons"][0]


def test_two_stations_watch_one_folder(tmp_path):
    """At once, on one database: each unit is judged once, by the station that saw it first."""
    serials = {f"A{k}" for k in range(20)}
    for serial in serials:
        (tmp_path / "photos" / serial).mkdir(parents=True)
        (tmp_path / "photos" / serial / "0.png").touch()
    names, done = ("left", "right"), {"left": [], "right": []}

    def station(number):
        name = names[number]
        database = begun(tmp_path, 0, name)
        arrivals = Arrivals(str(tmp_path / "photos"), settle=0)

        def arrived(known):
            if database.counts()["pass"] == len(serials):
                raise KeyboardInterrupt
            return arrivals(known)[:3]
        with suppress(KeyboardInterrupt):
            for one in watch_lot(database, Scripted(lambda *tag: outcome()), Request("dots"),
                                 LIMITS, name, arrived):
                done[name].append(one.serial)
    together(station, 2)
    assert sorted(done["left"] + done["right"]) == sorted(serials)
    database = begun(tmp_path, 0)
    for name in done:
        assert {database.unit(serial)["station"] for serial in done[name]} <= {name}
    assert {database.unit(serial)["tries"] for serial in serials} == {1}


@contextmanager
def page(database, waiting=(), problems=(), station="bench"):
    """Function that gets what the page of a station has at an address."""
    with closing(StationPage("127.0.0.1", 0)) as served:
        served.start("lot", database, station, SimpleNamespace(
            waiting=dict(waiting), problems=dict(enumerate(problems))))

        def get(path=""):
            try:
                with urlopen(served.url + path, timeout=20) as answer:
                    return answer.status, answer.headers, answer.read()
            except HTTPError as error:
                with error:
                    return error.code, error.headers, error.read()
        yield get


def sign(get):
    """Verdict and serial number that the page shows large."""
    return re.search(r"<h1>(.*)</h1>\s*<h2>(.*)</h2>", get("state")[2].decode()).groups()


def test_the_page_shows_the_newest_unit(tmp_path):
    database = begun(tmp_path, 0)
    with page(database) as get:
        assert sign(get) == ("READY", "no unit yet")
        for serial, figures, word in (("A1", {}, "PASS"), ("A2", {"max_error_px": .7}, "FAIL")):
            database.add([Unit(serial, ())], "bench")
            assert sign(get) == ("WORKING", serial)
            driven(database, lambda *tag, figures=figures: outcome(**figures))
            assert sign(get) == (word, serial)
        text = get("state")[2].decode()
        assert text.count("largest error of the map: 0.700 px, the maximum is 0.5 px") == 2
        assert re.findall(r"<td>(.*?)</td>", text) == ["2", "1", "0", "1", "50.0 %"]
        assert re.findall(r'<li class="(\w+)">', text) == ["fail", "pass"]
        database.add([Unit("B1", ())], "other")
        assert sign(get) == ("FAIL", "A2")      # of another station
        assert "all stations" in get("state")[2].decode()
        assert get("picture/A2")[::2] == (200, b"jpeg")
        assert get("picture/B1")[0] == 404 and get("nothing")[0] == 404
        for name in ("station.css", "station.js"):
            assert get(name)[0] == 200


def test_names_are_text(tmp_path):
    """Of folders, of photos and of stations: the browser would run nothing else either."""
    evil, database = "<script>alert(1)</script>", begun(tmp_path, 1)
    driven(database, lambda *tag: replace(outcome(), warnings=[f"{evil}.png is noisy \udcff"]))
    with page(database, {evil: 1}, [f"the unit '{evil}'"], evil) as get:
        other = get()[2].decode()
    with page(database, {evil: 1}, [f"the unit '{evil}'"]) as get:
        status, headers, text = get()
    assert status == 200 and "default-src 'none'" in headers["Content-Security-Policy"]
    text = text.decode()
    assert evil not in text + other and text.count("<script") == 1 == other.count("<script")
    assert text.count("&lt;script&gt;alert(1)&lt;/script&gt;") == 4


def test_a_page_whose_database_fails_says_so(tmp_path, caplog):
    database = begun(tmp_path, 1)
    with page(database) as get:
        (tmp_path / "lot.db").write_bytes(b"damaged" * 1000)
        for path in ("state", "picture/U1"):
            assert get(path)[::2] == (500, b"500 the database failed: file is not a database\n")
    assert not caplog.records


def test_the_page_needs_no_other_machine():
    from importlib import resources
    files = {file.name: file.read_text() for file in resources.files("ncdc.station").iterdir()
             if file.name.endswith((".jinja", ".css", ".js"))}
    assert files.keys() == {"page.html.jinja", "state.html.jinja", "station.css", "station.js"}
    assert not re.search(r"https?:|//\w+\.\w|url\(|@import", "".join(files.values()))


@pytest.mark.parametrize("arguments,message", [
    ("nothing", "cannot read nothing: No such file or directory"),
    ("photos --photos 0", "--photos is 0, the limits are 1 and 1000"),
    ("photos --settle nan", "--settle is nan s, the limits are 0 and 3600"),
    ("photos --port 65536", "--port is 65536, the limits are 0 and 65535"),
    ("photos --port {port}", "cannot listen on 127.0.0.1, port {port}: Address already in use"),
    ("photos --host 192.0.2.1", "cannot listen on 192.0.2.1, port 8047: Cannot assign"),
    ("photos --workers 0", "--workers is 0"), ("photos -o note.txt", "cannot write note.txt")])
def test_bad_input_is_one_sentence(tmp_path, monkeypatch, capsys, arguments, message):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "photos").mkdir()
    (tmp_path / "note.txt").touch()
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        assert main(["lot", "watch", *arguments.format(port=port).split()]) == 2
    said = capsys.readouterr().err
    assert message.format(port=port) in said and said.count("\n") == 1, said
    assert sorted(path.name for path in tmp_path.iterdir()) == ["note.txt", "photos"]

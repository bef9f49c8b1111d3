"""Several views in one picture of an emulated device: each is the golden model's, in its area."""

import numpy as np
import pytest

from devices import SIZE, device, view_lens
from ncdc_host.client import open_device
from ncdc_host.client.errors import BadValue
from ncdc_model.example import noise_picture
from ncdc_model.golden.corrector import correct
from ncdc_spec.view_layout import LAYOUTS, Area, areas
from ncdc_spec.view_matrix import Angles, PlaneCamera

LENS, RAW = view_lens(), noise_picture(*SIZE)
LOOKS = (Angles(pan=10), Angles(tilt=-8, zoom=1.5), Angles(roll=30), Angles(pan=-20, zoom=2))


@pytest.fixture(params=["gige", "tcp"])
def client(request):
    with device([LENS], RAW) as one:
        port = f":{one.table.port}" if request.param == "tcp" else ""
        with open_device(f"{request.param}://{one.options.address}{port}") as opened:
            opened.emulated = one
            yield opened


def look(client, looks=LOOKS):
    for k, angles in enumerate(looks):
        client.set("ViewSelector", f"View{k}")
        for name in ("Pan", "Tilt", "Roll", "Zoom"):
            client.set(name, getattr(angles, name.lower()))


def picture(client):
    frame = client.emulated.camera.newest()
    return np.frombuffer(frame.data, np.uint8).reshape(*frame.size[::-1], 3)[..., ::-1]


def part(angles, size):
    """A view of the golden model."""
    return correct(LENS, RAW, view=PlaneCamera.of(LENS).looking(angles, size)).picture


def test_four_views(client):
    look(client)
    assert client.set("ViewLayout", "Quad") == "Quad"
    parts = [part(angles, (32, 24)) for angles in LOOKS]
    wanted = np.vstack([np.hstack(parts[:2]), np.hstack(parts[2:])])
    np.testing.assert_array_equal(picture(client), wanted)
    valid = [~correct(LENS, RAW, view=PlaneCamera.of(LENS).looking(angles, (32, 24))).blank
             for angles in LOOKS]
    sums = client.emulated.camera.newest().sums
    assert sums.pixels == np.sum(valid) < np.size(valid)
    assert sums.red == sum(int(one[seen][:, 0].sum()) for one, seen in zip(parts, valid))
    client.set("ReverseX", True)
    client.set("Width", 40)
    np.testing.assert_array_equal(picture(client), wanted[:, ::-1][:, :40])


def test_an_overview_and_a_detail(client):
    look(client)
    client.set("ViewLayout", "Detail")
    wanted = part(LOOKS[0], SIZE)
    wanted[32:, 40:] = part(LOOKS[1], (24, 16))
    np.testing.assert_array_equal(picture(client), wanted)
    client.set("ViewLayout", "Single")
    np.testing.assert_array_equal(picture(client), part(LOOKS[0], SIZE))


def test_each_view_has_its_numbers(client):
    look(client)
    for k, angles in enumerate(LOOKS):
        client.set("ViewSelector", f"View{k}")
        assert [client.get(name) for name in ("Pan", "Tilt", "Roll", "Zoom")] == pytest.approx(
            [angles.pan, angles.tilt, angles.roll, angles.zoom])
    for name in ("ViewLayout", "ViewSelector"):
        with pytest.raises(BadValue, match=f"{name} is 'View4', one of"):
            client.set(name, "View4")


def test_registers_take_no_others():
    with device([LENS, view_lens(2, 9000)]) as one:
        words = {one.name: one.table[0] for one in one.registers.features if one.table}
        read, write = one.table.read, one.table.write
        for name, value in (("ViewLayout", len(LAYOUTS)), ("ViewSelector", 4)):
            write(words[name], value)
            assert read(None, words[name]) == 0
        # What suits no lens waits until it is shown: a layout that would show it is rejected.
        write(words["ViewSelector"], 3)
        write(words["Pan"], 9000)
        assert read(None, words["Pan"]) == 9000
        write(words["Pan"], 9001)
        assert read(None, words["Pan"]) == 9000
        write(words["ViewLayout"], 1)
        assert read(None, words["ViewLayout"]) == 0


def test_areas():
    assert areas("Quad", (1284, 722)) == [
        Area(x, y, (640, 360)) for y in (0, 360) for x in (0, 640)]
    assert areas("Detail", (640, 480))[1] == Area(400, 304, (240, 176))
    assert areas("Quad", (14, 64)) == areas("Single", (14, 64))
    assert [area.holds(640, 359) for area in areas("Quad", (1284, 722))] == [
        False, True, False, False]

"""``ncdc lot`` finds photos of another unit, photos that disagree, and photos that are spoiled."""

import cv2
import numpy as np
import pytest

from lots import Scripted, begun, driven, outcome
from ncdc.lot.agreement import disagreement, mixed
from ncdc.lot.figures import LIMITS, judge
from ncdc.lot.photo_checks import bad_lines, blur_ratio, level_picture, soft_half
from ncdc.lot.run import run_lot
from ncdc.lot.work import Request, process
from ncdc_bench.lot.units import make_unit, write_photos
from ncdc_model.calibration.boards import grey_picture
from ncdc_model.calibration.detect import detect_points
from ncdc_model.calibration.frame import ideal_frame
from ncdc_model.images import mosaic, read_image

MIXED = "is byte for byte a photo of the unit"


def with_hashes(hashes, **figures):
    one = outcome(**figures)
    one.photo_hashes = hashes
    return one


def test_a_photo_of_two_units_asks_for_a_look_at_both(tmp_path):
    """Also if the one that was judged earlier had passed, or fails, and another station has it."""
    hashes = {"U1": ["aa" * 32], "U2": ["bb" * 32], "U3": ["aa" * 32], "U4": ["aa" * 32]}
    first, second = begun(tmp_path, 4, "left"), begun(tmp_path, 4, "right")

    def answer(serial, number):
        return with_hashes(hashes[serial], max_error_px=.7 if serial == "U4" else .2)
    left, right = ([done.serial for done in run_lot(
        database, Scripted(answer, 1), Request(), LIMITS, station)]
        for database, station in ((first, "left"), (second, "right")))
    assert left == ["U1", "U2", "U3", "U1", "U4", "U1", "U3"] and right == []
    rows = {serial: first.unit(serial) for serial in hashes}
    assert {serial: row["verdict"] for serial, row in rows.items()} == {
        "U1": "look", "U2": "pass", "U3": "look", "U4": "fail"}
    assert rows["U1"]["reasons"] == [
        f"1.png {MIXED} U3 too (SHA-256 aaaaaaaaaaaa): photos are mixed up",
        f"1.png {MIXED} U4 too (SHA-256 aaaaaaaaaaaa): photos are mixed up"]
    assert rows["U3"]["cause"] == rows["U1"]["cause"] == "photo of two units"
    assert rows["U4"]["cause"] == "largest error of the map" and len(rows["U4"]["reasons"]) == 3
    assert first.counts() == {"units": 4, "pass": 1, "look": 2, "fail": 1}


def test_a_photo_of_another_station_is_found(tmp_path):
    left, right = begun(tmp_path, 2, "left"), begun(tmp_path, 2, "right")

    def answer(serial, number):
        if serial == "U1":
            assert [done.serial for done in driven(
                right, lambda *tag: with_hashes(["aa" * 32]), station="right")[0]] == ["U2"]
        return with_hashes(["aa" * 32])
    done, _ = driven(left, answer, 1, "left")
    assert [(one.serial, one.verdict, one.before) for one in done] == [
        ("U1", "look", None), ("U2", "look", "pass")]
    assert right.unit("U2")["reasons"] == [
        f"2.png {MIXED} U1 too (SHA-256 aaaaaaaaaaaa): photos are mixed up"]


def photos_of(folder, number, kind="", other=None):
    unit = make_unit(number, kind, other=other)
    write_photos(folder, unit)
    return sorted(map(str, (folder / unit.serial).iterdir()))


@pytest.fixture(scope="module")
def good(tmp_path_factory):
    return photos_of(tmp_path_factory.mktemp("units"), 3)


def frame_of(photos):
    return ideal_frame(detect_points([(path, read_image(path)) for path in photos], "dots"))


@pytest.mark.longer
def test_photos_of_two_lenses_disagree(tmp_path, good):
    """Two photos of a unit and one of another, of its own noise: no file is there twice."""
    frame = frame_of(good)
    off, noise = disagreement(frame)
    assert off < .006 < noise < .02 and mixed(frame)[1] == ""
    off, text = mixed(frame_of(photos_of(tmp_path, 5, "mixed photos", 3)))
    assert off > .05 and "they are not all of this unit, or the page bent or moved" in text
    assert mixed(frame_of(good[:1]))[1] == ""


@pytest.mark.longer
def test_a_lens_with_a_bump_agrees_with_itself(tmp_path):
    off, noise = disagreement(frame_of(photos_of(tmp_path, 6, "uneven")))
    assert off < .02 and noise > .03


@pytest.mark.longer
def test_a_unit_with_spoiled_photos_is_looked_at(tmp_path, good, monkeypatch):
    """From the photos to the verdict, without the network."""
    monkeypatch.setattr("ncdc.lot.work._train", lambda *_: None)
    request, limits = Request("dots", bayer="MONO"), LIMITS
    assert judge((done := process(good, request)).figures, done.warnings, done.error,
                 limits)[0] == "pass", done
    for kind, words in (("half out of focus", "the right half is out of focus"),
                        ("dead rows", "unlike the rows next to"),
                        ("swapped rows", "exchanged with the next one")):
        done = process(photos_of(tmp_path, 7 + len(words), kind), request)
        verdict, _, reasons = judge(done.figures, done.warnings, done.error, limits)
        assert verdict == "look" and any(words in reason for reason in reasons), reasons


def test_rows_of_the_sensor_are_checked(good):
    level = level_picture(read_image(good[0]))
    assert bad_lines(level) == []
    dead = level.copy()
    dead[150] = 0
    assert bad_lines(dead) == ["the row 150 is unlike the rows next to it: dead, or read from "
                               "another position"]
    weak = level.copy()
    weak[:, [100, 260]] *= .8
    assert bad_lines(weak) == ["the columns 100, 260 are unlike the columns next to it: dead, or "
                               "read from another position"]
    far = level.copy()
    far[[120, 129]] = far[[129, 120]]
    assert "120, 129 are unlike" in bad_lines(far)[0]
    swapped = level.copy()
    part = swapped[140:200].reshape(-1, 2, level.shape[1])[:, ::-1]
    swapped[140:200] = part.reshape(60, -1)
    [text] = bad_lines(swapped)
    numbers = [int(word) for word in text.split(" and ")[0].replace(",", "").split()
               if word.isdigit()]
    assert all(140 <= number < 200 and number % 2 == 0 for number in numbers) and numbers


def test_rows_of_raw_frames_and_of_empty_pictures_are_checked(good):
    grey = read_image(good[1]).astype(float)
    raw = mosaic(np.stack([grey * .6, grey, grey * .8], axis=2)).astype(np.uint8)
    assert bad_lines(level_picture(raw)) == []
    raw[77] = 255
    assert "the row 77 is unlike" in bad_lines(level_picture(raw))[0]
    noise = np.random.default_rng(1).integers(0, 4, (200, 300)).astype(np.uint8)
    assert bad_lines(level_picture(noise)) == bad_lines(level_picture(0 * noise)) == []


@pytest.mark.longer
def test_a_half_out_of_focus_is_found(good):
    sharp = read_image(good[0])
    soft, where = sharp.copy(), slice(0, 150)
    soft[where] = cv2.GaussianBlur(sharp, (0, 0), 2.0)[where]
    found = {}
    for name, picture in (("sharp", sharp), ("soft", soft),
                          ("all", cv2.GaussianBlur(sharp, (0, 0), 1.5))):
        [photo] = detect_points([("0.png", picture)], "dots").photos
        found[name] = blur_ratio(grey_picture(picture), photo)
    assert found["sharp"][0] < 1.1 and found["all"][0] < 1.2
    assert soft_half(*found["sharp"]) == soft_half(*found["all"]) == ""
    assert soft_half(*found["soft"]).startswith("the upper half is out of focus: edges are usually "
                                                "blurred by ")

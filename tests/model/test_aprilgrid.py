"""Kalibr's AprilGrid: corners, numbers and spacing, and what is no AprilGrid."""

from dataclasses import replace
from functools import cache

import cv2
import numpy as np
import pytest

from ncdc_model.calibration.aprilgrid import find_any_aprilgrid, find_aprilgrid
from ncdc_model.calibration.detect import detect_points, parse_target, stated_spacing
from ncdc_model.calibration.frame import ideal_frame
from ncdc_model.calibration.measure import measure_smooth
from ncdc_model.calibration.points import TargetPoints
from ncdc_model.calibration.points_csv import load_csv, save_csv
from ncdc_spec.errors import InputError
from small_boards import Equidistant, board_photo


@cache
def shot(turn=7.0, degrees=90.0, reach=38.0):
    """An AprilGrid of 5x4 tags, turned in the picture."""
    return board_photo("aprilgrid", 5, 4, Equidistant(degrees), reach, (4.0, -5.0, turn))


def off(photo, truth):
    """Distances (n,) of points from the true ones of their numbers."""
    place = {tuple(key): xy for key, xy in zip(truth.index.tolist(), truth.xy)}
    return np.array([np.linalg.norm(place[tuple(key)] - xy)
                     for key, xy in zip(photo.index.tolist(), photo.xy)])


@pytest.mark.parametrize("turn", [
    7.0, *(pytest.param(turn, marks=pytest.mark.longer) for turn in (97.0, -173.0))])
def test_corners_and_numbers_are_those_of_the_board_however_it_is_turned(turn):
    (truth,) = shot(turn).truths
    found, spacing = find_aprilgrid(shot(turn).image, 5, 4)
    assert spacing == pytest.approx(0.3, abs=1e-3)
    assert len(found.index) >= 0.95 * truth.visible.sum()
    assert np.sqrt(np.mean(off(found, truth)**2)) < 0.06 and off(found, truth).max() < 0.25


@pytest.mark.longer
def test_tags_that_bend_in_the_picture_are_found_by_the_lens():
    wide = shot(7.0, 150.0, 64.0)
    (truth,) = wide.truths
    found, spacing = find_aprilgrid(wide.image, 5, 4)
    assert spacing == pytest.approx(0.3, abs=1e-3)
    assert len(found.index) > 0.85 * truth.visible.sum() and off(found, truth).max() < 0.4


def test_the_size_is_read_and_another_size_is_rejected():
    image = shot().image
    assert find_any_aprilgrid(image) == (5, 4)
    for columns, rows, text in ((6, 4, "an AprilGrid of 5 columns of tags, not of 6"),
                                (5, 3, r"tags up to number 19, an AprilGrid of 5x3 has 15 from 0")):
        with pytest.raises(InputError, match=text):
            find_aprilgrid(image, columns, rows)


def test_a_stated_spacing_that_is_not_seen_is_rejected():
    with pytest.raises(InputError, match=r"gap between its tags is 0.\d+ of a tag's side, 0.25 is"):
        find_aprilgrid(shot().image, 5, 4, 0.25)
    assert find_aprilgrid(shot().image, 5, 4, 0.3)[1] == 0.3


def test_covered_tags_give_no_corners():
    image = shot().image.copy()
    (truth,) = shot().truths
    inner = truth.xy[(truth.index == (4, 2)).all(axis=1)][0]
    x, y = np.rint(inner).astype(int)
    image[y - 6:y + 60, x - 6:x + 70] = 150
    found, _ = find_aprilgrid(image, 5, 4)
    assert off(found, truth).max() < 0.3 and len(found.index) > 50
    assert not (np.abs(found.xy - (x + 30, y + 27)).max(axis=1) < 25).any()


def test_tags_with_the_numbers_of_others_are_found_out():
    """The middle of a tag covered by the cells of another one: its corners are dropped."""
    image = shot().image.copy()
    (truth,) = shot().truths
    corners = np.array([truth.xy[(truth.index == key).all(axis=1)][0]
                        for key in ((4, 2), (5, 2), (5, 3), (4, 3))], np.float32)
    family = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_APRILTAG_36h11)
    other = cv2.aruco.generateImageMarker(family, 99, 100, borderBits=2)[::-1, ::-1]
    matrix = cv2.getPerspectiveTransform(
        np.array([[-.5, -.5], [99.5, -.5], [99.5, 99.5], [-.5, 99.5]], np.float32), corners)
    size = image.shape[::-1]
    there = cv2.warpPerspective(np.full_like(other, 255), matrix, size) > 254
    image[there] = (30 + 0.7 * cv2.warpPerspective(other, matrix, size))[there]
    found, _ = find_aprilgrid(image, 5, 4)
    assert any("cells are not those" in reason for reason in found.rejected)
    assert not {(4, 2), (5, 2), (5, 3), (4, 3)} & set(map(tuple, found.index.tolist()))


def test_the_points_file_holds_the_spacing(tmp_path):
    points = detect_points([("a.png", shot().image)], "aprilgrid:5x4:0.3").rounded
    points.save(tmp_path / "p.json")
    again = TargetPoints.load(tmp_path / "p.json")
    assert again.spacing == points.spacing and again.digest == points.digest
    assert replace(points, spacing=0.31).digest != points.digest
    with pytest.raises(InputError, match="an aprilgrid needs one"):
        replace(points, spacing=None)
    save_csv(tmp_path / "p.csv", points, "opencv")
    places = np.genfromtxt(tmp_path / "p.csv", delimiter=",", names=True)["object_x"]
    assert set(np.round(places, 2)) >= {0, 1, 1.3, 2.3}
    assert load_csv(tmp_path / "p.csv", points.size).count == points.count


@pytest.mark.longer
def test_a_lens_is_fitted_to_the_places_of_the_corners():
    shots = [shot(), shot(97.0), shot(-173.0)]
    points = detect_points([(f"{k}.png", one.image) for k, one in enumerate(shots)],
                           "aprilgrid:5x4:0.3")
    frame = ideal_frame(points)
    assert frame.rms < 0.08 and not frame.gross
    assert measure_smooth(frame)["straightness_rms_px"] < 0.15
    image = np.column_stack([frame.on_target, np.ones(len(frame.index))])[frame.photo == 1]
    image = image @ frame.homographies[1].T
    np.testing.assert_allclose(image[:, :2] / image[:, 2:], frame.corrected[frame.photo == 1],
                               atol=1e-6)


@pytest.mark.parametrize("text", ["aprilgrid:6x6:", "aprilgrid:6x6:2", "aprilgrid:6x6:x",
                                  "aprilgrid:6x6:0.3:1", "aprilgrid:6", "aprilgrid"])
def test_a_bad_target_is_rejected(text):
    with pytest.raises(InputError, match=f"target.* '{text}' has the spacing|target is '{text}'"):
        parse_target(text)


def test_a_target_with_spacing():
    assert parse_target("aprilgrid:6x5:0.25") == ("aprilgrid", 6, 5)
    assert stated_spacing("aprilgrid:6x5:0.25") == 0.25 and stated_spacing("aprilgrid:6x5") is None

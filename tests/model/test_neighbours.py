"""Numbered points compared with their neighbours, the background and the lens."""

import cv2
import numpy as np
import pytest

from chessboards import chessboard
from ncdc_model.calibration.background import on_one_background
from ncdc_model.calibration.corners import check_squares, find_corner_lattices
from ncdc_model.calibration.dots import find_dots
from ncdc_model.calibration.lattice import find_lattices
from ncdc_model.calibration.neighbours import OutlierReason, check_neighbours, parts
from ncdc_model.calibration.outliers import without_outliers
from ncdc_model.calibration.points import PhotoPoints
from ncdc_spec.errors import InputError


def page(columns=20, rows=15, noise=0.05, seed=1):
    """Index and positions of a barrel-distorted lattice with 30 pixels between points."""
    i, j = np.meshgrid(np.arange(columns), np.arange(rows))
    index = np.stack([i.ravel(), j.ravel()], axis=1)
    flat = (index - (columns / 2, rows / 2)) * 30.0
    r2 = (flat**2).sum(axis=1, keepdims=True) / 300**2
    rng = np.random.default_rng(seed)
    return index, 320 + flat * (1 - 0.1 * r2) + rng.normal(0, noise, flat.shape)


def test_right_points_stay():
    held = check_neighbours(*page())
    assert held.keep.all() and held.reasons == {}
    assert held.sigma == pytest.approx(0.05, rel=0.3)


@pytest.mark.parametrize("victim", [0, 7, 150, 299], ids=["corner", "rim", "middle", "end"])
def test_a_point_off_by_three_pixels_is_dropped_alone(victim):
    index, xy = page()
    xy[victim] += (3.0, 0)
    held = check_neighbours(index, xy)
    assert set(held.reasons) == {victim}
    assert held.reasons[victim] in (OutlierReason.POSITION, OutlierReason.RIM)


def test_a_dot_of_another_size_is_dropped():
    index, xy = page()
    area = np.full(len(xy), 100.0)
    area[130] = 180
    assert check_neighbours(index, xy, area).reasons == {130: OutlierReason.SIZE}


def test_a_column_that_is_cut_lengthwise_is_dropped_though_it_agrees_with_itself():
    index, xy = page()
    area, last = np.full(len(xy), 100.0), index[:, 0] == 19
    xy[last] -= (3.0, 0)
    area[last] = 45
    held = check_neighbours(index, xy, area)
    assert not held.keep[last].any() and held.keep[~last].sum() >= 18 * 15


def test_points_apart_from_the_rest_are_dropped():
    index, xy = page()
    keep = (index[:, 0] < 12) | (index[:, 0] > 16)
    held = check_neighbours(index[keep], xy[keep])
    assert set(held.reasons.values()) == {OutlierReason.APART}
    assert held.keep.sum() == 12 * 15


def test_two_lattices_that_join_are_parted_at_their_kink():
    index, xy = page(columns=20, noise=0.02)
    turn = np.array([[np.cos(0.2), -np.sin(0.2)], [np.sin(0.2), np.cos(0.2)]])
    right = index[:, 0] >= 10
    pivot = xy[index[:, 0] == 10].mean(axis=0)
    xy[right] = pivot + (xy[right] - pivot) @ turn.T
    part = parts(index, xy)
    left, other = (np.bincount(part[side & (part >= 0)]).argmax() for side in (
        index[:, 0] < 8, index[:, 0] > 12))
    assert left != other


def test_points_that_scatter_are_no_target():
    index, xy = page(noise=2.5)
    with pytest.raises(InputError, match="4 % is the limit: that is no printed target"):
        without_outliers((640, 640), PhotoPoints(index=index, xy=xy, area=np.zeros(len(xy))))


def test_a_lattice_is_walked_around_a_hole_in_the_middle():
    index, xy = page(columns=21, rows=21)
    keep = (np.abs(index - 10) > 4).any(axis=1)
    (found,) = find_lattices(xy[keep], (320, 320))
    shift = index[keep][found.where] - found.index
    assert len(found.where) == keep.sum() and (shift == shift[0]).all()


def test_several_lattices_are_distinguished():
    index, xy = page()
    second = xy @ np.array([[0.9, 0.3], [-0.3, 0.9]]) + (1500, 0)
    found = find_lattices(np.vstack([xy, second[:200]]), (0, 0))
    assert [len(lattice.where) for lattice in found] == [300, 200]


def dots_picture(size, columns, rows, light):
    """Picture (h, w) of a dot page, brightness ``light`` (w,) by column of pixels."""
    y, x = np.mgrid[:size[1], :size[0]]
    ink = np.zeros(x.shape)
    for i in range(columns):
        for j in range(rows):
            ink = np.maximum(ink, np.clip(6.5 - np.hypot(x - 30 - 25 * i, y - 30 - 25 * j), 0, 1))
    return (light * (220 - 190 * ink) / 220).astype(np.uint8)


def test_dots_on_darker_ground_are_dropped_with_position_and_reason():
    light = np.where(np.arange(560) < 392, 220.0, 80.0)
    found = find_dots(dots_picture((560, 310), 20, 11, light))
    assert found.xy[:, 0].max() < 392 and len(found.index) >= 14 * 11
    reasons = {reason for *_, reason in found.dropped}
    assert any("another brightness" in reason for reason in reasons)
    assert all(x > 370 for x, _, reason in found.dropped if "another brightness" in reason)


def test_light_that_falls_off_slowly_drops_none():
    picture = dots_picture((560, 310), 20, 11, np.linspace(220, 60, 560))
    index = np.array([(i, j) for i in range(20) for j in range(11)])
    photo = PhotoPoints(index=index, xy=30.0 + 25 * index, area=np.full(220, 113.0))
    assert on_one_background(picture, photo) is photo


@pytest.mark.parametrize("columns,rows", [(3, 3), (7, 4), (15, 9)])
@pytest.mark.parametrize("blur", [0, 4])
def test_all_corners_of_a_board_of_unknown_size(columns, rows, blur):
    picture, first = chessboard(columns, rows, 30, 220)
    picture = cv2.GaussianBlur(picture, (0, 0), blur) if blur else picture
    (found,) = find_corner_lattices(picture)
    order = np.lexsort(found.index.T)
    assert len(order) == columns * rows
    np.testing.assert_allclose(found.xy[order], first + 30 * found.index[order], atol=0.1)


@pytest.mark.parametrize("skip", [2, 3])
def test_a_lattice_that_skips_corners_is_no_board(skip):
    picture = cv2.GaussianBlur(chessboard(12, 12, 30, 220)[0], (0, 0), 1).astype(np.float32)
    index = np.array([(i, j) for i in range(4) for j in range(4)])
    assert check_squares(picture, index, 59.5 + 30.0 * index).all()
    assert not check_squares(picture, index, 59.5 + 30.0 * skip * index).any()

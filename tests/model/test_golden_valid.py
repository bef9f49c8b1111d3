"""The valid region compared with distances and differences computed pixel by pixel."""

import numpy as np
import pytest

from ncdc_model.golden.valid import (
    REACH,
    Calibrated,
    Covering,
    connected,
    grid_pitch,
    grown,
    lost_pixels,
    masks_of,
    valid_mask,
    valid_rows,
)
from ncdc_spec.geometry import Geometry, ValidRows

SMALL = Geometry(30, 22, 40, 32)


def near_by_loops(u, v, reach, width=30, height=22):
    """Pixels at most ``reach`` from one of the whole points (u, v)."""
    return np.array([[any((x - a)**2 + (y - b)**2 <= reach**2 for a, b in zip(u, v))
                      for x in range(width)] for y in range(height)])


@pytest.mark.parametrize("reach", [0.0, 2.5, 3.0])
def test_pixels_near_points(reach):
    """Points also outside the frame, as far as they reach in and farther, and not on pixels."""
    out = int(reach)
    u = np.array([12, 13, 14, -out, 29 + out, 5, 24, -out - 1, 33 + out, 8, 20, -90])
    v = np.array([9, 9, 7, 4, 15, -out, 21 + out, 10, 3, -out - 1, 27, 400])
    hull = np.array([9.0, 9, 9]), np.array([9.0, 9, 9])         # of a single pixel
    got = Calibrated(u + .3, v - .4, np.resize(hull[0], len(u)), np.resize(hull[1], len(u)), reach)
    near = got.covering(SMALL).near
    np.testing.assert_array_equal(near, near_by_loops(u, v, reach))
    assert near.any() and not near.all()
    np.testing.assert_array_equal(
        got.mask(lambda u, v: (u + 2, v + 2), SMALL),
        near | (np.indices((22, 30)).T == [7, 7]).all(axis=2).T)
    far = Calibrated(u[-1:] + 0., v[-1:] + 0., hull[0][:1], hull[1][:1], reach).covering(SMALL)
    assert far.near.shape == (22, 30) and far.near.dtype == bool and not far.near.any()
    beyond = Calibrated(np.array([500.0]), np.array([5.0]), hull[0][:1], hull[1][:1], reach)
    assert not beyond.covering(SMALL).near.any()


def test_sources_in_the_hull_are_covered():
    """A diamond of points: |x - 20| + |y - 15| <= 8, its border included."""
    x, y = np.array([12.4, 28, 20.3, 19.9, 21]), np.array([15.2, 15, 6.8, 23, 16])
    covering = Calibrated(0 * x - 99, y, x, y, 1.0).covering(SMALL)
    at = np.array([[20.4, 28.4, 28.6, 12, 11.4, 17], [20, 20, 16, 24.4, 24, np.nan]])
    rows = np.array([[6.6, 15, 15, 15.4, 15, 12], [23.4, 24, 19, 19, 19, 9]])
    inside = np.array([[1, 1, 1, 1, 1, 0], [1, 1, 1, 1, 1, 0]], bool)
    want = inside & (np.abs(np.round(at) - 20) + np.abs(np.round(rows) - 15) <= 8)
    where = slice(3, 5), slice(0, 6)
    np.testing.assert_array_equal(covering(where, at, rows, inside), want)
    assert want.any() and (inside & ~want).any()
    assert covering(where, at, rows, inside).dtype == bool
    covering.near[3, 4] = covering.near[4, 5] = True            # but the latter has no source
    want[0, 4] = True
    np.testing.assert_array_equal(covering(where, at, rows, inside), want)
    corners = np.array([0.0, 39, 39, 0]), np.array([0.0, 0, 31, 31])
    everything = Calibrated(*corners, *corners, 0.0).covering(SMALL)
    x, y = np.meshgrid(np.arange(40.0), np.arange(32.0))
    first = np.zeros(x.shape, int)
    assert everything((first, first), x, y, x >= 0).all()


CELLS = np.arange(0.0, 12), np.arange(0.0, 14)


@pytest.mark.parametrize("shift", [0, 0.5])
def test_cells_inside_and_beyond_the_sides(shift):
    """Sides x = 1, y = 2 and 3 x + 4 y = 43 (a triangle), corners in both directions."""
    y, x = (a + shift for a in np.meshgrid(*CELLS, indexing="ij"))
    off = np.stack([x - 1, y - 2, (43 - 3 * x - 4 * y) / 5])
    # The lines meet at (1, 2), (1, 10) and (35 / 3, 2); scaled by 3 they are whole.
    corners = 3 * np.array([[1, 2], [1, 10], [35 / 3, 2]])
    margin = np.full((11, 13), .25)
    margin[4:8, 3:9] = [[0], [1.53], [3], [.65]]
    margin[4:8, 0] = 0          # of the cells whose corners are on a side, no more than that
    near = np.stack([off[:, :-1, :-1], off[:, :-1, 1:], off[:, 1:, :-1], off[:, 1:, 1:]])
    inside, outside = (near.min(axis=0) > margin), (near.max(axis=0) < -margin)
    for turn in (1, -1):
        covering = Covering(np.zeros((20, 30), bool), corners.round().astype(np.int32)[::turn],
                            (40, 32))
        within, beyond = covering.hull_of(3 * x, 3 * y, 3 * margin)
        np.testing.assert_array_equal(within, inside.all(axis=0))
        np.testing.assert_array_equal(beyond, outside.any(axis=0))
    assert inside.all(axis=0).any() and outside.any(axis=0).any()


def test_a_hull_without_an_area_has_no_cells():
    x, y = np.meshgrid(np.arange(6.0), np.arange(5.0))
    for hull in ([[2, 2]], [[1, 1], [4, 3]]):
        covering = Covering(np.zeros((20, 30), bool), np.array(hull, np.int32), (40, 32))
        with np.errstate(all="raise"):
            within, beyond = covering.hull_of(x, y, np.zeros((4, 5)))
        assert within.shape == beyond.shape == (4, 5) and not within.any() and not beyond.any()


def test_the_pitch_is_the_median_of_all_photos_distances():
    assert REACH == 2
    line = np.array([0.0, 1, 3, 6, 10])                 # nearest ones: 1, 1, 2, 3, 4
    assert grid_pitch([(line, 0 * line)]) == 2
    assert grid_pitch([(line, 0 * line), (np.zeros(2), np.array([0.0, 9]))]) == 3
    assert grid_pitch([(0 * line, line), (line[:1], line[:1])]) == 2
    assert grid_pitch([(np.array([0.0, 3]), np.array([0.0, 4]))]) == 5
    assert grid_pitch([(line[:1], line[:1])]) == 0 and grid_pitch([]) == 0
    assert grid_pitch([(line[:0], line[:0]), (line, 0 * line)]) == 2
    assert type(grid_pitch([(line, line)])) is float


def slope(values, axis):
    """Differences: central ones inside, one-sided ones at both ends."""
    values = np.moveaxis(values, axis, 0)
    inner = (values[2:] - values[:-2]) / 2
    return np.moveaxis(np.concatenate([values[1:2] - values[:1], inner,
                                       values[-1:] - values[-2:-1]]), 0, axis)


def waves(u, v):
    """A map that folds in places, and has no source in others."""
    x = 20 + u / 3 + 9 * np.sin(u / 9) * np.cos(v / 13)
    x[(u > 60) & (u < 63) & (v > 20)] = np.nan
    return x, 9 + v / 4 + 7 * np.cos(u / 8 - v / 9)


@pytest.mark.parametrize("size", [(256, 130), (300, 219), (96, 64)])
def test_a_fold_is_where_the_determinant_is_not_positive(size):
    """Bands of 128 and of 109 rows end in the middle, one row before the last, and nowhere."""
    geometry = Geometry(*size, 120, 60)
    v, u = np.indices(size[::-1]).astype(float)
    x, y = waves(u, v)
    fold = slope(x, 1) * slope(y, 0) - slope(x, 0) * slope(y, 1) <= 0
    inside = (x >= .5) & (np.floor(x - .5) <= 117) & (y >= .5) & (np.floor(y - .5) <= 57)
    masks = masks_of(waves, geometry)
    np.testing.assert_array_equal(masks.inside, inside)
    np.testing.assert_array_equal(masks.unfolded, inside & ~fold)
    assert masks.covered is None and masks.inside.dtype == masks.unfolded.dtype == bool
    assert (inside & fold).any() and (inside & ~fold).any()

    def covering(rows, x, y, inside):
        seen.append((rows.start, rows.stop))
        assert x.shape == y.shape == inside.shape == (rows.stop - rows.start, size[0])
        return (x > y) & inside
    seen = []
    np.testing.assert_array_equal(masks_of(waves, geometry, covering).covered, inside & (x > y))
    assert [a for a, _ in seen[1:]] == [b for _, b in seen[:-1]]
    assert seen[0][0] == 0 and seen[-1][1] == size[1]


def test_a_map_that_stands_still_is_a_fold():
    geometry = Geometry(16, 12, 40, 32)
    assert not masks_of(lambda u, v: (u * 0 + 9, v + 4), geometry).unfolded.any()
    assert not masks_of(lambda u, v: (20 - u, v + 4), geometry).unfolded.any()
    assert masks_of(lambda u, v: (v + 4, 20 - u), geometry).unfolded.all()


def drawing(*rows):
    return np.array([[letter == "#" for letter in row] for row in rows])


def test_the_part_around_the_middle_or_the_largest():
    # The middle is (2, 3). Diagonal neighbours are not connected.
    mask = drawing("####.##",
                   "#...#.#",
                   ".###..#",
                   "..#..##",
                   "##...##")
    np.testing.assert_array_equal(connected(mask), drawing(
        ".......", ".......", ".###...", "..#....", "......."))
    mask[2, 3] = False
    np.testing.assert_array_equal(connected(mask), drawing(
        ".....##", "......#", "......#", ".....##", ".....##"))
    np.testing.assert_array_equal(connected(~mask & False), mask & False)
    np.testing.assert_array_equal(connected(mask | True), mask | True)
    # One part only, not in the middle.
    np.testing.assert_array_equal(connected(drawing("#..", "...", "..."))[0], [True, False, False])


def test_the_valid_mask_is_connected_inside_and_unfolded():
    geometry = Geometry(96, 64, 120, 60)
    mask = masks_of(waves, geometry).unfolded
    np.testing.assert_array_equal(valid_mask(waves, geometry), connected(mask))
    within = np.indices((64, 96))[1] > 40
    part = valid_mask(waves, geometry, within)
    np.testing.assert_array_equal(part, connected(mask & within))
    assert part.any() and (connected(mask) != part).any()
    for given in (None, within):
        spans = valid_rows(waves, geometry, given)
        np.testing.assert_array_equal(spans.spans,
                                      ValidRows.of_mask(valid_mask(waves, geometry, given)).spans)


def test_grown_and_lost_pixels():
    mask = np.zeros((22, 30), bool)
    mask[[5, 15], [4, 22]] = True
    for distance in (1, 3, 4.5):
        np.testing.assert_array_equal(grown(mask, distance),
                                      near_by_loops([4, 22], [5, 15], distance))
    empty = mask & False
    bigger = grown(empty, 5)
    assert not bigger.any() and bigger.dtype == bool and bigger is not empty
    row = np.zeros((8, 30), bool)
    row[2, [1, 2, 3, 6, 9, 10, 20]] = row[4, 7] = True
    with np.errstate(all="raise"):
        assert lost_pixels(row, ValidRows.of_mask(row)) == 2    # the two shortest of four parts
        assert lost_pixels(row, ValidRows.everything(30, 8)) == 0
    assert type(lost_pixels(row, ValidRows.of_mask(row))) is int

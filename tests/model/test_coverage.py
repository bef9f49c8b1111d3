"""What of a lattice that was seen is not used is named: points, lines, regions."""

import numpy as np

from ncdc_model.calibration.coverage import numbered, uncovered
from ncdc_model.calibration.points import PhotoPoints

REASON = "not where its neighbours predict it"


def photo(drop, columns=20, rows=14, gone=None):
    """A barrel-distorted page of which the points ``drop`` marks were dropped, ``gone`` never
    seen."""
    index = np.stack(np.meshgrid(np.arange(columns), np.arange(rows)), axis=-1).reshape(-1, 2)
    flat = (index - (columns / 2, rows / 2)) * 30.0
    xy = 400 + flat * (1 - 0.15 * (flat**2).sum(axis=1, keepdims=True) / 400**2)
    keep = np.ones(len(index), bool) if gone is None else ~gone(index)
    whole = PhotoPoints(index=index[keep], xy=xy[keep], area=np.full(keep.sum(), 99.0))
    return whole.without(drop(index[keep]), REASON)


def nothing(index):
    return np.zeros(len(index), bool)


def test_a_whole_page_and_a_few_dropped_points_are_no_matter():
    assert uncovered(photo(nothing)) == []
    assert uncovered(photo(lambda index: index.sum(axis=1) % 11 == 0)) == []


def test_dropped_points_get_their_numbers_again():
    left = photo(lambda index: index[:, 0] < 3)
    where = numbered(left.index, left.xy, np.array([point[:2] for point in left.dropped]))
    np.testing.assert_array_equal(np.unique(where[:, 0]), [-3, -2, -1])
    assert len(np.unique(where, axis=0)) == 3 * 14


def test_more_than_a_tenth_and_whole_columns_are_named():
    share, columns = uncovered(photo(lambda index: index[:, 0] < 3), "a.png")
    assert share.startswith("a.png: 42 of 280 points seen on the lattice, 15 %, are not used")
    assert share.endswith(f"42 {REASON}")
    assert "columns -3 to -1 are left out" in columns and "0 of 42 points" in columns


def test_a_column_within_is_named():
    (text,) = uncovered(photo(lambda index: (index[:, 0] == 9) & (index[:, 1] != 5)))
    assert text.startswith("column 9 is left out, from (") and "1 of 14 points" in text


def test_a_region_that_no_point_was_seen_in_is_named():
    (text,) = uncovered(photo(nothing, gone=lambda index: (np.abs(index - (9, 6)) <= 1.5).all(1)))
    assert text.startswith("a region of 9 positions") and "columns 8 to 10, rows 5 to 7" in text


def test_a_staggered_grid_has_no_holes_between_its_circles():
    grid = photo(nothing, gone=lambda index: index.sum(axis=1) % 2 == 1)
    assert uncovered(grid, staggered=True) == []
    lost = photo(lambda index: index[:, 0] < 4, gone=lambda index: index.sum(axis=1) % 2 == 1)
    (text,) = uncovered(lost, staggered=True)
    assert text.startswith("28 of 140 points")

"""Golden model of the cache's tag stage compared with a dictionary that forgets nothing."""

import numpy as np
import pytest

from cameras import barrel_descriptor
from ncdc_model.golden.corrector import correct
from ncdc_model.golden.picture import fetches
from ncdc_model.planner.lookups import frame_windows, lookups
from ncdc_model.planner.tags import accesses, miss_count, misses
from ncdc_spec.cache_options import CacheOptions
from ncdc_spec.errors import InputError
from windows import random_windows, walking_windows


def plain_misses(boxes, options, split):
    """(look-up, bank, tile column, tile row, last user of the victim) one access at a time."""
    slots, found = {}, []
    kx, ky = 1 << split, options.sets >> split
    for i in np.flatnonzero(boxes.used).tolist():
        tiles = {(x >> 4, y >> 2) for x in (boxes.x0[i], boxes.x1[i])
                 for y in (boxes.y0[i], boxes.y1[i])}
        by_bank = sorted(((tx & 1) | (ty & 1) << 1, tx, ty) for tx, ty in tiles)
        assert len({bank for bank, _, _ in by_bank}) == len(tiles)
        for bank, tx, ty in by_bank:
            slot = bank, (ty >> 1) % ky, (tx >> 1) % kx
            tile, user = slots.get(slot, (None, -1))
            if tile != (tx, ty):
                found.append((i, bank, tx, ty, user))
            slots[slot] = (tx, ty), i
    return found


@pytest.mark.parametrize("make", [random_windows, walking_windows])
@pytest.mark.parametrize("tiles,split", [(16, 0), (16, 1), (16, 2), (64, 2), (256, 5)])
@pytest.mark.parametrize("strip", [0, 32])
def test_misses_are_those_of_a_dictionary(make, tiles, split, strip):
    boxes, options = lookups(make(tiles), strip), CacheOptions(tiles)
    found = misses(accesses(boxes), options, split)
    expected = plain_misses(boxes, options, split)
    assert len(found) == len(expected) == miss_count(accesses(boxes), options, split) > 50
    assert list(zip(found.lookup.tolist(), found.bank.tolist(), found.columns.tolist(),
                    found.rows.tolist(), found.victim.tolist())) == expected


def test_blank_pixels_read_nothing():
    windows = random_windows(3, blank=1)
    touched, options = accesses(lookups(windows)), CacheOptions(16)
    assert len(misses(touched, options, 0)) == miss_count(touched, options, 0) == 0


def test_windows_are_those_of_the_golden_model():
    descriptor = barrel_descriptor((48, 40), (64, 48))
    windows = frame_windows(descriptor)
    corrected = correct(descriptor, np.zeros((48, 64), np.uint8))
    np.testing.assert_array_equal(windows.used, ~corrected.blank)
    assert fetches(windows.x0, windows.y0, windows.used) == corrected.fetches


def test_a_split_that_the_cache_lacks_is_rejected():
    boxes = lookups(random_windows(1))
    with pytest.raises(InputError, match="split is 3, the limits are 0 and 2"):
        misses(accesses(boxes), CacheOptions(16), 3)


def plain_boxes(group):
    """Boxes of a group of (x0, y0, used), as lists of its lanes, by the rule of halves."""
    used = [(x, y) for x, y, on in group if on]
    if used:
        xs, ys = zip(*used)
        box = min(xs), min(ys), max(xs) + 2, max(ys) + 2
        if box[2] // 8 - box[0] // 8 > 1 or box[3] - box[1] > 3:
            half = len(group) // 2
            return plain_boxes(group[:half]) + plain_boxes(group[half:])
        return [box]
    return [None]


@pytest.mark.parametrize("lanes", [2, 4])
@pytest.mark.parametrize("strip", [0, 32])
def test_groups_are_cut_where_a_box_is_too_large(lanes, strip):
    windows = walking_windows(lanes)
    pixels = list(zip(*(array.tolist() for array in windows.scanned(strip))))
    expected = [box for k in range(0, len(pixels), lanes)
                for box in plain_boxes(pixels[k:k + lanes])]
    boxes = lookups(windows, strip, lanes)
    found = [edges if used else None for *edges, used in zip(
        boxes.x0.tolist(), boxes.y0.tolist(), boxes.x1.tolist(), boxes.y1.tolist(),
        boxes.used.tolist())]
    assert [box and tuple(box) for box in found] == expected
    assert len(pixels) / lanes < len(boxes) < len(pixels)
    assert boxes.pixels == len(pixels)


def test_groups_divide_the_width():
    with pytest.raises(InputError, match="the corrected width is 62, 4 pixels per clock need a "):
        lookups(random_windows(1, (62, 8)), lanes=4)

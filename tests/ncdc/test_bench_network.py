"""How the bench of the network judges what it measured."""

import numpy as np
import pytest

from ncdc.bench.network.command import failures, table
from ncdc.bench.network.measure import different

_BLACK, _GREY, _WHITE = (np.full((4, 5, 3), value, np.uint8) for value in (0, 128, 255))


def test_pictures_change_in_their_order():
    assert different([_BLACK, _GREY, _GREY, _WHITE], [_BLACK, _GREY, _WHITE]) == 0


def test_one_that_comes_back_differs():
    assert different([_BLACK, _GREY, _BLACK, _WHITE], [_BLACK, _GREY, _WHITE]) == 20


def test_one_that_never_comes_differs():
    assert different([_BLACK, _BLACK, _WHITE], [_BLACK, _GREY, _WHITE]) == 20


def test_a_torn_picture_differs():
    torn = _BLACK.copy()
    torn[2:] = _GREY[2:]
    assert different([_BLACK, torn, _GREY], [_BLACK, _GREY]) == 10


def row(**figures):
    return {"what": "idle", "peer": "GVCP", "frames": 0, "pixels_different": None,
            "megabytes_per_second": None, "underruns": 0, "resent": None,
            "clocks_per_command": None, "most_clocks_per_command": None,
            "clocks_per_pixel": None} | figures


@pytest.mark.parametrize("bad,word", (
    ({"pixels_different": 1}, "pixels"), ({"underruns": 1}, "wire"),
    ({"clocks_per_command": 3001}, "3000")))
def test_failures_are_told(bad, word):
    assert not failures([row(clocks_per_command=3000, pixels_different=0)])
    found = failures([row(**bad)])
    assert len(found) == 1 and word in found[0]
    assert "GVCP" in table([row(**bad)])

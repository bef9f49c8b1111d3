"""How the bench of the network judges what it measured."""

import numpy as np
import pytest

from ncdc.cli import main
from ncdc_bench.network.board import FULL, board_rows, shortfalls
from ncdc_bench.network.command import failures, table
from ncdc_bench.network.measure import different
from ncdc_boards.catalogue import board

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
def test_failures_are_reported(bad, word):
    assert not failures([row(clocks_per_command=3000, pixels_different=0)])
    found = failures([row(**bad)])
    assert len(found) == 1 and word in found[0]
    assert "GVCP" in table([row(**bad)])


@pytest.mark.parametrize("what,goal", (("corrected", 28), ("raw, from memory", 90)))
def test_rates_below_their_goals_are_reported(what, goal):
    good = {"what": what, "width": FULL[0], "height": FULL[1], "frames_per_second": goal,
            "lost": 0}
    assert shortfalls([good, good | {"width": 64, "frames_per_second": 1}]) == []
    found = shortfalls([good | {"frames_per_second": goal - .01}, good | {"lost": 3}])
    assert len(found) == 2 and f"goal {goal}" in found[0] and "3 frames" in found[1]


@pytest.mark.parametrize("options,said", (
    (["--screen"], "--screen is given without --board"),
    (["--core-mhz", "75"], "--core-mhz is given without --board"),
    (["--board", "de1-soc"], "de1-soc has no Ethernet chip at RGMII"),
    (["--board", "faka2"], "faka2 has no Ethernet chip at RGMII"),
    (["--board", "colorlight-i9"], "colorlight-i9 has no screen"),
    (["--board", "unknown"], "board is 'unknown'")))
def test_a_board_without_a_network_is_rejected(options, said, capsys):
    assert main(["bench", "network", *options]) == 2
    assert said in capsys.readouterr().err


@pytest.mark.many_clocks
@pytest.mark.regress
def test_goals_of_the_de2_115():
    """28 corrected pictures of 1280x1024 a second from the sensor, 90 raw ones from memory."""
    rows = board_rows(board("de2-115"), FULL, lambda text: None)
    assert failures(rows) == shortfalls(rows) == []
    assert [row["pixels_different"] for row in rows] == [0, 0]
    assert all(row["frames"] >= 4 for row in rows)

"""Bad photos: what is found on them is right, or one sentence says why nothing is."""

from pathlib import Path

import numpy as np
import pytest

from cases import cases
from ncdc_bench.photos import spoil
from ncdc_bench.photos.cases import CASES, Case
from ncdc_bench.photos.command import summary
from ncdc_bench.photos.measure import judge, try_case
from ncdc_bench.photos.targets import Bank, Pose
from ncdc_model.calibration.detection_result import DetectionResult
from ncdc_model.calibration.points import PhotoPoints
from ncdc_spec.errors import InputError

DATA = Path(__file__).resolve().parents[1] / "data"
# Of each kind of defect one, on small photos.
# One or two of each kind; all of them are in test_all_bad_photos.
QUICK = "dots, asked as chessboard:9x6", "board, 15x9", "board, two boards"
LONGER = ("dots, pen marks, small page", "circles, two grids", "board, one photo a pixel smaller",
          "charuco, a hand", "no target: a street", "board, partly blurred, px: 9",
          "board, from 62 degrees aside, x", "board, 5x4, steps of 163 px",
          "circles, white on black, rendered", "board, round a cylinder, 0.1 a step",
          "board, two sheets, right one by (3, -2) px", "dots, rolling shutter, waving by 3 px")


@pytest.fixture(scope="module")
def bank():
    return Bank(DATA, 0.5)


@pytest.mark.parametrize("name", cases(QUICK + LONGER, LONGER))
def test_what_must_become_of_it_does(bank, name):
    (case,) = [case for case in CASES if case.name == name]
    for outcome in try_case(case, case.make(bank)):
        assert outcome.right and not outcome.silent, outcome


@pytest.mark.longer
def test_ragged_corners_between_dots_are_no_chessboard(bank):
    # Out of focus, the saddles between dots look like corners, and are more than the dots.
    photo = spoil.blur(bank.render(("dots", 12, 9, Pose(step=0.1, turn=30.0)), clutter=True), 4)
    result = DetectionResult("page", photo.image)
    assert not result.boards and len(result.spots.lattices[0].index) > 100
    assert judge(photo, result.page)[1] == 0
    result.prepare("auto")
    assert result.target.kind in ("dots", "circles")


@pytest.mark.longer
@pytest.mark.parametrize("sigma", [1, 10])
def test_dots_far_out_of_focus_are_warned_of(bank, sigma):
    photo = spoil.blur(bank.example(), sigma)
    (outcome,) = try_case(Case("dots", ("either",), "auto", lambda bank: [photo]), [photo])
    assert not outcome.rejected and ("out of focus" in outcome.message) == (sigma == 10)
    assert bool(outcome.false) == (sigma == 10)


def test_a_board_asked_as_dots_is_rejected(bank):
    photo = bank.render(("chessboard", 8, 6, Pose()), clutter=True)
    with pytest.raises(InputError, match="it shows a chessboard of 48 corners, no page of dots"):
        DetectionResult("board", photo.image).page


@pytest.mark.regress
def test_all_bad_photos():
    bank, outcomes = Bank(DATA), []
    for case in CASES:
        outcomes += try_case(case, case.make(bank))
    assert len(outcomes) >= 160
    assert [outcome for outcome in outcomes if outcome.silent] == []
    total = summary(outcomes)[-1]
    assert total["usable_used"] >= 0.75 * total["usable"]


def test_truth_moves_with_the_picture(bank):
    board = bank.real("mild1")
    turned = spoil.turn(board, 30, 0.8)
    size = np.array(board.size)
    for before, after in zip(board.truths[0].xy[::9], turned.truths[0].xy[::9]):
        if ((after > 20) & (after < size - 20)).all():
            # A corner of squares looks the same after half a turn, before and after the move.
            for photo, (x, y) in ((board, before), (turned, after)):
                grey = photo.image if photo.image.ndim == 2 else photo.image[:, :, 0]
                patch = grey[round(y) - 4:round(y) + 5, round(x) - 4:round(x) + 5].astype(float)
                assert np.corrcoef(patch.ravel(), patch[::-1, ::-1].ravel())[0, 1] > 0.5


def test_judge_sees_false_points_and_numbers(bank):
    photo = bank.real("mild1")
    truth = photo.truths[0]

    def false(index, xy):
        return judge(photo, PhotoPoints(index=index, xy=xy, area=np.zeros(len(xy))))[1]
    turned = np.stack([truth.index[:, 1], -truth.index[:, 0]], axis=1) + (3, 9)
    assert false(truth.index, truth.xy) == false(turned, truth.xy) == 0
    moved = truth.xy.copy()
    moved[5] += (1.2, 0)
    assert false(truth.index, moved) == 1
    swapped = truth.index.copy()
    swapped[[3, 40]] = swapped[[40, 3]]
    assert false(swapped, truth.xy) == 2
    assert false(truth.index, truth.xy + 300) == len(truth.xy)

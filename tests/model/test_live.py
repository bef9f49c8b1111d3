"""Live calibration: which frames become pictures, when it ends, and how good the lens is then."""

import numpy as np
import pytest

from live_camera import (
    HAND_PICKED,
    SIZE,
    STEP,
    Hand,
    hand_picked,
    map_error,
    played,
    seen_by,
    sweep,
    true_lens,
)
from ncdc_model.calibration.detect import detect_points
from ncdc_model.calibration.frame import ideal_frame
from ncdc_model.calibration.live import calibrator as module
from ncdc_model.calibration.live.calibrator import LiveCalibrator
from ncdc_model.calibration.live.information import Information
from ncdc_model.calibration.live.poses import Pose, plane_of, wishes
from ncdc_model.calibration.live.sighting import Sighting, may_show
from ncdc_model.calibration.smooth import fit_smooth
from ncdc_spec.errors import InputError

BLANK = np.zeros(SIZE[::-1], np.uint8)


def rms(values):
    return float(np.sqrt(np.mean(np.square(values))))


@pytest.fixture
def shown(monkeypatch):
    """A list of sightings: each frame shows the first one that is left."""
    left = []
    monkeypatch.setattr(module, "sighting_of", lambda image, target: left.pop(0))
    monkeypatch.setattr(module, "may_show", lambda image, target: True)
    return left


def sighting(pose, blur=1.0, seed=0, shift=0.0):
    index, xy = seen_by(pose, SIZE, seed)
    return Sighting("chessboard:9x6", index, xy + shift, blur)


def looked(calibrator, count, start=0.0):
    return [calibrator.look(BLANK, start + STEP * k).seen for k in range(count)]


def test_a_picture_is_taken_when_the_target_has_been_still(shown):
    pose = HAND_PICKED[0]
    shown += [None, *(sighting(pose, shift=9.0 * k) for k in range(3)), *[sighting(pose)] * 4]
    calibrator = LiveCalibrator()
    assert looked(calibrator, 8) == ["nothing", "moving", "moving", "moving", "moving", "waiting",
                                     "taken", "known"]


def test_no_picture_is_blurred(shown):
    shown += [*[sighting(HAND_PICKED[0])] * 3, *[sighting(HAND_PICKED[1], blur=1.6)] * 3,
              *[sighting(HAND_PICKED[1], blur=1.1)]]
    assert looked(LiveCalibrator(), 7) == ["moving", "waiting", "taken", "moving", "blurred",
                                           "blurred", "taken"]


def test_wrong_points_are_no_picture(shown):
    wrong = sighting(HAND_PICKED[1])
    wrong.xy[:] += np.random.default_rng(1).normal(0, 4, wrong.xy.shape)
    shown += [*[sighting(HAND_PICKED[0])] * 3, *[wrong] * 3, *[sighting(HAND_PICKED[2])] * 3]
    calibrator = LiveCalibrator()
    assert looked(calibrator, 9)[2::3] == ["taken", "wrong", "taken"]


def test_another_part_of_a_regular_target_is_motion():
    here = sighting(HAND_PICKED[0])
    left = Sighting(here.target, here.index, here.xy - here.xy[1] + here.xy[0], 1.0)
    assert left.moved(here) == np.inf and here.moved(here) == 0


def test_the_frame_is_covered_where_points_are(shown):
    shown += [sighting(HAND_PICKED[1])] * 3
    calibrator = LiveCalibrator()
    state = [calibrator.look(BLANK, STEP * k) for k in range(3)][-1]
    rows, columns = state.coverage.shape
    assert (rows, columns) == (8, 10)
    assert state.coverage[:4, :4].any() and not state.coverage[-2:].any()
    assert state.report()["coverage"][-1] == "." * columns and 0 < state.covered < .5
    assert "left" not in state.wish.text.partition(" of ")[0]


def test_frames_have_one_size(shown):
    shown += [None] * 2
    calibrator = LiveCalibrator()
    calibrator.look(BLANK, 0)
    with pytest.raises(InputError, match="300x200 pixels, those before it have 480x360"):
        calibrator.look(BLANK[:200, :300], 1)


def test_without_a_target_frames_are_glanced_at(monkeypatch):
    """A whole search once in two seconds, and as soon as a glance shows something."""
    searched, glances = [], []
    monkeypatch.setattr(module, "sighting_of", lambda image, target: searched.append(time))
    monkeypatch.setattr(module, "may_show", lambda image, target: glances.append(time) or seen)
    calibrator, seen = LiveCalibrator(), False
    for time in (0, .5, 1, 1.5, 2, 2.5):
        calibrator.look(BLANK, time)
    seen = True
    for time in (3, 3.5):
        calibrator.look(BLANK, time)
    assert searched == [0, 2, 3, 3.5] and glances == [.5, 1, 1.5, 2.5, 3, 3.5]


@pytest.mark.parametrize("target", ["auto", "chessboard:9x6", "charuco:9x6"])
def test_a_glance_shows_a_board(target):
    photo = Hand().photo(HAND_PICKED[0]).image
    assert may_show(photo, target) and not may_show(photo, "dots")
    assert not may_show(np.full_like(photo, 90), target)


def test_a_glance_shows_dots():
    y, x = np.mgrid[:360, :480]
    dots = np.where((x % 24 - 12)**2 + (y % 24 - 12)**2 < 50, 30, 220).astype(np.uint8)
    for page in (dots, 255 - dots):
        assert may_show(np.repeat(page[..., None], 3, axis=2), "circles:20x15")
    assert not may_show(np.repeat(dots[..., None], 3, axis=2), "chessboard:9x6")


@pytest.fixture(scope="module")
def few():
    """Points of three poses, and the information on the lens that explains them."""
    photos = [seen_by(pose, SIZE, k) for k, pose in enumerate(HAND_PICKED[:3])]
    return photos, Information(fit_smooth(SIZE, photos, rough=True), photos)


def test_the_pose_of_points_is_found(few):
    photos, information = few
    for plane, (index, xy) in zip(information.fit.planes, photos):
        found = plane_of(information.camera, index, xy)
        assert not Pose.of(found, index).differs(Pose.of(plane, index))
    poses = [Pose.of(plane, index) for plane, (index, _) in zip(information.fit.planes, photos)]
    assert poses[0].differs(poses[1]) and poses[1].differs(poses[2])


def test_the_gain_is_what_a_further_pose_brings(few):
    photos, before = few
    gains = []
    for pose in HAND_PICKED[3:7]:
        more = seen_by(pose, SIZE, 9)
        after = Information(fit_smooth(SIZE, [*photos, more], rough=True), [*photos, more])
        predicted = before.gain(plane_of(before.camera, *more), more[0])
        gains.append((predicted, 1 - after.uncertainty / before.uncertainty))
    predicted, brought = np.array(gains).T
    assert predicted.max() > .2
    np.testing.assert_allclose(predicted, brought, atol=.15)
    # What is wanted brings more than a pose that is there already.
    index = photos[0][0]
    wish, *_, worst = wishes(before, index, 6.0)
    again = before.gain(before.fit.planes[0], index)
    assert wish.gain > max(again, worst.gain) and wish.gain >= predicted.max() - .1


def test_the_uncertainty_is_that_of_the_map():
    """Over many noises, with the same poses."""
    found = []
    for seed in range(6):
        photos = [seen_by(pose, SIZE, 50 * seed + k) for k, pose in enumerate(HAND_PICKED[:5])]
        information = Information(fit_smooth(SIZE, photos, rough=True), photos)
        found.append((information.uncertainty, rms(map_error(information.camera, true_lens(SIZE)))))
    said, true = np.array(found).T
    assert .5 < rms(true) / rms(said) < 2


@pytest.mark.longer
def test_it_ends_by_itself_with_a_lens_as_good_as_that_of_hand_picked_photos(shown):
    """Points with the noise of a detector; without it, see the test on pictures."""
    errors = []
    for seed in range(2):
        calibrator, time = LiveCalibrator(), 0.0
        for number, pose in enumerate(sweep(seed)):
            shown[:] = [sighting(pose, seed=100 * seed + number)] * 3
            for _ in range(3):
                state, time = calibrator.look(BLANK, time), time + STEP
            if state.done:
                break
        assert state.done and state.pictures < len(sweep()) and state.covered >= .9
        photos = [seen_by(pose, SIZE, 70 * seed + k) for k, pose in enumerate(HAND_PICKED)]
        lens = true_lens(SIZE)
        errors.append([rms(map_error(one, lens)) for one in (
            calibrator.lens, fit_smooth(SIZE, photos, rough=True).camera)])
    live, by_hand = np.array(errors).mean(axis=0)
    assert live < 1.2 * by_hand


@pytest.mark.regress
def test_a_rendered_camera_in_motion():
    hand = Hand()
    states, pictures = played(LiveCalibrator(), hand.frames(sweep()))
    assert states[-1].done and {"moving", "waiting", "taken"} <= {one.seen for one in states}
    assert len(pictures) == states[-1].pictures < len(sweep())
    live, by_hand = (rms(map_error(ideal_frame(detect_points(photos, hand.target)).camera,
                                   true_lens(SIZE)))
                     for photos in (pictures, hand_picked(hand)))
    assert live < 1.2 * by_hand < .1

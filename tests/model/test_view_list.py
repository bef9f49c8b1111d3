"""Lists of views: what they write, what is rejected, and the model of their buffer."""

from dataclasses import replace

import numpy as np
import pytest

from cameras import barrel_descriptor
from ncdc_model.correction import correct as compiled
from ncdc_model.golden.corrector import correct
from ncdc_model.golden.view_list import compose
from ncdc_spec.errors import InputError
from ncdc_spec.frames import BGR8, BGRX8, MONO8, stored_bytes
from ncdc_spec.hardware import Hardware
from ncdc_spec.view import View
from ncdc_spec.view_list import (
    Entry,
    buffer_bytes,
    check_largest,
    list_values,
    placed,
    quad,
)
from views import random_view

HARDWARE = Hardware(view=True, views=4)


def lens():
    return replace(barrel_descriptor((40, 20), (42, 22), 3, fill=(9, 8, 7)), nodes=8)


def some(count, size=(16, 12), seed=1):
    rng = np.random.default_rng(seed)
    return [random_view(rng, lens().geometry, 25, size, roll=180) for _ in range(count)]


def test_a_quad_is_four_pictures():
    d, views = lens(), some(4)
    raw = np.random.default_rng(2).integers(0, 256, (22, 42), np.uint8)
    picture = compose(d, raw, quad(views, BGR8)).reshape(24, 32, 3)
    for view, (v, u) in zip(views, ((0, 0), (0, 16), (12, 0), (12, 16))):
        part = stored_bytes(correct(d, raw, view=view).picture, BGR8)
        assert (picture[v:v + 12, u:u + 16] == part).all()
    assert (compose(d, raw, quad(views, BGR8), corrected=compiled) == picture.ravel()).all()


def test_later_views_cover_earlier_ones_and_leave_the_rest():
    d, (below, above) = lens(), some(2)
    raw = np.random.default_rng(3).integers(0, 256, (22, 42), np.uint8)
    buffer = np.full(30 * 14 * 4, 0x5A, np.uint8)
    compose(d, raw, placed([below, above], [(0, 0), (5, 2)], (30, 14)), buffer)
    picture = buffer.reshape(14, 30, 4)
    assert (picture[2:14, 5:21, :3] == correct(d, raw, view=above).picture[..., ::-1]).all()
    assert (picture[:2, :16, :3] == correct(d, raw, view=below).picture[:2, :, ::-1]).all()
    assert (picture[:, 21:] == 0x5A).all() and (picture[12:, :5] == 0x5A).all()


def test_the_registers_of_a_list():
    first, second = some(2)
    values = list_values((Entry(first), Entry(second, 64, 80, BGR8, 32, 1)), HARDWARE,
                         lens().geometry)
    assert values["VIEWS"] == 2 and len(values) == 1 + 2 * 16
    assert [values[f"VIEW1_{word}"] for word in ("OFFSET", "PITCH", "FORMAT", "STRIP", "SPLIT",
                                                  "WIDTH", "HEIGHT")] == [64, 80, 1, 32, 1, 16, 12]
    assert values["VIEW0_SPLIT"] == HARDWARE.split_for(lens().geometry)
    assert [values[f"VIEW0_{word}"] for word in ("X_U", "Z_0")] == [first.matrix[0],
                                                                    first.matrix[8]]
    assert buffer_bytes((Entry(first, 4, 0, BGR8), Entry(second)), 64) == 16 * 12 * 4
    assert buffer_bytes((Entry(first, 4, 100, BGR8),), 64) == 1152      # 4 + 11 * 100 + 48


@pytest.mark.parametrize("entries,message", [
    ((), "there are 0 views, the limits are 1 and 4"),
    (tuple(map(Entry, some(5))), "there are 5 views, the limits are 1 and 4"),
    ((Entry(some(1)[0], 6),), "the offset of view 0 is 6 bytes, a multiple of the memory word's 4"),
    ((Entry(some(1)[0], 0, 66),), "the pitch of view 0 is 66 bytes, a multiple"),
    ((Entry(some(1)[0], 0, 60),), "the pitch of view 0 is 60 bytes, the limits are 64 and 65532"),
    ((Entry(some(1)[0], form=MONO8),), "the format is Mono8, which needs a grey sensor"),
    ((Entry(some(1)[0], strip=33),), "33")])
def test_what_a_list_must_not_hold(entries, message):
    with pytest.raises(InputError, match=message):
        list_values(entries, HARDWARE, lens().geometry)


def test_sizes_and_corners_are_checked():
    views = some(3)
    with pytest.raises(InputError, match="3 views of 1 sizes, a quad needs 4"):
        quad(views)
    with pytest.raises(InputError, match="view 1 has 16x12 pixels from column 15, row 0 on, the "
                                         "picture has 30x12"):
        placed(views, [(0, 0), (15, 0), (0, 0)], (30, 12))
    with pytest.raises(InputError, match="view 0 has 16x12 pixels, the hardware makes up to 16x8"):
        check_largest(placed(views[:1], [(0, 0)], (16, 12)), (16, 8))
    odd = View.identity((18, 12))
    with pytest.raises(InputError, match="view 0 is 18 pixels wide, 4 pixels per clock"):
        list_values((Entry(odd),), Hardware(view=True, views=2, lanes=4), lens().geometry)
    assert placed(views[:1], [(3, 2)], (30, 14))[0] == Entry(views[0], 4 * 63, 120, BGRX8)


@pytest.mark.parametrize("settings,message", [
    (dict(views=2), "the number of views is 2, it needs hardware with a view"),
    (dict(view=True, views=1), "the number of views is 1, the limits are 2 and 8"),
    (dict(view=True, views=9), "the number of views is 9, the limits are 2 and 8"),
    (dict(view=True, views=2, output="stream"), "the number of views is 2, a video stream has one"),
])
def test_hardware_that_has_no_list(settings, message):
    with pytest.raises(InputError, match=message):
        Hardware(**settings)

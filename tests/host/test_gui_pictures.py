"""What the window shows is what the device sends: pixel by pixel, over either transport."""

import numpy as np
import pytest

from devices import SIZE, small_lens
from guis import SECONDS, announced, pixels_of, tab_on, url_of
from ncdc_host.client import open_device
from ncdc_model.example import noise_picture
from ncdc_model.golden.corrector import correct
from ncdc_model.images import demosaic, is_raw, read_image

RAW = noise_picture(*SIZE)
CORRECTED = correct(small_lens(), RAW).picture
SCHEMES = ("gige", "tcp")


def seen(tab):
    """The pixels of the picture on the screen, where each is one of the device's."""
    tab.view.set_scale(1)
    rect = tab.view.picture_rect().toRect()
    return pixels_of(tab.view.grab(rect).toImage())


def differ(a, b):
    return np.abs(a.astype(int) - b).max()


def test_two_devices_over_both_transports(qtbot):
    lenses = [small_lens()], [small_lens(seed=5)]
    with announced(descriptors=lenses[0]) as [one], announced(descriptors=lenses[1]) as [two]:
        with tab_on(qtbot, url_of(one, "gige")) as first, \
                tab_on(qtbot, url_of(two, "tcp")) as second:
            for tab, [lens] in zip((first, second), lenses):
                golden = correct(lens, RAW).picture
                assert differ(seen(tab), golden) <= 2
                assert np.array_equal(tab.shown.frame.pixels, golden)
            counts = first.shown.frame.number, second.shown.frame.number
            qtbot.waitUntil(lambda: first.shown.frame.number > counts[0] + 3
                            and second.shown.frame.number > counts[1] + 3, timeout=SECONDS)
            for tab in (first, second):
                qtbot.waitUntil(lambda: "pictures/s" in tab.rate.text(), timeout=SECONDS)
                assert tab.statistics.values["lost"].text() != "–"
    assert differ(correct(lenses[0][0], RAW).picture, correct(lenses[1][0], RAW).picture) > 2


@pytest.mark.parametrize("scheme", SCHEMES)
def test_before_is_the_raw_frame_and_after_the_corrected_one(qtbot, scheme):
    with announced() as [one], tab_on(qtbot, url_of(one, scheme)) as tab:
        tab.set_mode("before")
        qtbot.waitUntil(lambda: tab.shown.frame.pixel_format.raw, timeout=SECONDS)
        assert differ(seen(tab), demosaic(RAW, "RGGB")) <= 2
        assert np.array_equal(tab.shown.histogram[2], np.bincount(RAW[1::2, 1::2].ravel(),
                                                                  minlength=256))
        tab.set_mode("after")
        qtbot.waitUntil(lambda: not tab.shown.frame.pixel_format.raw, timeout=SECONDS)
        assert differ(seen(tab), CORRECTED) <= 2
        assert np.array_equal(tab.shown.histogram[0],
                              np.bincount(CORRECTED[..., 0].ravel(), minlength=256))


@pytest.mark.parametrize("scheme", SCHEMES)
def test_the_wipe_has_the_raw_frame_left_of_its_line(qtbot, scheme):
    with announced() as [one], tab_on(qtbot, url_of(one, scheme)) as tab:
        tab.set_mode("wipe")
        qtbot.waitUntil(lambda: tab.view.still is not None, timeout=SECONDS)
        middle = SIZE[0] // 2
        picture = seen(tab)
        # The line covers some pixels, and its handle a few more.
        left, right = slice(0, middle - 14), slice(middle + 14, None)
        assert differ(picture[:, left], demosaic(RAW, "RGGB")[:, left]) <= 2
        assert differ(picture[:, right], CORRECTED[:, right]) <= 2
        tab.view.set_wipe(1.0)
        assert differ(seen(tab)[:, left], demosaic(RAW, "RGGB")[:, left]) <= 2
        assert not tab.shown.frame.pixel_format.raw


def test_a_still_leaves_the_picture_as_it_was(qtbot):
    window = {"Width": 32, "Height": 20, "OffsetX": 6, "OffsetY": 4, "PixelFormat": "Mono8",
              "ReverseX": True}
    with announced() as [one]:
        with open_device(url_of(one, "tcp")) as other:
            for name in ("PixelFormat", "ReverseX", "Width", "Height", "OffsetX", "OffsetY"):
                other.set(name, window[name])
            with tab_on(qtbot, url_of(one, "gige")) as tab:
                with qtbot.waitSignal(tab.session.still, timeout=SECONDS) as still:
                    tab.session.take_still("test", mirrored=False)
                assert np.array_equal(still.args[0].shown.frame.pixels, RAW)
                assert {name: other.get(name) for name in window} == window
                with qtbot.waitSignal(tab.session.still, timeout=SECONDS) as still:
                    tab.session.take_still("test")
                assert np.array_equal(still.args[0].shown.frame.pixels, RAW[:, ::-1])
                number = tab.shown.frame.time_ns
                qtbot.waitUntil(lambda: tab.shown.frame.time_ns > number, timeout=SECONDS)


def test_saved_files_hold_the_pixels(qtbot, tmp_path):
    with announced() as [one], tab_on(qtbot, url_of(one, "gige")) as tab:
        tab.set_feature("ReverseX", True)
        qtbot.waitUntil(lambda: tab.infos["ReverseX"].value, timeout=SECONDS)
        qtbot.waitUntil(lambda: np.array_equal(tab.shown.frame.pixels, CORRECTED[:, ::-1]),
                        timeout=SECONDS)
        with qtbot.waitSignal(tab.session.saved, timeout=SECONDS):
            tab.files.save_picture(tmp_path / "picture.png")
        assert np.array_equal(read_image(tmp_path / "picture.png"), CORRECTED[:, ::-1])
        with qtbot.waitSignal(tab.session.saved, timeout=SECONDS):
            tab.files.save_raw(tmp_path / "frame.raw.png")
        raw = read_image(tmp_path / "frame.raw.png")
        assert is_raw(raw) and np.array_equal(raw, RAW)     # as ncdc correct wants it
        with qtbot.waitSignal(tab.session.rejected, timeout=SECONDS):
            tab.files.save_picture(tmp_path / "picture.nothing")
        assert "picture.nothing" in tab.messages.text


def test_a_frozen_picture_stays(qtbot):
    with announced() as [one], tab_on(qtbot, url_of(one, "gige")) as tab:
        tab.freeze()
        frozen = tab.shown
        tab.set_feature("TestPattern", "ColorBar")
        with qtbot.waitSignals(3 * [tab.session.picture], timeout=SECONDS):
            pass
        assert tab.shown is frozen
        tab.freeze()
        qtbot.waitUntil(lambda: tab.shown is not frozen, timeout=SECONDS)


def test_zoom_keeps_what_is_under_the_cursor(qtbot):
    with announced() as [one], tab_on(qtbot, url_of(one, "gige")) as tab:
        view = tab.view
        assert view.fitted
        points = []
        view.pointed.connect(lambda pixel, colour: points.append((pixel.toTuple(), colour)))
        rect = view.picture_rect()
        about = rect.topLeft() + (rect.bottomRight() - rect.topLeft()) * 0.3
        view._point(about)
        view.zoom(4, about)
        view._point(about)
        assert points[0] == points[1] and points[0][0] == (19, 14)
        assert points[0][1] == " ".join(map(str, tab.shown.frame.pixels[14, 19]))
        view.fit()
        assert view.fitted

"""Pictures whose bytes are not those of their size and format: lost, and the stream goes on."""

from dataclasses import replace

import numpy as np
import pytest

from devices import SIZE, device, small_lens
from guis import SECONDS, announced, tab_on, url_of
from ncdc_host.client import NoFrame, open_device
from ncdc_host.device.stream import Stream
from ncdc_model.example import noise_picture
from ncdc_model.golden.corrector import correct
from ncdc_spec.pixel_formats import MONO8
from peers import need

LIES = {"short": lambda frame: {"data": frame.data[:-3000]},
        "long": lambda frame: {"data": memoryview(bytes(frame.data) + bytes(5000))},
        "empty": lambda frame: {"size": (0, 0)},
        "huge": lambda frame: {"size": (100_000, 100_000)},
        "another format": lambda frame: {"pixel_format": MONO8},
        "unknown format": lambda frame: {"pixel_format": replace(MONO8, pfnc=0x01100010)}}
# Aravis drops what is more than the buffer holds: the picture is right.
CASES = [(scheme, lie) for scheme in ("gige", "aravis") for lie in LIES
         if (scheme, lie) != ("aravis", "long")]


@pytest.fixture
def lies(monkeypatch):
    """Makes devices lie about every picture of which ``chosen(block)`` is true."""
    def begin(kind, chosen):
        right = Stream.send_frame

        def send_frame(self, frame, *arguments):
            wrong = LIES[kind](frame) if chosen(self._block + 1) else {}
            right(self, replace(frame, **wrong), *arguments)

        monkeypatch.setattr(Stream, "send_frame", send_frame)
    return begin


@pytest.mark.longer
@pytest.mark.parametrize("scheme,kind", CASES)
def test_the_pictures_between_are_right(lies, scheme, kind):
    if scheme == "aravis":
        need("aravis")
    lies(kind, lambda block: block % 2)
    golden = correct(small_lens(), noise_picture(*SIZE)).picture
    with device(fps=20.0) as one, open_device(url_of(one, scheme)) as opened:
        with opened.stream() as frames:
            taken = [frames.next(SECONDS / 1000) for _ in range(4)]
            counted = frames.statistics
    assert all(np.array_equal(frame.pixels, golden) for frame in taken)
    assert not any(frame.number % 2 for frame in taken)
    assert frames.malformed >= 3 and counted.lost >= 3 and frames.trouble == ""


def test_only_malformed_ones_are_no_picture_with_a_reason(lies):
    lies("short", lambda block: True)
    with device() as one, open_device(url_of(one, "gige")) as opened, opened.stream() as frames:
        with pytest.raises(NoFrame, match="within 1 s: a picture of 64x48 BGR8 came with 6216 "
                                          "bytes, 9216 are needed"):
            frames.next(1)
        assert frames.statistics.frames == 0 and frames.statistics.lost == frames.malformed > 1


def test_the_window_goes_on_and_gives_the_reason(qtbot, lies):
    lies("short", lambda block: block < 40)
    with announced() as [one], tab_on(qtbot, url_of(one, "gige"), pictures=False) as tab:
        qtbot.waitUntil(lambda: tab.session.trouble != "", timeout=SECONDS)
        tab._no_picture_came()
        assert "came with 6216 bytes" in tab.view.text
        qtbot.waitUntil(lambda: tab.shown is not None, timeout=SECONDS)
        assert tab.view.text == ""

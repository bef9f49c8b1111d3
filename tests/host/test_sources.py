"""Frames of a running source: here of a device; see tests/ncdc/test_live_command.py for others."""

import numpy as np

from devices import SIZE, device
from guis import url_of
from ncdc_host.client import open_device
from ncdc_host.sources import frames_of
from ncdc_model.example import noise_picture

RAW = noise_picture(*SIZE)


def test_frames_of_a_device_are_raw_and_whole():
    with device(fps=20.0) as one:
        url = url_of(one, "tcp")
        view = {"CorrectionEnable": True, "ReverseX": True, "Width": SIZE[0] // 2}
        with open_device(url) as other:
            for name, value in view.items():
                other.set(name, value)
        with frames_of(url) as frames:
            (first, start), (second, end) = next(frames), next(frames)
        assert end > start
        np.testing.assert_array_equal(first, RAW)
        np.testing.assert_array_equal(second, RAW)
        with open_device(url) as other:
            assert {name: other.get(name) for name in view} == view

"""Peak memory of ``ncdc plan``, of the command as its own process."""

import json

import pytest

from cameras import barrel_descriptor
from ncdc_spec.descriptor import Descriptor
from ncdc_spec.interpolation import GRADIENT
from peaks import command_peak

LIMIT = 600             # MB, of a frame of twelve million pixels
CAMERA = """image_width: 4000
image_height: 3000
camera_name: wide
camera_matrix: {rows: 3, cols: 3, data: [2400.0, 0, 2010.0, 0, 2402.0, 1492.0, 0, 0, 1]}
distortion_model: plumb_bob
distortion_coefficients: {rows: 1, cols: 5, data: [-0.20, 0.03, 0.0004, -0.0003, 0]}
"""
# A raster scan has more look-ups that change tiles, and more lanes have more to group.
RASTER = "--cache-bytes", 8192, "--cache-split", 4, "--strip", 0, "--pixels-per-clock", 4


def planned(path, *options):
    """Peak memory in MB, and the report, of a plan of the descriptor ``path``."""
    megabytes, text = command_peak("plan", path, *options, "--json", "-")
    return megabytes, json.loads(text)


@pytest.mark.longer
def test_the_peak_grows_by_so_much_per_pixel(tmp_path):
    """The whole frame's arrays of 16 bits stay in memory, and none of 64."""
    peaks = []
    for k, size in enumerate(((160, 120), (1600, 1200))):
        path = tmp_path / f"{k}.toml"
        barrel_descriptor(size, size, interpolation=GRADIENT).save(path)
        megabytes, report = planned(path, *RASTER)
        assert report["misses"] > 0
        peaks.append(megabytes)
    pixels = 1600 * 1200 - 160 * 120
    per_pixel, allowed = (peaks[1] - peaks[0]) / pixels, (LIMIT - peaks[0]) / 12e6
    assert per_pixel < allowed


@pytest.mark.regress
@pytest.mark.parametrize("options", [
    (), ("--pixels-per-clock", 4), ("--memory", "sdram"), ("--follow", "--strip", 0)],
    ids=["planned", "lanes", "sdram", "follow"])
def test_twelve_million_pixels(options, tmp_path):
    (tmp_path / "camera.yaml").write_text(CAMERA)
    command_peak("train", tmp_path / "camera.yaml", "--neurons", 8, "-o", tmp_path / "net.toml")
    assert Descriptor.load(tmp_path / "net.toml").geometry.corrected == (4000, 3000)
    megabytes, report = planned(tmp_path / "net.toml", *options)
    assert report["misses"] > 0 and megabytes < LIMIT

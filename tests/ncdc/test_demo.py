"""The demo as a user runs it, with fewer neurons: its files, its figures, its pictures."""

import json

import pytest

from ncdc import cli
from ncdc_model.images import read_image
from ncdc_spec.descriptor import Descriptor

FILES = {"photo.png", "points.png", "distorted.png", "corrected.png", "comparison.png",
         "errors.png", "net.toml", "ncdc.v", "report.html", "report.json"}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    path = tmp_path_factory.mktemp("demo")
    assert cli.main(["demo", "-o", str(path), "--neurons", "4"]) == 0
    return path


@pytest.mark.longer
def test_every_file_is_there(folder):
    assert FILES <= {path.name for path in folder.iterdir()}
    page = (folder / "report.html").read_text()
    for name in ("comparison.png", "points.png", "errors.png"):
        assert f'src="{name}"' in page
    assert "none differs" in page
    assert read_image(folder / "corrected.png").shape == (480, 640, 3)


@pytest.mark.longer
def test_the_figures_hold(folder):
    report = json.loads((folder / "report.json").read_text())
    d = Descriptor.load(folder / "net.toml")
    assert report["pixels_compared"] == 640 * 480 and report["pixels_different"] == 0
    assert report["hidden_neurons"] == d.hidden_neurons == 4 and report["digest"] == d.digest
    assert (report["simulator"], report["fetch"]) == ("verilator", "cache")
    assert report["windows_fetched"] == report["windows_fetched_expected"]
    assert 1 < report["clocks_per_pixel"] and 0.5 < report["bytes_read_per_pixel"] < 1.1
    # Measured: MSE 0.7581 px², at most 3.073 px. The same seed gives the same network, but for the
    # last bits of another machine's linear algebra: a tenth more is another network.
    real, fixed = (report[f"map_error_{kind}_px"] for kind in ("float", "fixed"))
    assert real["mse"] < 1.1 * 0.7581 and real["max"] < 1.1 * 3.073
    # The integers' error differs from the float network's by no more than the two are apart.
    apart = report["fixed_minus_float_max_px"]
    assert 0 < apart <= 0.0022              # as in test_accuracy.py, of every network
    for key in ("mean", "max"):
        assert abs(fixed[key] - real[key]) <= 2**.5 * apart
    assert report["grey_levels_from_float_max"] <= 1
    assert report["straightness_rms_px"] < report["straightness_before_rms_px"] / 5
    assert report["interpolation"] == d.geometry.interpolation.name == "directional"
    assert report["psnr_gradient_db"] > report["psnr_fast_db"] + 4
    assert report["psnr_gradient_db"] > report["psnr_demosaic_db"] + 2.5
    assert report["psnr_directional_db"] > report["psnr_gradient_db"] + 2.5
    assert report["psnr_demosaic_db"] - report["psnr_fast_db"] <= 1.5
    assert report["psnr_fast_db"] - report["psnr_uncompensated_db"] > 2
    # The rough network may be off by its error at the edge, and no more.
    assert report["blanking_differs_within_px"] <= report["map_error_fixed_px"]["max"]

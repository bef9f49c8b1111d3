"""``ncdc train`` and ``ncdc evaluate``: from points and camera files to descriptors and errors."""

import json
from functools import partial

import cv2
import numpy as np
import pytest

from commands import call
from lenses import lens
from ncdc.cli import evaluate, train
from ncdc_model.calibration.camera_file import load_camera_map
from ncdc_model.calibration.points import PhotoPoints, TargetPoints
from ncdc_model.compare import fitted_view
from ncdc_model.evaluate import evaluate_frame
from ncdc_model.golden.valid import valid_rows
from ncdc_model.lens import Camera
from ncdc_model.plots import plot_error_map
from ncdc_model.training.backprop import Stop, train_backprop
from ncdc_model.training.train import TRAINERS
from ncdc_spec.descriptor import Descriptor
from ncdc_spec.errors import InputError
from ncdc_spec.geometry import ValidRows

SIZE = 320, 240


def page(turn, tilt, name):
    """A dot page seen by :func:`lens`: rotated, tilted, points exact."""
    grid = np.stack(np.meshgrid(np.arange(-16, 17), np.arange(-13, 14)), axis=-1).reshape(-1, 2)
    flat = .095 * grid @ [[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]]
    depth = 1 + flat @ tilt
    x, y = lens().distort(*(flat / depth[:, None]).T)
    on = (x > 3) & (x < 316) & (y > 3) & (y < 236)
    return PhotoPoints(grid[on] + 20, np.stack([x, y], axis=1)[on], np.zeros(on.sum()), {}, name)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Camera file, points of a page, points of another page, and descriptors of the first two."""
    folder = tmp_path_factory.mktemp("train")
    lens().save(folder / "camera.toml")
    TargetPoints("dots", SIZE, (page(.02, (.05, -.03), "a.png"),)).save(folder / "a.json")
    TargetPoints("dots", SIZE, (page(-.04, (-.04, .06), "b.png"),)).save(folder / "b.json")
    call(train, folder / "camera.toml", "--neurons", 5, "-o", folder / "camera-net.toml",
         "--json", folder / "camera-report.json")
    call(train, folder / "a.json", "--neurons", 7, "-o", folder / "net.toml", "--bayer", "GBRG",
         "--fill", "9,8,7", "--json", folder / "report.json")
    return folder


def report_of(command, *arguments, capsys):
    capsys.readouterr()
    call(command, *arguments, "--json", "-")
    return json.loads(capsys.readouterr().out)


@pytest.mark.longer
def test_camera_file_to_descriptor_with_the_errors_of_the_whole_frame(folder):
    descriptor = Descriptor.load(folder / "camera-net.toml")
    report = json.loads((folder / "camera-report.json").read_text())
    camera = lens()
    assert report["hidden_neurons"] == 5 and report["measured_on"] == "frame"
    assert report["map_error_fixed_px"] == report["frame"]["map_error_fixed_px"]
    assert report["map_error_fixed_px"]["mse"] < .05 and report["valid_pixels_lost"] == 0
    measured = evaluate_frame(descriptor, camera.back_map)
    for key in ("map_error_float_px", "map_error_fixed_px", "fixed_minus_float_max_px",
                "valid_pixels"):
        assert measured[key] == pytest.approx(report[key])
        assert descriptor.errors[key] == pytest.approx(report[key])
    np.testing.assert_array_equal(descriptor.valid.spans,
                                  valid_rows(camera.back_map, descriptor.geometry).spans)


@pytest.mark.longer
def test_points_to_descriptor_with_geometry_and_provenance(folder):
    descriptor = Descriptor.load(folder / "net.toml")
    report = json.loads((folder / "report.json").read_text())
    assert report["measured_on"] == "region" and "frame" not in report
    region, inner = (report[name]["map_error_fixed_px"] for name in ("region", "held_out"))
    assert region == report["map_error_fixed_px"] and region["max"] >= inner["max"]
    assert report["held_out"]["points"] + report["training"]["points"] < 900
    assert report["held_out"]["map_error_fixed_px"]["max"] < .5
    assert descriptor.geometry.bayer == "GBRG" and descriptor.geometry.fill == (9, 8, 7)
    about = descriptor.provenance
    assert about["source"] == "a.json" and about["source_kind"] == "dots points"
    assert about["source_hash"] == TargetPoints.load(folder / "a.json").digest
    assert len(about["homography"]) == 9 and (about["trainer"], about["seed"]) == ("lm", 0)
    assert str(folder) not in (folder / "net.toml").read_text()


@pytest.mark.longer
def test_points_know_nearly_the_region_of_the_true_camera(folder):
    descriptor = Descriptor.load(folder / "net.toml")
    camera = load_camera_map(folder / "camera.toml")
    v, u = np.indices((240, 320)).astype(np.float64)
    truth = descriptor.geometry.window_inside(*fitted_view(descriptor, camera)(u, v))
    assert .8 < truth.mean() < .99
    assert (descriptor.valid.mask(320) != truth).mean() < .005


@pytest.mark.longer
def test_same_points_are_evaluated_with_the_trained_pose(folder, capsys):
    report = report_of(evaluate, folder / "net.toml", "--reference", folder / "a.json",
                       capsys=capsys)
    trained = json.loads((folder / "report.json").read_text())
    assert report["measured_on"] == "points, pose trained"
    parts = [trained["training"], trained["held_out"]]
    count = sum(part["points"] for part in parts)
    mse = sum(part["points"] * part["map_error_fixed_px"]["mse"] for part in parts) / count
    assert report["points"] == count
    assert report["map_error_fixed_px"]["mse"] == pytest.approx(mse, rel=.02)


@pytest.mark.longer
def test_another_photo_is_evaluated_with_a_fitted_pose(folder, capsys):
    report = report_of(evaluate, folder / "net.toml", "--reference", folder / "b.json",
                       capsys=capsys)
    trained = json.loads((folder / "report.json").read_text())["held_out"]
    assert report["measured_on"] == "points, pose fitted" and report["points"] > 300
    assert report["map_error_float_px"]["mse"] < 4 * trained["map_error_float_px"]["mse"]


@pytest.mark.longer
def test_points_descriptor_agrees_with_the_true_camera_up_to_the_view(folder, capsys):
    report = report_of(evaluate, folder / "net.toml", "--reference", folder / "camera.toml",
                       capsys=capsys)
    assert report["measured_on"] == "frame, view fitted"
    assert report["map_error_fixed_px"]["mse"] < .02


@pytest.mark.longer
def test_camera_descriptor_compared_with_its_camera_repeats_the_training_report(folder, capsys):
    report = report_of(evaluate, folder / "camera-net.toml", "--reference", folder / "camera.toml",
                       capsys=capsys)
    trained = json.loads((folder / "camera-report.json").read_text())
    assert report["measured_on"] == "frame, view trained"
    for key in ("map_error_float_px", "map_error_fixed_px"):
        assert report[key] == pytest.approx(trained[key])


@pytest.mark.longer
def test_a_wrong_network_is_seen_through_every_fit(folder, tmp_path, capsys):
    good = Descriptor.load(folder / "net.toml")
    network = good.network
    network.output_weights[0, 0] += 8                     # pixels
    Descriptor.quantise(network, good.geometry, good.valid,
                        provenance=good.provenance).save(tmp_path / "bad.toml")
    for file in ("a.json", "b.json", "camera.toml"):
        report = report_of(evaluate, tmp_path / "bad.toml", "--reference", folder / file,
                           capsys=capsys)
        assert report["map_error_fixed_px"]["max"] > .5, file


@pytest.mark.regress
def test_same_seed_writes_the_same_file(folder, tmp_path):
    for name in ("1.toml", "2.toml"):
        call(train, folder / "a.json", "--neurons", 2, "-o", tmp_path / name)
    assert (tmp_path / "1.toml").read_bytes() == (tmp_path / "2.toml").read_bytes()


@pytest.mark.longer
def test_table_and_plots(folder, tmp_path, capsys, monkeypatch):
    call(train, folder / "camera.toml", "--neurons", 2, "--held-out", 0, "--size", "160x120",
         "--zoom", "fill", "-o", tmp_path / "net.toml")
    text = capsys.readouterr().out
    assert "160x120 corrected pixels, 100.0 % with a source" in text
    assert "held out" not in text and "frame         fixed" in text
    for where, name in ((tmp_path, "net"), (folder, "net"), (folder, "camera-net")):
        for kind in ("errors", "learning"):
            picture = cv2.imread(str(where / f"{name}.{kind}.png"))
            assert picture.shape[0] > 300 and picture.std() > 10


def test_error_map_plot_shows_the_errors(tmp_path):
    distance = np.full((60, 80), .1, np.float32)
    distance[:, :20] = np.nan
    plot_error_map(tmp_path / "even.png", distance, "even")
    distance[20:40, 50:70] = .4
    plot_error_map(tmp_path / "spot.png", distance, "spot")
    even, spot = (cv2.imread(str(tmp_path / f"{name}.png")) for name in ("even", "spot"))
    assert even.shape == spot.shape and (even != spot).mean() > .05


@pytest.mark.longer
def test_back_propagation_by_name(folder, tmp_path, monkeypatch):
    monkeypatch.setitem(TRAINERS, "ebp", partial(train_backprop, stop=Stop(epochs=40), runs=2))
    call(train, folder / "a.json", "--neurons", 3, "--trainer", "ebp", "-o", tmp_path / "e.toml")
    descriptor = Descriptor.load(tmp_path / "e.toml")
    assert descriptor.provenance["trainer"] == "ebp"
    assert descriptor.errors["map_error_float_px"]["mse"] < 100


@pytest.mark.regress
def test_beyond_its_points_the_network_follows_the_smooth_lens(tmp_path, capsys, monkeypatch):
    whole = page(.02, (.05, -.03), "a.png")
    x, y = (whole.xy - [160, 120]).T
    middle = (np.abs(x) < 85) & (np.abs(y) < 65)
    part = PhotoPoints(whole.index[middle], whole.xy[middle], whole.area[middle], {}, "part.png")
    TargetPoints("dots", SIZE, (part,)).save(tmp_path / "part.json")
    lens().save(tmp_path / "camera.toml")
    report = report_of(train, tmp_path / "part.json", "--neurons", 7, "-o", tmp_path / "net.toml",
                       capsys=capsys)
    assert report["extrapolated_percent"] > 25 and report["valid_percent"] > 80
    assert report["training"]["points"] + report["held_out"]["points"] == middle.sum()
    compared = report_of(evaluate, tmp_path / "net.toml", "--reference", tmp_path / "camera.toml",
                         capsys=capsys)
    assert compared["map_error_float_px"]["max"] < 3


@pytest.mark.longer
def test_the_source_is_not_replaced(folder):
    before = (folder / "camera.toml").read_bytes()
    with pytest.raises(InputError, match="camera.toml would replace the input"):
        call(train, folder / "camera.toml", "--neurons", 2, "-o", folder / "camera.toml")
    assert (folder / "camera.toml").read_bytes() == before


@pytest.mark.longer
@pytest.mark.parametrize("options,message", [
    (["--size", "320"], "size is '320', WxH is needed"),
    (["--fill", "1,2,300"], "fill is '1,2,300', R,G,B is needed, each of 0..255"),
    (["--zoom", "wide"], "zoom is 'wide', fit, fill or a number"),
    (["--size", "5000x240"], "corrected_width is 5000, the limits are 8 and 4096"),
    (["--neurons", "40"], "40 hidden neurons are asked for, the limits are 1 and 32"),
    (["--seed", "-1"], "seed is -1, it must not be negative"),
    (["--held-out", "1"], "one held-out point in 1 leaves none to train on"),
])
def test_bad_options_are_named(folder, tmp_path, options, message):
    with pytest.raises(InputError, match=message):
        call(train, folder / "a.json", "--neurons", 2, "-o", tmp_path / "n.toml", *options)
    assert not (tmp_path / "n.toml").exists()


@pytest.mark.longer
def test_a_camera_of_another_size_is_rejected(folder, tmp_path):
    camera = lens().to_dict() | {"width": 640}
    Camera.from_dict(camera).save(tmp_path / "other.toml")
    with pytest.raises(InputError, match="camera is for 640x240 pixels, the sensor has 320x240"):
        call(evaluate, folder / "net.toml", "--reference", tmp_path / "other.toml")


@pytest.mark.longer
def test_lost_pixels_are_warned_of(folder, tmp_path, capsys, monkeypatch):
    of_mask = ValidRows.of_mask

    def first_half(mask):
        return of_mask(mask & (np.arange(mask.shape[1]) < 160))
    monkeypatch.setattr("ncdc_model.training.pipeline.ValidRows.of_mask", first_half)
    call(train, folder / "a.json", "--neurons", 2, "-o", tmp_path / "n.toml")
    assert "pixels with a source are left blank" in capsys.readouterr().err

"""Every kind of input file, damaged in every way: one sentence and exit 2, or it is right."""

import json
import os
import re
import tomllib
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from cases import cases
from lenses import GEOMETRY, known_network, lens
from ncdc.cli import main
from ncdc_model.calibration.camera_file import load_camera_map
from ncdc_model.calibration.points import PhotoPoints, TargetPoints
from ncdc_model.images import write_image
from ncdc_model.lens import AsymmetricSurface
from ncdc_spec.descriptor import Descriptor
from ncdc_spec.errors import InputError
from ncdc_spec.geometry import ValidRows

_VALUES = ("nan", "inf", "-1", "1e400", "1e30", "0.5", "0", '"x"', "[]", "{}", "true", "[[1]]",
           "9" * 400)
_TEXTS = {"empty": b"", "blank": b"\n\n", "a word": b"word", "zeros": bytes(100),
          "noise": bytes(range(256)), "a list": b"[1, 2]", "deep": b"[" * 100000,
          "deep braces": b'{"a":' * 100000, "utf-16": "version = 1".encode("utf-16")}


def points_text():
    index = np.array([(i, j) for j in range(5) for i in range(6)])
    xy = np.stack([index[:, 0] * 50.0 + 35, index[:, 1] * 45.0 + 30], axis=1)
    xy += .02 * (xy - 120) * np.abs(xy - 120) / 120
    photo = PhotoPoints(index, xy, np.zeros(len(index)), name="a.png")
    return TargetPoints("chessboard", (320, 240), (photo,))


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A folder with one good file of each kind."""
    folder = tmp_path_factory.mktemp("good")
    points_text().save(folder / "points.json")
    replace(lens().framed(), surface=AsymmetricSurface(
        (320, 240), 1.0, ((.1, .2),), (.3,), ((1.0, 2.0),))).save(folder / "camera.toml")
    matrix = "{rows: 3, cols: 3, data: [160, 0, 160, 0, 160, 120, 0, 0, 1]}"
    (folder / "camera.yaml").write_text(
        f"image_width: 320\nimage_height: 240\ncamera_matrix: {matrix}\n"
        "distortion_model: plumb_bob\n"
        "distortion_coefficients: {rows: 1, cols: 5, data: [-0.1, 0.01, 0.0, 0.0, 0.0]}\n")
    (folder / "opencv.json").write_text(json.dumps({
        "K": [160, 0, 160, 0, 160, 120, 0, 0, 1], "D": [.1, .01, 0, 0], "width": 320,
        "height": 240}))
    (folder / "kalibr.yaml").write_text(
        "cam0:\n  camera_model: pinhole\n  intrinsics: [160, 160, 160, 120]\n"
        "  distortion_model: equidistant\n  distortion_coeffs: [0.1, 0.01, 0.0, 0.0]\n"
        "  resolution: [320, 240]\n")
    Descriptor.quantise(known_network(), GEOMETRY, ValidRows.everything(320, 240)).save(
        folder / "net.toml")
    write_image(folder / "frame.png", np.arange(320 * 240).reshape(240, 320).astype(np.uint8))
    return folder


class _Trained(InputError):
    """Raised instead of a training: the input was accepted."""


@pytest.fixture
def rejected(folder, tmp_path, capsys, monkeypatch):
    """Run the command that reads a file of a kind; its sentence, "" if the file was accepted."""
    def train_camera(*_):
        raise _Trained("accepted")
    monkeypatch.setattr("ncdc.cli.train.train_camera", train_camera)
    output = tmp_path / "out.png"
    commands = {"net.toml": lambda path: ["correct", path, str(folder / "frame.png")],
                "frame.png": lambda path: ["correct", str(folder / "net.toml"), path]}

    def run(kind, path):
        output.write_bytes(b"as it was")
        command = commands.get(kind, lambda path: ["train", path, "--neurons", "2"])(str(path))
        status = main([*command, "-o", str(output)])
        said = capsys.readouterr().err
        if status == 0 or said.splitlines()[-1:] == ["ncdc train: accepted"]:
            return ""
        lines = [line for line in said.splitlines() if not re.match(r"\w+: +\d+ %", line)]
        assert status == 2 and len(lines) == 1 and len(lines[0]) < 1000, said
        assert output.read_bytes() == b"as it was"
        return lines[0]
    return run


KINDS = ("points.json", "camera.toml", "camera.yaml", "opencv.json", "kalibr.yaml", "net.toml")


def test_the_good_files_are_accepted(rejected, folder):
    assert {kind: rejected(kind, folder / kind) for kind in (*KINDS, "frame.png")} == dict.fromkeys(
        (*KINDS, "frame.png"), "")


@pytest.mark.parametrize("kind", (*KINDS, "frame.png"))
@pytest.mark.parametrize("name", _TEXTS)
def test_nonsense_is_rejected(rejected, tmp_path, kind, name):
    path = tmp_path / kind
    path.write_bytes(_TEXTS[name])
    assert str(path) in rejected(kind, path)


@pytest.mark.parametrize("kind", (*KINDS, "frame.png"))
def test_what_is_no_file_is_rejected(rejected, tmp_path, kind):
    if kind != "frame.png":     # a folder of pictures is corrected into another one
        assert "Is a directory" in rejected(kind, tmp_path)
    assert "No such file" in rejected(kind, tmp_path / "none" / kind)
    assert "it is a device" in rejected(kind, Path("/dev/zero"))
    if os.geteuid():
        path = tmp_path / kind
        path.touch(mode=0)
        assert "Permission denied" in rejected(kind, path)


@pytest.mark.parametrize("kind", KINDS)
def test_marks_and_line_ends_of_other_systems_are_read(rejected, folder, tmp_path, kind):
    content = (folder / kind).read_bytes()
    path = tmp_path / kind
    for written in (b"\xef\xbb\xbf" + content, content.replace(b"\n", b"\r\n")):
        path.write_bytes(written)
        assert rejected(kind, path) == ""


@pytest.mark.parametrize("kind", (*KINDS, "frame.png"))
def test_a_part_of_a_file_is_no_traceback(rejected, folder, tmp_path, kind):
    content = (folder / kind).read_bytes()
    path = tmp_path / kind
    for part in np.linspace(0, len(content), 12, endpoint=False).astype(int):
        path.write_bytes(content[:part])
        rejected(kind, path)


def changed(text, part, parts):
    """Texts of a file with one number, or one name, changed; a note of each.

    Of all pairs of a number and a value for it those of one part in ``parts``: each number gets
    every ``parts``-th value, each value comes to every ``parts``-th number.
    """
    matches = list(re.finditer(r"(?<![\w.\"])-?\d+(\.\d+)?(e-?\d+)?(?![\w.\"])", text))
    step = max(1, len(matches) // 12)
    for n, match in enumerate(matches[::step]):
        for value in _VALUES[(part - n) % parts::parts]:
            yield f"{n} {value}", text[:match.start()] + value + text[match.end():]
    for match in re.finditer(r"(?m)(?<=^)\w+(?= ?[=:])|\"\w+\"(?=:)", text):
        yield f"without {match[0]}", text[:match.start()] + '"zz"' + text[match.end():]


@pytest.mark.parametrize("part", [
    0, *(pytest.param(part, marks=pytest.mark.regress) for part in range(1, 4))])
@pytest.mark.parametrize("kind", cases(KINDS, longer=["points.json"]))
def test_a_wrong_value_is_no_traceback(rejected, folder, tmp_path, kind, part):
    path = tmp_path / kind
    for note, text in changed((folder / kind).read_text(), part, 4):
        path.write_text(text)
        try:
            rejected(kind, path)
        except Exception as error:
            raise AssertionError(f"{kind}, {note}: {error!r}") from error


IMPORTED = {
    "camodocal.yaml": (
        "%YAML:1.0\n---\nmodel_type: MEI\nimage_width: 320\nimage_height: 240\nmirror_parameters:\n"
        "   xi: 1.2\ndistortion_parameters:\n   k1: -0.1\n   k2: 0.01\n   p1: 0.0\n   p2: 0.0\n"
        "projection_parameters:\n   gamma1: 360.0\n   gamma2: 361.0\n   u0: 160.0\n   v0: 120.0\n"),
    "transforms.json": json.dumps({
        "w": 320, "h": 240, "fl_x": 160.0, "fl_y": 160.0, "cx": 160.0, "cy": 120.0, "k1": -.1,
        "k2": .01, "camera_model": "OPENCV", "frames": [{"file_path": "a"}]}, indent=0),
    "realsense.json": json.dumps({
        "width": 320, "height": 240, "ppx": 160.0, "ppy": 120.0, "fx": 160.0, "fy": 160.0,
        "model": "brown_conrady", "coeffs": [-.1, .01, 0.0, 0.0, 0.0]}, indent=0),
    "cameras.txt": "# Camera list\n1 OPENCV 320 240 160.0 160.0 160.0 120.0 -0.1 0.01 0.0 0.0\n",
    "c.cameramodel": ("{\n'lensmodel': 'LENSMODEL_OPENCV4',\n'intrinsics': [160.0, 160.0, 160.0, "
                      "120.0, -0.1, 0.01, 0.0, 0.0],\n'imagersize': [320, 240],\n}\n"),
    "Calib_Results.m": ("fc = [ 160.0 ; 160.0 ];\ncc = [ 160.0 ; 120.0 ];\nalpha_c = 0.0;\nkc = [ "
                        "-0.1 ; 0.01 ; 0.0 ; 0.0 ; 0.0 ];\nnx = 320;\nny = 240;\n"),
    "ost.ini": ("[image]\nwidth\n320\nheight\n240\n[cam]\ncamera matrix\n160.0 0.0 160.0\n"
                "0.0 160.0 120.0\n0.0 0.0 1.0\ndistortion\n-0.1 0.01 0.0 0.0 0.0\n"),
    "stereo.yml": ("%YAML:1.0\n---\nM1: !!opencv-matrix\n   rows: 3\n   cols: 3\n   dt: d\n   "
                   "data: [ 160., 0., 160., 0., 160., 120., 0., 0., 1. ]\nD1: !!opencv-matrix\n"
                   "   rows: 1\n   cols: 5\n   dt: d\n   data: [ -0.1, 0.01, 0., 0., 0. ]\n"
                   "image_size: [ 320, 240 ]\n")}


@pytest.mark.longer
@pytest.mark.parametrize("kind", IMPORTED)
def test_files_of_other_programs_spoilt_are_one_sentence(tmp_path, kind):
    path, text, accepted = tmp_path / kind, IMPORTED[kind], []
    damaged = [text.encode(), *_TEXTS.values()]
    damaged += [text.encode()[:part] for part in range(0, len(text), len(text) // 12)]
    damaged += [part.encode() for _, part in changed(text, 0, 4)]
    for content in damaged:
        path.write_bytes(content)
        try:
            load_camera_map(path, zoom=.5)
            accepted.append(content)
        except InputError as error:
            assert str(error).startswith(str(path)) and "\n" not in str(error)
            assert len(str(error)) < 1000
    assert text.encode() in accepted and len(accepted) < len(damaged) / 2


@pytest.mark.parametrize("change,sentence", [
    ({"f_corrected": -3.0}, "f_corrected is -3, it must be positive"),
    ({"f_distorted": 0}, "f_distorted is 0, it must be positive"),
    ({"corrected_size": [96.5, 64]}, "corrected_size is 96.5, a whole number of 8 to 4096"),
    ({"corrected_size": [96, 5000]}, "corrected_size is 5000, a whole number of 8 to 4096"),
    ({"p": [.5]}, "p is [0.5], at least 2 numbers are needed"),
    ({"tilt": [0, 0]}, "the camera has the unknown value 'tilt'"),
    ({"residual": {"scale": 1, "bump_centres": [[0, 0]], "bump_vectors": [[1, 1]]}},
     "1 bump_centres, 0 bump_sigmas and 1 bump_vectors"),
    ({"residual": {"scale": 1, "bump_centres": [[0, 0]], "bump_vectors": [[1, 1]],
                   "bump_sigmas": [0]}}, "bump_sigmas holds 0.0, positive numbers"),
    ({"residual": {"scale": 1, "poly": [[1, 2], [3, 4]]}}, "two rows of nine numbers"),
    ({"residual": {"bump_sigmas": []}}, "the camera's residual lacks the value 'scale'"),
    ({"residual": 3}, "the camera's residual is 3, names and values are needed"),
])
def test_a_wrong_camera_is_named(rejected, folder, tmp_path, change, sentence):
    table = tomllib.loads((folder / "camera.toml").read_text()) | change
    residual = table.pop("residual")
    lines = [f"{name} = {json.dumps(value)}" for name, value in table.items()]
    if isinstance(residual, dict):
        lines += ["[residual]"] + [f"{name} = {json.dumps(value)}"
                                   for name, value in residual.items()]
    else:
        lines.append(f"residual = {residual}")
    path = tmp_path / "camera.toml"
    path.write_text("\n".join(lines))
    assert sentence in rejected("camera.toml", path)


@pytest.mark.parametrize("keep", [
    lambda i, j: j == 2, lambda i, j: j < 2, lambda i, j: i == 0, lambda i, j: i == j])
def test_points_of_one_or_two_lines_are_rejected(rejected, tmp_path, keep):
    index = np.array([(i, j) for j in range(30) for i in range(30) if keep(i, j)])
    xy = index * 7.0 + 20 + .01 * index**2
    path = tmp_path / "points.json"
    TargetPoints("dots", (320, 240), (PhotoPoints(index, xy, np.ones(len(index))),)).save(path)
    assert "12 whole points on at least 3 rows and 3 columns" in rejected("points.json", path)


def test_points_at_one_position_are_rejected(rejected, tmp_path):
    index = np.array([(i, j) for j in range(5) for i in range(6)])
    path = tmp_path / "points.json"
    TargetPoints("dots", (320, 240), (PhotoPoints(index, index * 0. + 50, np.ones(30)),)).save(path)
    assert "explains the points" in rejected("points.json", path)


def test_a_broken_points_file_is_reported_as_one(rejected, folder, tmp_path):
    path = tmp_path / "points.json"
    path.write_text((folder / "points.json").read_text()[:200])
    assert f"{path} is no points file: " in rejected("points.json", path)


def test_interruption_is_one_line(folder, tmp_path, monkeypatch, capsys):
    def interrupted(*_):
        raise KeyboardInterrupt
    monkeypatch.setattr("ncdc.cli.train.train_camera", interrupted)
    assert main(["train", str(folder / "points.json"), "--neurons", "2",
                 "-o", str(tmp_path / "net.toml")]) == 130
    *warnings, last = capsys.readouterr().err.strip().splitlines()
    assert last == "ncdc train: interrupted" and "Traceback" not in "".join(warnings)

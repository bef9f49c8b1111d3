"""Points of one's own detector as CSV: lattices in any unit, and what is wrong in a sentence."""

import numpy as np
import pytest

from ncdc.cli import main
from ncdc_model.calibration.frame import ideal_frame
from ncdc_model.calibration.points import PhotoPoints, TargetPoints
from ncdc_model.calibration.points_csv import load_csv, save_csv
from ncdc_model.lens import Camera
from ncdc_spec.errors import InputError

HEADER = "photo,object_x,object_y,object_z,image_x,image_y\n"


def lens():
    return Camera.from_dict({"width": 320, "height": 240, "f_distorted": 160.0,
                             "centre": [161.0, 118.5], "k": [.02]})


def board(aspect=1.0, photos=2):
    """Exact photos of a board whose rows are ``aspect`` as far apart as its columns."""
    index = np.array([(i, j) for j in range(8) for i in range(11)])
    shots = []
    for k in range(photos):
        flat = (index - (5, 3.5)) * (1, aspect)
        rays = np.column_stack([flat + (.2 * k, -.1 * k), 5.5 + .06 * flat[:, 0] * (k - .5)])
        shots.append(PhotoPoints(index, np.stack(lens().project(rays), axis=1),
                                 np.zeros(len(index)), name=f"{k}, x.png"))
    return TargetPoints("chessboard", (320, 240), tuple(shots), aspect=aspect)


@pytest.mark.parametrize("aspect", [pytest.param(1.0, marks=pytest.mark.longer), 3**-.5])
def test_what_export_writes_is_read_again(tmp_path, aspect):
    points = board(aspect)
    points.save(tmp_path / "points.json")
    assert main(["export", str(tmp_path / "points.json"), "-o", str(tmp_path / "p.csv")]) == 0
    read = load_csv(tmp_path / "p.csv", (320, 240))
    assert read.aspect == pytest.approx(aspect, abs=1e-6) and read.size == points.size
    for ours, theirs in zip(read.photos, points.photos):
        assert ours.name == theirs.name
        np.testing.assert_array_equal(ours.index, theirs.index)
        np.testing.assert_allclose(ours.xy, theirs.xy, atol=6e-5)
    fitted, exact = ideal_frame(read), ideal_frame(points)
    # The digits that the CSV has move the whole view by some thousandths of a pixel.
    np.testing.assert_allclose(fitted.corrected, exact.corrected, atol=5e-3)


@pytest.mark.parametrize("write", [
    lambda column, row: (column * 25.4, row * 25.4),                     # millimetres
    lambda column, row: (round(column * .03, 4), round(row * .03 - .105, 4)),     # metres
    lambda column, row: (-10 * column, 3 + 10 * row)])
def test_the_lattice_is_found_in_any_unit(tmp_path, write):
    points = board()
    lines = ["object_y,object_x,score,image_x,image_y"]
    for (column, row), (x, y) in zip(points.photos[0].index, points.photos[0].xy):
        across, down = write(column, row)
        lines.append(f"{down:g}, {across:g}, 0.9, {x}, {y}")
    (tmp_path / "p.csv").write_text("\n".join(lines))
    read = load_csv(tmp_path / "p.csv", (320, 240))
    expected = points.photos[0].index * (1, 1)
    if write(1, 0)[0] < 0:
        expected[:, 0] = 10 - expected[:, 0]
    np.testing.assert_array_equal(read.photos[0].index, expected)
    assert read.aspect == pytest.approx(1, abs=1e-6)
    frame = ideal_frame(read)
    # The view is the lens's own, whatever the target's unit and direction.
    np.testing.assert_allclose(frame.corrected, ideal_frame(board(photos=1)).corrected, atol=.02)


def test_corners_of_tags_lie_on_a_finer_lattice(tmp_path):
    tag, gap = .088, .0264
    positions = np.array([k * (tag + gap) + side for k in range(4) for side in (0, tag)])
    lines = [HEADER.strip()] + [f"a,{x:.4f},{y:.4f},0,{40 + 500 * x},{30 + 450 * y}"
                                for y in positions for x in positions]
    (tmp_path / "p.csv").write_text("\n".join(lines))
    index = load_csv(tmp_path / "p.csv", (320, 240)).photos[0].index
    assert np.unique(index[:, 0]).tolist() == [0, 10, 13, 23, 26, 36, 39, 49]


@pytest.mark.longer
def test_a_network_is_trained_and_measured(tmp_path, capsys):
    save_csv(tmp_path / "p.csv", board(photos=3), "opencv")
    train = ["train", str(tmp_path / "p.csv"), "--neurons", "2", "--trainer", "ebp",
             "--epochs", "30", "-o", str(tmp_path / "net.toml")]
    assert main(train) == 2
    said = capsys.readouterr().err
    assert "the size of the photos is not known; --sensor-size WxH gives it" in said
    assert main([*train, "--sensor-size", "320x240"]) == 0
    capsys.readouterr()
    measure = ["evaluate", str(tmp_path / "net.toml"), "--reference", str(tmp_path / "p.csv")]
    assert main(measure) == 0
    assert "measured on points, pose trained" in capsys.readouterr().out


def rows(count=20):
    return "".join(f"a,{k % 5},{k // 5},0,{40 + 30 * (k % 5)},{40 + 30 * (k // 5)}\n"
                   for k in range(count))


@pytest.mark.parametrize("text,message", [
    ("", "the first line names no columns"), (HEADER, "it holds no points"),
    ("x,y,u,v\n1,2,3,4\n", "names x, y, u, v: object_x, object_y, image_x, image_y is missing"),
    ("photo,direction,line,y,x\na,horizontal,0,1,2\n", "in the style of Discorpy"),
    (HEADER + rows() + "a,1,2,x,3,4\n", "line 22 holds no number"),
    (HEADER + rows() + "a,1,2,0,3\n", "line 22 holds no number"),
    (HEADER + rows() + "a,9,9,3.5,3,4\n", "object_z is 3.5 in line 22, 0 is needed: the target"),
    (HEADER + rows() + "a,9,9,0,nan,4\n", "line 22 holds a number that is not finite"),
    (HEADER + rows() + "a,4,3,0,50,50\n", "21 points have 20 different indices"),
    (HEADER + rows() + "a,4,9,0,350,50\n", r"point \(350, 50\) lies outside the image of 320x240"),
    (HEADER + "a,1,1,0,3,4\na,1,2,0,3,8\n", "object_x is 1 in every line"),
    (HEADER + rows() + "a,1.2345,9,0,50,50\na,2.7182,9,0,60,50\n", "object_x lie on no lattice"),
])
def test_bad_files_are_named(tmp_path, text, message):
    (tmp_path / "p.csv").write_text(text)
    with pytest.raises(InputError, match=message) as caught:
        load_csv(tmp_path / "p.csv", (320, 240))
    assert str(caught.value).startswith(str(tmp_path / "p.csv"))

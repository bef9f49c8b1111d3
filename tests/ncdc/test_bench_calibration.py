"""``ncdc bench calibration``: its rows on small photos, compared with the same version."""

import json

import pytest

from ncdc.cli import main
from ncdc_bench.calibration import command, measure, photos
from ncdc_bench.photos.targets import Pose


@pytest.fixture
def small(monkeypatch):
    """The bench on one small photo of a ChArUco board."""
    sets = {"board": photos.PhotoSet("charuco:9x6", (960, 720), [Pose(step=.3)])}
    for module in (command, measure, photos):
        monkeypatch.setattr(module, "SETS", sets)


@pytest.mark.longer
def test_both_versions_are_measured_on_the_same_photos(small, tmp_path, capsys):
    folder = tmp_path / "photos"
    folder.mkdir()
    report = tmp_path / "report.json"
    assert main(["bench", "calibration", "--older", str(measure.ROOT), "--folder", str(folder),
                 "--json", str(report)]) == 0
    calibrate, train = json.loads(report.read_text())["rows"]
    assert (calibrate["command"], train["command"]) == ("calibrate", "train")
    assert 30 < calibrate["points"] == calibrate["reference_points"] <= 40
    # The map has no limit of its own: beyond the board, one photo says little about the lens.
    assert calibrate["points_rms_px"] < .1
    for row, error in ((calibrate, "points_rms_px"), (train, "true_rms_px")):
        assert 0 < row[error] == row[f"reference_{error}"]
        assert row["ratio"] == row["seconds"] / row["reference_seconds"]
    assert [path.suffix for path in sorted(folder.glob("board-*"))] == [".npz", ".png"]


@pytest.mark.parametrize("options,message", [
    (["--only", "fog"], "no set of photos has 'fog' in its name"),
    (["--older", "nowhere"], "nowhere holds no checkout of NCDC"),
    (["--folder", "nowhere"], "the folder nowhere does not exist")])
def test_bad_requests_are_named(options, message, capsys):
    assert main(["bench", "calibration", *options]) == 2
    assert message in capsys.readouterr().err

"""``ncdc bench system``: which runs a camera has, and what counts as a failure."""

import pytest

from ncdc.cli import main
from ncdc_bench.system.command import failures
from ncdc_bench.system.measure import FAULTS, runs_of

# As of a run without any failure.
ROW = {"width": 640, "height": 480, "memory": "sdram", "fault": None, "pixels_different": 0,
       "frames_torn": 0, "camera_bytes_dropped": 0, "clocks_per_pixel": 1.5,
       "predicted_clocks_per_pixel": None, "follow_bound_clocks": None, "recovered": None,
       "csi_faults": 0}


def faults(camera):
    return {run.fault for run in runs_of(camera, True)} - {""}


def test_a_camera_has_the_faults_of_its_port():
    assert faults("mt9p031") == FAULTS.keys() - {"checksum"}
    assert faults("imx219") == {"checksum", "cut_frame", "memory_stall", "nack", "stuck_sda"}
    runs = runs_of("ov5647", False)
    assert {run.camera for run in runs} == {"ov5647"} and max(run.size for run in runs)[0] == 1920


def test_an_unknown_camera_is_rejected(capsys):
    assert main(["bench", "system", "--camera", "d5m", "--quick"]) == 2
    assert "the sensor is 'd5m', known are mt9p031" in capsys.readouterr().err


@pytest.mark.parametrize("change,said", [
    ({}, []), ({"csi_faults": 3}, ["640x480 on sdram: the receiver counted 3 faults"]),
    ({"csi_faults": 1, "fault": "checksum", "recovered": True}, []),
    ({"fault": "checksum", "recovered": False}, ["checksum: the fault was not reported"]),
    ({"pixels_different": 2}, ["640x480 on sdram: 2 pixels differ"])])
def test_failures(change, said):
    assert failures([ROW | change]) == said

"""``ncdc bench system``: which runs a camera has, and what counts as a failure."""

import pytest

from ncdc.cli import main
from ncdc_bench.system import uhd
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


# Of a run in which every frame came in time.
UHD = {"interpolation": "gradient", "memory": "ddr3", "clock_mhz": 125, "cache_bytes": 131072,
       "frames": 2, "pixels_different": 0, "frames_skipped": 0, "frames_lost": 0,
       "clocks": 2_080_000, "predicted_clocks": 2_081_000, "clocks_per_pixel": .2508,
       "frames_per_second": 60.1, "bytes_read": 8_000_000.0, "bytes_read_expected": 8_000_000,
       "bytes_written": 8_294_400.0, "amplification": 1.003, "memory_load": .6}


@pytest.mark.parametrize("change,said", [
    ({}, ""), ({"pixels_different": 2}, "131072 bytes of cache: 2 pixels differ"),
    ({"frames_skipped": 1}, "1 frames of the camera were skipped"),
    ({"frames_lost": 1}, "1 frames were lost"),
    ({"bytes_read": 8_000_032.0}, "8000032 bytes were read for a frame, 8000000 are expected"),
    ({"frames_per_second": 59.9}, "59.90 frames per second, at least 60 are asked for"),
    ({"clocks": 2_110_000}, "2081000 clocks of a frame were predicted, 2110000 are measured")])
def test_a_camera_of_3840x2160_fails_by_its_figures(monkeypatch, capsys, change, said):
    monkeypatch.setattr(uhd, "measure", lambda runs, progress: [UHD | change])
    assert main(["bench", "system", "--uhd"]) == (1 if said else 0)
    out, err = capsys.readouterr()
    assert said in err and "ddr3@125" in out


def test_the_camera_of_3840x2160_is_no_sensor(capsys):
    assert main(["bench", "system", "--uhd", "--camera", "imx219"]) == 2
    assert "--uhd and --camera imx219 are given" in capsys.readouterr().err


def test_the_camera_of_3840x2160_sends_60_frames_per_second():
    assert 0 <= uhd.UHD.frames_per_second - uhd.FRAMES_PER_SECOND < .01


@pytest.mark.many_clocks
@pytest.mark.regress
def test_every_frame_of_3840x2160_is_corrected_in_time():
    row, = uhd.measure(uhd.RUNS[:1])
    assert row.keys() >= UHD.keys() and uhd.failures([row]) == []
    assert (row["frames"], row["pixels_compared"]) == (2, 2 * 3840 * 2160)

"""viva-genicam, Aravis and tshark with emulated devices, in a network of their own."""

import subprocess
import time

import pytest

from cameras import barrel_descriptor
from ncdc_bench.client.command import complaints, rows_of, table
from ncdc_bench.client.measure import Case, case_row, discovery_rows, killed_row, monitor_row
from ncdc_sim.tools import SimulationError
from ncdc_spec.protocols.features import FEATURES
from peers import need, served

LENS = barrel_descriptor((320, 240), (320, 240), 4)
FAST = {"CorrectionEnable": 1, "AcquisitionFrameRate": 20, "GevSCPD": 50_000}
BOTH = ("gige", "aravis")


@pytest.fixture(scope="module")
def three(tmp_path_factory):
    """Three devices that lose nothing."""
    need("aravis")
    with served(tmp_path_factory.mktemp("three"), LENS, count=3) as one:
        yield one


@pytest.mark.longer
def test_both_find_every_device(three):
    rows = discovery_rows(three, 3)
    assert [row["found"] for row in rows] == [3, 3]


def unhurried(row_of):
    """The row of the first of three runs in which every frame came whole, or of the last.

    A receiver that a busy machine keeps from its socket for longer than a device keeps packets
    reports a frame that is not whole. No pixel may be wrong in any run.
    """
    for _ in range(3):
        row = row_of()
        if not row["incomplete"] or row["wrong_pixels"]:
            break
    return row


@pytest.mark.longer
@pytest.mark.parametrize("scheme", BOTH)
def test_every_feature_and_frames_of_three_devices(three, scheme):
    row = unhurried(lambda: case_row(
        three, Case(scheme, 3, 5, every_feature=True, settings=FAST)))
    assert row["features"] == row["features_read_back"] == 3 * len(FEATURES)
    assert (row["frames"], row["incomplete"], row["wrong_pixels"]) == (15, 0, 0)
    # Aravis' packet socket gets single packets: of 160 per frame, a busy machine loses a few.
    assert row["resent"] < 20 * row["frames"]


@pytest.mark.longer
def test_a_wrong_pixel_is_seen(three, monkeypatch):
    """Frames of the raw source, compared with the corrected picture."""
    right = three.expected(True)
    monkeypatch.setattr(three, "expected", lambda corrected: right)
    row = case_row(three, Case("gige", 1, 2, settings={"CorrectionEnable": 0}))
    assert row["wrong_pixels"] == 2 * 320 * 240 and complaints([row])


@pytest.mark.longer
def test_monitors_watch_and_do_not_write(three):
    row = unhurried(lambda: monitor_row(three, 5, 2, FAST))
    assert (row["frames"], row["incomplete"], row["wrong_pixels"]) == (5, 0, 0)
    assert row["writes_rejected"] == 2


@pytest.mark.longer
def test_control_is_free_when_its_holder_is_killed(three):
    row = killed_row(three)
    # Not before the heartbeat's time, which runs from the last command before the death.
    assert 1 < row["seconds_until_free"]


@pytest.mark.longer
def test_a_second_controller_is_rejected(three):
    holder = three.start(three.task("gige", frames=100_000))
    while holder.stderr.readline() != "streaming\n":
        assert holder.poll() is None
    for scheme in BOTH:
        with pytest.raises(SimulationError, match="Rejected"):
            three.report(three.start(three.task(scheme, settings={"Gain": 2})))
    holder.kill()
    holder.wait()


@pytest.fixture(scope="module")
def lossy(tmp_path_factory):
    """A device that loses one packet in twenty."""
    need("tshark", "aravis")
    with served(tmp_path_factory.mktemp("lossy"), LENS, loss=0.05) as one:
        yield one


@pytest.mark.longer
@pytest.mark.parametrize("scheme", BOTH)
def test_lost_packets_are_sent_again_and_none_is_malformed(lossy, tmp_path, scheme):
    """Frames are whole although packets get lost, and tshark's dissectors know every packet."""
    file = tmp_path / "capture.pcapng"
    capture = lossy.network.start(["tshark", "-q", "-i", lossy.network.client_link, "-w",
                                   str(file)], stderr=subprocess.PIPE)
    while "Capture" not in (line := capture.stderr.readline()):
        assert line
    time.sleep(0.5)
    row = unhurried(lambda: case_row(
        lossy, Case(scheme, 1, 5, 0.05, every_feature=True, settings=FAST)))
    lossy.report(lossy.start(lossy.task("discover")))
    capture.terminate()
    capture.wait(20)
    assert (row["frames"], row["incomplete"], row["wrong_pixels"]) == (5, 0, 0)
    assert row["resent"] > 0
    lines = dissected(file)
    assert sum("gvcp" in line for line in lines) > 200
    assert sum("gvsp" in line for line in lines) > 400
    assert malformed(lines) == []


def dissected(file):
    """Protocols and complaints of every packet in a capture, a line each."""
    return subprocess.run(
        ["tshark", "-r", str(file), "--enable-heuristic", "gvsp_udp", "-T", "fields", "-e",
         "frame.protocols", "-e", "_ws.malformed"], capture_output=True, text=True,
        check=True).stdout.splitlines()


def malformed(lines):
    return [line for line in lines if "malformed" in line.lower()]


@pytest.mark.longer
def test_a_malformed_packet_is_seen(tmp_path):
    """A discovery whose header announces more than there is."""
    need("tshark")
    text = tmp_path / "packet.txt"
    text.write_text("0000 42 01 00 02 00 40 00 01 00\n")
    subprocess.run(["text2pcap", "-q", "-4", "10.77.0.1,10.77.0.11", "-u", "5000,3956",
                    str(text), str(tmp_path / "one.pcap")], check=True, capture_output=True)
    text.write_text("0000 42 01 00 80 00 04 00 01 00\n")
    subprocess.run(["text2pcap", "-q", "-4", "10.77.0.1,10.77.0.11", "-u", "5000,3956",
                    str(text), str(tmp_path / "two.pcap")], check=True, capture_output=True)
    assert malformed(dissected(tmp_path / "one.pcap") + dissected(tmp_path / "two.pcap"))


@pytest.mark.regress
def test_the_whole_bench():
    need("aravis")
    rows = rows_of(False, lambda step: None)
    assert complaints(rows) == [], table(rows)

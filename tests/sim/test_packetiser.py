"""Packets from memory: every byte, under pauses of memory and link; tshark reads them."""

import re
import subprocess

import pytest

from cocotb_run import design_of, run_cocotb
from ncdc_hdl.link.packet_queue import PacketQueue
from ncdc_hdl.link.packetiser import Packetiser
from ncdc_sim.tools import SimulationError
from peers import need

pytestmark = pytest.mark.longer

regress = pytest.mark.regress

CAPACITY = 512


def run(data_width=32, simulator="icarus", packetiser=Packetiser, **given):
    """The log of the bench."""
    values = {"stall": 0.3, "wait": 0.3, "latency": [1, 30], "seed": 1, "frames": 12,
              "payload": CAPACITY, "capacity": CAPACITY, "rate": [], "bytes": 8192} | given
    capacity = values["capacity"]
    design = design_of(packetiser(data_width, capacity=capacity), top=f"dut_packets{data_width}")
    return run_cocotb(design, "packetiser", simulator, **values)


@pytest.mark.parametrize("data_width,simulator,given", [
    pytest.param(32, "icarus", {"stall": 0, "wait": 0, "latency": [1, 1]}, marks=regress),
    (64, "icarus", {}),
    (128, "verilator", {"seed": 2, "stall": 0.6}),
    *(pytest.param(width, "verilator", {"seed": seed, "frames": 60, "stall": stall,
                                        "latency": [1, 60]}, marks=regress)
      for width in (32, 64, 128) for seed, stall in ((3, 0.6), (4, 0.1)))])
def test_packets(data_width, simulator, given):
    run(data_width, simulator, **given)


def test_tshark_knows_every_packet(tmp_path):
    """Ethernet, IP with its check sum, UDP and GVSP: none is malformed, numbers and blocks are
    as they should be."""
    need("tshark")
    text, capture = tmp_path / "packets.txt", tmp_path / "packets.pcap"
    packets = re.findall(r"PACKET (\w+)", run(64))
    text.write_text("".join("000000 " + " ".join(re.findall("..", packet)) + "\n"
                            for packet in packets))
    subprocess.run(["text2pcap", "-q", str(text), str(capture)], check=True, capture_output=True)
    fields = ("frame.protocols", "_ws.malformed", "ip.checksum.status", "gvsp.blockid16",
              "gvsp.packetid24", "gvsp.sizex")
    lines = subprocess.run(
        ["tshark", "-r", str(capture), "-d", "udp.port==50000,gvsp", "-o",
         "ip.check_checksum:TRUE", "-T", "fields", *(part for name in fields
                                                      for part in ("-e", name))],
        capture_output=True, text=True, check=True).stdout.splitlines()
    rows = [line.split("\t") for line in lines]
    assert {row[0] for row in rows} == {"eth:ethertype:ip:udp:gvsp"}
    assert {row[1] for row in rows} == {""} and {row[2] for row in rows} == {"1"}
    numbers = [(int(row[3], 0), int(row[4], 0)) for row in rows]
    assert numbers == [(block, number) for block in (7, 8) for number in range(7)]
    assert {row[5] for row in rows} == {"", "40"}


RATE = {"stall": 0, "wait": 0, "latency": [60, 60], "frames": 0}


def check_rate(rates, packets, capacity):
    """A bench without ``rates`` skips that test: here it has run, with each of them."""
    log = run(32, "verilator", capacity=capacity, rate=rates, packets=packets,
              bytes=packets * max(rates), **RATE)
    assert [int(payload) for payload in re.findall(r"RATE (\d+)", log)] == rates


def test_a_gigabit_port_never_waits():
    check_rate([1456], packets=12, capacity=3840)


@regress
def test_nor_with_jumbo_frames():
    check_rate([1456, 8960], packets=60, capacity=18176)


class Hasty(PacketQueue):
    """A planted error: a packet begins with its first beat."""

    def _may_begin(self, whole):
        return self.put | (whole != 0)


def test_a_packet_that_begins_too_early_is_found(monkeypatch):
    monkeypatch.setattr("ncdc_hdl.link.packetiser.PacketQueue", Hasty)
    with pytest.raises(SimulationError, match="failed: gvsp, mraw, any_headers"):
        run(32, stall=0, frames=1)


class Crowded(Packetiser):
    """A planted error: two packets at a time, whether or not the queue has space for them."""

    def _pair(self):
        return self.capacity


def test_packets_without_space_are_found():
    with pytest.raises(SimulationError, match="failed: mraw"):
        run(32, packetiser=Crowded, stall=0.9, frames=1)

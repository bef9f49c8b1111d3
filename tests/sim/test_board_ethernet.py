"""Boards with a processor: from the sensor's pins to the network's cable, and to the screen of one
that has it.

What the cable brings and what comes back is made and read by scapy and tshark."""

import struct
import subprocess
from collections import defaultdict
from dataclasses import replace

import numpy as np
import pytest
from scapy.layers.inet import ICMP, IP, UDP
from scapy.layers.l2 import ARP, Ether
from scapy.packet import Raw
from scapy.utils import wrpcap

from board_bench import SMALL, Bench
from ncdc_boards.camera_board.design import hardware_for
from ncdc_boards.catalogue import board
from ncdc_boards.quartus import plls
from ncdc_hdl.video.modes import mode_named
from ncdc_sim.board.ethernet import Ethernet, Passed
from ncdc_soc import board as soc_board
from ncdc_soc import firmware
from ncdc_spec.interpolation import FAST, GRADIENT
from ncdc_spec.protocols import gvcp
from ncdc_spec.protocols.features import feature
from peers import need

pytestmark = pytest.mark.regress        # compiling it takes a minute

DEVICE, ADDRESS = "02:4e:0a:4d:00:0b", "10.77.0.11"
PC, PC_ADDRESS = "02:00:00:00:00:01", "10.77.0.10"
GVCP_FROM, GVSP_TO = 50000, 50001
BEGINS_US = 8000            # when the chip has a link
MODES = {"de2-115": SMALL, "colorlight-i9": None}
COLOUR = {"de2-115": FAST, "colorlight-i9": GRADIENT}       # its tiles share block RAMs
# In the firmware, what makes the chip's clock to us late: as it is, and forgotten.
RECEIVED_LATE = {"de2-115": ("0x0080 | BY_CHIP", "0x0000 | BY_CHIP"),
                 "colorlight-i9": ("0x8107", "0x8007")}


@pytest.fixture(scope="module", autouse=True)
def quick_reset():
    """The chip's reset takes a tenth of its time."""
    need("riscv64-unknown-elf-gcc")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(soc_board, "_RESET_MS", 1)
        yield


@pytest.fixture(scope="module", params=MODES)
def bench(request):
    return Bench(request.param, MODES[request.param], (64, 24), processor=True,
                 interpolation=COLOUR[request.param])


def to_device(data, port=gvcp.PORT):
    return Ether(dst=DEVICE, src=PC) / IP(src=PC_ADDRESS, dst=ADDRESS) / UDP(
        sport=GVCP_FROM, dport=port) / Raw(data)


def write_register(request, address, value):
    return gvcp.command_packet(gvcp.WRITEREG, request, struct.pack(">II", address, value))


def asked():
    """What the cable brings: ARP, an echo, and GVCP's way to a stream of pictures."""
    pc = int.from_bytes(bytes(map(int, PC_ADDRESS.split("."))), "big")
    commands = [gvcp.command_packet(gvcp.DISCOVERY, 1)] + [
        write_register(request, address, value) for request, (address, value) in enumerate((
            (gvcp.register("ControlPrivilege").address, 2),
            (gvcp.register("StreamPort").address, GVSP_TO),
            (gvcp.register("StreamAddress").address, pc),
            (feature("AcquisitionStart").address, 1)), 2)]
    packets = [
        Ether(dst="ff:ff:ff:ff:ff:ff", src=PC) / ARP(op=1, hwsrc=PC, psrc=PC_ADDRESS,
                                                     pdst=ADDRESS),
        Ether(dst=DEVICE, src=PC) / IP(src=PC_ADDRESS, dst=ADDRESS) / ICMP() / Raw(b"anyone there"),
        *map(to_device, commands)]
    return tuple(Passed(BEGINS_US + 300 * k, bytes(packet)) for k, packet in enumerate(packets))


def changed_firmware(folder, monkeypatch, old, new):
    """From here on phy.c has another text."""
    sources = folder / "firmware"
    subprocess.run(["cp", "-r", str(firmware.FIRMWARE), str(sources)], check=True)
    text = (sources / "phy.c").read_text()
    assert text.count(old) == 1
    (sources / "phy.c").write_text(text.replace(old, new))
    monkeypatch.setattr(firmware, "FIRMWARE", sources)


def run(bench, run_us, received):
    files = soc_board.processor_files(bench.design, bench.sensor)
    return bench.run(run_us, optimise="-O1", ethernet=Ethernet(files, received))


def pictures(packets, size):
    """The whole pictures of GVSP packets, BGR."""
    parts = defaultdict(dict)
    for packet in packets:
        data = packet[Raw].load
        _, block, word = struct.unpack_from(">HHI", data)
        parts[block][word & 0xFFFFFF, word >> 24] = data[8:]
    found = []
    for _, block in sorted(parts.items()):
        kinds = {kind for _, kind in block}
        if kinds != {1, 2, 3}:
            continue                # the last one is not over
        last = max(number for number, _ in block)
        data = b"".join(block[number, 3] for number in range(1, last))
        found.append(np.frombuffer(data, np.uint8).reshape(size[1], size[0], 3))
    return found


@pytest.fixture(scope="module")
def whole(bench):
    return run(bench, BEGINS_US + 9000, asked())


def test_pictures_go_to_the_network_and_to_the_screen(bench, whole):
    results = whole.results
    assert results["violations"] == results["failures"] == 0
    assert results["refreshes"] > 0 and results["beats_written"] > 0
    assert results["ethernet_errors"] == 0 and results["ethernet_resets"] == 1
    assert results["ethernet_received"] == 7
    packets = [Ether(passed.data) for passed in whole.sent]
    arp, echo, *rest = packets
    assert arp[ARP].hwsrc == DEVICE and arp[ARP].psrc == ADDRESS
    assert echo[ICMP].type == 0 and echo[Raw].load.startswith(b"anyone there")
    answers = [gvcp.parse_acknowledge(packet[Raw].load) for packet in rest
               if packet[UDP].dport == GVCP_FROM]
    assert [(status, request) for status, _, request, _ in answers] == [
        (0, k) for k in range(1, 6)]
    goldens = bench.golden(0)
    taken = pictures([packet for packet in rest if packet[UDP].dport == GVSP_TO], bench.size)
    assert len(taken) >= 3
    for picture in taken:
        assert any(np.array_equal(picture[..., ::-1], golden) for golden in goldens)
    if bench.mode is None:
        assert results["led"] == 1
        return
    assert results["underruns"] == 0
    shown = [bench.inside(frame) for frame in whole.screen.frames]
    assert sum(any(np.array_equal(frame, golden) for golden in goldens) for frame in shown) >= 3


def test_tshark_knows_every_frame(whole, tmp_path):
    need("tshark")
    capture = tmp_path / "cable.pcap"
    wrpcap(str(capture), [Ether(passed.data) for passed in whole.sent])
    fields = ("frame.protocols", "_ws.malformed", "ip.checksum.status")
    rows = [line.split("\t") for line in subprocess.run(
        ["tshark", "-r", str(capture), "-d", f"udp.port=={GVSP_TO},gvsp", "-o",
         "ip.check_checksum:TRUE", "-T", "fields", *(part for name in fields
                                                      for part in ("-e", name))],
        capture_output=True, text=True, check=True).stdout.splitlines()]
    assert len(rows) == len(whole.sent)
    assert {row[1] for row in rows} == {""}
    assert {row[2] for row in rows if ":ip" in row[0]} == {"1"}
    kinds = {row[0].rpartition(":")[2] for row in rows}
    assert {"arp", "gvcp", "gvsp"} <= kinds


def test_a_chip_that_is_not_set_up_is_not_understood(bench, tmp_path, monkeypatch):
    """Its clock to us comes with the data, unless it is configured to be late."""
    changed_firmware(tmp_path, monkeypatch, *RECEIVED_LATE[bench.design.board.name])
    result = run(bench, BEGINS_US + 1000, asked()[:2])
    assert result.results["ethernet_resets"] == 1 and result.sent == []


def test_a_clock_that_is_sent_with_the_data_is_seen(bench, tmp_path, monkeypatch):
    """The device sends that clock on one board, the chip on the other."""
    if bench.design.board.ethernet.delays:
        changed_firmware(tmp_path, monkeypatch, "BY_CHIP(0x0200)", "0")
    else:
        monkeypatch.setattr(plls, "_ETHERNET_LATE_PS", 0)
        bench = Bench("de2-115", SMALL, (64, 24), processor=True)
    result = run(bench, BEGINS_US + 1000, asked()[:2])
    assert result.results["ethernet_errors"] > 0


@pytest.mark.parametrize("name,run_us", [("de2-115", 190_000), ("colorlight-i9", 150_000)])
def test_whole_pictures_on_the_network_and_on_a_screen_at_once(name, run_us):
    """640x480 at the sensor's own rate: memory serves camera, corrector, packets, and the screen of
    the board that has one."""
    mode = mode_named("640x480")
    hardware = replace(hardware_for(board(name)), strip=256)
    bench = Bench(name, mode if MODES[name] else None, mode.size, frames=4, processor=True,
                  interpolation=COLOUR[name], hardware=hardware)
    files = soc_board.processor_files(bench.design, bench.sensor)
    result = bench.run(run_us, optimise="-O2", ethernet=Ethernet(files, asked()))
    results = result.results
    assert results["violations"] == results["ethernet_errors"] == results["failures"] == 0
    goldens = bench.golden(0)
    sent = [Ether(passed.data) for passed in result.sent]
    taken = pictures([packet for packet in sent if UDP in packet and packet[UDP].dport == GVSP_TO],
                     bench.size)
    assert len(taken) >= 3
    for picture in taken:
        assert any(np.array_equal(picture[..., ::-1], golden) for golden in goldens)
    if bench.mode is None:
        return
    assert results["underruns"] == 0
    numbers = [number for number in bench.shown(result) if number is not None]
    assert len(set(numbers)) >= 3

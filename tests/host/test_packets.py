"""The page on packets: its drawing and its filters, compared with packets and with tshark."""

import re
import subprocess
from pathlib import Path

import pytest

from ncdc_bench.figures.packet_diagrams import FILE, PACKETS, draw_packets
from ncdc_spec.pixel_formats import BGR8
from ncdc_spec.protocols import gvcp, gvsp
from ncdc_spec.protocols.table_one import REQUEST, WRITE
from ncdc_spec.protocols.table_two import MrawHeader
from peers import need

DOCS = Path(__file__).resolve().parents[2] / "docs"
PAGE = (DOCS / "reference" / "packets.md").read_text()
COMMAND = gvcp.command_packet(gvcp.READREG, 0x1234, b"\0\0\x0a\0")
STREAM = {
    "leader": gvsp.leader(7, 0x0102030405, BGR8, (640, 480), (16, 8)),
    "payload": gvsp.header(7, gvsp.PAYLOAD, 1) + bytes(64),
    "trailer": gvsp.trailer(7, 2, 480)}


def drawn(title, packet):
    """Numbers of a packet's fields, as the drawing has them."""
    at, found = 0, {}
    for name, size in PACKETS[title]:
        if size:
            found[name] = int.from_bytes(packet[at:at + size], "big")
            at += size
    if not any(size == 0 for _, size in PACKETS[title]):
        assert at == len(packet)
    return found


def test_the_drawing_is_of_the_packets_that_are_sent():
    head = {"status": 0, "block": 7}
    assert drawn("GVSP: leader (kind 1)", STREAM["leader"]) == head | {
        "kind": 1, "packet": 0, "reserved": 0, "type": 1, "time": 0x0102030405,
        "pixel format": BGR8.pfnc, "width": 640, "height": 480, "column": 16, "row": 8,
        "padding x": 0, "padding y": 0}
    assert drawn("GVSP: payload (kind 3)", STREAM["payload"]) == head | {"kind": 3, "packet": 1}
    assert drawn("GVSP: trailer (kind 2)", STREAM["trailer"]) == head | {
        "kind": 2, "packet": 2, "reserved": 0, "type": 1, "height": 480}
    assert drawn("GVCP: command", COMMAND) == {
        "0x42": 0x42, "flags": 1, "command": gvcp.READREG, "length": 4, "request": 0x1234}
    answer = gvcp.acknowledge(gvcp.parse_command(COMMAND), gvcp.ACCESS_DENIED)
    assert drawn("GVCP: answer", answer) == {
        "status": gvcp.ACCESS_DENIED, "answer to": gvcp.READREG + 1, "length": 0,
        "request": 0x1234}
    assert drawn("Table I: request, answer", REQUEST.pack(WRITE, 9, 777)) == {
        "code": WRITE, "address": 9, "value": 777}
    header = MrawHeader(640, 480, BGR8, "10.77.0.11", 4000, 5).pack()
    assert drawn("Table II: MRAW package", header) == {
        "width": 640, "height": 480, "formation": BGR8.mraw, "size": 3 * 640 * 480,
        "socket ip": 0x0A4D000B, "socket port": 4000, "capture time": 5}


def test_the_drawing_is_current(tmp_path):
    draw_packets(tmp_path)
    assert (tmp_path / FILE).read_bytes() == (DOCS / "figures" / FILE).read_bytes()


@pytest.fixture(scope="module")
def captures(tmp_path_factory):
    """A capture of GVCP, and one of GVSP."""
    need("tshark")
    folder = tmp_path_factory.mktemp("packets")
    for name, ports, packets in (("gvcp", "5000,3956", [COMMAND]),
                                 ("gvsp", "3957,50000", STREAM.values())):
        (folder / f"{name}.txt").write_text("".join(
            f"000000 {packet.hex(' ')}\n" for packet in packets))
        subprocess.run(["text2pcap", "-q", "-4", "10.77.0.1,10.77.0.11", "-u", ports,
                        str(folder / f"{name}.txt"), str(folder / f"{name}.pcap")],
                       check=True, capture_output=True)
    return folder


def shown(capture, *arguments):
    """What tshark prints of a capture."""
    done = subprocess.run(
        ["tshark", "-r", str(capture), "-d", "udp.port==50000,gvsp", *arguments],
        text=True, capture_output=True)
    assert done.returncode == 0, done.stderr
    return done.stdout.splitlines()


def test_tshark_reads_the_same_numbers(captures):
    names = ("gvsp.blockid16", "gvsp.format", "gvsp.packetid24", "gvsp.timestamp", "gvsp.pixel",
             "gvsp.sizex", "gvsp.sizey", "gvsp.offsetx", "gvsp.offsety", "_ws.malformed")
    rows = [line.split("\t") for line in shown(
        captures / "gvsp.pcap", "-T", "fields", *(part for name in names
                                                  for part in ("-e", name)))]
    numbers = [[int(cell, 0) if cell else None for cell in row] for row in rows]
    assert numbers == [
        [7, 1, 0, 0x0102030405, BGR8.pfnc, 640, 480, 16, 8, None],
        [7, 3, 1, *[None] * 7], [7, 2, 2, None, None, None, 480, None, None, None]]
    assert shown(captures / "gvcp.pcap", "-T", "fields", "-e", "gvcp.cmd.command", "-e",
                 "gvcp.cmd.req_id", "-e", "_ws.malformed") == ["0x0080\t0x1234\t"]


@pytest.mark.longer
def test_the_page_s_filters_are_tshark_s(captures):
    table = PAGE.partition("| to see | display filter |")[2].partition("\n\n")[0]
    filters = [row.split("`")[1] for row in table.splitlines() if "`" in row]
    found = re.findall(r'-Y "?([^"\n]*)"?', PAGE)
    assert len(filters) >= 7 and found == ["gvcp", "gvsp && frame.number < 200"]
    for one in [*filters, *found]:
        shown(captures / "gvsp.pcap", "-Y", one)
    assert len(shown(captures / "gvsp.pcap", "-Y", "gvsp.format == 1")) == 1

"""What device and client agree on: the paper's tables as printed, the rest declared once."""

import itertools
import struct
import xml.etree.ElementTree as ElementTree

import numpy as np
import pytest

from ncdc_model.images import mosaic
from ncdc_spec.errors import InputError
from ncdc_spec.geometry import BAYER_PHASE
from ncdc_spec.pixel_formats import (
    BGR8,
    BGRA8,
    MONO8,
    PIXEL_FORMATS,
    bayer_format,
    format_of_mraw,
    format_of_name,
    format_of_pfnc,
    packed,
    unpacked,
)
from ncdc_spec.protocols import gvcp, gvsp, table_one
from ncdc_spec.protocols.features import FEATURES, feature
from ncdc_spec.protocols.genicam import genicam_xml
from ncdc_spec.protocols.table_two import FIELDS, HEADER_BYTES, MRAW_BYTES_MAX, MrawHeader

# The paper's Table I and II, typed from its pages.
TABLE_ONE = """
0x80	2 bytes	2 bytes	Read setting from CMOS sensor register.
0x81	2 bytes	2 bytes	Write setting to CMOS sensor register.
0x82	-	-	Reserve.
0x83	-	-	Receive an MRAW package.
"""
TABLE_TWO = """
Width	4	Image width.
Height	4	Image height.
Formation	1	Image formation.
Size	7	Image size.
Socket IP	4	Ethernet IP of verification system.
Socket Port	4	Ethernet port of verification system.
Capture time	4	Capture time from camera subsystem.
"""


def test_table_one_is_the_papers():
    rows = [f"0x{c.code:02X}\t{c.address}\t{c.data}\t{c.text}" for c in table_one.COMMANDS]
    assert rows == TABLE_ONE.strip().splitlines()
    assert table_one.REQUEST.pack(0x81, 0x0102, 0xA0B0) == bytes.fromhex("81 0102 a0b0")


def test_table_two_is_the_papers():
    assert [f"{f.name}\t{f.length}\t{f.text}" for f in FIELDS] == TABLE_TWO.strip().splitlines()
    header = MrawHeader(1280, 1024, BGR8, "192.168.1.20", 4000, 0x1_2345_6789)
    assert header.pack() == bytes.fromhex(
        "00000500 00000400 10 000000003c0000 c0a80114 00000fa0 23456789".replace(" ", ""))
    assert MrawHeader.unpack(header.pack()) == MrawHeader(1280, 1024, BGR8, "192.168.1.20", 4000,
                                                          0x2345_6789)


@pytest.mark.parametrize("change,message", [
    ({0: 0}, "width 0, the limits are 1 and 4096"), ({0: 4097}, "width 4097"),
    ({1: 0xFFFFFFFF}, "height 4294967295"), ({2: 0x04}, "0x04 of Table II is none of"),
    ({3: 2**56 - 1}, "says 72057594037927935 bytes, a picture of 64x48 Mono8 has 3072"),
    ({3: 0}, "says 0 bytes"), ({5: 65536}, "port 65536")])
def test_bad_mraw_headers_are_rejected(change, message):
    values = [64, 48, MONO8.mraw, 3072, 1, 4000, 7]
    for offset, value in change.items():
        values[offset] = value
    data = b"".join(v.to_bytes(f.length, "big") for f, v in zip(FIELDS, values))
    with pytest.raises(InputError, match=message):
        MrawHeader.unpack(data)
    with pytest.raises(InputError, match="27 bytes"):
        MrawHeader.unpack(data[:-1])


def test_no_random_header_announces_more_than_the_largest_picture():
    rng = np.random.default_rng(1)
    good = 0
    for _ in range(3000):
        data = bytearray(MrawHeader(64, 48, BGRA8, "1.2.3.4", 4000, 0).pack())
        for offset in rng.integers(0, HEADER_BYTES, rng.integers(1, 6)):
            data[offset] = rng.integers(0, 256)
        try:
            header = MrawHeader.unpack(bytes(data))
        except InputError:
            continue
        good += 1
        assert header.size <= MRAW_BYTES_MAX
    assert good > 100       # those whose address, port or time alone changed


def test_formats_are_found_by_each_of_their_numbers():
    for one in PIXEL_FORMATS:
        assert format_of_name(one.name) == format_of_pfnc(one.pfnc) == format_of_mraw(one.mraw)
        # The code says how many bits a pixel takes.
        assert one.pfnc >> 16 & 0xFF == 8 * one.pixel_bytes
    for pattern, (column, row) in BAYER_PHASE.items():
        assert bayer_format(pattern).mraw == column | row << 1     # as the register BAYER_PHASE


def test_pictures_are_packed_and_unpacked():
    picture = np.random.default_rng(2).integers(0, 256, (6, 8, 3), np.uint8)
    for one, stored in ((BGR8, picture[..., ::-1]), (BGRA8, np.dstack(
            [picture[..., ::-1], np.zeros((6, 8), np.uint8)]))):
        assert np.array_equal(packed(picture, one), stored)
        assert np.array_equal(unpacked(packed(picture, one), one), picture)
    grey = packed(picture, MONO8)
    for (y, x), value in np.ndenumerate(grey):
        red, green, blue = (int(v) for v in picture[y, x])
        assert value == (red + 2 * green + blue + 2) // 4
    raw = mosaic(picture)
    assert np.array_equal(packed(raw, bayer_format("RGGB")), raw)


def test_no_two_features_share_an_address():
    addresses = [one.address for one in FEATURES]
    assert len(set(addresses)) == len({f.name for f in FEATURES}) == len(FEATURES)
    for a, b in itertools.combinations([f for f in FEATURES if f.table], 2):
        for one, other in itertools.product(a.parts, b.parts):
            assert one.address != other.address or not one.mask & other.mask, (a.name, b.name)
    words = [word.address for word in table_one.SYSTEM_WORDS]
    assert len(set(words)) == len(words) and min(words) >= table_one.SYSTEM_PAGE


def test_xml_is_whole_and_has_every_feature():
    root = ElementTree.fromstring(genicam_xml())
    space = "{http://www.genicam.org/GenApi/Version_1_1}"
    names = [node.get("Name") for node in root]
    assert len(set(names)) == len(names)
    used = {node.text for node in root.iter() if node.tag.startswith(f"{space}p")
            and node.tag != f"{space}pPort"}
    assert used <= set(names)
    addresses = {int(node.text, 16) for node in root.iter(f"{space}Address")}
    assert addresses == {one.address for one in FEATURES}
    assert {one.name for one in FEATURES} <= set(names)
    assert genicam_xml() == genicam_xml()


def test_xml_follows_the_table():
    before = genicam_xml()
    changed = [f if f.name != "Gain" else type(f)(**{**vars(f), "high": 99}) for f in FEATURES]
    found = genicam_xml(features=changed)
    assert found != before and b"12.375" in found


def test_gvcp_packets():
    packet = gvcp.command_packet(gvcp.READREG, 7, struct.pack(">I", 0xA00))
    assert packet == bytes.fromhex("42 01 0080 0004 0007 00000a00".replace(" ", ""))
    command = gvcp.parse_command(packet)
    assert (command.code, command.request, command.answered) == (0x80, 7, True)
    for bad in (packet[:7], packet[:-1], packet + b"\0", b"\x43" + packet[1:]):
        assert gvcp.parse_command(bad) is None
    answer = gvcp.acknowledge(command, gvcp.ACCESS_DENIED)
    assert answer == bytes.fromhex("8006 0081 0000 0007".replace(" ", ""))
    assert gvcp.parse_acknowledge(answer) == (0x8006, 0x81, 7, b"")


def test_gvsp_packets():
    leader = gvsp.leader(5, 0x1_0000_0002, BGR8, (640, 480), (2, 4))
    assert leader == bytes.fromhex(
        "0000 0005 01000000 0000 0001 0000000100000002 02180015 00000280 000001e0 00000002 "
        "00000004 0000 0000".replace(" ", ""))
    assert gvsp.trailer(5, 9, 480) == bytes.fromhex(
        "0000 0005 02000009 0000 0001 000001e0".replace(" ", ""))
    assert gvsp.payload_packets(921600, 1500) == (1464, 630)


def test_limits_of_features_are_those_of_their_words():
    for one in FEATURES:
        if one.parts and one.access == "rw" and not one.choices:
            width = sum(part.width for part in one.parts)
            assert one.high < 1 << width or one.high_from, one.name
    assert feature("ExposureTime").table == (0x08, 0x09)

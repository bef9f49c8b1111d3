"""The transmitter's packets by the specification's examples and by others' programs."""

from types import SimpleNamespace

import numpy as np
import pytest
from amaranth.lib.crc.catalog import CRC16_MCRF4XX

from ncdc_hdl.camera.csi2.packing import Packing
from ncdc_sim.csi2.lanes import Lanes
from ncdc_sim.csi2.packets import checksum, long_packet, pack, short_packet, with_ecc
from ncdc_sim.csi2.run import receive
from ncdc_spec.sensors.csi2 import SAMPLE_BITS_OF, DataType


def test_a_header_of_a_sensor():
    """2,400 bytes of RAW10, as a logic analyser saw them."""
    assert with_ecc(0, DataType.RAW10, 2400) == bytes.fromhex("2B 60 09 1D")


@pytest.mark.parametrize("payload,sent", [
    ("FF 00 00 02 B9 DC F3 72 BB D4 B8 5A C8 75 C2 7C 81 F8 05 DF FF 00 00 01", "F0 00"),
    ("FF 00 00 00 1E F0 1E C7 4F 82 78 C5 82 E0 8C 70 D2 3C 78 E9 FF 00 00 01", "69 E5")])
def test_checksums_of_the_specification(payload, sent):
    assert checksum(bytes.fromhex(payload)) == bytes.fromhex(sent)


def test_checksum_equals_that_of_amaranths_catalogue():
    peer = CRC16_MCRF4XX(8)
    for length in range(40):
        payload = np.random.default_rng(length).bytes(length)
        assert checksum(payload) == peer.compute(payload).to_bytes(2, "little")


@pytest.mark.parametrize("kind", SAMPLE_BITS_OF, ids=lambda kind: kind.name)
@pytest.mark.parametrize("lanes", [1, 2, 4])
def test_the_unpacker_knows_where_each_sample_lies(lanes, kind):
    bits = SAMPLE_BITS_OF[kind]
    samples = np.random.default_rng(bits).integers(0, 1 << bits, 16)
    payload, packing = pack(samples, bits), Packing(bits, lanes)
    for number, sample in enumerate(samples):
        value = payload[packing.upper(number)] << packing.low_bits
        if packing.low_bits:
            byte, first = packing.lower(number)
            value |= payload[byte] >> first & (1 << packing.low_bits) - 1
        assert value == sample


@pytest.mark.parametrize("bits,groups", [(10, 4), (12, 2)])
def test_only_whole_groups_are_packed(bits, groups):
    with pytest.raises(ValueError):
        pack(np.zeros(groups + 1), bits)


@pytest.mark.parametrize("kind", [DataType.RAW10, DataType.RAW12], ids=lambda kind: kind.name)
def test_samples_equal_those_of_pidng(kind):
    """Any bytes of a row are unpacked as pidng unpacks those of a Raspberry Pi's camera."""
    core = pytest.importorskip("pidng.core")
    bits, rows, width = SAMPLE_BITS_OF[kind], 6, 60
    rng = np.random.default_rng(bits)
    payload = rng.integers(0, 256, (rows, width * bits // 8), np.uint8)
    model = SimpleNamespace(fmt={"size": (width, rows), "bpp": bits, "format": "CSI2P"})
    expected = core.RPICAM2DNG(model).__unpack_pixels__(payload)
    wire = Lanes(2, rng)
    wire.rest(3)
    for packet in (short_packet(0, DataType.FRAME_START),
                   *(long_packet(0, kind, row.tobytes()) for row in payload),
                   short_packet(0, DataType.FRAME_END)):
        wire.burst(packet)
    frame, = receive(2, *wire.clocks, channel=0, kind=kind).frames
    assert not frame.bad and np.array_equal(np.array(frame.rows) >> 12 - bits, expected)

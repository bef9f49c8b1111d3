"""A picture from memory to RGMII's wires: packetiser, LiteEth's MAC, cocotbext-eth's PHY."""

import cocotb
from cocotb.triggers import Timer, with_timeout
from cocotbext.eth import RgmiiPhy

from benches.avalon import read_memory
from benches.common import settings, start
from benches.ethernet import GAP_BITS, filled
from benches.packetiser import SOURCE, TARGET, Link
from ncdc_spec.pixel_formats import format_of_name
from ncdc_spec.protocols.link_headers import gvsp_headers
from ncdc_spec.registers.link_map import CONTROL_SEND

__all__ = ["a_picture_leaves"]


@cocotb.test()
async def a_picture_leaves(dut):
    """Each packet once, whole, in order, without an error, no slower than asked for."""
    s = settings()
    phy = RgmiiPhy(dut.tx_data, dut.tx_en, dut.tx_clk, dut.rx_data, dut.rx_dv, dut.rx_clk)
    await start(dut, csr__read=0, csr__write=0, memory_rst=1, bus__waitrequest=0)
    dut.memory_rst.value = 0
    link = Link(dut, s["seed"])
    cocotb.start_soon(read_memory(dut, "bus", link.content, wait=s["wait"],
                                  latency=tuple(s["latency"])))
    await Timer(4, "us")        # the chip's reset, 256 clocks
    picture = (format_of_name("BayerGB8"), s["width"], s["height"])
    headers = gvsp_headers(SOURCE, TARGET, picture, 7, 123_456_789_012, s["payload"])
    await link.prepare(headers, 0)
    await link.put(CONTROL=CONTROL_SEND)
    first = end = None
    for number, expected in enumerate(link.frame(headers, 0)):
        wire = await with_timeout(phy.tx.recv(), 200, "us")
        assert not any(wire.error or ()), f"packet {number} is sent with an error"
        assert wire.check_fcs(), f"packet {number} is sent with a wrong check sequence"
        assert wire.get_payload() == filled(expected), f"packet {number} is sent wrong"
        assert end is None or wire.sim_time_start - end >= GAP_BITS * 1000, \
            f"the gap before packet {number} is too short"
        end = wire.sim_time_end
        if number == 1:
            first = wire.sim_time_start
        if number == headers.packets:
            rate = len(link.content) / ((end + GAP_BITS * 1000 - first) / 1e6)
    print(f"MEGABYTES_PER_SECOND {rate:.2f}")
    assert rate >= s["min_rate"], f"{rate:.2f} MB/s"
    assert phy.tx.empty()

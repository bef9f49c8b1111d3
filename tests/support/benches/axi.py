"""The corrector with AXI ports between the memory, host and sink of ``cocotbext-axi``."""

import logging
import random

import cocotb
import numpy as np
from cocotb.clock import Clock
from cocotb.triggers import ClockCycles, RisingEdge, with_timeout
from cocotbext.axi import (
    AxiLiteBus,
    AxiLiteMaster,
    AxiRamRead,
    AxiRamWrite,
    AxiReadBus,
    AxiStreamBus,
    AxiStreamSink,
    AxiWriteBus,
)

from benches.common import PERIOD, settings
from ncdc_model.correction import correct
from ncdc_spec.descriptor import Descriptor
from ncdc_spec.frames import FrameAddresses, frame_bytes, raw_image, stored_picture
from ncdc_spec.hardware import Hardware
from ncdc_spec.registers.host_values import address_values, host_values, table_words
from ncdc_spec.registers.register_map import CTRL_COMMIT, CTRL_START, STATUS_DONE, registers

__all__ = ["frames_equal_model"]

_MEMORY = 1 << 16           # bytes


def pauses(probability, seed):
    """Whether a channel pauses, clock by clock."""
    rng = random.Random(seed)
    while True:
        yield rng.random() < probability


class Peer:
    """Memory, host and sink at the ports of ``dut``; ``pause``: its probability in a channel."""

    def __init__(self, dut, pause):
        reset = {"reset": dut.aresetn, "reset_active_level": False}
        self.dut, self.sink, self.write_side = dut, None, None
        readers = [f"m_axi_read{k}" for k in range(3) if hasattr(dut, f"m_axi_read{k}_araddr")]
        self.memories = [AxiRamRead(AxiReadBus.from_prefix(dut, name), dut.aclk, size=_MEMORY,
                                    **reset) for name in readers]
        shared = self.memories[0].mem
        for memory in self.memories[1:]:
            memory.mem = shared
        channels = [each for memory in self.memories
                    for each in (memory.ar_channel, memory.r_channel)]
        if hasattr(dut, "m_axi_write_awaddr"):
            self.write_side = AxiRamWrite(AxiWriteBus.from_prefix(dut, "m_axi_write"), dut.aclk,
                                          mem=shared, **reset)
            channels += [self.write_side.aw_channel, self.write_side.w_channel,
                         self.write_side.b_channel]
        self.host = AxiLiteMaster(AxiLiteBus.from_prefix(dut, "s_axi"), dut.aclk, **reset)
        write, read = self.host.write_if, self.host.read_if
        channels += [write.aw_channel, write.w_channel, write.b_channel, read.ar_channel,
                     read.r_channel]
        if hasattr(dut, "m_axis_tdata"):
            self.sink = AxiStreamSink(AxiStreamBus.from_prefix(dut, "m_axis"), dut.aclk,
                                      byte_lanes=len(dut.m_axis_tdata) // 8, **reset)
            channels.append(self.sink)
        for part in (*self.memories, self.write_side, write, read, self.sink):
            if part is not None:        # a line per access would take most of the run's time
                part.log.setLevel(logging.WARNING)
        for seed, channel in enumerate(channels):
            channel.set_pause_generator(pauses(pause, seed))

    async def put(self, address, value):
        """Write the register at a word address."""
        await self.host.write_dword(4 * address, value & 0xFFFFFFFF)

    async def get(self, address):
        """Its value."""
        return await self.host.read_dword(4 * address)

    async def picture(self, d, target):
        """The corrected picture: of the stream's lines, or of memory from ``target`` on."""
        g = d.geometry
        if self.sink is None:
            content = np.frombuffer(self.write_side.read(target, frame_bytes(g)), np.uint8)
            return stored_picture(content.reshape(g.corrected_height, g.corrected_width, 4))
        lines = [await with_timeout(self.sink.recv(), 20_000 * PERIOD, "ns")
                 for _ in range(g.corrected_height)]
        starts = [np.atleast_1d(line.tuser if line.tuser is not None else 0) for line in lines]
        assert [bool(start.flat[0]) for start in starts] == [True] + [False] * (len(lines) - 1)
        rows = np.array([np.frombuffer(bytes(line.tdata), np.uint8) for line in lines])
        # Green, blue, red from the lowest byte on.
        return rows.reshape(g.corrected_height, g.corrected_width, 3)[..., [2, 0, 1]]


@cocotb.test()
async def frames_equal_model(dut):
    """Two frames, each at addresses of its own; a write of a byte is rejected."""
    s = settings()
    d = Descriptor.load(s["descriptor"])
    g, rng = d.geometry, np.random.default_rng(9)
    rows = {r.name: r.address for r in registers(d.hidden_neurons, d.formats)}
    values = host_values(d, Hardware(
        data_width=s["data_width"], output=s["output"], strip=s["strip"]))
    pitch, size = values["SOURCE_PITCH"], 8192
    raw = rng.integers(0, 256, (2, *g.distorted[::-1]), np.uint8)

    dut.aresetn.value, dut.core_rst.value, dut.camera_rows.value = 0, 0, 0
    peer = Peer(dut, s["pause"])
    cocotb.start_soon(Clock(dut.aclk, PERIOD, unit="ns").start())
    await ClockCycles(dut.aclk, 5)
    dut.aresetn.value = 1
    await ClockCycles(dut.aclk, 2)
    for name, value in values.items():
        await peer.put(rows[name], value)
    for address, value in table_words(d.valid):
        await peer.put(address, value)
    assert await peer.get(rows["SOURCE_PITCH"]) == pitch
    await peer.put(rows["IRQ_ENABLE"], 1)
    for k in range(2):
        # The corrected frame crosses the end of a page in the middle of a burst.
        source, target = 2 * k * size, (2 * k + 1) * size + 4096 - 80
        peer.memories[0].write(source, raw_image(raw[k], pitch))
        for name, value in address_values(g, s["data_width"],
                                        FrameAddresses(source, target, pitch)).items():
            await peer.put(rows[name], value)
        await peer.put(rows["CTRL"], CTRL_COMMIT | CTRL_START)
        await with_timeout(RisingEdge(dut.irq), 20_000 * PERIOD, "ns")
        golden = correct(d, raw[k]).picture
        np.testing.assert_array_equal(await peer.picture(d, target), golden)
        await peer.put(rows["STATUS"], STATUS_DONE)
        assert await peer.get(rows["PIXELS"]) == g.corrected_width * g.corrected_height
    assert await peer.get(rows["FRAMES"]) == 2 and await peer.get(rows["FAULT"]) == 0
    # A write of some bytes of a word is rejected, and changes nothing.
    answer = await peer.host.write(4 * rows["IRQ_ENABLE"], b"\0")
    assert int(answer.resp) == 2 and await peer.get(rows["IRQ_ENABLE"]) == 1

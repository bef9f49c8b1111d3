"""The whole corrector between memory agents and a register host, byte by byte."""

import cocotb
import numpy as np

from benches.avalon import Host, read_memory, write_memory
from benches.common import clocks, settings, start
from ncdc_model.correction import correct
from ncdc_sim.system.corrector import tiles_fetched
from ncdc_spec.descriptor import Descriptor
from ncdc_spec.frames import FrameAddresses, frame_bytes, raw_image, stored_picture
from ncdc_spec.hardware import Hardware
from ncdc_spec.interpolation import FAST
from ncdc_spec.registers.host_values import address_values, host_values, table_words
from ncdc_spec.registers.register_map import CTRL_COMMIT, CTRL_START, STATUS_DONE, registers

__all__ = ["two_frames_equal_model"]


@cocotb.test()
async def two_frames_equal_model(dut):
    """Two frames, the second waiting for the first, of two pictures at two addresses."""
    s = settings()
    d = Descriptor.load(s["descriptor"])
    rng, g = np.random.default_rng(9), d.geometry
    values = host_values(d)
    pitch, size = values["SOURCE_PITCH"], values["TARGET_BASE"]
    raw = rng.integers(0, 256, (2, g.distorted_height, g.distorted_width), np.uint8)
    memory = bytearray(b"\xa5" * (4 * size))
    for k in range(2):
        image = raw_image(raw[k], pitch)
        memory[2 * k * size:2 * k * size + len(image)] = image

    readers = [f"read{r}" for r in range(3) if hasattr(dut, f"read{r}_read")]
    await start(dut, csr_read=0, csr_write=0, csr_address=0, csr_writedata=0, write_waitrequest=0,
                memory_rst=0,
                **{f"{reader}_{name}": 0 for reader in readers
                   for name in ("waitrequest", "readdata", "readdatavalid")})
    logs = [[] for _ in readers]
    for r, reader in enumerate(readers):
        cocotb.start_soon(read_memory(dut, reader, memory, wait=s["wait"],
                                      latency=s["latency"], seed=r, log=logs[r]))
    written = []
    cocotb.start_soon(write_memory(dut, "write", memory, wait=s["wait"], log=written))

    host, rows = Host(dut, "csr"), {
        r.name: r.address for r in registers(d.hidden_neurons, d.formats)}
    for name, value in values.items():
        await host.write(rows[name], value)
    for address, value in table_words(d.valid):
        await host.write(address, value)
    await host.write(rows["IRQ_ENABLE"], 1)
    await host.write(rows["CTRL"], CTRL_COMMIT | CTRL_START)
    await clocks(dut, 4)
    for name, value in address_values(g, 32, FrameAddresses(2 * size, 3 * size, pitch)).items():
        await host.write(rows[name], value)
    await host.write(rows["CTRL"], CTRL_COMMIT | CTRL_START)
    for k in range(2):
        for _ in range(60000):
            if int(dut.irq.value):
                break
            await clocks(dut, 1)
        else:
            raise AssertionError(f"frame {k} does not end")
        await host.write(rows["STATUS"], STATUS_DONE)
    assert await host.read(rows["FRAMES"]) == 2
    assert await host.read(rows["PIXELS"]) == g.corrected_width * g.corrected_height

    count, fetched = frame_bytes(g), 0
    for k in range(2):
        golden = correct(d, raw[k])
        fetched += golden.fetches if len(readers) == 3 else FAST.tile_height * tiles_fetched(
            d, Hardware())
        stored = np.frombuffer(bytes(memory[(2 * k + 1) * size:(2 * k + 2) * size]), np.uint8)
        pixels = stored[:count].reshape(g.corrected_height, g.corrected_width, 4)
        np.testing.assert_array_equal(stored_picture(pixels), golden.picture)
        assert not pixels[..., 3].any()
        assert (stored[count:] == 0xA5).all(), "written beyond the frame"
    assert [len(log) for log in logs] == [fetched] * len(readers)
    assert sum(words for _, words in written) == 2 * count // 4

"""Whole frames in each format of pixels in memory, and what the planner says of them."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from cameras import barrel_descriptor
from ncdc_hdl.corrector import Corrector
from ncdc_hdl.export.verilog import verilog_of
from ncdc_model.planner.lookups import frame_windows, lookups
from ncdc_model.planner.memory_timing import memory_timing
from ncdc_model.planner.tags import accesses, misses
from ncdc_model.planner.timing import predict_clocks
from ncdc_model.planner.writes import frame_writes
from ncdc_sim.system.corrector import simulate_correction
from ncdc_sim.system.frame import Program, simulate_frame
from ncdc_spec.cache_options import CacheOptions
from ncdc_spec.frames import FrameAddresses, frame_bytes, output_format, raw_image
from ncdc_spec.hardware import FORMATS, Hardware
from ncdc_spec.interpolation import GRADIENT
from ncdc_spec.registers.host_values import host_values
from ncdc_spec.registers.register_map import (
    CTRL_COMMIT,
    CTRL_START,
    FAULT_FORMAT,
    STATUS_ABORTED,
    STATUS_DONE,
)

CACHE = CacheOptions(64, pending=64, outstanding=8, interpolation=GRADIENT)
LARGEST = 160, 120
FILL = 30, 20, 10           # no grey: Mono8 has its green
QUICK = 64, 1               # data width and lanes of the build that is not of regress
EACH_BUILD = pytest.mark.parametrize("data_width,lanes", [
    QUICK, *(pytest.param(width, lanes, marks=pytest.mark.regress)
             for width, lanes in ((32, 2), (128, 4), (32, 4)))])


def camera(size=LARGEST, bayer="MONO"):
    return barrel_descriptor(size, size, bayer=bayer, interpolation=GRADIENT, strength=.5,
                             fill=FILL)


@cache
def built(data_width, lanes):
    """A hardware, its corrector, and that one's Verilog."""
    hardware = Hardware(data_width=data_width, lanes=lanes, cache=CACHE, split=2)
    corrector = Corrector(camera(), hardware)
    return hardware, corrector, verilog_of(corrector)


def noise(descriptor):
    return np.random.default_rng(2).integers(0, 256, descriptor.geometry.distorted[::-1], np.uint8)


def check(simulation, descriptor, form):
    """All bytes of the frame, each written once, and no other one."""
    assert simulation.differing == []
    assert simulation.bytes_outside == 0
    assert simulation.bytes_written == frame_bytes(descriptor.geometry, output_format(form))


@EACH_BUILD
@pytest.mark.parametrize("form", FORMATS)
@pytest.mark.parametrize("strip,memory", [(0, "hostile"), (32, "hostile"), (64, "sdram")])
def test_frames_of_a_grey_sensor(data_width, lanes, form, strip, memory):
    """A width that is no multiple of the word, nor of a strip; a memory that rejects half of the
    time."""
    hardware, _, verilog = built(data_width, lanes)
    descriptor = camera((100 + lanes, 40))
    simulation = simulate_correction(descriptor, noise(descriptor),
                                     replace(hardware, strip=strip, format=form), verilog=verilog,
                                     memory=memory)
    check(simulation, descriptor, form)
    assert simulation.blank.any() and not simulation.blank.all()


@EACH_BUILD
@pytest.mark.parametrize("form", ["BGRX8", "BGR8"])
def test_frames_of_a_colour_sensor(data_width, lanes, form):
    hardware, _, verilog = built(data_width, lanes)
    descriptor = camera((100 + lanes, 40), "GRBG")
    check(simulate_correction(descriptor, noise(descriptor),
                              replace(hardware, strip=32, format=form), verilog=verilog,
                              memory="hostile"), descriptor, form)


def predicted(corrector, hardware, memory):
    """Clocks that the planner promises ``corrector``, registers set as ``hardware``."""
    descriptor, timing = corrector.descriptor, corrector.timing
    geometry, memory = descriptor.geometry, memory_timing(memory)
    buffers = FrameAddresses.after_reset(geometry, hardware.data_width)
    boxes = lookups(frame_windows(descriptor), hardware.strip, hardware.lanes)
    missed = misses(accesses(boxes), hardware.cache, hardware.split)
    writes = frame_writes(geometry, hardware, getattr(memory, "access_bytes", 1), buffers.target,
                          timing)
    return predict_clocks(missed, boxes, hardware, memory, timing, buffers, writes).clocks


@pytest.mark.parametrize("data_width,lanes", [
    QUICK, pytest.param(32, 1, marks=pytest.mark.regress)])
@pytest.mark.parametrize("form", FORMATS)
@pytest.mark.parametrize("strip,memory", [
    (64, "sdram"), (0, "fixed:20:1.5"), *(pytest.param(*case, marks=pytest.mark.regress)
                                          for case in ((64, "ddr3"), (0, "ideal")))])
def test_the_planner_knows_the_format(data_width, lanes, form, strip, memory):
    """Clocks within a hundredth; the slow memories are full, with writes mostly. With more lanes or
    wider words the planner knows such a small tile cache less well, whatever the format."""
    hardware, corrector, verilog = built(data_width, lanes)
    hardware = replace(hardware, strip=strip, format=form)
    descriptor = corrector.descriptor
    simulation = simulate_correction(descriptor, noise(descriptor), hardware, verilog=verilog,
                                     memory=memory)
    check(simulation, descriptor, form)
    assert simulation.counters["CLOCKS"] == pytest.approx(
        predicted(corrector, hardware, memory), rel=.01)


@pytest.mark.parametrize("bayer,code,rejected", [
    ("GRBG", 2, True), ("MONO", 3, True), ("GRBG", 3, True), ("MONO", 2, False),
    ("GRBG", 1, False)])
def test_a_format_that_loses_colours_is_rejected(bayer, code, rejected):
    """Nothing is written, FAULT states why; the next frame is not rejected for that."""
    hardware, corrector, verilog = built(*QUICK)
    descriptor = camera((40, 16), bayer)
    values = host_values(descriptor, hardware)
    rows = {r.name: r.address for r in corrector.registers.table}
    program = Program().write(rows["IRQ_ENABLE"], 1)
    for form in (code, 0):
        for name, value in (values | {"OUTPUT_FORMAT": form}).items():
            program.write(rows[name], value)
        program.write(rows["CTRL"], CTRL_COMMIT | CTRL_START).wait_irq()
        program.read(rows["FAULT"]).read(rows["STATUS"]).write(rows["FAULT"], 0xFF)
        program.write(rows["STATUS"], STATUS_DONE)
    result = simulate_frame(
        verilog, raw_image(noise(descriptor), values["SOURCE_PITCH"]), program, source_base=0,
        output_base=values["TARGET_BASE"], output_bytes=frame_bytes(descriptor.geometry))
    faults = [value for address, value in result.reads if address == rows["FAULT"]]
    flags = [value & STATUS_ABORTED for address, value in result.reads if address == rows["STATUS"]]
    assert faults == [FAULT_FORMAT * rejected, 0]
    assert [bool(flag) for flag in flags] == [rejected, False]
    assert result.outputs[0] == (0 if rejected else 40 * 16 * {1: 3, 2: 1}[code])

"""Passes of a list of views, back to back, on one corrector: another lens and list each time."""

from dataclasses import dataclass

import numpy as np

from ncdc_hdl.export.drivers.lenses import Lens
from ncdc_model.golden.view_list import compose
from ncdc_sim.system.frame import UNWRITTEN, Camera, Program, simulate_frame
from ncdc_spec.frames import OUTPUT_FORMATS, raw_image
from ncdc_spec.registers.register_map import (
    FAULT_TARGET,
    STATUS_ABORTED,
    STATUS_BANK,
    STATUS_BUSY,
    STATUS_DONE,
    TABLE,
)
from ncdc_spec.view_list import Entry, buffer_bytes, list_values
from simulations.series import aligned, begin, read_measured
from views import random_view

__all__ = ["PassResult", "random_entries", "simulate_follow", "simulate_passes",
           "simulate_wrong_lists"]


@dataclass(frozen=True)
class PassResult:
    """Results of the passes.

    Parameters
    ----------
    differing : tuple of int
        Bytes of each pass's buffer that are not those of the golden model. If all passes have one
        buffer, the last number is of that.
    outside : int
        Bytes that any pass read or wrote outside its buffers.
    pixels : tuple of int
        The corrector's own count of each pass's pixels.
    """
    differing: tuple
    outside: int
    pixels: tuple


def simulate_passes(corrector, verilog, cameras, lists, together=False, origins=(0, 0),
                    **options):
    """Make a pass of each of ``lists``, the cameras taking turns, each started while the last one
    runs.

    Parameters
    ----------
    corrector, verilog : Corrector, str
    cameras : sequence of (Descriptor, ndarray of uint8)
        Each with its raw frame.
    lists : sequence of sequence of Entry
    together : bool
        Whether all passes write to one buffer, each its part of it.
    origins : (int, int)
        Bytes that are added to the addresses of the raw frames, and of the buffers. Without them
        the raw frames begin at 0, and the buffers after them.
    options :
        As of :func:`ncdc_sim.system.frame.simulate_frame`.
    """
    rows = {r.name: r.address for r in corrector.registers.table}
    content, sources = b"", []
    for descriptor, raw in cameras:
        sources.append(len(content))
        image = raw_image(raw, Lens.of(corrector, descriptor).values["SOURCE_PITCH"])
        content += image.ljust(aligned(len(image)), b"\0")
    sizes = [buffer_bytes(entries, corrector.hardware.data_width) for entries in lists]
    starts = np.cumsum([len(content), *map(aligned, sizes)]).tolist()
    if together:
        starts = [len(content)] * len(lists) + [len(content) + max(map(aligned, sizes))]
    first, start = origins[0], origins[1] + starts[0]
    program = Program().allow((first, first + len(content)),
                              (start, start + starts[-1] - starts[0]))
    program.write(rows["IRQ_ENABLE"], 1)
    for k in range(len(lists) + 1):
        if k:
            program.compare(rows["STATUS"], STATUS_BUSY | (0 if k % 2 else STATUS_BANK))
        if k < len(lists):
            turn = k % len(cameras)
            _begin(program, rows, corrector, cameras[turn][0], lists[k], k % 2, {
                "SOURCE_BASE": first + sources[turn], "SOURCE_LIMIT": first + len(content),
                "TARGET_BASE": origins[1] + starts[k],
                "TARGET_LIMIT": origins[1] + starts[k] + sizes[k]})
        if k:
            program.wait_irq().write(rows["STATUS"], STATUS_DONE)
            read_measured(program, corrector.registers.table)
    program.compare(rows["FRAMES"], len(lists)).compare(rows["FAULT"], 0)
    result = simulate_frame(verilog, content, program, source_base=first, output_base=start,
                            output_bytes=starts[-1] - starts[0], **options)
    expected = np.full(starts[-1] - starts[0], UNWRITTEN, np.uint8)
    for k, entries in enumerate(lists):
        compose(*cameras[k % len(cameras)], entries, expected[starts[k] - starts[0]:])
    wrong = np.frombuffer(result.output, np.uint8) != expected
    return PassResult(
        tuple(int(wrong[a - starts[0]:b - starts[0]].sum()) for a, b in zip(starts, starts[1:])),
        result.counters["outside_bytes"],
        tuple(value for address, value in result.reads if address == rows["PIXELS"]))


def simulate_wrong_lists(corrector, verilog, camera, entries, cases, **options):
    """Make a pass of ``entries`` for each of ``cases``, with register values that are changed.

    Parameters
    ----------
    corrector, verilog : Corrector, str
    camera : (Descriptor, ndarray of uint8)
    entries : sequence of Entry
    cases : sequence of (dict, tuple of int, int)
        Values by register name; numbers of the views that are made nevertheless; bits of FAULT.
    options :
        As of :func:`ncdc_sim.system.frame.simulate_frame`.

    Returns
    -------
    (tuple of int, int)
        Bytes of each pass's buffer that are not those of the golden model; bytes that were read or
        written outside the frames.
    """
    rows = {r.name: r.address for r in corrector.registers.table}
    descriptor, raw = camera
    content = raw_image(raw, Lens.of(corrector, descriptor).values["SOURCE_PITCH"])
    content = content.ljust(aligned(len(content)), b"\0")
    size = buffer_bytes(entries, corrector.hardware.data_width)
    starts = [len(content) + k * aligned(size) for k in range(len(cases) + 1)]
    program = Program().write(rows["IRQ_ENABLE"], 1)
    expected = np.full(starts[-1] - starts[0], UNWRITTEN, np.uint8)
    for start, (changed, made, faults) in zip(starts, cases):
        program.allow((0, len(content)), (start, start + size))
        _begin(program, rows, corrector, descriptor, entries, 0, {
            "SOURCE_BASE": 0, "SOURCE_LIMIT": len(content), "TARGET_BASE": start,
            "TARGET_LIMIT": start + size}, changed)
        program.wait_irq().compare(rows["FAULT"], faults).write(rows["FAULT"], 0xFF)
        aborted = STATUS_ABORTED if faults & ~FAULT_TARGET else 0
        program.compare(rows["STATUS"], STATUS_DONE | aborted).write(rows["STATUS"], STATUS_DONE)
        read_measured(program, corrector.registers.table)
        for k in made:
            compose(descriptor, raw, entries[k:k + 1], expected[start - starts[0]:])
    result = simulate_frame(verilog, content, program, source_base=0, output_base=starts[0],
                            output_bytes=len(expected), **options)
    wrong = np.frombuffer(result.output, np.uint8) != expected
    return (tuple(int(wrong[start - starts[0]:][:aligned(size)].sum()) for start in starts[:-1]),
            result.counters["outside_bytes"])


def simulate_follow(corrector, verilog, camera, entries, line, **options):
    """Make a pass of ``entries`` with early start, of a camera that begins its next frame, in
    another buffer, when the first view is complete.

    Parameters
    ----------
    corrector, verilog : Corrector, str
    camera : (Descriptor, ndarray of uint8)
    entries : sequence of Entry
    line : int
        Clocks of the camera from row to row.
    options :
        As of :func:`ncdc_sim.system.frame.simulate_frame`.

    Returns
    -------
    (int, int, int)
        Bytes that are not those of the golden model; read commands for rows that were not there;
        clocks from the start to the interrupt.
    """
    rows = {r.name: r.address for r in corrector.registers.table}
    descriptor, raw = camera
    pitch = Lens.of(corrector, descriptor).values["SOURCE_PITCH"]
    content = raw_image(raw, pitch)
    second = aligned(len(content))
    start, size = 2 * second, buffer_bytes(entries, corrector.hardware.data_width)
    program = Program().allow((0, second), (start, start + size))
    program.write(rows["IRQ_ENABLE"], 1).camera(0)
    _begin(program, rows, corrector, descriptor, entries, 0, {
        "SOURCE_BASE": 0, "SOURCE_LIMIT": second, "TARGET_BASE": start,
        "TARGET_LIMIT": start + size, "FOLLOW": 1})
    program.poll(rows["VIEWS_STATE"], corrector.hardware.views | 1 << 8)
    program.camera(second).wait_irq().compare(rows["FAULT"], 0)
    read_measured(program, corrector.registers.table)
    result = simulate_frame(
        verilog, content.ljust(2 * second, b"\0"), program, source_base=0, output_base=start,
        output_bytes=size, camera=Camera(*raw.shape[::-1], pitch, line), **options)
    expected = compose(descriptor, raw, entries, np.full(size, UNWRITTEN, np.uint8))
    wrong = np.frombuffer(result.output, np.uint8) != expected
    return int(wrong.sum()), result.counters["early_reads"], result.clocks[0]


def _begin(program, rows, corrector, descriptor, entries, bank, addresses, changed=None):
    """Write a lens, a list of views, the ``addresses`` and what is ``changed``; commit and start.
    """
    lens = Lens.of(corrector, descriptor)
    program.write(rows["VALID_WINDOW"], bank)
    for row, value in enumerate(lens.valid_rows):
        program.write(TABLE + row, value)
    begin(program, rows, lens.values | addresses | {"VALID_BANK": bank} | list_values(
        entries, corrector.hardware, descriptor.geometry) | (changed or {}))


def random_entries(rng, geometry, focal, hardware, count):
    """So many entries with views of random sizes, formats and strips, in one column of a buffer."""
    word, offset, entries = hardware.data_width // 8, 0, []
    for _ in range(count):
        width, height = int(rng.integers(2, 9)) * 4, int(rng.integers(8, 20))
        width = max(8, width)
        view = random_view(rng, geometry, focal, (width, height), pan=50, roll=180, zoom=(.5, 4))
        form = OUTPUT_FORMATS[str(rng.choice(["BGRX8", "BGR8"]))]
        row = -(-width * form.pixel_bytes // word) * word
        entry = Entry(view, offset, int(rng.choice([0, row, row + word, row + 7 * word])), form,
                      int(rng.choice([0, 32])))
        entries.append(entry)
        offset += -(-(entry.end - offset) // word) * word + word * int(rng.integers(0, 3))
    return tuple(entries)

"""Frames with random register values, each followed by a valid one."""

from dataclasses import dataclass

import numpy as np

from ncdc_model.correction import correct
from ncdc_sim.system.frame import Program, simulate_frame
from ncdc_spec.frames import FrameAddresses, frame_bytes, output_format, raw_image
from ncdc_spec.registers.host_values import address_values, host_values, table_words
from ncdc_spec.registers.register_map import CTRL_ABORT, STATUS_DONE, TABLE
from ncdc_spec.view_list import ENTRY_WORDS, entry_register
from ncdc_spec.view_rows import ROWS_COUNT, ROWS_TABLE
from simulations.series import aligned, begin, differing, output_bytes, read_measured

__all__ = ["FuzzResult", "simulate_register_fuzz"]

_JUNK_BYTES = 200, 2500     # size of the buffer that a fuzzed frame may write
_TIMEOUT = 3000         # clocks, at most, before a frame is aborted that might wait for a camera


@dataclass(frozen=True)
class FuzzResult:
    """Results of a run.

    Parameters
    ----------
    differing : tuple of int
        Pixels of each valid frame that differ from the golden model.
    outside : int
        Bytes that any frame read or wrote outside its buffers.
    faults : tuple of int
        FAULT after each fuzzed frame.
    """
    differing: tuple
    outside: int
    faults: tuple


def simulate_register_fuzz(corrector, verilog, raw, frames, *, lens=None, seed=1, **options):
    """Correct ``frames`` fuzzed frames, and as many that must be right, in turn.

    In a fuzzed frame each register of the set has its own value, one beyond a limit, or any bits.
    The limits of the buffers stay. Half of these frames are aborted at a random clock, among them
    all with early start, as there is no camera.

    Parameters
    ----------
    corrector, verilog : Corrector, str
    raw : ndarray of uint8
    lens : Descriptor, optional
        Of the frames; that of the corrector if absent.
    frames, seed : int
    options :
        As of :func:`ncdc_sim.system.frame.simulate_frame`.

    Raises
    ------
    SimulationError
        If a frame does not end, or a rule of a bus is broken, an unaligned address included.
    """
    rng = np.random.default_rng(seed)
    d, hardware = lens or corrector.descriptor, corrector.hardware
    stream, form = hardware.stream, output_format(hardware.format)
    table = {r.name: r for r in corrector.registers.table}
    rows = {name: r.address for name, r in table.items()}
    right = host_values(d, hardware) | _further_views(d, hardware)
    pitch = right["SOURCE_PITCH"]
    image = raw_image(raw, pitch)
    size = frame_bytes(d.geometry, form)
    step = aligned(size)
    # Fuzzed frames go to the first buffer, valid frames each to one of their own.
    junk = aligned(right["SOURCE_LIMIT"])
    base = junk + 2 * aligned(1)
    program = Program().write(rows["IRQ_ENABLE"], 1)
    for address, value in table_words(d.valid) if lens else ():
        program.write(address, value)
    for k in range(frames):
        _fuzzed_frame(program, rng, table, right, junk, bool(k % 2))
        target = base + k * step
        values = right | address_values(d.geometry, hardware.data_width,
                                      FrameAddresses(0, target, pitch), form)
        program.allow((0, values["SOURCE_LIMIT"]), (target, target + size))
        begin(program, rows, values)
        program.wait_irq().compare(rows["FAULT"], 0).write(rows["STATUS"], STATUS_DONE)
        read_measured(program, table.values())
    result = simulate_frame(
        verilog, image.ljust(base, b"\x5a"), program, source_base=0, output_base=base,
        output_bytes=_max_bytes(corrector, frames) if stream else frames * step, seed=seed,
        **options)
    golden = correct(d, raw, strip=hardware.strip).picture
    count = output_bytes(d.geometry, stream, form)
    begins = [end - count for end in result.outputs[1::2]] if stream else range(
        0, frames * step, step)
    # Every other one is read after a right frame.
    faults = tuple(value for address, value in result.reads if address == rows["FAULT"])[::2]
    wrong = differing(result.output, begins, len(begins) * [golden], stream, form)
    return FuzzResult(wrong, result.counters["outside_bytes"], faults)


def _further_views(descriptor, hardware):
    """Values of all other entries of a list of views, by name: each once more the first one."""
    first = host_values(descriptor, hardware)
    return {"VIEWS": hardware.views} | {
        entry_register(k, word): first.get(name, 0) for k in range(1, hardware.views)
        for word, name in ENTRY_WORDS.items()} if hardware.views else {}


def _max_bytes(corrector, frames):
    """Bytes that the stream of so many frames, and of as many largest ones, has at most."""
    width, height = corrector.table.largest
    return 6 * frames * width * height


def _fuzzed_frame(program, rng, table, right, junk, short):
    """A frame with random values in its registers and valid rows; it may write from ``junk`` on.

    ``short``: the limit of the raw frame is some bytes too low.
    """
    rows = {name: r.address for name, r in table.items()}
    values = _fuzzed_values(rng, table, right) | {
        "VALID_BANK": 1, "TARGET_LIMIT": junk + int(rng.integers(*_JUNK_BYTES))}
    values["SOURCE_LIMIT"] = right["SOURCE_LIMIT"] - int(rng.integers(0, 40)) * short
    if rng.random() < .7:
        for name, first in (("SOURCE_BASE", 0), ("TARGET_BASE", junk)):
            step_of = int(rng.choice([1, 16, 16, 16]))
            values[name] = first + step_of * int(rng.integers(0, 64))
    # Below it is the raw frame, which later frames need.
    values["TARGET_BASE"] = max(values["TARGET_BASE"], junk)
    program.allow((values["SOURCE_BASE"], values["SOURCE_LIMIT"]),
                  (values["TARGET_BASE"], values["TARGET_LIMIT"]))
    program.write(rows["VALID_WINDOW"], 1)
    for row in range(8):
        program.write(TABLE + int(rng.integers(0, 64)), int(rng.integers(0, 1 << 32)))
    if ROWS_COUNT in rows:
        values[ROWS_COUNT] = int(rng.integers(0, 6))
        for address in rng.integers(ROWS_TABLE, 2 * ROWS_TABLE, 20).tolist():
            program.write(address, int(rng.integers(0, 1 << 32)))
    begin(program, rows, values)
    if values["FOLLOW"] & 1 or rng.random() < .5:
        program.wait(int(rng.integers(1, _TIMEOUT))).write(rows["CTRL"], CTRL_ABORT)
    program.wait_irq().read(rows["FAULT"]).write(rows["FAULT"], 0xFF)
    program.write(rows["STATUS"], STATUS_DONE)


def _fuzzed_values(rng, table, right):
    """A value for every register of the set; up to four of them are no right ones."""
    values = dict(right)
    for name in rng.choice(list(right), int(rng.integers(0, 5))):
        value, width = right[name], table[name].shape.width
        values[name] = int(rng.choice([
            value + int(rng.integers(-5, 6)), 0, (1 << width) - 1,
            int(rng.integers(0, 1 << width)), int(rng.integers(0, 64))])) & (1 << width) - 1
    return values

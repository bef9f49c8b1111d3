"""Frames of several cameras in turn, back to back, on one corrector: every frame another lens."""

from dataclasses import dataclass

import numpy as np

from ncdc_hdl.export.registers.lenses import Lens
from ncdc_model.corrector import correct
from ncdc_model.interface.frames import frame_bytes, raw_image, stored_picture
from ncdc_model.interface.register_map import (
    CTRL_COMMIT,
    CTRL_START,
    STATUS_BANK,
    STATUS_BUSY,
    STATUS_COMMITTED,
    STATUS_DONE,
    STATUS_PENDING,
    STATUS_REFUSED,
    TABLE,
)
from ncdc_sim.system.frame import Program, simulate_frame

__all__ = ["LensChange", "simulate_lens_change"]

_ALIGN = 4096       # bytes; frames in memory begin at multiples of this


@dataclass(frozen=True)
class LensChange:
    """What the Verilog made of the frames.

    Parameters
    ----------
    differing : tuple of int
        Pixels of each frame that differ from the golden model of its own camera.
    pixels : int
        Compared, of all frames together.
    clocks : tuple of int
        The corrector's own count of each frame's clocks.
    periods : tuple of int
        Clocks from the end of each frame to the end of the next, counted outside.
    """
    differing: tuple
    pixels: int
    clocks: tuple
    periods: tuple

    @property
    def idle(self):
        """Clocks between each frame's last pixel and the next one's start, all but the first."""
        return tuple(period - clocks for period, clocks in zip(self.periods, self.clocks[1:]))


def simulate_lens_change(corrector, verilog, cameras, frames, *, intruder=False, **options):
    """Correct ``frames`` frames, the cameras taking turns, each started while the last one runs.

    While frame k runs the host writes all registers and valid rows for frame k + 1, commits and
    starts it. It checks that nothing of that was refused and that the bank in use is frame k's.

    Parameters
    ----------
    corrector, verilog : Corrector, str
        With the neurons, formats and largest size that the cameras need; and its text.
    cameras : sequence of (Descriptor, ndarray of uint8)
        Each with its raw frame.
    frames : int
    intruder : bool
        After each commit write other values to every register of the set and to the valid rows;
        the corrector must refuse them.
    options :
        As of :func:`ncdc_sim.system.frame.simulate_frame`.
    """
    rows = {r.name: r for r in corrector.registers.table}
    lenses = [Lens.of(corrector, camera) for camera, _ in cameras]
    content, sources = b"", []
    for (_, raw), lens in zip(cameras, lenses):
        sources.append(len(content))
        image = raw_image(raw, lens.values["SOURCE_PITCH"])
        content += image + bytes(-len(image) % _ALIGN)
    places, end = [], len(content)
    for k in range(frames):
        places.append(end)
        end += -(-frame_bytes(cameras[k % len(cameras)][0].geometry) // _ALIGN) * _ALIGN

    def prepare(program, k):
        """Write the set and the valid rows of frame ``k``, commit and start."""
        turn, bank = k % len(cameras), k % 2
        changed = lenses[turn].values | {"SOURCE_BASE": sources[turn], "TARGET_BASE": places[k],
                                         "VALID_BANK": bank}
        for name, value in changed.items():
            program.write(rows[name].address, value)
        program.write(rows["VALID_WINDOW"].address, bank)
        for row, value in enumerate(lenses[turn].valid_rows):
            program.write(TABLE + row, value)
        program.write(rows["CTRL"].address, CTRL_COMMIT | CTRL_START)
        if intruder and k:
            for name, value in changed.items():
                program.write(rows[name].address, ~value)
            for row in range(len(lenses[turn].valid_rows)):
                program.write(TABLE + row, 0)
            program.compare(rows["STATUS"].address, STATUS_BUSY | STATUS_PENDING | STATUS_COMMITTED
                            | STATUS_REFUSED | (0 if bank else STATUS_BANK))
            program.write(rows["STATUS"].address, STATUS_REFUSED)

    program = Program().write(rows["IRQ_ENABLE"].address, 1)
    prepare(program, 0)
    for k in range(frames):
        program.compare(rows["STATUS"].address, STATUS_BUSY | (STATUS_BANK if k % 2 else 0))
        if k + 1 < frames:
            prepare(program, k + 1)
        program.wait_irq().write(rows["STATUS"].address, STATUS_DONE)
        program.read(rows["CLOCKS"].address)
    program.compare(rows["FRAMES"].address, frames)

    stream = corrector.hardware.stream
    sizes = [3 * camera.geometry.corrected_width * camera.geometry.corrected_height
             for camera, _ in cameras]
    if stream:
        places = [sum(sizes[j % len(cameras)] for j in range(k)) for k in range(frames + 1)]
        base, length = 0, places.pop()
    else:
        base, length = places[0], end - places[0]
    result = simulate_frame(verilog, content, program, source_base=0, output_base=base,
                            output_bytes=length, **options)
    golden = [correct(camera, raw).picture for camera, raw in cameras]
    differing = []
    for k, place in enumerate(places):
        expected = golden[k % len(cameras)]
        height, width, _ = expected.shape
        count, step = height * width, 3 if stream else 4
        got = np.frombuffer(result.output, np.uint8, count * step, place - base)
        got = got.reshape(height, width, step)
        got = got if stream else stored_picture(got)
        differing.append(int((got != expected).any(axis=2).sum()))
    return LensChange(
        differing=tuple(differing),
        pixels=sum(golden[k % len(golden)][..., 0].size for k in range(frames)),
        clocks=tuple(value for address, value in result.reads if address == rows["CLOCKS"].address),
        periods=tuple(b - a for a, b in zip(result.ends, result.ends[1:])))

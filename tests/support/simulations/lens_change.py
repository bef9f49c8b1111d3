"""Frames of several cameras in turn, back to back, on one corrector: every frame another lens,
and another view."""

from dataclasses import dataclass

import numpy as np

from ncdc_hdl.export.drivers.lenses import Lens
from ncdc_model.correction import correct
from ncdc_sim.system.frame import Program, simulate_frame
from ncdc_spec.frames import FrameAddresses, frame_bytes, raw_image
from ncdc_spec.registers.host_values import address_values
from ncdc_spec.registers.register_map import (
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
from ncdc_spec.view import VIEW_REGISTERS
from ncdc_spec.view_rows import ROWS_COUNT, rows_values, rows_words
from simulations.series import aligned, differing, output_bytes, read_measured

__all__ = ["LensChange", "simulate_lens_change"]


@dataclass(frozen=True)
class LensChange:
    """Results of the frames.

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


def simulate_lens_change(corrector, verilog, cameras, frames, *, views=(), intruder=False,
                         **options):
    """Correct ``frames`` frames, the cameras taking turns, each started while the last one runs.

    While frame k runs the host writes all registers and valid rows for frame k + 1, commits and
    starts it. It checks that no write was rejected and that the bank in use is frame k's.

    Parameters
    ----------
    corrector, verilog : Corrector, str
        With the neurons, formats and largest size that the cameras need; and its text.
    cameras : sequence of (Descriptor, ndarray of uint8)
        Each with its raw frame.
    frames : int
    views : sequence of View
        One of each frame, of a corrector that has views; none: the trained pictures.
    intruder : bool
        After each commit write other values to every register of the set and to the valid rows.
        The corrector must reject them.
    options :
        As of :func:`ncdc_sim.system.frame.simulate_frame`.
    """
    layout = _Layout.of(corrector, cameras, views or [None] * frames)
    rows = {r.name: r for r in corrector.registers.table}
    result = simulate_frame(verilog, layout.content, _program(layout, rows, intruder),
                            source_base=0, output_base=layout.base, output_bytes=layout.length,
                            **options)
    golden = [correct(*cameras[k % len(cameras)], view=view).picture
              for k, view in enumerate(layout.views)]
    return LensChange(
        differing=differing(result.output, layout.outputs, golden, layout.stream),
        pixels=sum(picture[..., 0].size for picture in golden),
        clocks=tuple(value for address, value in result.reads if address == rows["CLOCKS"].address),
        periods=tuple(b - a for a, b in zip(result.ends, result.ends[1:])))


@dataclass(frozen=True)
class _Layout:
    """Addresses of every camera's raw frame and of every corrected frame.

    Parameters
    ----------
    lenses : list of Lens
        One of each camera.
    content : bytes
        The raw frames, at byte addresses ``sources``.
    sources : list of int
    targets : list of int
        TARGET_BASE of each corrected frame.
    outputs : list of int
        Where each corrected frame begins in the run's output.
    base, length : int
        Byte address and size of the run's output.
    stream : bool
        The output is a stream, 3 bytes per pixel.
    views : list of View or None
    geometries : list of Geometry
        One of each frame, with the size of its view.
    data_width : int
        Bits of a memory word.
    """
    lenses: list
    content: bytes
    sources: list
    targets: list
    outputs: list
    base: int
    length: int
    stream: bool
    views: list
    geometries: list
    data_width: int

    @classmethod
    def of(cls, corrector, cameras, views):
        """The layout of a frame of each of ``views``, of the ``cameras`` in turn."""
        lenses = [Lens.of(corrector, camera) for camera, _ in cameras]
        content, sources = b"", []
        for (_, raw), lens in zip(cameras, lenses):
            sources.append(len(content))
            image = raw_image(raw, lens.values["SOURCE_PITCH"])
            content += image.ljust(aligned(len(image)), b"\0")
        turns = [cameras[k % len(cameras)][0].geometry for k in range(len(views))]
        turns = [view.geometry(one) if view else one for view, one in zip(views, turns)]
        targets = _starts(len(content), [aligned(frame_bytes(one)) for one in turns])
        outputs, base = [target - targets[0] for target in targets], targets[0]
        if corrector.hardware.stream:
            outputs, base = _starts(0, [output_bytes(one, True) for one in turns]), 0
        return cls(lenses, content, sources, targets[:-1], outputs[:-1], base, outputs[-1],
                   corrector.hardware.stream, list(views), turns, corrector.hardware.data_width)


def _starts(start, sizes):
    """Addresses of consecutive pieces of these sizes from ``start`` on, and their end."""
    return np.cumsum([start, *sizes]).tolist()


def _program(layout, rows, intruder):
    """Register accesses of all frames; ``rows``: the registers by name."""
    program = Program().write(rows["IRQ_ENABLE"].address, 1)
    _prepare(program, layout, rows, 0, False)
    frames = len(layout.targets)
    for k in range(frames):
        program.compare(rows["STATUS"].address, STATUS_BUSY | (STATUS_BANK if k % 2 else 0))
        if k + 1 < frames:
            _prepare(program, layout, rows, k + 1, intruder)
        program.wait_irq().write(rows["STATUS"].address, STATUS_DONE)
        read_measured(program, rows.values())
    return program.compare(rows["FRAMES"].address, frames)


def _prepare(program, layout, rows, k, intruder):
    """Write the set and the valid rows of frame ``k``, commit and start."""
    turn, bank = k % len(layout.lenses), k % 2
    lens = layout.lenses[turn]
    buffers = FrameAddresses(layout.sources[turn], layout.targets[k], lens.values["SOURCE_PITCH"])
    geometry, view = layout.geometries[k], layout.views[k]
    changed = lens.values | address_values(geometry, layout.data_width, buffers) | {
        "VALID_BANK": bank}
    if view:
        changed |= dict(zip(VIEW_REGISTERS, view.matrix)) | {
            "CORRECTED_WIDTH": view.size[0], "CORRECTED_HEIGHT": view.size[1]}
    if ROWS_COUNT in rows:
        changed |= rows_values(view.rows, bank)
    for name, value in changed.items():
        program.write(rows[name].address, value)
    program.write(rows["VALID_WINDOW"].address, bank)
    for row, value in enumerate(lens.valid_rows):
        program.write(TABLE + row, value)
    for address, value in rows_words(view.rows, bank) if view and view.rows else ():
        program.write(address, value)
    program.write(rows["CTRL"].address, CTRL_COMMIT | CTRL_START)
    if intruder:
        for name, value in changed.items():
            program.write(rows[name].address, ~value)
        for row in range(len(lens.valid_rows)):
            program.write(TABLE + row, 0)
        program.compare(rows["STATUS"].address, STATUS_BUSY | STATUS_PENDING | STATUS_COMMITTED
                        | STATUS_REFUSED | (0 if bank else STATUS_BANK))
        program.write(rows["STATUS"].address, STATUS_REFUSED)

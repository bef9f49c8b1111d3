"""Frames cut short by resets, of the corrector alone or of the memory too, and the next ones."""

from dataclasses import dataclass

import numpy as np

from ncdc_hdl.export.drivers.lenses import Lens
from ncdc_model.correction import correct
from ncdc_sim.system.frame import Program, simulate_frame
from ncdc_spec.frames import FrameAddresses, frame_bytes, raw_image
from ncdc_spec.registers.host_values import address_values
from ncdc_spec.registers.register_map import STATUS_DONE, TABLE
from simulations.series import aligned, begin, differing, output_bytes, read_measured

__all__ = ["Resets", "simulate_resets"]

_MAX_TRAILS = 5         # clocks by which one of both resets comes and goes after the other


@dataclass(frozen=True)
class Resets:
    """Results of the frames after the resets.

    Parameters
    ----------
    differing : tuple of int
        Pixels of each of these frames that differ from the golden model.
    under_way : int
        Resets that fell into a frame: it had begun, and its output was not complete.
    """
    differing: tuple
    under_way: int


def simulate_resets(corrector, verilog, raws, frames, *, forgets, longest, lens=None, seed=1,
                    **options):
    """Begin ``frames`` frames, reset each at a random clock, and correct a whole one after it.

    Parameters
    ----------
    corrector, verilog : Corrector, str
    raws : (ndarray, ndarray) of uint8
        Raw frames of those that are cut short, and of those after them.
    frames : int
    forgets : bool
        Whether the memory is reset with the corrector, sometimes some clocks earlier or later, and
        drops the reads under way. Else it is not reset, and answers.
    longest : int
        Clocks from a frame's start to its reset, at most.
    lens : Descriptor, optional
        Of the frames; each loads it. That of the corrector if absent, which a reset loads.
    seed : int
    options :
        As of :func:`ncdc_sim.system.frame.simulate_frame`.

    Raises
    ------
    SimulationError
        If a frame does not end, or a rule of a bus is broken.
    """
    rng = np.random.default_rng(seed)
    d, stream = lens or corrector.descriptor, corrector.hardware.stream
    rows = {r.name: r.address for r in corrector.registers.table}
    loaded = Lens.of(corrector, lens).values if lens else {}
    valid_rows = Lens.of(corrector, lens).valid_rows if lens else ()
    pitch = (loaded or corrector.registers.values)["SOURCE_PITCH"]
    images = [raw_image(raw, pitch) for raw in raws]
    sources = [0, aligned(len(images[0]))]
    size = frame_bytes(d.geometry)
    step = aligned(size)
    base = sources[1] + aligned(len(images[1]))
    program = Program()

    def begin_at(source, target):
        for row, value in enumerate(valid_rows):
            program.write(TABLE + row, value)
        begin(program, rows, loaded | address_values(
            d.geometry, corrector.hardware.data_width, FrameAddresses(source, target, pitch)))

    for k in range(frames):
        # The frame that is cut short goes to the first buffer, the others each to its own.
        begin_at(sources[0], base)
        program.wait(int(rng.integers(1, longest)))
        clocks = int(rng.integers(1, 60))
        if forgets:
            trails = min(_MAX_TRAILS, clocks - 1)
            program.reset_all(clocks, int(rng.integers(-trails, trails, endpoint=True)))
        else:
            program.reset(clocks)
        program.write(rows["IRQ_ENABLE"], 1)
        begin_at(sources[1], base + (k + 1) * step)
        program.wait_irq().write(rows["STATUS"], STATUS_DONE)
        program.write(rows["IRQ_ENABLE"], 0)
        read_measured(program, corrector.registers.table)
    span = (frames + 1) * step
    result = simulate_frame(
        verilog, images[0].ljust(sources[1], b"\0") + images[1], program, source_base=0,
        output_base=base, output_bytes=2 * frames * size if stream else span, seed=seed, **options)
    golden = correct(d, raws[1]).picture
    count = output_bytes(d.geometry, stream)
    begins = [end - count for end in result.outputs] if stream else range(
        step, span, step)
    before = (0, *result.outputs)
    return Resets(differing(result.output, begins, len(begins) * [golden], stream),
                  sum(0 < reset - out < count for reset, out in zip(result.resets, before)))

"""The generated corrector on a raw frame, compared with the golden model pixel by pixel."""

from dataclasses import dataclass

import numpy as np

from ncdc_hdl.export.verilog import corrector_verilog
from ncdc_model.correction import coloured, correct
from ncdc_model.golden.colour import ColourSums
from ncdc_model.golden.corrector import check_raw
from ncdc_model.planner.lookups import frame_windows, lookups
from ncdc_model.planner.tags import accesses, misses
from ncdc_sim.system.frame import Camera, Program, Run, simulate_frame
from ncdc_spec.colour import Colour
from ncdc_spec.frames import (
    FrameAddresses,
    frame_bytes,
    output_format,
    raw_image,
    stored_bytes,
    stored_picture,
)
from ncdc_spec.hardware import Hardware
from ncdc_spec.registers.host_values import host_values, table_words
from ncdc_spec.registers.register_map import (
    COLOUR_COUNTERS,
    COUNTERS,
    CTRL_COMMIT,
    CTRL_START,
    absent,
    registers,
)
from ncdc_spec.view_rows import rows_words

__all__ = ["Simulation", "corrector_program", "registers_of", "simulate_correction",
           "tiles_fetched"]


@dataclass(frozen=True)
class Simulation:
    """A frame corrected by the Verilog, and the golden model's.

    Parameters
    ----------
    picture, golden : ndarray of uint8, shape (height, width, 3)
    stored, expected : ndarray of uint8, shape (height, width, bytes of a pixel)
        The same as memory holds them, all bytes of the format. With a stream, the pictures.
    blank : ndarray of bool, shape (height, width)
        Pixels without a source, of the golden model.
    counters : dict
        The corrector's own counters, by name.
    fetches_expected : int
        Windows, or tiles, read by the golden model.
    bytes_read, bytes_written : int
        On the memory's ports.
    bytes_outside : int
        Those of these bytes that are outside the raw frame and the corrected one.
    clocks_outside : int
        From the start's register write to the interrupt, counted by the bench.
    follow : dict
        Figures of a frame with early start, else empty. ``follow_latency_clocks``: from the
        camera's last byte in memory to the interrupt. ``follow_early_reads``: read commands for
        rows that were not in memory yet.
    sums, sums_expected : dict
        The corrector's sums of the frame's colours, by name, and the golden model's; empty where
        the hardware has none.
    setup : dict
        ``simulator``, ``memory``, and the names of :meth:`Hardware.report`.
    """
    picture: np.ndarray
    golden: np.ndarray
    stored: np.ndarray
    expected: np.ndarray
    blank: np.ndarray
    counters: dict
    fetches_expected: int
    bytes_read: int
    bytes_written: int
    bytes_outside: int
    clocks_outside: int
    follow: dict
    sums: dict
    sums_expected: dict
    setup: dict

    @property
    def differing(self):
        """(u, v) of the pixels that differ, in raster order."""
        rows, columns = np.nonzero((self.stored != self.expected).any(axis=2))
        return list(zip(columns.tolist(), rows.tolist()))

    def report(self):
        """The figures under their names in every report."""
        pixels = self.golden.shape[0] * self.golden.shape[1]
        return {
            "pixels_compared": pixels, "pixels_different": len(self.differing),
            "clocks": self.counters["CLOCKS"],
            "clocks_per_pixel": self.counters["CLOCKS"] / pixels,
            "bytes_read_per_pixel": self.bytes_read / pixels,
            "bytes_written_per_pixel": self.bytes_written / pixels,
            "bytes_outside": self.bytes_outside,
            "windows_fetched": self.counters["FETCHES"],
            "windows_fetched_expected": self.fetches_expected,
            **{name.lower(): self.counters[name] for name in COUNTERS if name.endswith("_STALLS")},
            **{name.lower(): value for name, value in self.sums.items()},
            **self.follow, **self.setup,
        }


def corrector_program(descriptor, hardware, checked=True, follow=False, colour=Colour(),
                      view=None):
    """Register accesses of a host to correct one frame.

    Every parameter is written (and, if ``checked``, read back), a frame started and awaited, the
    counters read. What the ``hardware`` leaves out must ignore what is written, and read 0. With
    ``follow`` the camera begins its frame just before the start. ``colour`` is
    of hardware that has it, and so is ``view``.
    """
    host = host_values(descriptor, hardware, follow=follow, colour=colour, view=view)
    rows = registers_of(descriptor, hardware)
    gone = absent(rows.values(), hardware)
    writes = [(rows[name].address, value, 0 if name in gone else value)
              for name, value in host.items()]
    writes += [(address, value, 0 if hardware.fixed_lens else value)
               for address, value in table_words(descriptor.valid)]
    written_only = rows_words(view.rows) if view and view.rows else []
    target = host["TARGET_BASE"]
    picture = view.geometry(descriptor.geometry) if view else descriptor.geometry
    written = 0 if hardware.stream else frame_bytes(picture, output_format(hardware.format))
    program = Program().allow((host["SOURCE_BASE"], host["SOURCE_LIMIT"]),
                              (target, target + written))
    for address, value, *_ in [*writes, *written_only, (rows["IRQ_ENABLE"].address, 1)]:
        program.write(address, value)
    if checked:
        for address, _, value in writes:
            program.compare(address, value)
    if follow:
        program.camera(host["SOURCE_BASE"])
    program.write(rows["CTRL"].address, CTRL_COMMIT | CTRL_START).wait_irq()
    for name in (*COUNTERS, *_colour_counters(hardware)):
        program.read(rows[name].address)
    return program


def _follow(result):
    """Latency and early reads of a frame with early start."""
    return {"follow_latency_clocks": result.ends[0] - result.counters["camera_end"],
            "follow_early_reads": result.counters["early_reads"]}


def registers_of(descriptor, hardware):
    """The registers by name."""
    return {r.name: r for r in registers(descriptor.hidden_neurons, descriptor.formats,
                                         colour=hardware.colour,
                                         raw_balance=hardware.raw_balance,
                                         view=hardware.view, views=hardware.views,
                                         view_rows=hardware.view_rows)}


def _colour_counters(hardware):
    """Names of the sums of the colours that ``hardware`` has."""
    return COLOUR_COUNTERS if hardware.colour else ()


def tiles_fetched(descriptor, hardware, view=None):
    """Tiles that the golden model of the cache reads."""
    geometry = descriptor.geometry
    accessed = accesses(lookups(frame_windows(descriptor, view=view), hardware.strip,
                                hardware.lanes))
    return len(misses(accessed, hardware.cache_for(geometry), hardware.split_for(geometry)))


def simulate_correction(descriptor, raw, hardware=Hardware(), *, verilog=None, follow_line=None,
                        colour=Colour(), view=None, memory="sdram", **run):
    """Correct the ``raw`` frame with the generated Verilog and with the golden model.

    Parameters
    ----------
    descriptor : Descriptor
    raw : ndarray of uint8, shape (distorted height, distorted width)
    hardware : Hardware
    verilog : str, optional
        The corrector's text; generated if absent.
    follow_line : int, optional
        Begin with the camera's frame, which comes as the frame is corrected, a byte per clock:
        clocks of a row of that camera.
    colour : Colour
        Gains before and after interpolation and tone curve, of hardware that has them.
    view : View, optional
        What the corrected frame shows, of hardware that has views.
    memory, run :
        As of :func:`ncdc_sim.system.frame.simulate_frame`.

    Raises
    ------
    InputError
        If the frame is not of the descriptor's size, or an option is unknown.
    SimulationError
        If the simulation fails; differing pixels are no failure, see :attr:`Simulation.differing`.
    """
    geometry = descriptor.geometry
    check_raw(raw, geometry)
    hardware = hardware.made_for(descriptor)
    if verilog is None:
        verilog = corrector_verilog(descriptor, hardware)
    picture = view.geometry(geometry) if view else geometry
    buffers = FrameAddresses.after_reset(picture, hardware.data_width)
    width, height = picture.corrected
    form, follow = output_format(hardware.format), follow_line is not None
    camera = Camera(*geometry.distorted, buffers.pitch, follow_line) if follow else None
    result = simulate_frame(
        verilog, raw_image(raw, buffers.pitch),
        corrector_program(descriptor, hardware, follow=follow, colour=colour, view=view),
        source_base=buffers.source, output_base=buffers.target,
        output_bytes=3 * width * height if hardware.stream else frame_bytes(picture, form),
        camera=camera, memory=memory, **run)
    stored = np.frombuffer(result.output, np.uint8).reshape(height, width, -1)
    golden = correct(descriptor, raw, strip=hardware.strip, crest=colour.crest,
                     raw_gains=colour.raw_gains, view=view)
    finished = coloured(golden, colour)
    shown, expected = stored, finished
    if not hardware.stream:
        shown, expected = stored_picture(stored, form), stored_bytes(finished, form)
    rows = registers_of(descriptor, hardware)
    return Simulation(
        picture=shown, golden=finished, stored=stored, expected=expected, blank=golden.blank,
        counters={name: result.registers[rows[name].address] for name in COUNTERS},
        fetches_expected=(tiles_fetched(descriptor, hardware, view) if hardware.cached
                          else golden.fetches),
        bytes_read=sum(result.bytes_read), bytes_written=result.bytes_written,
        bytes_outside=result.counters["outside_bytes"],
        clocks_outside=result.clocks[0], follow=_follow(result) if follow else {},
        sums={name: result.registers[rows[name].address] for name in _colour_counters(hardware)},
        sums_expected=ColourSums.of(golden).registers if hardware.colour else {},
        setup={"simulator": run.get("simulator", Run.simulator),
               "memory": memory if isinstance(memory, str) else "custom",
               **hardware.report(geometry)})

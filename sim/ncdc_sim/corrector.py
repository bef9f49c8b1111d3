"""The generated corrector on a raw frame, compared with the golden model pixel by pixel."""

from dataclasses import dataclass

import numpy as np

from ncdc_hdl.avalon.register_table import (CTRL_COMMIT, CTRL_START, frame_bytes, host_values,
                                            registers, table_words)
from ncdc_hdl.avalon.registers import COUNTERS
from ncdc_hdl.export.verilog import corrector_verilog
from ncdc_hdl.options import FetchOptions, FrontEndOptions
from ncdc_model.corrector import check_raw, correct
from ncdc_model.fetch.follow import camera_line
from ncdc_model.fetch.lookups import frame_windows, lookups
from ncdc_model.fetch.tags import accesses, misses
from ncdc_sim.frame import Camera, Program, simulate_frame

__all__ = ["Simulation", "corrector_program", "raw_image", "simulate_correction",
           "tiles_fetched"]


@dataclass(frozen=True)
class Simulation:
    """What the Verilog made of a frame, beside the golden model's.

    Parameters
    ----------
    picture, golden : ndarray of uint8, shape (height, width, 3)
    filled : ndarray of bool, shape (height, width)
        Pixels without a source, of the golden model.
    counters : dict
        The corrector's own counters, by name.
    fetches_expected : int
        Windows, or tiles, that the golden model says are read.
    bytes_read, bytes_written : int
        On the memory's ports.
    clocks_outside : int
        From the start's register write to the interrupt, counted by the bench.
    follow : dict
        Of a frame that begins with the camera's: ``follow_latency_clocks``, from the camera's last
        byte in memory to the interrupt, and ``follow_early_reads``, read commands for rows that
        were not in memory yet; empty otherwise.
    setup : dict
        ``simulator``, ``memory``, ``fetch``, ``cache_bytes``, ``cache_split``, ``data_width``,
        ``output``, ``hidden``, ``share``, ``products``, ``strip``, ``pixels_per_clock``.
    """
    picture: np.ndarray
    golden: np.ndarray
    filled: np.ndarray
    counters: dict
    fetches_expected: int
    bytes_read: int
    bytes_written: int
    clocks_outside: int
    follow: dict
    setup: dict

    @property
    def differing(self):
        """(u, v) of the pixels that differ, in raster order."""
        rows, columns = np.nonzero((self.picture != self.golden).any(axis=2))
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
            "windows_fetched": self.counters["FETCHES"],
            "windows_fetched_expected": self.fetches_expected,
            **{name.lower(): self.counters[name] for name in COUNTERS if name.endswith("_STALLS")},
            **self.follow, **self.setup,
        }


def corrector_program(descriptor, data_width, checked=True, split=None, strip=0, follow=False):
    """Register accesses that a host makes to correct one frame: every parameter is written
    (and, if ``checked``, read back), a frame started and awaited, the counters read. ``split``,
    ``strip``, ``follow``: as of :func:`ncdc_hdl.avalon.register_table.host_values`; with
    ``follow`` the camera begins its frame just before the start."""
    host = host_values(descriptor, data_width, split, strip, follow)
    rows = {r.name: r for r in registers(descriptor.hidden_neurons, descriptor.formats)}
    writes = [(rows[name].address, value)
              for name, value in host.items()]
    writes += table_words(descriptor.valid)
    program = Program()
    for address, value in [*writes, (rows["IRQ_ENABLE"].address, 1)]:
        program.write(address, value)
    if checked:
        for address, value in writes:
            program.compare(address, value)
    if follow:
        program.camera(host["SOURCE_BASE"])
    program.write(rows["CTRL"].address, CTRL_COMMIT | CTRL_START).wait_irq()
    for name in COUNTERS:
        program.read(rows[name].address)
    return program


def tiles_fetched(descriptor, fetch, lanes=1):
    """Tiles that the golden model of the cache reads, with ``lanes`` pixels per clock."""
    geometry = descriptor.geometry
    accessed = accesses(lookups(frame_windows(descriptor), fetch.strip, lanes))
    return len(misses(accessed, fetch.cache_for(geometry), fetch.split_for(geometry)))


def raw_image(raw, pitch):
    """Bytes of the ``raw`` frame in memory, rows ``pitch`` bytes apart."""
    return np.pad(raw, ((0, 0), (0, pitch - raw.shape[1]))).tobytes()


def simulate_correction(descriptor, raw, *, verilog=None, data_width=32, output="memory",
                        front_end=FrontEndOptions(), fetch=FetchOptions(), memory="sdram",
                        simulator="verilator", seed=1, follow=False, line=None, progress=None):
    """Correct the ``raw`` frame with the generated Verilog and with the golden model.

    Parameters
    ----------
    descriptor : Descriptor
    raw : ndarray of uint8, shape (distorted height, distorted width)
    verilog : str
        The corrector's text; generated if absent.
    data_width, output, front_end, fetch :
        As of :class:`ncdc_hdl.corrector.Corrector`.
    follow : bool
        Begin with the camera's frame, which comes as the frame is corrected, a byte per clock.
    line : int, optional
        Clocks of a row of that camera; default one per sample.
    memory, simulator, seed, progress :
        As of :func:`ncdc_sim.frame.simulate_frame`.

    Raises
    ------
    InputError
        If the frame is not of the descriptor's size, or an option is unknown.
    SimulationError
        If the simulation fails; differing pixels are no failure, see :attr:`Simulation.differing`.
    """
    check_raw(raw, descriptor.geometry)
    if verilog is None:
        verilog = corrector_verilog(descriptor, data_width=data_width, output=output,
                                    front_end=front_end, fetch=fetch)
    split = fetch.split_for(descriptor.geometry)
    values = host_values(descriptor, data_width, split, fetch.strip)
    width, height = descriptor.geometry.corrected
    stream = output == "stream"
    pitch, camera = values["SOURCE_PITCH"], None
    if follow:
        distorted = descriptor.geometry.distorted
        camera = Camera(*distorted, pitch, camera_line(line, descriptor.geometry))
    result = simulate_frame(
        verilog, raw_image(raw, pitch), corrector_program(
            descriptor, data_width, split=split, strip=fetch.strip, follow=follow),
        source_base=values["SOURCE_BASE"], output_base=values["TARGET_BASE"],
        output_bytes=3 * width * height if stream else frame_bytes(descriptor.geometry),
        memory=memory, simulator=simulator, seed=seed, camera=camera, progress=progress)
    picture = np.frombuffer(result.output, np.uint8).reshape(height, width, -1)
    if not stream:
        picture = picture[..., 2::-1]  # stored blue first, a zero byte last
    golden = correct(descriptor, raw, strip=fetch.strip)
    cache = fetch.cache_for(descriptor.geometry) if fetch.fetcher == "cache" else None
    rows = {r.name: r for r in registers(descriptor.hidden_neurons, descriptor.formats)}
    return Simulation(
        picture=picture, golden=golden.picture, filled=golden.filled,
        counters={name: result.registers[rows[name].address] for name in COUNTERS},
        fetches_expected=(tiles_fetched(descriptor, fetch, front_end.lanes) if cache
                          else golden.fetches),
        bytes_read=sum(result.bytes_read),
        bytes_written=result.bytes_written, clocks_outside=result.clocks[0],
        follow={} if not follow else {
            "follow_latency_clocks": result.ends[0] - result.counters["camera_end"],
            "follow_early_reads": result.counters["early_reads"]},
        setup={"simulator": simulator, "memory": memory if isinstance(memory, str) else "custom",
               "fetch": fetch.fetcher, "cache_bytes": cache.bytes if cache else 0,
               "cache_split": split if cache else 0, "data_width": data_width, "output": output,
               "hidden": front_end.hidden, "share": front_end.share,
               "products": front_end.products, "strip": fetch.strip,
               "pixels_per_clock": front_end.lanes})

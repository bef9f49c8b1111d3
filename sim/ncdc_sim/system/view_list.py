"""A list of views of a raw frame on the generated corrector, compared with the golden model."""

import numpy as np

from ncdc_hdl.corrector import Corrector
from ncdc_hdl.export.verilog import verilog_of
from ncdc_model.correction import correct
from ncdc_model.golden.corrector import check_raw
from ncdc_model.golden.view_list import compose
from ncdc_sim.system.corrector import Simulation, registers_of, tiles_fetched
from ncdc_sim.system.frame import UNWRITTEN, Program, Run, simulate_frame
from ncdc_spec.frames import FrameAddresses, raw_image, stored_picture
from ncdc_spec.registers.host_values import host_values, table_words
from ncdc_spec.registers.register_map import COUNTERS, CTRL_COMMIT, CTRL_START
from ncdc_spec.view_list import ENTRY_WORDS, buffer_bytes, check_largest, list_values

__all__ = ["list_program", "simulate_view_list"]


def list_program(descriptor, hardware, entries, target):
    """Register accesses of a host that makes the views ``entries`` of one raw frame, in a buffer at
    byte address ``target``."""
    values = {name: value for name, value in host_values(descriptor, hardware).items()
              if name not in ENTRY_WORDS.values()}
    values |= list_values(entries, hardware, descriptor.geometry) | {
        "TARGET_BASE": target, "TARGET_LIMIT": target + buffer_bytes(entries, hardware.data_width)}
    rows = registers_of(descriptor, hardware)
    program = Program().allow((values["SOURCE_BASE"], values["SOURCE_LIMIT"]),
                              (target, values["TARGET_LIMIT"]))
    writes = [(rows[name].address, value) for name, value in values.items()]
    writes += table_words(descriptor.valid)
    for address, value in [*writes, (rows["IRQ_ENABLE"].address, 1)]:
        program.write(address, value)
    for address, value in writes:
        program.compare(address, value)
    program.write(rows["CTRL"].address, CTRL_COMMIT | CTRL_START).wait_irq()
    program.compare(rows["VIEWS_STATE"].address, hardware.views | len(entries) << 8)
    for name in COUNTERS:
        program.read(rows[name].address)
    return program


def simulate_view_list(descriptor, raw, hardware, entries, size, *, memory="sdram", **run):
    """Make the views ``entries`` of the ``raw`` frame in one picture of ``size``.

    Parameters
    ----------
    descriptor : Descriptor
    raw : ndarray of uint8, shape (distorted height, distorted width)
    hardware : Hardware
        With a list of as many views.
    entries : sequence of Entry
        All of one format, and a ``pitch`` of that picture's rows, see
        :func:`ncdc_spec.view_list.placed`.
    size : (int, int)
        Width and height of the picture. Pixels of no view are black.
    memory, run :
        As of :func:`ncdc_sim.system.frame.simulate_frame`.

    Returns
    -------
    Simulation
        Its pictures are the whole one, ``blank`` are pixels of no view; counters are those of the
        pass. The bytes of pixels of no view are compared too: none is written.

    Raises
    ------
    InputError
        If the frame is not of the descriptor's size, or the hardware cannot make these views.
    SimulationError
        If the simulation fails.
    """
    check_raw(raw, descriptor.geometry)
    corrector = Corrector(descriptor, hardware)
    check_largest(entries, corrector.table.largest)
    hardware, form = corrector.hardware, entries[0].form
    width, height = size
    pixels = (height, width, form.pixel_bytes)
    buffers = FrameAddresses.after_reset(descriptor.geometry, hardware.data_width)
    result = simulate_frame(
        verilog_of(corrector), raw_image(raw, buffers.pitch),
        list_program(descriptor, hardware, entries, buffers.target), source_base=buffers.source,
        output_base=buffers.target, output_bytes=int(np.prod(pixels)), memory=memory, **run)
    expected = np.full(pixels, UNWRITTEN, np.uint8)
    compose(descriptor, raw, entries, expected.reshape(-1), correct)
    stored = np.frombuffer(result.output, np.uint8).reshape(pixels)
    empty = _empty(entries, size)
    rows = registers_of(descriptor, hardware)
    return Simulation(
        picture=stored_picture(np.where(empty[..., None], np.uint8(0), stored), form),
        golden=stored_picture(np.where(empty[..., None], np.uint8(0), expected), form),
        stored=stored, expected=expected, blank=empty,
        counters={name: result.registers[rows[name].address] for name in COUNTERS},
        fetches_expected=sum(tiles_fetched(descriptor, hardware, entry.view) for entry in entries),
        bytes_read=sum(result.bytes_read), bytes_written=result.bytes_written,
        bytes_outside=result.counters["outside_bytes"], clocks_outside=result.clocks[0],
        follow={}, sums={}, sums_expected={},
        setup={"simulator": run.get("simulator", Run.simulator),
               "memory": memory if isinstance(memory, str) else "custom",
               **hardware.report(descriptor.geometry)})


def _empty(entries, size):
    """Pixels of a picture of ``size`` that are of no view, bool (height, width)."""
    width, height = size
    empty = np.ones((height, width), bool)
    for entry in entries:
        v, u = divmod(entry.offset // entry.form.pixel_bytes, width)
        empty[v:v + entry.view.size[1], u:u + entry.view.size[0]] = False
    return empty

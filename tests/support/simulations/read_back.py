"""Registers and valid rows that a host reads: after reset, and after it wrote them."""

import numpy as np

from ncdc_hdl.export.drivers.lenses import Lens
from ncdc_sim.system.frame import Program, simulate_frame
from ncdc_spec.registers.register_map import TABLE
from ncdc_spec.view_list import ENTRY_WORDS, entry_register
from simulations.series import read_measured

__all__ = ["simulate_read_back"]

_ONES = 0xFFFFFFFF
_UNUSED = 0x3F          # an address without a register


def simulate_read_back(corrector, verilog, *, seed=1, **options):
    """Read all registers after reset, and twice after other values were written to each.

    Parameters
    ----------
    corrector, verilog : Corrector, str
    seed : int
    options :
        As of :func:`ncdc_sim.system.frame.simulate_frame`.

    Returns
    -------
    list of str
        Names of the registers that read wrong values after reset.

    Raises
    ------
    SimulationError
        If a register or an entry of the valid rows does not read what was written.
    """
    rng = np.random.default_rng(seed)
    table = corrector.registers.table
    written = [r for r in table if r.access in ("rw", "shadow")]
    program = Program()
    for register in table:
        program.read(register.address)
    program.read(_UNUSED)
    first = {r.name: _random(rng, r.shape) for r in written}
    # The other way round, too: what a write changes of a register written before it is read.
    for values, order in ((first, 1), ({name: ~value for name, value in first.items()}, -1)):
        _write(program, table, written[::order], _shared(values))
    _rows(program, rng, corrector, {r.name: r.address for r in table})
    result = simulate_frame(verilog, b"", program, source_base=0, output_base=0, output_bytes=16,
                            **options)
    found = dict(result.reads[:len(table)])
    expected = Lens.of(corrector, corrector.descriptor).values
    return [r.name for r in table if r.name in expected
            and found[r.address] != expected[r.name] & _ONES]


def _random(rng, shape):
    """A value of a register of ``shape``."""
    low = -1 << shape.width - 1 if shape.signed else 0
    return int(rng.integers(low, low + (1 << shape.width)))


def _shared(values):
    """``values`` by name, with one value for each two names of a register: those of the set are
    those of the first view of a list."""
    return values | {entry_register(0, word): values[name] for word, name in ENTRY_WORDS.items()
                     if name in values}


def _write(program, table, written, values):
    """Write ``values`` to all registers that a host may write, ones to the others; read all."""
    for register in table:
        if register.access == "ro":
            program.write(register.address, _ONES)
    for register in written:
        program.write(register.address, values[register.name])
    program.write(_UNUSED, _ONES)
    for register in written:
        width, signed = register.shape.width, register.shape.signed
        value = values[register.name] & (1 << width) - 1
        program.compare(register.address,
                        value - (1 << width) if signed and value >> width - 1 else value)
    read_measured(program, table)


def _rows(program, rng, corrector, rows):
    """Write valid rows of both banks, and read them."""
    width, height = corrector.table.largest
    numbers = sorted({0, *(1 << k for k in range(height.bit_length() - 1)), height - 1,
                      *(int(row) for row in rng.integers(0, height, 8))})
    words = [(bank, TABLE + 2 * row + k, int(rng.integers(0, width)) | int(rng.integers(0, width))
              << 16) for bank in range(2) for row in numbers for k in range(2)]
    for of_words in (words, [(*where, word ^ (width - 1) * 0x10001) for *where, word in words]):
        for reads in (False, True):
            for bank, address, word in of_words:
                if address in (TABLE, TABLE + 1):
                    program.write(rows["VALID_WINDOW"], bank)
                (program.compare if reads else program.write)(address, word)

"""Pairs of ECP5's tables that a multiplexer joins: what Yosys puts before them moves into them."""

import numpy as np

from ncdc.toolchain.ecp5_netlist.cells import Wires, of_type

__all__ = ["absorb_tables"]

_PINS = "ABCD"


def absorb_tables(netlist, top):
    """Move tables before joined pairs of tables into them, in a JSON netlist of ``synth_ecp5``.

    Two tables of four inputs each and the multiplexer after them (PFUMX) choose one of four bits.
    Yosys takes a pair for a function of five inputs only, and adds a third table for the sixth. A
    table that feeds nothing but a pair is removed if some input of the whole, as the multiplexer's
    select, leaves each table four others at most. The function stays the same.

    Parameters
    ----------
    netlist : dict
        Parsed; changed in place.
    top : str
        Name of the flat top module.

    Returns
    -------
    int
        Tables that were removed.
    """
    module = netlist["modules"][top]
    cells, users = module["cells"], Wires.of(module).users
    tables = {cell["connections"]["Z"][0]: name for name, cell in cells.items()
              if cell["type"] == "LUT4"}
    absorbed = 0
    for joined in of_type(module, "PFUMX"):
        wires = joined["connections"]
        (select,), halves = wires["C0"], [wires[port][0] for port in ("BLUT", "ALUT")]
        if not all(half in tables and users[half] == 1 for half in halves):
            continue
        pair = [cells[tables[half]] for half in halves]
        for before in _feeding(pair, select, tables, users):
            fused = _fused(cells[tables[before]], before, pair, select)
            if fused:
                wires["C0"] = [fused[0]]
                for half, (inputs, table) in zip(pair, fused[1:]):
                    half["connections"].update(zip(_PINS, ([wire] for wire in inputs)))
                    half["parameters"]["INIT"] = f"{table:016b}"
                del cells[tables.pop(before)]
                absorbed += 1
                break
    return absorbed


def _feeding(pair, select, tables, users):
    """Outputs of tables that feed nothing but the tables of ``pair``, or the ``select``."""
    inputs = [select, *(cell["connections"][pin][0] for cell in pair for pin in _PINS)]
    return [wire for wire in dict.fromkeys(inputs)
            if wire in tables and users[wire] == inputs.count(wire)]


def _fused(before, between, pair, select):
    """``pair``, joined by ``select``, with the table ``before`` them, whose output is ``between``.

    Gives the new select, and (inputs, contents) of the two tables; None if they do not fit.
    """
    inputs = [select, *(cell["connections"][pin][0] for cell in (*pair, before) for pin in _PINS)]
    wires = [wire for wire in dict.fromkeys(inputs) if isinstance(wire, int) and wire != between]
    # All values of the wires, an axis for each.
    values = dict(zip(wires, np.indices((2,) * len(wires)))) | {"0": 0, "1": 1, "x": 0}
    values[between] = _output(before, values)
    whole = np.where(values[select], *(_output(cell, values) for cell in pair[::-1]))
    for axis, wire in enumerate(wires):
        others = wires[:axis] + wires[axis + 1:]
        parts = [_table(whole.take(value, axis), others) for value in range(2)]
        if all(parts):
            return wire, *parts
    return None


def _output(cell, values):
    """What a table gives for the ``values`` of its inputs."""
    number = sum(values[cell["connections"][pin][0]] << k for k, pin in enumerate(_PINS))
    return int(cell["parameters"]["INIT"], 2) >> number & 1


def _table(values, wires):
    """(Inputs, contents) of the table that gives ``values``, an axis for each of ``wires``; None
    if it needs more than four inputs."""
    used = [axis for axis in range(len(wires))
            if (values.take(0, axis) != values.take(1, axis)).any()]
    if len(used) > len(_PINS):
        return None
    unused = len(_PINS) - len(used)
    few = values[tuple(slice(None) if axis in used else 0 for axis in range(len(wires)))]
    bits = few.transpose().reshape(-1).tolist() * (1 << unused)
    return ([wires[axis] for axis in used] + ["0"] * unused,
            sum(bit << k for k, bit in enumerate(bits)))

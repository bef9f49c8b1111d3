"""Tables of an ECP5 that move into joined pairs of tables: the function stays, whatever it is."""

import copy
import itertools

import numpy as np
import pytest

from ncdc.toolchain.ecp5_netlist.joined_tables import absorb_tables

CHOICE, FIRST = 0b11001010, 0b1010      # C ? B : A in eight values; A in four


def table(contents, *inputs, z):
    """A cell of the ``contents`` for its first inputs; the others are 0."""
    size = 1 << len(inputs)
    return {"type": "LUT4", "parameters": {"INIT": f"{contents & (1 << size) - 1:016b}"},
            "port_directions": dict.fromkeys("ABCD", "input") | {"Z": "output"},
            "connections": {pin: [wire] for pin, wire in
                            zip("ABCD", [*inputs, "0", "0", "0", "0"])} | {"Z": [z]}}


def joined(before, a, b, select):
    """A netlist: ``before`` drives wire 20, ``a`` and ``b`` 21 and 22, the pair 23."""
    pair = {"type": "PFUMX", "parameters": {},
            "port_directions": {"ALUT": "input", "BLUT": "input", "C0": "input", "Z": "output"},
            "connections": {"ALUT": [21], "BLUT": [22], "C0": [select], "Z": [23]}}
    return {"modules": {"top": {
        "ports": {"o": {"direction": "output", "bits": [23]}},
        "cells": {"t": before, "a": a, "b": b, "pair": pair}}}}


def values(netlist):
    """What wire 23 is for all values of the wires 2 to 9."""
    cells = netlist["modules"]["top"]["cells"]
    known = dict(zip(range(2, 10), np.indices((2,) * 8))) | {"0": 0, "1": 1}
    for name in "tab":
        if name in cells:
            wires = cells[name]["connections"]
            number = sum(known[wires[pin][0]] << k for k, pin in enumerate("ABCD"))
            known[wires["Z"][0]] = int(cells[name]["parameters"]["INIT"], 2) >> number & 1
    wires = cells["pair"]["connections"]
    return np.where(known[wires["C0"][0]], *(known[wires[port][0]] for port in ("ALUT", "BLUT")))


def test_one_of_four_bits_takes_two_tables():
    """As Yosys leaves it: the third table's output is the select."""
    netlist = joined(table(CHOICE, 2, 3, 6, z=20), table(0b1101110111110101, 7, 5, 4, 6, z=21),
                     table(0b1000100010100000, 7, 5, 4, 6, z=22), 20)
    before = values(netlist)
    assert absorb_tables(netlist, "top") == 1
    cells = netlist["modules"]["top"]["cells"]
    assert set(cells) == {"a", "b", "pair"} and cells["pair"]["connections"]["C0"] in ([6], [7])
    assert (values(netlist) == before).all()


def test_any_function_stays_the_same():
    rng, absorbed = np.random.default_rng(3), 0
    for _ in range(400):
        def wires(last):
            return [int(wire) for wire in rng.choice(range(2, last), 3, replace=False)]
        contents = [int(each) for each in rng.integers(1, 1 << 16, 3)]
        first, second = [20, *wires(6)], [20, *wires(7)]
        netlist = joined(table(contents[0], *wires(9)[:int(rng.integers(1, 4))], z=20),
                         table(contents[1], *first, z=21),
                         table(contents[2], *rng.permutation(second).tolist(), z=22),
                         int(rng.integers(2, 10)))
        before = values(netlist)
        absorbed += absorb_tables(netlist, "top")
        assert (values(netlist) == before).all()
    assert 50 < absorbed < 350


@pytest.mark.parametrize("change", [
    lambda top: top["ports"]["o"]["bits"].append(20),           # the table is read elsewhere
    lambda top: top["ports"]["o"]["bits"].append(21),           # a table of the pair is
    lambda top: top["cells"]["t"].update(type="CCU2C"),
    lambda top: top["cells"]["a"].update(type="CCU2C"),
    lambda top: top["cells"]["a"]["connections"].update(zip("ABCD", ([8], [9], [4], [6]))),
])
def test_other_tables_stay(change):
    netlist = joined(table(CHOICE, 2, 3, 6, z=20), table(0b1101110111110101, 7, 5, 4, 6, z=21),
                     table(0b1000100010100000, 7, 5, 4, 6, z=22), 20)
    change(netlist["modules"]["top"])
    before = copy.deepcopy(netlist)
    assert absorb_tables(netlist, "top") == 0
    assert netlist == before


def test_tables_of_constants_and_of_fewer_inputs():
    for select, (a, b) in itertools.product((20, 6), ((0, 0xFFFF), (FIRST, 0b1100))):
        netlist = joined(table(CHOICE, 2, "1", 6, z=20), table(a, 3, 20, z=21),
                         table(b, 20, "1", z=22), select)
        before = values(netlist)
        assert absorb_tables(netlist, "top") == 1
        assert (values(netlist) == before).all()

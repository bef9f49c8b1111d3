"""Output registers of ECP5 block RAMs, which Yosys leaves beside the RAM."""

from collections import Counter

__all__ = ["absorb_output_registers"]


def absorb_output_registers(netlist, top):
    """Move registers right behind a block RAM into it, in a JSON netlist of ``synth_ecp5``.

    A RAM's output comes 4.3 ns after the clock, that of its output register much earlier. Yosys
    does not use that register; vendors' tools do. A RAM whose every used output feeds one plain
    flip-flop of the RAM's own clock, and nothing else, is changed; the function stays the same.

    Parameters
    ----------
    netlist : dict
        Parsed; changed in place.
    top : str
        Name of the flat top module.

    Returns
    -------
    int
        Flip-flops that became part of a RAM.
    """
    module = netlist["modules"][top]
    cells = module["cells"]
    users, readers = Counter(), {}
    for port in module["ports"].values():
        users.update(bit for bit in port["bits"] if port["direction"] == "output")
    for name, cell in cells.items():
        for port, bits in cell["connections"].items():
            if cell["port_directions"][port] == "input":
                users.update(bits)
                readers.update(dict.fromkeys(bits, (name, port)))
    absorbed = 0
    for ram in [cell for cell in cells.values() if cell["type"] == "DP16KD"]:
        outputs = {port: bits[0] for port, bits in ram["connections"].items()
                   if port.startswith("DO") and bits and users[bits[0]]}
        behind = {port: readers[bit] for port, bit in outputs.items()}
        if not outputs or not all(
                users[outputs[port]] == 1 and _plain(cells[name], reader, ram)
                for port, (name, reader) in behind.items()):
            continue
        for port, (name, _) in behind.items():
            ram["connections"][port] = cells.pop(name)["connections"]["Q"]
        ram["parameters"] |= {"REGMODE_A": "OUTREG", "REGMODE_B": "OUTREG"}
        absorbed += len(behind)
    return absorbed


def _plain(cell, port, ram):
    """Whether ``cell`` is a flip-flop that only delays what its ``port`` reads from ``ram``."""
    wires = cell["connections"]
    return (cell["type"] == "TRELLIS_FF" and port in ("DI", "M")
            and cell["parameters"]["CEMUX"].strip() == "1" and wires.get("LSR", ["0"]) == ["0"]
            and cell["parameters"]["REGSET"] == "RESET" and cell["parameters"]["CLKMUX"] == "CLK"
            and wires["CLK"] == ram["connections"]["CLKB"]
            and ram["connections"]["OCEB"] == ["1"] and ram["connections"]["CEA"] == ["0"])

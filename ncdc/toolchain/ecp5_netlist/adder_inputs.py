"""Conditional subtraction in ECP5's carry chains, before which Yosys leaves a table."""

from ncdc.toolchain.ecp5_netlist.cells import Wires, of_type

__all__ = ["absorb_inversions"]

_ADD = 0x96AA           # propagate A xor B xor C, generate A; D is one
_PINS = "ABCD"


def absorb_inversions(netlist, top):
    """Move exclusive-ors before adders into them, in a JSON netlist of ``synth_ecp5``.

    An adder's bit holds a table of four inputs, of which a sum needs two. ``a + (b ^ s)`` adds or
    subtracts as ``s`` says, and needs one level of logic with the table instead of two. Yosys does
    so only if ``s`` is a constant, vendors' tools always. The function stays the same.

    Parameters
    ----------
    netlist : dict
        Parsed; changed in place.
    top : str
        Name of the flat top module.

    Returns
    -------
    int
        Bits of adders that took in an exclusive-or.
    """
    module = netlist["modules"][top]
    cells = module["cells"]
    users, gates = Wires.of(module).users, {}
    for name, cell in cells.items():
        if cell["type"] == "LUT4" and (gate := _exclusive_or(cell)):
            gates[cell["connections"]["Z"][0]] = (name, *gate)
    absorbed = 0
    for adder in of_type(module, "CCU2C"):
        for half in "01":
            absorbed += _absorb(adder, half, gates, users)
    for bit, (name, *_) in gates.items():
        if not users[bit]:
            del cells[name]
    return absorbed


def _absorb(adder, half, gates, users):
    """Whether one bit of ``adder`` could be changed."""
    wires = adder["connections"]
    a, b, c, d = (wires[f"{pin}{half}"][0] for pin in _PINS)
    if int(adder["parameters"][f"INIT{half}"], 2) != _ADD or c not in ("0", "1") or d != "1":
        return False
    gated, other = (b, a) if b in gates else (a, b)
    if gated not in gates:
        return False
    _, inputs, inverted = gates[gated]
    for pin, wire in zip("ABC", (other, *inputs, "0")):
        wires[f"{pin}{half}"] = [wire]
        users[wire] += 1
    for wire in (a, b):
        users[wire] -= 1
    if inverted != (c == "1"):
        adder["parameters"][f"INIT{half}"] = f"{_ADD ^ 0xFF00:016b}"
    return True


def _exclusive_or(cell):
    """Inputs and inversion of a LUT that is an exclusive-or of two wires, or the inverse of one;
    else None."""
    table = int(cell["parameters"]["INIT"], 2)
    wires = [cell["connections"][pin][0] for pin in _PINS]
    used = [k for k, wire in enumerate(wires) if isinstance(wire, int)]
    fixed = sum(1 << k for k, wire in enumerate(wires) if wire == "1")
    values = [table >> (fixed | sum((j >> i & 1) << k for i, k in enumerate(used))) & 1
              for j in range(1 << len(used))]
    if values not in ([1, 0], [0, 1, 1, 0], [1, 0, 0, 1]) or len({*wires} - {"0", "1"}) < len(used):
        return None
    return [wires[k] for k in used], values[0] == 1

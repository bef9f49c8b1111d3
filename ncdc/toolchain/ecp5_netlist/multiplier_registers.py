"""Registers of ECP5 multipliers, which Yosys leaves outside the multiplier."""

from ncdc.toolchain.ecp5_netlist.cells import (
    Wires,
    enable_of,
    flip_flop_without_reset,
    of_type,
)

__all__ = ["absorb_multiplier_registers"]


def absorb_multiplier_registers(netlist, top):
    """Move registers around 18 x 18 multipliers into them, in a JSON netlist of ``synth_ecp5``.

    A multiplier has a register at each factor, one within and one at its product; without them
    4.5 ns pass from factors to product. Yosys does not use them; vendors' tools do. A factor's is
    used if flip-flops without a reset, of one clock and one enable, drive all bits that are no
    constants. The flip-flops remain for their other readers. A product's register is used if every
    bit that is read feeds one such flip-flop and nothing else. If these feed only flip-flops again,
    both registers are used. The registers of a multiplier share clock and enable. The function
    stays the same, but for the first clocks after configuration.

    Parameters
    ----------
    netlist : dict
        Parsed; changed in place.
    top : str
        Name of the flat top module.

    Returns
    -------
    int
        Registers of multipliers that are now in use.
    """
    module = netlist["modules"][top]
    cells = module["cells"]
    wires = Wires.of(module)
    used = sum(_Multiplier(mult, cells, wires).absorb() for mult in of_type(module, "MULT18X18D"))
    # Flip-flops without readers; those after a multiplier are removed already.
    for bit, name in wires.drivers.items():
        if not wires.users[bit] and name in cells:
            del cells[name]
    return used


class _Multiplier:
    def __init__(self, cell, cells, wires):
        self.cell, self.cells = cell, cells
        self.users, self.readers, self.drivers = wires.users, wires.readers, wires.drivers
        self.control = None         # wires of its clock and its enable

    def absorb(self):
        """Use what registers can be used; their number."""
        return self._factor("A") + self._factor("B") + self._product()

    def _factor(self, side):
        wires = {port: bits[0] for port, bits in self.cell["connections"].items()
                 if port[0] == side and port[1:].isdigit() and bits and isinstance(bits[0], int)}
        flip_flops = {port: self.cells.get(self.drivers.get(bit)) for port, bit in wires.items()}
        if not wires or not self._same_control(flip_flops.values()):
            return 0
        for port, flip_flop in flip_flops.items():
            before = flip_flop["connections"]["DI"][0]
            self.users[wires[port]] -= 1
            self.users[before] += 1
            self.cell["connections"][port] = [before]
        self._use(f"INPUT{side}")
        return 1

    def _product(self):
        wires = {port: bits[0] for port, bits in self.cell["connections"].items()
                 if port[0] == "P" and bits and self.users[bits[0]]}
        registers = 0
        while registers < 2 and wires:
            after = {port: self.readers.get(bit, (None,))[0] for port, bit in wires.items()}
            flip_flops = {port: self.cells.get(name) for port, name in after.items()}
            if (any(self.users[bit] != 1 for bit in wires.values())
                    or not self._same_control(flip_flops.values())
                    or any(self.readers[bit][1] != "DI" for bit in wires.values())):
                break
            for port, name in after.items():
                wires[port] = flip_flops[port]["connections"]["Q"][0]
                self.cell["connections"][port] = [wires[port]]
                del self.cells[name], self.drivers[wires[port]]
            self._use("PIPELINE" if registers else "OUTPUT")
            registers += 1
        return registers

    def _same_control(self, flip_flops):
        """Whether these are flip-flops without a reset, of the multiplier's clock and enable."""
        if not all(flip_flop and flip_flop_without_reset(flip_flop) for flip_flop in flip_flops):
            return False
        controls = {(flip_flop["connections"]["CLK"][0], enable_of(flip_flop))
                    for flip_flop in flip_flops}
        controls |= {self.control} if self.control else set()
        if len(controls) != 1:
            return False
        self.control, = controls
        return True

    def _use(self, register):
        self.cell["parameters"][f"REG_{register}_CLK"] = "CLK0"
        clock, enable = self.control
        for port, wire in (("CLK0", clock), ("CE0", enable), ("RST0", "0")):
            self.cell["port_directions"][port] = "input"
            self.cell["connections"][port] = [wire]

"""A flat JSON netlist of ``synth_ecp5``: who reads and who drives each wire, and its flip-flops."""

from collections import Counter
from dataclasses import dataclass

__all__ = ["Wires", "enable_of", "flip_flop_without_reset", "of_type"]


@dataclass(frozen=True)
class Wires:
    """The wires of a module, by their numbers.

    Parameters
    ----------
    users : Counter
        How many inputs of cells and outputs of the module read each.
    readers : dict
        Name and port of a cell that reads it; of the only one, if ``users`` is 1 and no output.
    drivers : dict
        Name of the flip-flop whose output it is.
    """
    users: Counter
    readers: dict
    drivers: dict

    @classmethod
    def of(cls, module):
        """The wires of a ``module`` of a parsed netlist."""
        users, readers, drivers = Counter(), {}, {}
        for port in module["ports"].values():
            users.update(bit for bit in port["bits"] if port["direction"] == "output")
        for name, cell in module["cells"].items():
            for port, bits in cell["connections"].items():
                if cell["port_directions"][port] == "input":
                    users.update(bits)
                    readers.update(dict.fromkeys(bits, (name, port)))
            if cell["type"] == "TRELLIS_FF":
                drivers[cell["connections"]["Q"][0]] = name
        return cls(users, readers, drivers)


def of_type(module, kind):
    """The cells of the type ``kind``, as a list: the module may be changed meanwhile."""
    return [cell for cell in module["cells"].values() if cell["type"] == kind]


def enable_of(cell):
    """The wire that enables a flip-flop, or "1"."""
    return "1" if cell["parameters"]["CEMUX"].strip() == "1" else cell["connections"]["CE"][0]


def flip_flop_without_reset(cell):
    """Whether ``cell`` is a flip-flop that takes what its port DI reads, when it is enabled."""
    parameters, wires = cell["parameters"], cell["connections"]
    return (cell["type"] == "TRELLIS_FF" and "DI" in wires
            and parameters["CEMUX"].strip() in ("1", "CE") and wires.get("LSR", ["0"]) == ["0"]
            and parameters["REGSET"] == "RESET" and parameters["CLKMUX"] == "CLK")

"""The netlist that is mutated: where each of its cells comes from, in words."""

import json
from dataclasses import dataclass
from pathlib import Path

from ncdc_hdl.export.verilog.convert import Netlist

__all__ = ["ROOT", "Sources", "distinct_modules"]

ROOT = Path(__file__).resolve().parents[3]      # of the checkout

_MAX_STEPS = 12     # cells that are followed from one without a line of source to a named net
_WORDS = {"$mux": "multiplexer", "$pmux": "multiplexer", "$dff": "register", "$dffe": "register",
          "$sdff": "register", "$add": "adder", "$sub": "subtractor", "$mul": "multiplier",
          "$eq": "comparison", "$ne": "comparison", "$lt": "comparison", "$le": "comparison",
          "$gt": "comparison", "$ge": "comparison", "$memrd_v2": "memory read port",
          "$memwr_v2": "memory write port", "$shl": "shift", "$shr": "shift", "$sshr": "shift",
          "$shift": "selection", "$shiftx": "selection", "$not": "inverter", "$and": "AND",
          "$or": "OR", "$xor": "XOR", "$logic_not": "test for zero", "$neg": "negation",
          "$reduce_or": "OR of all bits", "$reduce_and": "AND of all bits",
          "$reduce_bool": "OR of all bits", "$reduce_xor": "XOR of all bits"}


@dataclass(frozen=True)
class Distinct:
    """One distinct module.

    Parameters
    ----------
    name : str
        As in the Verilog that is shipped.
    original : str
        The converter's name of its first instance.
    source : str
        File of its class, relative to the checkout; empty for one that Amaranth made.
    """
    name: str
    original: str
    source: str


def distinct_modules(component, top):
    """:class:`Distinct` modules of a component's Verilog, the top first."""
    netlist, found = Netlist(component, top), []
    for original in netlist.written():
        made_by = netlist.parts[original].component
        module = type(made_by).__module__ if made_by is not None else ""
        source = module.replace(".", "/") + ".py" if module.startswith("ncdc_") else ""
        found.append(Distinct(netlist.names[original], original, source))
    return found


class Sources:
    """Lines of source of a netlist's cells.

    Parameters
    ----------
    path : Path
        The netlist, as Yosys's ``write_json`` writes it.
    """

    def __init__(self, path):
        self._modules = {name: _Module(module)
                         for name, module in json.loads(path.read_text())["modules"].items()}

    def line(self, module, cell, port, bit):
        """File and line of the gateware that a mutated bit comes from, or an empty text.

        A cell that Yosys made of a choice has no line. Then it is that of the first named net, or
        the first cell with a line, that its output reaches.
        """
        return self._modules[module].line(cell, port, bit)

    def words(self, module, cell, port, bit):
        """The mutated bit in words."""
        return self._modules[module].words(cell, port, bit)

    def init(self, module, cell, port, bit):
        """What a register's bit holds after configuration, "0" or "1"; None if it is open."""
        return self._modules[module].init(cell, port, bit)


class _Module:
    """Cells and nets of one module."""

    def __init__(self, module):
        self.cells = module["cells"]
        self.nets, self.readers, self.inits = {}, {}, {}
        for name, net in module["netnames"].items():
            self.inits |= dict(zip(net["bits"], reversed(net["attributes"].get("init", ""))))
            if not net["hide_name"]:
                for k, bit in enumerate(net["bits"]):
                    self.nets.setdefault(bit, (name, k, net))
        for name, cell in self.cells.items():
            for port, bits in cell["connections"].items():
                if cell["port_directions"][port] == "input":
                    for bit in bits:
                        self.readers.setdefault(bit, []).append(name)

    def line(self, cell, port, bit):
        """See :meth:`Sources.line`."""
        target = self.cells[cell]["connections"][port][bit]
        waiting, seen = [cell], {cell}
        if self.cells[cell]["port_directions"][port] == "output" and target in self.nets:
            found = _source_line(self.nets[target][2])
            if found:
                return found
        for _ in range(_MAX_STEPS):
            following = []
            for name in waiting:
                found = _source_line(self.cells[name])
                if found:
                    return found
                for out in self._outputs(name):
                    if out in self.nets and _source_line(self.nets[out][2]):
                        return _source_line(self.nets[out][2])
                    following += [one for one in self.readers.get(out, []) if one not in seen]
                    seen |= set(following)
            waiting = following
        return ""

    def words(self, cell, port, bit):
        """See :meth:`Sources.words`."""
        described = self.cells[cell]
        kind = described["type"]
        of = _WORDS.get(kind, kind.lstrip("$")) if kind.startswith("$") else f"instance {cell}"
        net = self.nets.get(described["connections"][port][bit])
        named = f" (`{net[0]}[{net[1]}]`)" if net else ""
        if not net and kind.startswith("$"):
            named = self._reached(cell)
        return f"bit {bit} of {port} of the {of}{named}"

    def init(self, cell, port, bit):
        """See :meth:`Sources.init`."""
        found = self.inits.get(self.cells[cell]["connections"][port][bit])
        return found if found in ("0", "1") else None

    def _outputs(self, name):
        cell = self.cells[name]
        return [bit for port, bits in cell["connections"].items()
                if cell["port_directions"][port] == "output" for bit in bits]

    def _reached(self, cell):
        """The named net that a cell's output reaches first."""
        waiting, seen = [cell], {cell}
        for _ in range(_MAX_STEPS):
            following = []
            for name in waiting:
                for out in self._outputs(name):
                    if out in self.nets:
                        return f" towards `{self.nets[out][0]}`"
                    following += [one for one in self.readers.get(out, []) if one not in seen]
                    seen |= set(following)
            waiting = following
        return ""


def _source_line(described):
    """The first line of an object's attribute that lies in the checkout, else an empty text."""
    for entry in described["attributes"].get("src", "").split("|"):
        path, _, line = entry.rpartition(":")
        if path and Path(path).is_relative_to(ROOT) and ".venv" not in path:
            return f"{Path(path).relative_to(ROOT)}:{line.partition('.')[0]}"
    return ""

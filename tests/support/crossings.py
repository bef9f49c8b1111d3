"""Which registers of a design read those of another clock, from its netlist."""

import re
from dataclasses import dataclass

from amaranth import *

from ncdc_hdl.export.verilog.rtlil import Switch, bits_of, parse

__all__ = ["Clocks", "Crossing", "Wire"]

_ALIKE = ("$not", "$and", "$or", "$xor", "$mux")      # bit k of the result reads bit k


@dataclass(frozen=True)
class Crossing:
    """A register, memory or input that what another clock clocks reads.

    Parameters
    ----------
    source, sink : str
        Paths below the top module.
    bits : frozenset
        Numbers of the bits of the source that the sink reads; "content" of a memory.
    direct : bool
        There is no logic between them.
    """
    source: str
    sink: str
    bits: frozenset
    direct: bool


class Clocks:
    """What each clock of a design clocks, and who reads it.

    Parameters
    ----------
    rtlil : str
        The design in RTLIL, as Amaranth writes it.
    domains : dict
        Inputs of the top module that are, or change with, another clock than "clk": the name of
        that clock, or "" of what changes at any time.
    """

    # Nodes are (module, wire, bit), or a number for a piece of logic.
    def __init__(self, rtlil, domains):
        modules = parse(rtlil)
        self.modules = {module.name: module for module in modules}
        self.top = modules[0]
        self.reads = {}         # of a node: those that it reads in the same clock
        self.count = 0          # pieces of logic
        self.sources = {}       # nodes that hold a value: (name, clock)
        self.sinks = {}         # (name, clock) of what clocks in a value: nodes that it reads
        self.clocks = []        # (name, source nodes, sink's nodes, clock's node)
        for module in modules:
            self._module(module)
        for name, held, read, clock in self.clocks:
            domain = self._root(clock)
            self.sources |= dict.fromkeys(held, (name, domain))
            self.sinks.setdefault((name, domain), set()).update(read)
        for wire, about in self.top.wires.items():
            bits = [(self.top.name, wire, k) for k in range(about.width)]
            name = wire.removeprefix("\\")
            if about.port == "input":
                self.sources |= dict.fromkeys(bits, (name, domains.get(name, "clk")))
            elif about.port == "output":
                self.sinks.setdefault((name, "clk"), set()).update(bits)

    def readers(self, source):
        """Paths of the registers, memories and outputs that read a register, and whether each
        does through wires alone."""
        found = {}
        for (sink, _), nodes in self.sinks.items():
            ways = [direct for node, direct in self._sources(nodes).items()
                    if self.sources[node][0] == source]
            if ways:
                found[sink] = all(ways)
        return found

    def crossings(self):
        """Every :class:`Crossing`, a set."""
        found, cones = set(), {}
        for (sink, domain), nodes in self.sinks.items():
            if domain not in cones:
                every = set().union(*(read for (_, of), read in self.sinks.items() if of == domain))
                cones[domain] = self._foreign(every, domain)
            if cones[domain].isdisjoint(nodes):
                continue
            read = {}
            for node, direct in self._sources(nodes).items():
                name, of = self.sources[node]
                if of != domain:
                    read.setdefault(name, {})[node[2]] = direct
            found |= {Crossing(name, sink, frozenset(bits), all(bits.values()))
                      for name, bits in read.items()}
        return found

    def _foreign(self, nodes, domain):
        """Nodes after ``nodes`` that depend on a source of another clock."""
        readers, seen, begin = {}, set(nodes), []
        waiting = list(nodes)
        while waiting:
            node = waiting.pop()
            if node in self.sources:
                begin += [node] * (self.sources[node][1] != domain)
                continue
            for read in self.reads.get(node, ()):
                readers.setdefault(read, []).append(node)
                if read not in seen:
                    seen.add(read)
                    waiting.append(read)
        found = set(begin)
        while begin:
            for reader in readers.get(begin.pop(), ()):
                if reader not in found:
                    found.add(reader)
                    begin.append(reader)
        return found

    def _sources(self, nodes):
        """Sources that ``nodes`` depend on, and whether through wires alone."""
        seen, found = {}, {}
        waiting = [(node, True) for node in nodes]
        while waiting:
            node, direct = waiting.pop()
            if seen.get(node, 2) <= direct:     # known, by logic or by the same way
                continue
            seen[node] = direct
            if node in self.sources:
                found[node] = direct
                continue
            waiting += [(read, direct and not isinstance(read, int))
                        for read in self.reads.get(node, ())]
        return found

    def _root(self, node):
        """The top module's input that a clock is, through wires alone.

        Raises
        ------
        ValueError
            If there is logic in it.
        """
        while node in self.reads:
            node, = self.reads[node]
            if isinstance(node, int):
                raise ValueError("a clock is not the top module's")
        return node[1].removeprefix("\\")

    def _read(self, target, *nodes):
        self.reads.setdefault(target, []).extend(node for node in nodes if node is not None)

    def _logic(self, nodes):
        """A new piece of logic that reads ``nodes``."""
        self.count += 1
        self.reads[self.count] = [node for node in nodes if node is not None]
        return self.count

    def _nodes(self, module, signal):
        """Nodes of a signal's bits, None of a constant."""
        return [None if isinstance(bit, str) else (module.name, *bit) for bit in bits_of(signal)]

    def _module(self, module):
        for target, source in module.connects:
            for at, read in zip(self._nodes(module, target), self._nodes(module, source)):
                self._read(at, read)
        for process in module.processes:
            self._statements(module, process, None)
        for cell in module.cells:
            wires = {port: self._nodes(module, parts) for port, parts in cell.connections.items()}
            if cell.kind in ("$dff", "$adff"):
                self._register(module, wires)
            elif cell.kind in ("$memrd_v2", "$memwr_v2"):
                self._memory_port(module, cell, wires)
            elif cell.kind.startswith("$"):
                self._operator(cell, wires)
            else:
                self._instance(cell, wires)

    def _statements(self, module, statements, condition):
        for item in statements:
            if isinstance(item, Switch):
                inner = self._logic([condition, *self._nodes(module, item.value)])
                for _, found in item.cases:
                    self._statements(module, found, inner)
            else:
                for at, read in zip(self._nodes(module, item[0]), self._nodes(module, item[1])):
                    self._read(at, read, condition)

    def _name(self, module, name):
        path = [re.sub(r"\$\d+$", "", step) for step in module.name.split(".")[1:]]
        return ".".join([*path, name.lstrip("\\")])

    def _register(self, module, wires):
        name = self._name(module, wires["Q"][0][1])
        read = [node for port in ("D", "ARST") for node in wires.get(port, ()) if node]
        self.clocks.append((name, wires["Q"], read, wires["CLK"][0]))

    def _memory_port(self, module, cell, wires):
        memory = cell.parameters["MEMID"].strip('"').replace("\\\\", "\\").lstrip("\\")
        name, content = self._name(module, memory), (module.name, memory, "content")
        read = [node for port in ("ADDR", "EN", "DATA") for node in wires[port] if node]
        if cell.kind == "$memwr_v2":
            self.clocks.append((name, [content], read, wires["CLK"][0]))
            return
        read = [node for port in ("ADDR", "EN") for node in wires[port] if node]
        if cell.parameters["CLK_ENABLE"] == "1":
            self.clocks.append((self._name(module, wires["DATA"][0][1]), wires["DATA"],
                                [*read, content], wires["CLK"][0]))
        else:
            logic = self._logic([*read, content])
            for node in wires["DATA"]:
                self._read(node, logic)

    def _operator(self, cell, wires):
        inputs = [nodes for port, nodes in wires.items() if port not in ("Y", "S")]
        if cell.kind in _ALIKE and all(len(nodes) == len(wires["Y"]) for nodes in inputs):
            for at, *nodes in zip(wires["Y"], *inputs):
                self._read(at, self._logic([*nodes, *wires.get("S", ())]))
            return
        logic = self._logic([node for nodes in inputs for node in nodes] + wires.get("S", []))
        for at in wires["Y"]:
            self._read(at, logic)

    def _instance(self, cell, wires):
        child = self.modules[cell.kind.removeprefix("\\")]
        for port, nodes in wires.items():
            wire = f"\\{port}"
            inner = [(child.name, wire, k) for k in range(child.wires[wire].width)]
            for outside, inside in zip(nodes, inner, strict=True):
                if child.wires[wire].port == "input":
                    self._read(inside, outside)
                else:
                    self._read(outside, inside)


class Wire(Elaboratable):
    """A planted error: no synchroniser."""

    def __init__(self, i, o, **_):
        self.i, self.o = i, o

    def elaborate(self, platform):
        m = Module()
        m.d.comb += self.o.eq(self.i)
        return m

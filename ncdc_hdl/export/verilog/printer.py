"""One module of a netlist as Verilog-2005."""

from ncdc_hdl.export.verilog.expressions import Expressions, constant, joined, slice_text
from ncdc_hdl.export.verilog.memories import memory_lines
from ncdc_hdl.export.verilog.processes import clocked_lines, comb_expression, targets_of
from ncdc_hdl.export.verilog.rtlil import Slice, Switch, part_of, width_of

__all__ = ["module_lines"]

_WIDTH = 100        # characters of a line

_REGISTERS, _MEMORY = ("$dff", "$adff"), ("$memrd_v2", "$memwr_v2")


def module_lines(module, children, port_lines):
    """The lines of a renamed ``module``, from its port list on.

    Order: ports; registers and memories; nets that instances drive; nets by assignment, each after
    those that it reads; memories' ports; registers' clocks; instances; outputs.

    Parameters
    ----------
    module : Module
    children : dict
        Renamed modules of the cells, by the kind of the cell.
    port_lines : callable
        Lines of the port list of (name, wire, "reg" or "wire", text of the initial value).
    """
    return _Printer(module, children).lines(port_lines)


class _Printer:
    """Sorts the parts of a module, then writes them."""

    def __init__(self, module, children):
        self.module, self.children = module, children
        self.registers = {}         # the $dff or $adff of each register
        self.operators = {}         # the cell that computes each net
        self.driven = set()         # nets driven by instances and by memories' asynchronous ports
        self.instances, self.reads = [], {}
        for cell in module.cells:
            self._sort(cell)
        self.sources = {}           # parts (low, source) of nets that connects drive
        for target, source in module.connects:
            self._connect(target, source)
        self.uses = self._count_uses()
        self.next_of, self.comb = self._sort_processes()
        fields = self._fields()
        # Names that the source has for slices of other wires.
        self.aliases = {name for name, parts in self.sources.items()
                        if len(parts) == 1 and len(joined(parts[0][1])) == 1}
        self.expressions = Expressions(module, self.operators, fields, self.uses)

    def _sort(self, cell):
        if cell.kind in _REGISTERS:
            part, = cell.connections["Q"]
            self.registers[part.wire] = cell
        elif cell.kind == "$memrd_v2":
            part, = cell.connections["DATA"]
            self.reads[part.wire] = cell
        elif cell.kind.startswith("$mem"):
            pass
        elif cell.kind.startswith("$"):
            part, = cell.connections["Y"]
            self.operators[part.wire] = cell
        else:
            self.instances.append(cell)
            for port, parts in cell.connections.items():
                if self._drives(cell, port):
                    self.driven |= {part.wire for part in parts if isinstance(part, Slice)}

    def _drives(self, cell, port):
        """Whether an instance drives the net at its ``port``."""
        child = self.children.get(cell.kind)
        return child is not None and child.wires[port].port != "input"

    def _connect(self, target, source):
        at = 0
        for part in target:
            self.sources.setdefault(part.wire, []).append(
                (part.low, part_of(source, at, part.width)))
            at += part.width

    def _count_uses(self):
        uses = {}

        def count(parts):
            for part in joined(parts):
                if isinstance(part, Slice):
                    uses[part.wire] = uses.get(part.wire, 0) + 1

        def statements(found):
            for item in found:
                if isinstance(item, Switch):
                    count(item.value)
                    for _, inner in item.cases:
                        statements(inner)
                else:
                    count(item[1])
        for cell in self.module.cells:
            for port, parts in cell.connections.items():
                if not (port in ("Y", "Q") or cell.kind == "$memrd_v2" and port == "DATA"
                        or self._drives(cell, port)):
                    count(parts)
        for process in self.module.processes:
            statements(process)
        for parts in self.sources.values():
            for _, source in parts:
                count(source)
        return uses

    def _sort_processes(self):
        """Processes that compute a register's next value, by register; others, by net.

        A net with a name in the source stays one, even if only a register reads it.
        """
        by_next = {}
        for name, cell in self.registers.items():
            parts = joined(cell.connections["D"])
            if len(parts) == 1 and isinstance(parts[0], Slice) and parts[0].low == 0 \
                    and parts[0].width == self.module.wires[parts[0].wire].width \
                    and self.module.wires[parts[0].wire].made \
                    and self.uses.get(parts[0].wire) == 1:
                by_next[parts[0].wire] = name
        clocked, comb = {}, {}
        for process in self.module.processes:
            for wire in targets_of(process):
                if wire in by_next:
                    clocked[by_next[wire]] = (wire, process)
                else:
                    comb[wire] = process
        return clocked, comb

    def _fields(self):
        """Names for slices of other wires: fields of a structure."""
        fields = {}
        for name, parts in self.sources.items():
            wire = self.module.wires[name]
            source = joined(parts[0][1])
            if len(parts) == 1 and len(source) == 1 and isinstance(source[0], Slice) \
                    and not wire.port and source[0].width == wire.width:
                key = (source[0].wire, source[0].low, source[0].width)
                if key not in fields or len(name) < len(fields[key]):
                    fields[key] = name
        return fields

    def lines(self, port_lines):
        """All lines of the module."""
        clocked = self._clocked()
        memories = memory_lines(self.module, self.expressions)
        instances = [line for cell in self.instances for line in self._instance(cell)]
        outputs = self._outputs()
        nets = self._nets()
        module = self.module
        ports = [(name, wire, "reg" if self._held(name) else "wire", self._initial(name))
                 for name, wire in module.wires.items() if wire.port]
        lines = [*port_lines(ports)]
        lines += [self._declaration("reg", name, self._initial(name))
                  for name, wire in module.wires.items()
                  if self._held(name) and not wire.port]
        lines += [f"  {_attributes(memory)}reg {_range(memory.width)}{name} [0:{memory.size - 1}];"
                  for name, memory in module.memories.items()]
        # Nets that instances and memories drive are declared before their uses.
        lines += [self._declaration("wire", name) for name in module.wires
                  if name in self.driven and not module.wires[name].port]
        body = [*nets, *memories, *clocked, *instances, *outputs]
        return [*lines, *(part for line in body for part in _folded(line)), "endmodule"]

    def _held(self, name):
        """Whether the name is a register in Verilog's sense."""
        return name in self.registers or name in self.reads and \
            self.reads[name].parameters["CLK_ENABLE"] == "1"

    def _initial(self, name):
        if name not in self.registers or self.module.wires[name].init is None:
            return ""
        return f" = {constant(self.module.wires[name].init)}"

    def _declaration(self, kind, name, value=""):
        wire = self.module.wires[name]
        return f"  {_attributes(wire)}{kind} {_range(wire.width)}{name}{value};"

    def _clocked(self):
        """The registers, in one block for each clock."""
        lines, clocks = [], {}
        for name, cell in self.registers.items():
            edge = "posedge" if cell.parameters["CLK_POLARITY"] == "1" else "negedge"
            clock = f"{edge} {self.expressions.signal(cell.connections['CLK'])}"
            if cell.kind == "$adff":
                lines += self._asynchronous(name, cell, clock)
            else:
                clocks.setdefault(clock, []).append(name)
        for clock, names in clocks.items():
            plain = [(name, self.registers[name].connections["D"]) for name in names
                     if name not in self.next_of]
            held = [(name, *self.next_of[name]) for name in names if name in self.next_of]
            lines += [f"  always @({clock}) begin",
                      *clocked_lines(self.module, self.expressions, plain, held), "  end"]
        return lines

    def _asynchronous(self, name, cell, clock):
        """A register with an asynchronous reset: the last stages of a synchroniser."""
        write, parameters = self.expressions, cell.parameters
        reset, high = write.signal(cell.connections["ARST"]), parameters["ARST_POLARITY"] == "1"
        width = self.module.wires[name].width
        value = write.whole(cell.connections["D"], width)
        at_reset = f"{width}'b{parameters['ARST_VALUE'].partition(chr(39))[2]}"
        return [f"  always @({clock} or {'posedge' if high else 'negedge'} {reset})",
                f"    if ({'' if high else '~'}{reset}) {name} <= {at_reset};",
                f"    else {name} <= {value};"]

    def _instance(self, cell):
        connections = []
        for port, parts in cell.connections.items():
            text = "" if not parts else ", ".join(
                slice_text(self.module, part) for part in parts) if self._drives(cell, port) else \
                self.expressions.condition(parts)
            connections.append(f".{port}({text})")
        parameters = [f".{name}({value})" for name, value in cell.parameters.items()]
        head = f"  {cell.kind} " + (f"#({', '.join(parameters)}) " if parameters else "")
        return _wrapped(f"{head}{cell.name} (", connections)

    def _outputs(self):
        """Assignments to outputs that are no registers."""
        return [f"  assign {name} = {self._value(name)};"
                for name, wire in self.module.wires.items()
                if wire.port == "output" and not self._held(name) and name not in self.driven]

    def _nets(self):
        """Nets that are read, or that the source names, each after those that it reads."""
        module, wanted, texts = self.module, set(self.expressions.read), {}
        wanted |= {name for name, wire in module.wires.items()
                   if not wire.made and not wire.port and name not in self.aliases}
        while missing := [name for name in sorted(wanted) if name not in texts
                          and not module.wires[name].port and not self._held(name)
                          and name not in self.driven]:
            for name in missing:
                before = self.expressions.read
                self.expressions.read = set()
                texts[name] = (self._value(name), self.expressions.read)
                wanted |= self.expressions.read
                self.expressions.read = before
        order = {name: k for k, name in enumerate(module.wires)}
        names, circular = _sorted({name: reads for name, (_, reads) in texts.items()}, order)
        return [*(self._declaration("wire", name) for name in names if name in circular),
                *(f"  assign {name} = {texts[name][0]};" if name in circular else
                  self._declaration("wire", name, f" = {texts[name][0]}") for name in names)]

    def _value(self, name):
        """The driver of a net, as an expression of its width.

        Raises
        ------
        ValueError
            If the net or a part of it has no driver.
        """
        wire, write = self.module.wires[name], self.expressions
        write.net = name
        if name in self.operators:
            return write.cell(self.operators[name])
        if name in self.comb:
            return comb_expression(self.module, write, name, self.comb[name])
        if name in self.reads:
            cell = self.reads[name]
            return f"{cell.parameters['MEMID']}[{write.condition(cell.connections['ADDR'])}]"
        parts = []
        for low, source in sorted(self.sources.get(name, []), key=lambda part: part[0]):
            if low != width_of(parts):
                raise ValueError(f"{self.module.name}: bit {width_of(parts)} of {name} has no "
                                 f"driver")
            parts += source
        if width_of(parts) != wire.width:
            raise ValueError(f"{self.module.name}: {name} has {wire.width} bits, "
                             f"{width_of(parts)} are driven")
        return write.whole(parts, wire.width)


def _sorted(reads, order):
    """Names sorted so that each is after those it reads, else in ``order``; and those for which
    this is impossible, as one bit of a net depends on another."""
    done, doing, found, circular = set(), set(), [], set()

    def visit(name):
        if name in doing:
            circular.add(name)
        elif name in reads and name not in done:
            doing.add(name)
            for other in sorted(reads[name], key=lambda name: order.get(name, 0)):
                visit(other)
            doing.discard(name)
            done.add(name)
            found.append(name)
    for name in sorted(reads, key=order.get):
        visit(name)
    return found, circular


def _range(width):
    return f"[{width - 1}:0] " if width > 1 else ""


def _attributes(item):
    return "".join(f"(* {name} = {value} *) " for name, value in item.attributes.items())


def _wrapped(head, items):
    """``head``, the ``items`` between commas, the statement's end; wrapped into lines."""
    lines, line = [head], ""
    for k, item in enumerate(items):
        item += "," if k < len(items) - 1 else ""
        if line and len(line) + 1 + len(item) > _WIDTH - 6:
            lines.append(f"    {line}")
            line = ""
        line += f" {item}" if line else item
    return [*lines, f"    {line});"] if line else [f"{head});"]


def _folded(line):
    """A long statement on several lines, cut at blanks."""
    lines, indent = [], " " * (len(line) - len(line.lstrip()) + 4)
    while len(line) > _WIDTH and (at := line.rfind(" ", len(indent) + 1, _WIDTH)) > 0:
        lines.append(line[:at])
        line = indent + line[at + 1:]
    return [*lines, line]

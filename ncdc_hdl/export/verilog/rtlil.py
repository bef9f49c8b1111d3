"""A netlist in RTLIL, Yosys's intermediate language, as Amaranth writes it, read into objects."""

import re
from dataclasses import dataclass, field

__all__ = ["Bits", "Cell", "Memory", "Module", "Slice", "Switch", "Wire", "bits_of", "parse",
           "part_of", "width_of"]

_TOKEN = re.compile(r'"(?:[^"\\]|\\.)*"|\S+')
_NUMBER = re.compile(r"(\d+)'([01xz-]*)$")


@dataclass(frozen=True)
class Slice:
    """Bits ``low`` to ``low + width - 1`` of a wire."""
    wire: str
    low: int
    width: int


@dataclass(frozen=True)
class Bits:
    """A constant, its highest bit first, of the digits 0, 1 and x."""
    text: str

    @property
    def width(self):
        """Number of its bits."""
        return len(self.text)


@dataclass
class Wire:
    """A wire or a register of a module.

    ``port``: "input", "output" or "" for none; ``init``: digits of the value after configuration,
    None for a wire without one; ``made``: by the converter, without a name in the source.
    """
    width: int
    port: str = ""
    init: str | None = None
    made: bool = False
    attributes: dict = field(default_factory=dict)


@dataclass
class Memory:
    """A memory of ``size`` words; ``init``: digits of the words, the last word first, or None."""
    width: int
    size: int
    init: str | None = None
    attributes: dict = field(default_factory=dict)


@dataclass
class Cell:
    """An operator, a register, a port of a memory (kinds that begin with $), or a module."""
    kind: str
    name: str
    parameters: dict = field(default_factory=dict)
    connections: dict = field(default_factory=dict)


@dataclass
class Switch:
    """A choice of a process: of the cases, (pattern or None as default, statements), the first
    whose pattern matches ``value``. A statement is a Switch or a pair (target, source)."""
    value: list
    cases: list


@dataclass
class Module:
    """One module.

    ``processes``: a list of statements for each; ``connects``: pairs (target, source). Targets and
    sources, and the connections of cells, are lists of :class:`Slice` and :class:`Bits`, the lowest
    first.
    """
    name: str
    wires: dict = field(default_factory=dict)
    memories: dict = field(default_factory=dict)
    cells: list = field(default_factory=list)
    processes: list = field(default_factory=list)
    connects: list = field(default_factory=list)


def width_of(signal):
    """Bits of a list of slices and constants."""
    return sum(part.width for part in signal)


def bits_of(signal):
    """Each bit of a list of slices and constants, the lowest first: (wire, number) or a digit."""
    found = []
    for part in signal:
        if isinstance(part, Bits):
            found += reversed(part.text)
        else:
            found += [(part.wire, k) for k in range(part.low, part.low + part.width)]
    return found


def part_of(signal, low, width):
    """Bits ``low`` to ``low + width - 1`` of a signal."""
    found, at = [], 0
    for part in signal:
        begin, end = max(low, at), min(low + width, at + part.width)
        if begin < end:
            found.append(Slice(part.wire, part.low + begin - at, end - begin)
                         if isinstance(part, Slice)
                         else Bits(part.text[::-1][begin - at:end - at][::-1]))
        at += part.width
    return found


def parse(text):
    """The modules of an RTLIL text, in its order.

    Raises
    ------
    ValueError
        If a line is not of the form that Amaranth writes.
    """
    return _Reader(text).modules


class _Reader:
    """Reads line by line."""

    def __init__(self, text):
        self.modules, self.attributes = [], {}
        self.lines = iter(text.splitlines())
        for tokens in self._lines():
            if tokens[0] == "attribute":
                self._attribute(tokens)
            elif tokens[0] == "module":
                self.attributes = {}
                self.module = Module(tokens[1].removeprefix("\\"))
                self.modules.append(self.module)
                self._module()
            else:
                raise ValueError(f"RTLIL has the line {' '.join(tokens)!r} outside of a module")

    def _lines(self):
        """The tokens of each line that has any."""
        for line in self.lines:
            if tokens := _TOKEN.findall(line):
                yield tokens

    def _attribute(self, tokens):
        self.attributes[tokens[1].removeprefix("\\")] = tokens[2]

    def _module(self):
        for tokens in self._lines():
            kind = tokens[0]
            if kind == "end":
                return
            if kind == "attribute":
                self._attribute(tokens)
                continue
            if kind not in ("wire", "memory", "cell", "process", "connect"):
                raise ValueError(f"RTLIL has the line {' '.join(tokens)!r} in a module")
            getattr(self, f"_{kind}")(tokens)
            self.attributes = {}

    def _attributes_used(self):
        """Attributes used after the converter, without source locations."""
        return {name: value for name, value in self.attributes.items()
                if name not in ("src", "init", "top", "generator")
                and not name.startswith(("enum_", "amaranth."))}

    def _wire(self, tokens):
        init = self.attributes.get("init")
        port = next((kind for kind in ("input", "output", "inout") if kind in tokens), "")
        self.module.wires[tokens[-1]] = Wire(
            int(tokens[tokens.index("width") + 1]), port,
            _NUMBER.match(init)[2] if init else None, attributes=self._attributes_used())

    def _memory(self, tokens):
        self.module.memories[tokens[-1]] = Memory(
            int(tokens[tokens.index("width") + 1]), int(tokens[tokens.index("size") + 1]),
            attributes=self._attributes_used())

    def _cell(self, tokens):
        cell = Cell(tokens[1], tokens[2])
        for tokens in self._lines():
            if tokens[0] == "end":
                break
            if tokens[0] == "parameter":
                # `parameter signed NAME VALUE` too.
                cell.parameters[tokens[-2].removeprefix("\\")] = tokens[-1]
            elif tokens[0] == "connect":
                cell.connections[tokens[1].removeprefix("\\")] = self._signal(tokens[2:])
        if cell.kind == "$meminit_v2":
            memory = self.module.memories["\\" + cell.parameters["MEMID"].strip('"').lstrip("\\")]
            memory.init = "".join(part.text for part in reversed(cell.connections["DATA"]))
        else:
            self.module.cells.append(cell)

    def _connect(self, tokens):
        # Two signals follow each other; a concatenation is in braces.
        self.module.connects.append(tuple(self._signals(tokens[1:])))

    def _process(self, tokens):
        self.module.processes.append(self._statements()[0])

    def _statements(self):
        """Statements up to the line that ends them, and that line."""
        found = []
        for tokens in self._lines():
            if tokens[0] == "assign":
                found.append(tuple(self._signals(tokens[1:])))
            elif tokens[0] == "switch":
                found.append(self._switch(self._signal(tokens[1:])))
            elif tokens[0] != "attribute":
                return found, tokens
        raise ValueError("RTLIL ends within a process")

    def _switch(self, value):
        cases = []
        tokens = next(self._lines())
        while tokens[0] == "attribute":
            tokens = next(self._lines())
        while tokens[0] == "case":
            patterns = [_NUMBER.match(token.rstrip(","))[2] for token in tokens[1:]] or [None]
            statements, tokens = self._statements()
            cases += [(pattern, statements) for pattern in patterns]
        return Switch(value, cases)

    def _signal(self, tokens):
        signal, = self._signals(tokens)
        return signal

    def _signals(self, tokens):
        """All signals in a list of tokens."""
        found, index = [], 0
        while index < len(tokens):
            if tokens[index] == "{}":
                found.append([])
                index += 1
            elif tokens[index] == "{":
                end = tokens.index("}", index)
                parts = [part for signal in self._signals(tokens[index + 1:end])
                         for part in reversed(signal)]
                found.append(parts[::-1])
                index = end + 1
            else:
                part, index = self._part(tokens, index)
                found.append([part] if part.width else [])
        return found

    def _part(self, tokens, index):
        if match := _NUMBER.match(tokens[index]):
            return Bits(match[2]), index + 1
        name = tokens[index]
        if index + 1 < len(tokens) and tokens[index + 1].startswith("["):
            high, _, low = tokens[index + 1].strip("[]").partition(":")
            low = int(low or high)
            return Slice(name, low, int(high) - low + 1), index + 2
        return Slice(name, 0, self.module.wires[name].width), index + 1

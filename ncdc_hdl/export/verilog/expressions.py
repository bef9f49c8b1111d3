"""Signals and operators of a netlist as Verilog expressions."""

from itertools import groupby

from ncdc_hdl.export.verilog.rtlil import Bits, Slice, width_of

__all__ = ["Expressions", "constant", "joined"]

_BINARY = {"$and": "&", "$or": "|", "$xor": "^", "$add": "+", "$sub": "-", "$mul": "*",
           "$eq": "==", "$ne": "!=", "$lt": "<", "$le": "<=", "$gt": ">", "$ge": ">="}
_SHIFT = {"$shl": "<<", "$shr": ">>", "$shift": ">>", "$sshr": ">>>", "$sshl": "<<"}
_UNARY = {"$not": "~", "$neg": "-", "$pos": "", "$reduce_or": "|", "$reduce_and": "&",
          "$reduce_xor": "^", "$reduce_bool": "|", "$logic_not": "!"}
_COMPARED = ("$eq", "$ne", "$lt", "$le", "$gt", "$ge")
_BITWISE = ("$and", "$or", "$xor", "$not")
_LONGEST = 84           # most characters of an expression that is inlined in another one


def constant(digits):
    """A constant of these digits, the highest first, in Verilog."""
    if set(digits) <= {"0", "1"}:
        if len(digits) == 1:
            return f"1'b{digits}"
        return f"{len(digits)}'h{int(digits, 2):0{-(-len(digits) // 4)}x}"
    return f"{len(digits)}'b{digits}"


def joined(parts):
    """``parts`` of a signal with adjacent slices merged."""
    found = []
    for part in parts:
        last = found[-1] if found else None
        if isinstance(part, Slice) and isinstance(last, Slice) and part.wire == last.wire \
                and part.low == last.low + last.width:
            found[-1] = Slice(part.wire, last.low, last.width + part.width)
        elif isinstance(part, Bits) and isinstance(last, Bits):
            found[-1] = Bits(part.text + last.text)
        else:
            found.append(part)
    return found


class Expressions:
    """Writes the drivers of a module's wires.

    An operator whose result has no name in the source and is read once is inlined in the
    expression that reads it, if Verilog's rules on widths preserve its bits. Such uses are all of
    the right side of an assignment of its own width. If it cannot be wider than its result, also
    a condition, a concatenation, and bitwise operators of its width.

    Parameters
    ----------
    module : Module
        Renamed.
    drivers : dict
        The cell that drives each wire, by the wire's name, of operators only.
    fields : dict
        Names of slices of wires: {(wire, low, width): name}.

    Attributes
    ----------
    read : set of str
        Names of the wires that the expressions written so far read.
    net : str
        The net whose driver is being written.
    """

    def __init__(self, module, drivers, fields, uses):
        self.module, self.drivers, self.fields, self.uses = module, drivers, fields, uses
        self.read = set()
        self.net = None         # the net being written: not to be named as a field of itself

    def signal(self, parts, exact=True):
        """A signal as an operand; ``exact``: in a context that does not widen it."""
        parts = joined(parts)
        if not parts:
            return "1'b0"           # an operand of no bits is zero
        texts = [self._part(part, exact or len(parts) > 1) for part in reversed(parts)]
        return texts[0] if len(texts) == 1 else "{" + ", ".join(_repeated(
            text[1:-1] if text.startswith("(") and _enclosed(text) else text
            for text in texts)) + "}"

    def whole(self, parts, width):
        """A signal as the whole right side of an assignment to ``width`` bits."""
        parts = joined(parts)
        if len(parts) == 1 and (cell := self._alone(parts[0])) and width == parts[0].width:
            text, before = self.cell(cell), set(self.read)
            if len(text) <= _LONGEST:
                return text
            self.read = before
        text = self.signal(parts)
        return text[1:-1] if text.startswith("(") and _enclosed(text) else text

    def condition(self, parts):
        """A signal of one bit as a condition."""
        text = self.signal(parts)
        return text[1:-1] if text.startswith("(") and _enclosed(text) else text

    def _part(self, part, exact):
        if isinstance(part, Bits):
            return constant(part.text)
        if exact and (cell := self._alone(part)) and self._cannot_widen(cell):
            before = set(self.read)
            text = self.cell(cell)
            if len(text) <= _LONGEST:
                return f"({text})" if " " in text else text
            self.read = before
        name = self.fields.get((part.wire, part.low, part.width))
        name = None if name == self.net else name
        self.read.add(name or part.wire)
        return name or slice_text(self.module, part)

    def _alone(self, part):
        """The operator that drives all of ``part`` and is read nowhere else, or None."""
        if not isinstance(part, Slice) or part.low or self.uses.get(part.wire, 0) != 1:
            return None
        wire = self.module.wires[part.wire]
        if not wire.made or wire.port or wire.width != part.width:
            return None
        return self.drivers.get(part.wire)

    def _cannot_widen(self, cell):
        """Whether operator and operands have the width of the result."""
        width = width_of(cell.connections["Y"])
        if cell.kind in _COMPARED or cell.kind.startswith("$reduce"):
            return width == 1
        if cell.kind in _BITWISE:
            return all(width_of(cell.connections[port]) == width for port in "AB"
                       if port in cell.connections)
        return cell.kind == "$mux"

    def cell(self, cell):
        """The operator of a cell.

        Raises
        ------
        ValueError
            If there is no expression for it.
        """
        kind, inputs = cell.kind, cell.connections
        signs = {port: cell.parameters.get(f"{port}_SIGNED", "0") == "1" for port in "AB"}
        exact = self._cannot_widen(cell) and kind not in _COMPARED
        if kind == "$mux":
            return (f"{self.signal(inputs['S'])} ? {self.signal(inputs['B'])} : "
                    f"{self.signal(inputs['A'])}")
        if kind in _UNARY:
            text = self.signal(inputs["A"], exact or kind.startswith("$reduce"))
            return _UNARY[kind] + (f"$signed({text})" if signs["A"] else text)
        if kind in _BINARY:
            # Verilog's operators are signed only if both of their operands are.
            a, b = (f"$signed({text})" if signs["A"] and signs["B"] else text
                    for text in (self.signal(inputs[port], exact) for port in "AB"))
            return f"{a} {_BINARY[kind]} {b}"
        if kind in _SHIFT and not signs["B"]:
            a = self.signal(inputs["A"], exact=False)
            a = f"$signed({a})" if signs["A"] else a
            return f"{a} {_SHIFT[kind]} {self.signal(inputs['B'])}"
        raise ValueError(f"a cell {kind} has no Verilog expression")


def slice_text(module, part):
    """A slice in Verilog, on either side of an assignment."""
    width = module.wires[part.wire].width
    if part.width == width:
        return part.wire
    high = part.low + part.width - 1
    return f"{part.wire}[{high}]" if part.width == 1 else f"{part.wire}[{high}:{part.low}]"


def _repeated(texts):
    """``texts`` with three or more equal ones in a row as one replication."""
    for text, same in groupby(texts):
        count = len(list(same))
        yield from [f"{{{count}{{{text}}}}}"] if count > 2 else [text] * count


def _enclosed(text):
    """Whether the first parenthesis of ``text`` closes at its end."""
    depth = 0
    for k, letter in enumerate(text):
        depth += (letter == "(") - (letter == ")")
        if depth == 0:
            return k == len(text) - 1
    return False

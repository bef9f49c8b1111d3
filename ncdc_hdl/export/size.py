"""Size of a design before any technology mapping."""

import re
from collections import Counter

from amaranth.back import rtlil

__all__ = ["design_size"]

_MODULE = re.compile(r"^module \\(\S+)$")
_CELL = re.compile(r"^  cell (\S+) ")
_WIDTH = re.compile(r"^    parameter \\WIDTH (\d+)$")
_MEMORY = re.compile(r"^  memory width (\d+) size (\d+) ")


def design_size(component):
    """Registers, multipliers and memory of an Amaranth ``component``.

    Returns
    -------
    dict
        ``flip_flops`` (bits), ``multipliers`` (of any width), ``memory_bits``. A synthesizer may
        need fewer: it shares logic and drops unused parts.
    """
    own, children, module, cell = {}, {}, None, None
    for line in rtlil.convert(component, name="top", emit_src=False).splitlines():
        if match := _MODULE.match(line):
            module = match[1]
            own[module], children[module] = Counter(), []
        elif match := _CELL.match(line):
            cell = match[1]
            if cell.startswith("\\"):
                children[module].append(cell[1:])
            own[module]["multipliers"] += cell == "$mul"
        elif (match := _WIDTH.match(line)) and cell in ("$dff", "$adff", "$dffe", "$sdff"):
            own[module]["flip_flops"] += int(match[1])
        elif match := _MEMORY.match(line):
            own[module]["memory_bits"] += int(match[1]) * int(match[2])

    def total(name):
        return sum((total(child) for child in children[name] if child in own), start=+own[name])

    counts = total("top")
    return {name: counts[name] for name in ("flip_flops", "multipliers", "memory_bits")}

"""Port list of a generated module, read back from its Verilog text."""

import re
from dataclasses import dataclass

__all__ = ["Port", "ports_of_text"]

_PORT = re.compile(r"^  (input|output) +(?:wire|reg) +(\[\d+:0\])? *(\w+)[^,/]*,? *// (.*)$")


@dataclass(frozen=True)
class Port:
    """Direction ``input`` or ``output``, range as text, name, comment; ``title`` of the interface
    that begins with it, if there is one."""
    direction: str
    range: str
    name: str
    about: str
    title: str

    @property
    def width(self):
        """Width in bits."""
        return int(self.range[1:].partition(":")[0]) + 1 if self.range else 1


def ports_of_text(verilog, module):
    """:class:`Port` of each port of ``module``, in order.

    Raises
    ------
    ValueError
        If the text has no such module.
    """
    lines, title, found = iter(verilog.splitlines()), "", []
    if f"module {module} (" not in lines:       # the search continues after it
        raise ValueError(f"there is no module {module}")
    for line in lines:
        if line.startswith(");"):
            break
        if line.startswith("  // "):
            title = line[5:]
        elif match := _PORT.match(line):
            direction, size, name, about = match.groups()
            found.append(Port(direction, size or "", name, about, title))
            title = ""
    return found

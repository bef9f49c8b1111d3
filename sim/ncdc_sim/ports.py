"""The ports of a module of generated Verilog."""

import re

from ncdc_spec.errors import InputError

__all__ = ["ports_of"]

_DECLARATION = re.compile(r"^\s*(?:input|output)\s+(?:reg\s+|wire\s+)?(?:signed\s+)?"
                          r"(?:\[(\d+):0\]\s*)?(\w+)\s*(?:=[^,;)]*)?(?:[;,]|//|\)|$)",
                          re.MULTILINE)


def ports_of(verilog, module):
    """Widths in bits of the ports of ``module``, by name.

    Understands one declaration per line, in the module's header or after it.

    Raises
    ------
    InputError
        If the text has no such module.
    """
    match = re.search(rf"^module\s+{re.escape(module)}\s*\(.*?^endmodule", verilog,
                      re.MULTILINE | re.DOTALL)
    if not match:
        raise InputError(f"the Verilog has no module {module}")
    return {name: int(high or 0) + 1 for high, name in _DECLARATION.findall(match[0])}

"""The registers as SystemRDL 2.0."""

from ncdc_spec.registers.register_map import ADDRESS_WORDS_BITS, TABLE
from ncdc_spec.view_rows import ROWS_TABLE

__all__ = ["system_rdl"]

_ACCESS = {"ro": "sw = r; hw = w;", "rw": "sw = rw; hw = r;", "shadow": "sw = rw; hw = r;",
           "w1": "sw = w; hw = r; singlepulse;", "w1c": "sw = rw; onwrite = woclr; hw = r; hwset;"}


def system_rdl(agent):
    """Text of the address map ``ncdc`` of ``agent``, a
    :class:`ncdc_hdl.registers.agent.Registers`.

    Offsets are in bytes. Reset values are those after configuration. A signed register is a field
    of its width; on reading its sign extends to 32 bits.
    """
    values = {**agent.values, **agent.constants}
    lines = ["addrmap ncdc {", '    name = "NCDC corrector";', "    lsb0;",
             "    addressing = regalign;", "    default regwidth = 32;",
             "    default accesswidth = 32;", ""]
    for register in (row for row in agent.table if row.name not in agent.constant):
        lines += ["    reg {", f"        desc = {_quoted(_text(register))};"]
        for flag in register.flags:
            lines.append(f"        field {{ {_ACCESS[flag.access]} desc = {_quoted(flag.text)}; }} "
                         f"{flag.name}[{flag.bit}:{flag.low}] = "
                         f"{(values.get(register.name, 0) & flag.mask) >> flag.low};")
        if not register.flags:
            width = register.shape.width
            value = values.get(register.name, 0) & (1 << width) - 1
            lines.append(f"        field {{ {_field_access(register, agent.constants)} }} "
                         f"VALUE[{width - 1}:0] = {width}'h{value:x};")
        lines.append(f"    }} {register.name} @ 0x{4 * register.address:04X};")
    if not agent.fixed:
        lines += ["    external mem {",
                  '        desc = "Valid rows: start | stop << 16 of two spans.";',
                  f"        mementries = {(1 << ADDRESS_WORDS_BITS) - TABLE};",
                  "        memwidth = 32;",
                  "        sw = rw;", f"    }} VALID_ROWS @ 0x{4 * TABLE:04X};"]
    if agent.view_rows:
        lines += ["    external mem {",
                  '        desc = "View: matrices down the raw frame.";',
                  "        mementries = 2048;", "        memwidth = 32;", "        sw = w;",
                  f"    }} VIEW_MATRICES @ 0x{4 * ROWS_TABLE:04X};"]
    lines += ["};", ""]
    return "\n".join(lines)


def _field_access(register, constants):
    return "sw = r; hw = na;" if register.name in constants else _ACCESS[register.access]


def _text(register):
    kind = {"shadow": "Active after a commit. "}.get(register.access, "")
    signed = " Two's complement." if getattr(register.shape, "signed", False) else ""
    return f"{kind}{register.text}{signed}".strip() or register.name


def _quoted(text):
    return '"' + text.replace("\\", "\\\\").replace('"', '\\"') + '"'

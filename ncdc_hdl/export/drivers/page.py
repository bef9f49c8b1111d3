"""The registers as a page of the documentation: ``python -m ncdc_hdl.export.drivers.page``."""

from importlib.resources import files

from ncdc_spec.camera_port import KINDS
from ncdc_spec.descriptor import Formats
from ncdc_spec.frames import SOURCE_BEYOND
from ncdc_spec.geometry import MAX_SIZE
from ncdc_spec.hardware import Hardware
from ncdc_spec.registers.register_map import ADDRESS_WORDS_BITS, NODES, SKIP, TABLE, registers
from ncdc_spec.registers.system_map import system_registers
from ncdc_spec.registers.system_values import stores_for
from ncdc_spec.view_list import MAX_VIEWS
from ncdc_spec.view_rows import MAX_MATRICES, ROWS_TABLE

__all__ = ["register_doc"]

def register_doc(hidden_neurons, formats):
    """Markdown page of the registers of an instance; the neurons' registers have one row each.

    Raises
    ------
    ValueError
        If the registers of one kind are not at equal distances.
    """
    lines = _rows(registers(hidden_neurons, formats, colour=True, raw_balance=True, view=True,
                            views=MAX_VIEWS, view_rows=MAX_MATRICES))
    lines.append(f"| 0x{4 * ROWS_TABLE:04X} + 4096 b + 64 k + 16 r + 4 c | `VIEW_MATRICES` | wo | "
                 "32 | Rolling shutter: row r, column c of matrix k in bank b, see below. |\n")
    lines.append(f"| 0x{4 * TABLE:04X} + 8 r | `VALID_ROWS` | rw | 2 x 32 | "
                 "Spans of pixels with a source in row r, see below. |\n")
    bits = MAX_SIZE.bit_length() - 1
    page = (files("ncdc_hdl.export.drivers") / "page.md").read_text()
    return page.format(words=1 << ADDRESS_WORDS_BITS, neurons=hidden_neurons, beyond=SOURCE_BEYOND,
                       last=hidden_neurons - 1, skip=4 * SKIP, nodes=4 * NODES,
                       rows="".join(lines), bits=bits, high=16 + bits,
                       system_rows="".join(_rows(
                           system_registers(stores_for(Hardware(), 2), MAX_SIZE, KINDS, phy=True))))


def _rows(table):
    """Lines of the registers of ``table``, one for each family."""
    rows = {}
    for register in table:
        rows.setdefault(register.family, []).append(register)
    return [_row(_offset(name, same), name, same[0].access, same[0].shape, _text(same[0], text))
            for (name, text), same in rows.items()]


def _offset(name, same):
    first = 4 * same[0].address
    steps = {4 * (b.address - a.address) for a, b in zip(same, same[1:])}
    if len(steps) > 1:
        raise ValueError(f"the registers {name} are at unequal distances {sorted(steps)}")
    return f"0x{first:04X} + {steps.pop()} j" if steps else f"0x{first:04X}"


def _text(register, text):
    flags = (f"{flag.position.capitalize()} `{flag.name}` ({flag.access}): {flag.text}."
             for flag in register.flags)
    return " ".join(part for part in (*flags, text) if part)


def _row(offset, name, access, shape, text):
    bits = f"{shape.width}, signed" if shape.signed else f"{shape.width}"
    return f"| {offset} | `{name}` | {access} | {bits} | {text} |\n"


if __name__ == "__main__":
    print(register_doc(8, Formats()), end="")

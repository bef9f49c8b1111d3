"""The registers as a C header."""

from ncdc_hdl.avalon.register_table import ID, TABLE, host_values, registers, table_words

__all__ = ["c_header"]


def c_header(descriptor, data_width=32):
    """Text of a C header: byte offset of each register, and the descriptor's values.

    ``NCDC_<NAME>`` are byte offsets from the agent's base; ``ncdc_values`` and
    ``ncdc_valid_rows`` hold the {offset, value} pairs that set the corrector up for the
    camera of ``descriptor``. Frame addresses are those of a raw frame at address 0: a host sets
    SOURCE_BASE and TARGET_BASE to its own.
    """
    rows = registers(descriptor.hidden_neurons, descriptor.formats)
    offset = {r.name: 4 * r.address for r in rows}
    lines = [f"/* NCDC registers; values of descriptor {descriptor.digest}.",
             " * SOURCE_BASE and TARGET_BASE among them are an example: set your own. */",
             "#ifndef NCDC_REGISTERS_H", "#define NCDC_REGISTERS_H", "", "#include <stdint.h>", ""]
    lines += [f"#define NCDC_{r.name} 0x{offset[r.name]:04X}u /* {r.access}: {r.text} */"
              for r in rows]
    lines += [f"#define NCDC_ID_VALUE 0x{ID:X}u"]
    lines += [f"#define NCDC_{r.name}_{flag.name} 0x{flag.mask:X}u /* {flag.access}: {flag.text} */"
              for r in rows for flag in r.flags]
    lines += [f"#define NCDC_VALID_ROWS 0x{4 * TABLE:04X}u "
              "/* rw: 8 bytes per row, two spans of start | stop << 16 */", "",
              "struct ncdc_value { uint32_t offset, value; };", ""]
    for name, pairs in (
            ("ncdc_values", [(offset[n], v) for n, v in host_values(descriptor, data_width).items()]),
            ("ncdc_valid_rows", [(4 * a, v) for a, v in table_words(descriptor.valid)])):
        lines += [f"static const struct ncdc_value {name}[{len(pairs)}] = {{"]
        lines += [f"    {{0x{o:04X}u, 0x{v & 0xFFFFFFFF:08X}u}}," for o, v in pairs]
        lines += ["};", ""]
    return "\n".join([*lines, "#endif", ""])

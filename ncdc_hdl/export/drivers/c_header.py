"""The registers and lenses in C."""

import re

from ncdc_model.golden.tone import tone_named
from ncdc_spec.frames import SOURCE_BEYOND
from ncdc_spec.registers.register_map import ID, TABLE, VERSION, counters
from ncdc_spec.tone import COMMON_TONES
from ncdc_spec.view_rows import ROWS_COUNT, ROWS_TABLE

__all__ = ["c_header", "c_lenses", "c_lenses_header"]


def c_header(table):
    """Text of the C header of the registers in ``table``.

    ``NCDC_<NAME>`` are byte offsets from the agent's base, ``NCDC_<REGISTER>_<FLAG>`` masks;
    ``NCDC_EACH_COUNTER(X)`` is ``X(member, offset)`` of every counter. Macros only, so that any
    number of C files may include it.
    """
    lines = ["/* Registers of the NCDC corrector, byte offsets from its base. */",
             "#ifndef NCDC_REGISTERS_H", "#define NCDC_REGISTERS_H", ""]
    lines += [f"#define NCDC_{r.name} 0x{4 * r.address:04X}u /* {r.access}: {_comment(r.text)} */"
              for r in table]
    lines += [f"#define NCDC_VALID_ROWS 0x{4 * TABLE:04X}u "
              "/* rw: 8 bytes per row, two spans of start | stop << 16 */"]
    if any(r.name == ROWS_COUNT for r in table):
        lines += [f"#define NCDC_VIEW_MATRICES 0x{4 * ROWS_TABLE:04X}u "
                  "/* wo: + 4096 bank + 64 k + 16 row + 4 column */"]
    lines += ["", f"#define NCDC_ID_VALUE 0x{ID:X}u", f"#define NCDC_VERSION {VERSION}u",
              f"#define NCDC_SOURCE_BEYOND {SOURCE_BEYOND}u "
              "/* most bytes after a raw frame's last row that may be read; rows are not */"]
    lines += [f"#define NCDC_{r.name}_{flag.name} 0x{flag.mask:X}u /* {flag.access}: {flag.text} */"
              for r in table for flag in r.flags]
    each = [f"X({r.name.lower()}, NCDC_{r.name})" for r in counters(table)]
    lines += ["", "#define NCDC_EACH_COUNTER(X) \\", " \\\n".join(f"    {x}" for x in each)]
    if any(r.name == "TONE0" for r in table):
        lines += ["", "/* Nodes of tone curves, initialisers from NCDC_TONE0 on. */"]
        lines += [f"#define NCDC_TONE_{_macro(name)} "
                  f"{{{', '.join(map(str, tone_named(name)))}}}" for name in COMMON_TONES]
    return "\n".join([*lines, "", "#endif", ""])


def c_lenses_header(lenses):
    """Text of the header that declares ``lenses``, a dict of :class:`Lens` by name."""
    lines = ["/* Lenses that the corrector can be given, see ncdc_load(). */",
             "#ifndef NCDC_LENSES_H", "#define NCDC_LENSES_H", "", '#include "ncdc.h"', ""]
    lines += ["#ifdef __cplusplus", 'extern "C" {', "#endif", ""]
    lines += [f"extern const struct ncdc_lens ncdc_lens_{name};" for name in lenses]
    return "\n".join([*lines, "", "#ifdef __cplusplus", "}", "#endif", "", "#endif", ""])


def c_lenses(lenses):
    """Text of the C file that defines ``lenses``, a dict of :class:`Lens` by name."""
    lines = ['#include "ncdc_lenses.h"', ""]
    for name, lens in lenses.items():
        lines += [f"static const struct ncdc_value values_{name}[] = {{"]
        lines += [f"    {{NCDC_{register}, 0x{value & 0xFFFFFFFF:08X}u}},"
                  for register, value in lens.values.items()]
        lines += ["};", "", f"static const uint32_t valid_rows_{name}[] = {{"]
        lines += [f"    {', '.join(f'0x{span:08X}u' for span in lens.valid_rows[k:k + 6])},"
                  for k in range(0, len(lens.valid_rows), 6)]
        lines += ["};", "", f"const struct ncdc_lens ncdc_lens_{name} = {{",
                  f'    "{lens.digest}", {{{", ".join(map(str, lens.kind))}}},',
                  f"    {lens.neurons}, "
                  f"NCDC_CAPABILITIES_{lens.interpolation.upper()},",
                  f"    {lens.width}, {lens.height}, {lens.source_bytes}, {lens.target_bytes},",
                  f"    values_{name}, {len(lens.values)},",
                  f"    valid_rows_{name}, {len(lens.valid_rows)}", "};", ""]
    return "\n".join(lines)


def _macro(name):
    return re.sub(r"\W", "_", name).upper()


def _comment(text):
    return text or "see its bits"

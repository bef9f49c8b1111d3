"""The registers and lenses as modules for the Python driver."""

from ncdc_model.golden.tone import tone_named
from ncdc_spec.frames import SOURCE_BEYOND
from ncdc_spec.registers.register_map import ID, INTERPOLATION_BITS, TABLE, VERSION, counters
from ncdc_spec.tone import COMMON_TONES
from ncdc_spec.view_rows import ROWS_COUNT, ROWS_TABLE, STEPS

__all__ = ["python_lenses", "python_registers"]


def python_registers(table):
    """Text of the module of the registers in ``table``."""
    lines = ['"""Registers of the NCDC corrector: byte offsets from its base, masks of flags."""',
             "", "OFFSET = {"]
    lines += [f'    "{r.name}": 0x{4 * r.address:04X},' for r in table]
    lines += ["}", f"VALID_ROWS = 0x{4 * TABLE:04X}"]
    if any(r.name == ROWS_COUNT for r in table):
        lines += ["", "# Table of a view's matrices, for ncdc_driver.Corrector.view_rows.",
                  f"VIEW_MATRICES = 0x{4 * ROWS_TABLE:04X}", f"VIEW_ROW_STEPS = {STEPS}", ""]
    lines += [f"COUNTERS = {tuple(r.name for r in counters(table))!r}", "", f"ID_VALUE = 0x{ID:X}",
              f"VERSION = {VERSION}", f"SOURCE_BEYOND = {SOURCE_BEYOND}"]
    lines += [f"{r.name}_{flag.name} = 0x{flag.mask:X}" for r in table for flag in r.flags]
    lines += ["", "# Flags of CAPABILITIES.", "INTERPOLATIONS = {",
              *(f'    "{name}": 0x{mask:X},' for name, mask in INTERPOLATION_BITS.items()), "}"]
    if any(r.name == "TONE0" for r in table):
        lines += ["", "# Nodes of tone curves, for ncdc_driver.Corrector.tone.",
                  "TONES = {"]
        lines += [*(f'    "{name}": {tone_named(name)},' for name in COMMON_TONES), "}"]
    return "\n".join([*lines, ""])


def python_lenses(lenses):
    """Text of the module of ``lenses``, a dict of :class:`Lens` by name."""
    lines = ['"""Lenses that the NCDC corrector can be given, see ncdc_driver.Corrector.load."""',
             "", "LENSES = {"]
    for name, lens in lenses.items():
        lines += [f'    "{name}": {{', f'        "digest": "{lens.digest}",',
                  f'        "neurons": {lens.neurons}, "width": {lens.width}, '
                  f'"height": {lens.height},',
                  f'        "interpolation": "{lens.interpolation}",',
                  f'        "source_bytes": {lens.source_bytes}, '
                  f'"target_bytes": {lens.target_bytes},', '        "values": {']
        lines += [f'            "{register}": {value},' for register, value in lens.values.items()]
        lines += ["        },", '        "valid_rows": (']
        lines += [f"            {', '.join(f'0x{span:08X}' for span in lens.valid_rows[k:k + 6])},"
                  for k in range(0, len(lens.valid_rows), 6)]
        lines += ["        ),", "    },"]
    return "\n".join([*lines, "}", ""])

"""The registers and lenses for System Console."""

from ncdc_spec.frames import output_format
from ncdc_spec.registers.register_map import ID, INTERPOLATION_BITS, TABLE, VERSION, counters

__all__ = ["tcl_data"]


def tcl_data(table, lenses, form):
    """Text of ``ncdc_console_data.tcl``, which ``ncdc_console.tcl`` reads.

    Parameters
    ----------
    table : sequence of Register
    lenses : dict
        :class:`~ncdc_hdl.export.drivers.lenses.Lens` by name.
    form : str
        Output format of the corrector.
    """
    lines = ["# Registers (byte offsets), masks of their flags, lenses: for ncdc_console.tcl.",
             f"variable id 0x{ID:08x}", f"variable version {VERSION}",
             f"variable valid_rows 0x{4 * TABLE:04x}",
             f"variable counted {{{' '.join(r.name for r in counters(table))}}}",
             "variable offsets {"]
    lines += [f"    {r.name} 0x{4 * r.address:04x}" for r in table]
    lines += ["}", "variable flags {"]
    lines += [f"    {r.name}_{flag.name} 0x{flag.mask:x}" for r in table for flag in r.flags]
    lines += ["}", "variable lenses {"]
    for name, lens in lenses.items():
        lines += [f"    {name} {{", f"        digest {lens.digest}",
                  f"        neurons {lens.neurons} width {lens.width} "
                  f"height {lens.height} "
                  f"interpolation 0x{INTERPOLATION_BITS[lens.interpolation]:x}",
                  f"        raw_width {lens.values['DISTORTED_WIDTH']} "
                  f"raw_height {lens.values['DISTORTED_HEIGHT']} "
                  f"pixel_bytes {output_format(form).pixel_bytes}",
                  f"        source_bytes {lens.source_bytes} target_bytes {lens.target_bytes}",
                  "        values {"]
        lines += [f"            {register} {value}" for register, value in lens.values.items()]
        lines += ["        }", "        valid_rows {"]
        lines += [f"            {' '.join(f'0x{span:08x}' for span in lens.valid_rows[k:k + 8])}"
                  for k in range(0, len(lens.valid_rows), 8)]
        lines += ["        }", "    }"]
    return "\n".join([*lines, "}", ""])

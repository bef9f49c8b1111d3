"""Lint rules that the generated Verilog does not keep, and why that is harmless."""

__all__ = ["DEFAULT_WARNINGS", "SLANG", "VERILATOR", "verilator_config"]

# Amaranth's expressions have the width that holds their result; they are printed as Verilog
# expressions whose width the context extends or cuts: the same bits, without a cast.
_WIDTHS = "the width of an expression is made fit where it is assigned, as Amaranth means it"

VERILATOR = {
    "WIDTHEXPAND": _WIDTHS,
    "WIDTHTRUNC": _WIDTHS,
    "CASEINCOMPLETE": "a signal keeps the default assigned before in the other cases",
    "PROCASSINIT": "a register's value after configuration is where it is declared; FPGAs load it",
    "UNUSEDSIGNAL": "a record stays whole where a module uses some of its bits",
    "DECLFILENAME": "all modules are in one file",
}
# Those that Verilator gives without -Wall too.
DEFAULT_WARNINGS = "WIDTHEXPAND", "WIDTHTRUNC", "CASEINCOMPLETE"
SLANG = {
    "width-trunc": _WIDTHS,
    "sign-conversion": _WIDTHS,
}


def verilator_config():
    """Text of ``ncdc.vlt``: the waivers as a configuration file of Verilator."""
    lines = ["`verilator_config", "// Waivers for verilator -Wall on ncdc.v."]
    for rule, reason in VERILATOR.items():
        lines += [f"// {reason}", f'lint_off -rule {rule} -file "*ncdc.v"']
    return "\n".join(lines) + "\n"

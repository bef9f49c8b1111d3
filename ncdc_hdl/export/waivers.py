"""Lint rules that the generated Verilog does not keep, and why that is harmless."""

__all__ = ["DEFAULT_WARNINGS", "SLANG", "VERILATOR", "verilator_config"]

# Amaranth's expressions have the width that holds their result, and Yosys writes them as Verilog
# expressions whose width the context extends or cuts: the same bits, without a cast.
_WIDTHS = "the width of an expression is made fit where it is assigned, as Amaranth means it"
_CASES = "a register keeps its value, or a signal its default assigned before, in the other cases"

VERILATOR = {
    "WIDTHEXPAND": _WIDTHS,
    "WIDTHTRUNC": _WIDTHS,
    "CASEINCOMPLETE": _CASES,
    "PROCASSINIT": "a register's value after configuration is where it is declared; FPGAs load it",
    "UNUSEDSIGNAL": "every internal name of the source is kept, for waveforms",
    "DECLFILENAME": "all modules are in one file",
}
# Those that Verilator gives without -Wall too.
DEFAULT_WARNINGS = "WIDTHEXPAND", "WIDTHTRUNC", "CASEINCOMPLETE"
SLANG = {
    "width-trunc": _WIDTHS,
    "sign-conversion": _WIDTHS,
    "case-incomplete": _CASES,
}


def verilator_config():
    """Text of ``ncdc.vlt``: the waivers as a configuration file of Verilator."""
    lines = ["`verilator_config", "// Waivers for verilator -Wall on ncdc.v."]
    for rule, reason in VERILATOR.items():
        lines += [f"// {reason}", f'lint_off -rule {rule} -file "*ncdc.v"']
    return "\n".join(lines) + "\n"

"""Lint rules that the generated Verilog violates, and the reasons why that is harmless."""

__all__ = ["DEFAULT_WARNINGS", "SLANG", "SYSTEM_WAIVERS", "VERILATOR", "verilator_config"]

# Amaranth's expressions have the width that holds their result. They are printed as Verilog
# expressions whose width the context extends or cuts: the same bits, without a cast.
_WIDTHS = "an assignment adapts the width of an expression, as Amaranth intends"

VERILATOR = {
    "WIDTHEXPAND": _WIDTHS,
    "WIDTHTRUNC": _WIDTHS,
    "CASEINCOMPLETE": "a signal keeps the default assigned before in the other cases",
    "PROCASSINIT": "a register's value after configuration is where it is declared; FPGAs load it",
    "UNUSEDSIGNAL": "a record stays whole where a module uses some of its bits",
    "DECLFILENAME": "all modules are in one file",
}
# Rules that Verilator also reports without -Wall.
DEFAULT_WARNINGS = "WIDTHEXPAND", "WIDTHTRUNC", "CASEINCOMPLETE"
SLANG = {
    "width-trunc": _WIDTHS,
    "sign-conversion": _WIDTHS,
}


SYSTEM_WAIVERS = {
    "SYNCASYNCNET": "the reset is synchronous, and asynchronous for the sensor's clock"}
"""Further rules for ``ncdc_system.v``."""


def verilator_config(top="ncdc", more=None):
    """The waivers of the Verilog of a top module, and ``more``, as a configuration file of
    Verilator."""
    lines = ["`verilator_config", f"// Waivers for verilator -Wall on {top}.v."]
    for rule, reason in (VERILATOR | (more or {})).items():
        lines += [f"// {reason}", f'lint_off -rule {rule} -file "*{top}.v"']
    return "\n".join(lines) + "\n"

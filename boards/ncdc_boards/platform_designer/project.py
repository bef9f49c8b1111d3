"""The Quartus project of a board around a Platform Designer system."""

from ncdc_boards.board import project_name
from ncdc_boards.platform_designer.system import SYSTEM, exports, system_tcl

__all__ = ["project_files"]

_QSF = """\
set_global_assignment -name FAMILY "{board.family}"
set_global_assignment -name DEVICE {board.device}
set_global_assignment -name TOP_LEVEL_ENTITY {system}
set_global_assignment -name QIP_FILE {system}/synthesis/{system}.qip
set_global_assignment -name SDC_FILE {name}.sdc
"""
_SDC = """\
create_clock -name clk_clk -period {period} [get_ports {{clk_clk}}]
derive_clock_uncertainty
set_false_path -from [get_ports {{reset_reset_n}}]
"""


def project_files(board, corrector):
    """Text of each file of the project without the Verilog and the component, by name.

    ``ncdc_<board>.qpf``, ``.qsf`` (device, sources), ``.sdc``, ``ncdc_qsys.tcl``, ``build.sh``, and
    ``PORTS.md``: what is left to the user.
    """
    name = project_name(board)
    return {
        f"{name}.qsf": _QSF.format(board=board, name=name, system=SYSTEM),
        f"{name}.sdc": _SDC.format(period=1000 / board.core_mhz),
        f"{name}.qpf": f'PROJECT_REVISION = "{name}"\n',
        f"{SYSTEM}.tcl": system_tcl(board, corrector), "build.sh": _build(name),
        "PORTS.md": _ports(board, corrector)}


def _build(name):
    """Script from these files to a bitstream; needs Quartus Prime on the path."""
    return (f"#!/bin/sh\n# Makes {name}.sof; needs Quartus Prime (16.1 or later) on the path.\n"
            "set -e\n"
            f'qsys-script --script={SYSTEM}.tcl --search-path=".,$"\n'
            f'qsys-generate {SYSTEM}.qsys --synthesis=VERILOG --search-path=".,$"\n'
            + "".join(f"quartus_{tool} {name}\n" for tool in ("map", "fit", "asm", "sta")))


def _ports(board, corrector):
    return "\n".join([
        f"# Ports of the top, {board.title}", "",
        f"Device {board.device}. Published in: {'; '.join(board.sources)}.", "",
        "Left to the user:", "",
        *(f"- {what}: {why}" for what, why in board.left_to_user.items()), "",
        f"The top is the system `{SYSTEM}`; its interfaces want pins of your board:", "",
        *(f"- `{name}`" for name, *_ in exports(corrector)), ""])

"""The project of a board with a hard processor: Platform Designer's system, and Quartus's."""

from ncdc_boards.board import project_name
from ncdc_boards.hps_board.linux import host_files
from ncdc_boards.hps_board.ports import SYSTEM
from ncdc_boards.hps_board.system import system_tcl
from ncdc_boards.hps_board.top import HpsTop
from ncdc_boards.quartus.project import assembled
from ncdc_boards.quartus.sdc import TRACE, constraints, generated, ports_like

__all__ = ["project_files"]

# Analog Devices, ADV7511/ADV7513, video data to clock, rounded up, in ns.
_HDMI_SETUP, _HDMI_HOLD = 1.8, 1.3
# U-Boot loads a .rbf. A compressed one fits the board's switches MSEL at 01010.
_SETTINGS = f"""\
set_global_assignment -name QIP_FILE {SYSTEM}/synthesis/{SYSTEM}.qip
set_global_assignment -name GENERATE_RBF_FILE ON
set_global_assignment -name ON_CHIP_BITSTREAM_DECOMPRESSION ON
"""
_BEFORE = f"""\
qsys-script --script={SYSTEM}.tcl
qsys-generate {SYSTEM}.qsys --synthesis=VERILOG
"""
_MAPPED = """\
# Standards and terminations of the processor's memory pins.
quartus_sta -t {system}/synthesis/submodules/hps_sdram_p0_pin_assignments.tcl {name}
"""


def project_files(design):
    """Text of each file of the project, by name, without Linux's drivers.

    Those of :func:`ncdc_boards.quartus.project.project_files`, ``ncdc_qsys.tcl``, and what
    :func:`~ncdc_boards.hps_board.linux.host_files` returns.

    Parameters
    ----------
    design : ncdc_boards.hps_board.core.HpsDesign
    """
    board, (setup, _) = design.board, design.sensor
    return assembled(
        board, HpsTop(design),
        lambda ports: constraints(design, setup.timing.pixel_clock_hz / 1e6, ports, _hdmi()),
        settings=_SETTINGS, before=_BEFORE,
        mapped=_MAPPED.format(system=SYSTEM, name=project_name(board)),
    ) | {f"{SYSTEM}.tcl": system_tcl(board)} | host_files(design)


def _hdmi():
    """Constraints of the transmitter's pins."""
    outputs = ports_like(f"hdmi_0__{name}__io*" for name in ("de", "hs", "vs", "r", "g", "b"))
    return [
        "# HDMI transmitter; the processor's memory has constraints of its own, in the .qip",
        generated("hdmi_pin", "pixel", "hdmi_0__clk__io", invert=True),
        f"set_output_delay -clock hdmi_pin -max {_HDMI_SETUP + TRACE} {outputs}",
        f"set_output_delay -clock hdmi_pin -min {-_HDMI_HOLD - TRACE} {outputs}"]

"""The Quartus project of a board."""

import re

from ncdc_boards.constraints import constraints
from ncdc_boards.system import SYSTEM, system_tcl
from ncdc_boards.top import BoardTop
from ncdc_hdl.export.platform_designer import interfaces
from ncdc_hdl.video.modes import mode_for
from ncdc_model.errors import InputError

__all__ = ["check_board", "project_files", "project_name"]

_SETTINGS = (f"set_global_assignment -name QIP_FILE {SYSTEM}/synthesis/{SYSTEM}.qip\n"
             "set_global_assignment -name SDC_FILE {name}.sdc\n")
_PINLESS_QSF = """\
set_global_assignment -name FAMILY "{board.family}"
set_global_assignment -name DEVICE {board.device}
set_global_assignment -name TOP_LEVEL_ENTITY {system}
"""
_PINLESS_SDC = """\
create_clock -name clk_clk -period {period} [get_ports {{clk_clk}}]
derive_clock_uncertainty
set_false_path -from [get_ports {{reset_reset_n}}]
"""


def project_name(board):
    """Name of the project, and of its files."""
    return "ncdc_" + board.name.replace("-", "_")


def check_board(board, descriptor, output):
    """Raise :class:`InputError` unless the board's project holds a corrector of ``descriptor``."""
    if board.platform is None:
        return
    if output != "stream":
        raise InputError(f"board {board.name} shows the corrected stream, output {output} is for "
                         f"a design of your own")
    mode_for(*descriptor.geometry.corrected)


def project_files(board, corrector):
    """Text of each file of the project beside the Verilog and the component, by name.

    ``ncdc_<board>.qpf``, ``.qsf`` (device, sources, pins), ``.sdc``, ``.v`` (the top, where the
    pins are known), ``ncdc_qsys.tcl``, ``build.sh``, and ``PORTS.md``: of every port of the top,
    its pin, or that it is left to the user.

    Raises
    ------
    InputError
        As :func:`check_board`.
    """
    check_board(board, corrector.descriptor, corrector.hardware.output)
    name = project_name(board)
    files = _with_pins(board, corrector, name) if board.platform else _without_pins(board, name)
    return files | {
        f"{name}.qpf": f'PROJECT_REVISION = "{name}"\n',
        f"{SYSTEM}.tcl": system_tcl(board, corrector),
        "build.sh": _build(name),
        "PORTS.md": _ports(board, corrector, files[f"{name}.qsf"])}


def _with_pins(board, corrector, name):
    geometry = corrector.descriptor.geometry
    top = BoardTop(board, mode_for(*geometry.corrected), *geometry.corrected)
    plan = board.platform().prepare(top, name, add_settings=_SETTINGS.format(name=name),
                                    add_constraints=constraints(board))
    wanted = {f"{name}.{kind}" for kind in ("v", "qsf", "sdc", "srf")}
    return {file: text.decode() if isinstance(text, bytes) else text
            for file, text in plan.files.items() if file in wanted}


def _without_pins(board, name):
    return {f"{name}.qsf": _PINLESS_QSF.format(board=board, system=SYSTEM)
            + _SETTINGS.format(name=name),
            f"{name}.sdc": _PINLESS_SDC.format(period=1000 / board.pll.core_mhz)}


def _build(name):
    """Script from these files to a bitstream; needs Quartus Prime on the path."""
    return (f"#!/bin/sh\n# Makes {name}.sof; needs Quartus Prime (16.1 or later) on the path.\n"
            "set -e\n"
            f'qsys-script --script={SYSTEM}.tcl --search-path=".,$"\n'
            f'qsys-generate {SYSTEM}.qsys --synthesis=VERILOG --search-path=".,$"\n'
            + "".join(f"quartus_{tool} {name}\n" for tool in ("map", "fit", "asm", "sta")))


def _ports(board, corrector, qsf):
    pins = re.findall(r"^set_location_assignment -to \"?([^\s\"]+)\"? PIN_(\w+)$", qsf,
                      re.MULTILINE)
    lines = [f"# Ports of the top, {board.title}", "",
             f"Device {board.device}. Published in: {'; '.join(board.sources)}.", ""]
    if pins:
        lines += ["| port | pin |", "|---|---|",
                  *(f"| `{_plain(port)}` | {pin} |" for port, pin in pins), ""]
    lines += ["Left to the user:", ""]
    lines += [f"- {what}: {why}" for what, why in board.left_to_user.items()]
    if not pins:
        lines += ["", f"The top is the system `{SYSTEM}`; its interfaces want pins of your board:",
                  "", *(f"- `{name}`" for name in _open(board, corrector))]
    return "\n".join(lines) + "\n"


def _plain(port):
    return port.replace("\\", "")


def _open(board, corrector):
    """Exported interfaces of a system without a top around it."""
    names = ["clk", "reset", "irq", "front_end_idle", "camera_rows", "memory"]
    return [*names, "video"] if "stream" in interfaces(corrector) else names

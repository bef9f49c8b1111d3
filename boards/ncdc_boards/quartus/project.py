"""The Quartus project of a board."""

import re

from ncdc_boards.quartus.names import USER
from ncdc_boards.quartus.sdc import constraints
from ncdc_boards.quartus.user import user_module

__all__ = ["USER_FILE", "project_files", "project_name", "top_verilog"]

USER_FILE = f"{USER}.v"
"""The file that is the user's: written if it is not there."""

_SETTINGS = f"""\
set_global_assignment -name FAMILY "{{family}}"
set_global_assignment -name VERILOG_FILE {USER_FILE}
set_global_assignment -name SDC_FILE {{name}}.sdc
set_global_assignment -name OPTIMIZATION_MODE "HIGH PERFORMANCE EFFORT"
set_global_assignment -name TIMING_ANALYZER_MULTICORNER_ANALYSIS ON
set_global_assignment -name RESERVE_ALL_UNUSED_PINS_WEAK_PULLUP "AS INPUT TRI-STATED WITH WEAK PULL-UP"
set_global_assignment -name CYCLONEII_RESERVE_NCEO_AFTER_CONFIGURATION "USE AS REGULAR IO"
"""
_BUILD = """\
#!/bin/sh
# Makes {name}.sof; needs Quartus Prime (Lite or Standard, 17.0 or later) on the path.
set -e
cd "$(dirname "$0")"
for tool in map fit asm; do
    quartus_$tool --rev={name} {name}
done
# Ends with an error if a clock is missed, in any corner, or a port has no constraint.
quartus_sta -t check_timing.tcl
echo "{name}.sof: quartus_pgm -m jtag -o 'p;{name}.sof{second}'"
"""
_CHECK = """\
# Run by build.sh: fails if a clock is missed in any corner, or something is not constrained.
project_open {name} -revision {name}
create_timing_netlist
read_sdc
set worst 1e9
foreach_in_collection corner [get_available_operating_conditions] {{
    set_operating_conditions $corner
    update_timing_netlist
    foreach kind {{setup hold recovery removal mpw}} {{
        # Domain by domain: {{name slack total}}.
        foreach domain [get_clock_domain_info -$kind] {{
            set slack [lindex $domain 1]
            puts "$kind [lindex $domain 0] slack $slack ns"
            if {{$slack < $worst}} {{ set worst $slack }}
        }}
    }}
}}
report_ucp -panel_name "Unconstrained Paths"
write_sdc -expand {name}.constrained.txt
if {{$worst == 1e9}} {{
    puts stderr "no slack was found: the design has no clocks"
    qexit -error
}}
if {{$worst < 0}} {{
    puts stderr "the design misses its timing by [expr {{-$worst}}] ns"
    qexit -error
}}
puts "the least slack is $worst ns"
project_close
"""


def project_name(board):
    """Name of the project, of its files and of its top."""
    return "ncdc_" + board.name.replace("-", "_")


def top_verilog(design):
    """Verilog of the top and of all below it but the user's module."""
    return _prepared(design)[f"{project_name(design.board)}.v"]


def project_files(design, setup):
    """Text of each file of the project, by name.

    ``ncdc_<board>.v`` (the top and all below it), ``.qpf``, ``.qsf`` (device, sources, pins),
    ``.sdc``, ``build.sh``, ``check_timing.tcl``, ``PORTS.md``, and :data:`USER_FILE`.

    Parameters
    ----------
    design : ncdc_boards.camera_board.core.Design
        Of a :class:`~ncdc_boards.quartus.board.QuartusBoard`.
    setup : Setup
        Of the sensor.
    """
    board, name = design.board, project_name(design.board)
    pins = _pins(_prepared(design)[f"{name}.qsf"])
    ports = sorted({port.partition("[")[0] for port, _ in pins})
    files = _prepared(
        design, add_settings=_SETTINGS.format(family=board.family, name=name),
        add_constraints=constraints(design, setup.timing.pixel_clock_hz / 1e6, ports))
    wanted = [f"{name}.{kind}" for kind in ("v", "qsf", "sdc", "srf")]
    second = "@2" if board.device.startswith("5CSE") else ""    # behind the processor
    return {file: files[file] for file in wanted} | {
        f"{name}.qpf": f'PROJECT_REVISION = "{name}"\n',
        "build.sh": _BUILD.format(name=name, second=second),
        "check_timing.tcl": _CHECK.format(name=name), "PORTS.md": _ports(board, pins),
        USER_FILE: user_module()}


def _prepared(design, **overrides):
    """Text of each file that Amaranth writes, by name."""
    board = design.board
    plan = board.platform().prepare(board.top(design), project_name(board), **overrides)
    return {name: text.decode() if isinstance(text, bytes) else text
            for name, text in plan.files.items()}


def _pins(qsf):
    """[(bit of a port, pin)] of a .qsf's text."""
    found = re.findall(r"^set_location_assignment -to \"?([^\s\"]+)\"? PIN_(\w+)$", qsf,
                       re.MULTILINE)
    return [(port.replace("\\", ""), pin) for port, pin in found]


def _ports(board, pins):
    """A table of the pins."""
    return "\n".join([
        f"# Ports of the top, {board.title}", "",
        f"Device {board.device}. Published in: {'; '.join(board.sources)}.", "",
        "| port | pin |", "|---|---|", *(f"| `{port}` | {pin} |" for port, pin in pins), ""])

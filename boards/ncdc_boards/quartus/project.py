"""The Quartus project of a board."""

import re

from ncdc_boards.board import project_name
from ncdc_boards.quartus.names import USER
from ncdc_boards.quartus.sdc import constraints
from ncdc_boards.quartus.user import user_module

__all__ = ["USER_FILE", "assembled", "project_files", "top_verilog"]

USER_FILE = f"{USER}.v"
"""The user's file: written only if it does not exist."""

_SETTINGS = f"""\
set_global_assignment -name FAMILY "{{family}}"
set_global_assignment -name VERILOG_FILE {USER_FILE}
set_global_assignment -name SDC_FILE {{name}}.sdc
set_global_assignment -name OPTIMIZATION_MODE "HIGH PERFORMANCE EFFORT"
set_global_assignment -name TIMING_ANALYZER_MULTICORNER_ANALYSIS ON
set_global_assignment -name RESERVE_ALL_UNUSED_PINS "AS INPUT TRI-STATED WITH WEAK PULL-UP"
set_global_assignment -name CYCLONEII_RESERVE_NCEO_AFTER_CONFIGURATION "USE AS REGULAR IO"
"""
_BUILD = """\
#!/bin/sh
# Makes {name}.sof; needs Quartus Prime (Lite or Standard, 17.0 or later) on the path.
set -e
cd "$(dirname "$0")"
{before}quartus_map --rev={name} {name}
{mapped}for tool in fit asm; do
    quartus_$tool --rev={name} {name}
done
# Ends with an error if a clock or a counter's skew is violated, or a constraint has found nothing.
quartus_sta -t check_timing.tcl
echo "{name}.sof: quartus_pgm -m jtag -o 'p;{name}.sof{second}'"
"""
_CHECK = """\
# Run by build.sh: fails if a clock violates its timing, or a constraint has found nothing.
project_open {name} -revision {name}
create_timing_netlist
read_sdc
proc fail {{text}} {{
    puts stderr $text
    qexit -error
}}
foreach clock {{{clocks}}} {{
    if {{[get_collection_size [get_clocks -nowarn $clock]] != 1}} {{
        fail "there is no clock $clock"
    }}
}}
foreach pattern {{{registers}}} {{
    if {{[get_collection_size [get_registers -nowarn $pattern]] == 0}} {{
        fail "no register is called $pattern"
    }}
}}
# The longest or the shortest way from registers to others, in ns; constraints are ignored.
proc way {{from to args}} {{
    set found {{}}
    set paths [get_path -from [get_registers $from] -to [get_registers $to] -npaths 1000 \
        -pairs_only {{*}}$args]
    foreach_in_collection path $paths {{ lappend found [get_path_info $path -arrival_time] }}
    if {{[llength $found] == 0}} {{ fail "there is no path from $from to $to" }}
    set order [lsort -real $found]
    return [expr {{$args eq "-min_path" ? [lindex $order 0] : [lindex $order end]}}]
}}
set worst 1e9
foreach_in_collection corner [get_available_operating_conditions] {{
    set_operating_conditions $corner
    update_timing_netlist
    # For each Gray counter: the skew of its bits, and its limit in ns.
    foreach {{from to limit}} {{{counters}}} {{
        set skew [expr {{[way $from $to] - [way $from $to -min_path]}}]
        puts "skew from $from to $to: $skew ns"
        if {{$skew > $limit}} {{ fail "bits of $from arrive $skew ns apart, $limit at most" }}
    }}
    foreach kind {{setup hold recovery removal mpw}} {{
        # For each clock: its name, its slack, and more.
        foreach clock [get_clock_domain_info -$kind] {{
            set slack [lindex $clock 1]
            puts "$kind [lindex $clock 0]: slack $slack ns"
            if {{$slack < $worst}} {{ set worst $slack }}
        }}
    }}
}}
if {{$worst == 1e9}} {{ fail "no slack was found" }}
if {{$worst < 0}} {{ fail "the design does not meet timing by [expr {{-$worst}}] ns" }}
puts "the minimum slack is $worst ns"
project_close
"""


def top_verilog(design):
    """Verilog of the top and of all below it but the user's module."""
    return _prepared(design.board, design.board.top(design))["v"]


def project_files(design, sources=()):
    """Text of each file of the project, by name.

    ``ncdc_<board>.v`` (the top and all below it), ``.qpf``, ``.qsf`` (device, sources, pins),
    ``.sdc``, ``build.sh``, ``check_timing.tcl``, ``PORTS.md``, and :data:`USER_FILE`.

    Parameters
    ----------
    design : ncdc_boards.camera_board.core.Design
        Design of a :class:`~ncdc_boards.quartus.board.QuartusBoard`.
    sources : sequence of str
        Names of more Verilog files, of a processor.
    """
    settings = "".join(f"set_global_assignment -name VERILOG_FILE {name}\n" for name in sources)
    setup, _ = design.sensor
    return assembled(design.board, design.board.top(design), lambda ports: constraints(
        design, setup.timing.pixel_clock_hz / 1e6, ports), settings=settings)


def assembled(board, top, timing, *, settings="", before="", mapped=""):
    """The files of :func:`project_files`, for a board with or without an SDRAM of its own.

    Parameters
    ----------
    board : object
        With ``name``, ``title``, ``family``, ``device``, ``platform``, ``sources``.
    top : Elaboratable
    timing : callable
        Function of the top's ports; returns the text of the .sdc after the oscillator's clock.
    settings : str
        More lines of the .qsf.
    before, mapped : str
        Lines of ``build.sh`` before and after Quartus's first program.
    """
    name = project_name(board)
    files = _prepared(board, top)
    pins = _pins(files["qsf"])
    ports = sorted({port.partition("[")[0] for port, _ in pins})
    files["qsf"] += _SETTINGS.format(family=board.family, name=name) + settings
    files["sdc"] += timing(ports)
    second = "@2" if board.device.startswith("5CSE") else ""    # after the processor
    return {f"{name}.{kind}": text for kind, text in files.items()} | {
        f"{name}.qpf": f'PROJECT_REVISION = "{name}"\n',
        "build.sh": _BUILD.format(name=name, second=second, before=before, mapped=mapped),
        "check_timing.tcl": _check(board, name, files["sdc"]), "PORTS.md": _ports(board, pins),
        USER_FILE: user_module()}


def _check(board, name, sdc):
    """Script that checks the slack of all clocks."""
    clocks = re.findall(r"-name \"?(\w+)\"?", sdc)
    registers = sorted(set(re.findall(r"get_registers ({[^}]*})", sdc)))
    counters = re.findall(r"set_net_delay -max ([\d.]+) -from \[get_registers ({[^}]*})\] "
                          r"-to \[get_registers ({[^}]*})\]", sdc)
    return _CHECK.format(name=name, clocks=" ".join(clocks), registers=" ".join(registers),
                         counters=" ".join(f"{source} {sink} {limit}"
                                           for limit, source, sink in counters))


def _prepared(board, top):
    """Text of what Amaranth writes, by the ends of the files' names."""
    name = project_name(board)
    files = board.platform().prepare(top, name).files
    texts = {kind: files[f"{name}.{kind}"] for kind in ("v", "qsf", "sdc", "srf")}
    texts = {kind: text.decode() if isinstance(text, bytes) else text
             for kind, text in texts.items()}
    # Amaranth's placeholders are removed; further lines are appended instead.
    return {kind: re.sub(r"^# \(add_\w+ placeholder\)\n*", "", text, flags=re.M).rstrip() + "\n"
            for kind, text in texts.items()}


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

"""What the files of a Quartus project say: calls of its Tcl, pins, directions of its ports."""

import subprocess
from fnmatch import fnmatchcase
from pathlib import Path

from ncdc_boards.board import project_name
from ncdc_boards.catalogue import board
from ncdc_boards.quartus.sdc import CHAIN_PORTS

__all__ = ["TCL", "directions", "pins_of", "recorded"]

TCL = Path(__file__).parent / "tcl"


def recorded(kind, path):
    """Calls that a Tcl file makes: lists of words."""
    done = subprocess.run(["tclsh", TCL / "record.tcl", kind, path], capture_output=True,
                          text=True)
    assert done.returncode == 0, done.stderr
    return [line.split("\x1f") for line in done.stdout.splitlines()]


def pins_of(folder, name):
    """{bit of a port: pin} of a project."""
    calls = recorded("qsf", folder / f"{project_name(board(name))}.qsf")
    return {to: pin for command, _, to, pin in (
        call for call in calls if call[0] == "set_location_assignment")}, calls


def directions(folder, name):
    """Direction of each port, as the board's resources have them."""
    ports = {bit.partition("[")[0] for bit in pins_of(folder, name)[0]}
    bidirectional = {"sdram_0__dq__io", "camera_0__scl__io", "camera_0__sda__io"}
    ports |= set(CHAIN_PORTS)
    inputs = ("clk50*", "button*", "uart_0__rx*", "camera_0__[dflp]*",
              "altera_reserved_t[cdm][kis]")
    return {port: "inout" if port in bidirectional else
            "input" if any(fnmatchcase(port, pattern) for pattern in inputs) else "output"
            for port in ports}

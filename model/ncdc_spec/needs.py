"""What is missing on a machine, and the line that installs it: Debian's programs, NCDC's extras."""

import shutil

from ncdc_spec.errors import InputError

__all__ = ["PACKAGE_OF", "apt_line", "check_programs", "pip_line"]

PACKAGE_OF = {
    "g++": "g++", "gcc": "gcc", "make": "make", "perl": "perl", "ccache": "ccache",
    "iverilog": "iverilog", "vvp": "iverilog", "tclsh": "tcl",
    "riscv64-unknown-elf-gcc": "gcc-riscv64-unknown-elf",
    "unshare": "util-linux", "nsenter": "util-linux", "ip": "iproute2", "tshark": "tshark",
    "dnsmasq": "dnsmasq-base",
}
"""Debian package of each program."""


def apt_line(programs):
    """The line to type on Debian for ``programs``, all of them in :data:`PACKAGE_OF`."""
    return "apt install " + " ".join(dict.fromkeys(PACKAGE_OF[name] for name in programs))


def pip_line(extra=""):
    """The line to type for an extra of NCDC's package, or for several joined by commas; "": for the
    package itself."""
    return f'pip install "ncdc[{extra}]"' if extra else "pip install ncdc"


def check_programs(purpose, *programs, path=None):
    """Check that all ``programs`` are on the ``path``, as of :func:`shutil.which`.

    Raises
    ------
    InputError
        If one is not; ``purpose`` is the part of the sentence on its use, as "Verilator needs".
    """
    lost = [name for name in programs if shutil.which(name, path=path) is None]
    if lost:
        raise InputError(f"{' and '.join(lost)} {'are' if len(lost) > 1 else 'is'} not installed, "
                         f"which {purpose}: {apt_line(lost)}")

"""Capabilities of NCDC on this machine: for each purpose what is missing, and the line to type.

Only the standard library is imported: it must work where a package is missing.
"""

import re
import shutil
import socket
import subprocess
import sys
from ctypes.util import find_library
from dataclasses import dataclass
from importlib import metadata
from pathlib import Path

from ncdc_spec.needs import PACKAGE_OF, apt_line, pip_line

__all__ = ["CAPABILITIES", "Capability", "Missing", "missing", "package_of", "packages_of"]

_PYTHON = (3, 11)
_QT = {"EGL": "libegl1", "GL": "libgl1", "fontconfig": "libfontconfig1", "dbus-1": "libdbus-1-3",
       "xkbcommon": "libxkbcommon0", "xcb-cursor": "libxcb-cursor0"}
_PACKAGES = {"cv2": "opencv-python-headless", "PIL": "pillow", "yaml": "pyyaml", "migen": "litex",
             "PySide6": "PySide6-Essentials"}      # by the modules that are named otherwise
_SECONDS = 20       # a program that takes longer to answer does not work


@dataclass(frozen=True)
class Missing:
    """One thing that is missing: its name, and the line to type or the step to take."""
    what: str
    line: str


@dataclass(frozen=True)
class Capability:
    """Something that NCDC does, and what it needs for it.

    Parameters
    ----------
    purpose : str
        For people: the commands.
    extra : str, optional
        Group of packages, as in ``pip install "ncdc[EXTRA]"``; "": those of NCDC itself.
    programs : tuple of str
        Names in :data:`PACKAGE_OF`.
    checks : tuple
        Functions that return a list of :class:`Missing`.
    base : bool
        Without it NCDC is of no use.
    """
    purpose: str
    extra: str | None = None
    programs: tuple = ()
    checks: tuple = ()
    base: bool = False


def missing(capability):
    """List of :class:`Missing` of a :class:`Capability`; empty if it is all there."""
    found = []
    if capability.extra is not None:
        lost = [name for name in packages_of(capability.extra) if not _installed(name)]
        found += [Missing(name, pip_line(capability.extra)) for name in lost]
    found += [Missing(name, apt_line([name])) for name in capability.programs if not _there(name)]
    for check in capability.checks:
        found += check()
    return found


def package_of(module, extras):
    """Package that has a module, and the line that installs it; None if NCDC does not list it.

    Parameters
    ----------
    module : str
        Dotted name of the module that could not be imported.
    extras : str
        Extras that the command wants, joined by commas; they are searched before the others.

    Returns
    -------
    Missing or None
    """
    top = module.partition(".")[0]
    name = _PACKAGES.get(top, top.replace("_", "-"))
    listed = metadata.metadata("ncdc").get_all("Provides-Extra") or ()
    wanted = extras.split(",")
    for extra in ("", *filter(None, wanted), *listed):
        if name.lower() in map(str.lower, packages_of(extra)):
            return Missing(name, pip_line(extras if extra in wanted else extra))
    return None


def packages_of(extra):
    """Names of the packages of a group of NCDC and of the groups in it, from NCDC's metadata.

    "": the packages that NCDC always needs.
    """
    names = []
    for line in metadata.requires("ncdc") or ():
        name, inner, condition = re.match(r"([\w.-]+)(?:\[([\w,]+)\])?(.*)", line).groups()
        of = re.search(r"extra\s*==\s*['\"]([\w-]+)['\"]", condition)
        elsewhere = "darwin" in condition and sys.platform == "darwin"
        if (of[1] if of else "") != extra or elsewhere:
            continue
        if name == "ncdc":
            names += [one for group in inner.split(",") for one in packages_of(group)]
        else:
            names.append(name)
    return list(dict.fromkeys(names))


def _installed(name):
    try:
        metadata.version(name)
    except metadata.PackageNotFoundError:
        return False
    return True


def _there(program):
    # Debian has it where only root's PATH leads.
    return shutil.which(program) is not None or Path("/usr/sbin", program).is_file()


def _python():
    if sys.version_info >= _PYTHON:
        return []
    return [Missing(f"Python {'.'.join(map(str, _PYTHON))} (this is {sys.version.split()[0]})",
                    "make a virtual environment with a newer one")]


def _answers(command, text=""):
    """Whether a command ends with status 0."""
    try:
        return not subprocess.run(command, input=text.encode(), capture_output=True,
                                  timeout=_SECONDS).returncode
    except (OSError, subprocess.TimeoutExpired):
        return False


def _compiler():
    if any(map(_there, ("cc", "gcc", "clang"))):
        return []
    return [Missing("gcc", apt_line(["gcc"]))]


def _headers():
    lost = [package for header, package in (("lz4.h", "liblz4-dev"), ("zlib.h", "zlib1g-dev"))
            if not _answers(["g++", "-E", "-x", "c++", "-"], f"#include <{header}>\n")]
    return [Missing(name, f"apt install {name}") for name in lost]


def _qt():
    if sys.platform != "linux":
        return []
    return [Missing(f"lib{name}", f"apt install {package}") for name, package in _QT.items()
            if find_library(name) is None]


def _picolibc():
    if _answers(["riscv64-unknown-elf-gcc", "--specs=picolibc.specs", "-E", "-x", "c", "-"],
                "#include <stdint.h>\n"):
        return []
    return [Missing("picolibc", "apt install picolibc-riscv64-unknown-elf")]


def _namespaces():
    if shutil.which("unshare") is None or _answers(["unshare", "-Urn", "true"]):
        return []
    return [Missing("the right to make network namespaces",
                    "sysctl kernel.unprivileged_userns_clone=1, or run as root")]


def _tap():
    if Path("/dev/net/tun").exists():
        return []
    return [Missing("/dev/net/tun", "modprobe tun")]


def _gvcp():
    from ncdc_spec.protocols.gvcp import PORT
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as one:
        try:
            one.bind(("127.0.0.2", PORT))
        except OSError as error:
            return [Missing(f"UDP port {PORT} of 127.0.0.2 ({error.strerror})",
                            "end the device that has it, or --address with another one")]
    return []


def _aravis():
    code = 'import gi; gi.require_version("Aravis", "0.8")'
    if _answers(["/usr/bin/python3", "-c", code]):
        return []
    return [Missing("Aravis 0.8", "apt install gir1.2-aravis-0.8 python3-gi")]


def _quartus():
    if shutil.which("quartus_sh"):
        return []
    return [Missing("quartus_sh", "install Intel's Quartus Prime Lite, and put it on the PATH")]


CAPABILITIES = (
    Capability("correct, sensor, device; client with tcp://", "", checks=(_python,), base=True),
    Capability("the same a hundred times as fast: the compiled model", checks=(_compiler,)),
    Capability("target, calibrate, train, evaluate, export; demo", "calibrate"),
    Capability("plan, generate, report", "hdl"),
    Capability("simulate, demo", "sim", ("g++", "make", "perl")),
    Capability("the same without compiling twice", programs=("ccache",)),
    Capability("simulate --simulator icarus", programs=("iverilog", "vvp")),
    Capability("simulate --fst", programs=("g++",), checks=(_headers,)),
    Capability("simulate --memory litedram", "litedram"),
    Capability("build: projects for Quartus", "boards"),
    Capability("build --board ulx3s, colorlight-i9; bench with synthesis", "synth"),
    Capability("bitstreams of the projects for Quartus", checks=(_quartus,)),
    Capability("build --system; soc build", "soc",
               ("g++", "make", "perl", "riscv64-unknown-elf-gcc"), (_picolibc,)),
    Capability("soc run: a network of its own", programs=("unshare", "nsenter", "ip"),
               checks=(_namespaces, _tap)),
    Capability("device serve", checks=(_gvcp,)),
    Capability("correct, calibrate --live: films", "video"),
    Capability("lot: production lots", "lot"),
    Capability("client with gige://", "client"),
    Capability("client with aravis://", checks=(_aravis,)),
    Capability("client with usb://", "usb"),
    Capability("client gui", "gui", checks=(_qt,)),
    Capability("the console of the generated Tcl driver", programs=("tclsh",)),
    Capability("the documentation as a site (make docs)", "docs"),
    Capability("every command", "all"),
    Capability("the tests", "test", ("tclsh", "tshark", "dnsmasq", "iverilog")),
    Capability("make types, make dist", "dev"),
)
assert all(name in PACKAGE_OF for one in CAPABILITIES for name in one.programs)

"""The firmware as a program of this machine, under sanitizers."""

import subprocess
from pathlib import Path

from ncdc_soc.firmware import DRIVER, FIRMWARE, SOURCES
from ncdc_soc.lwip import FILES, lwip_source

__all__ = ["host_program"]

_PROGRAMS = Path(__file__).parent / "firmware"
_ON_TARGET = ("start.S", "main.c", "memory.c")      # what a PC does without


def host_program(text, folder, name, firmware=FIRMWARE):
    """Program of ``firmware/<name>.c`` and the sources in the folder ``firmware``.

    ``text`` is that of ``config.h``, ``folder`` exists.
    """
    folder, lwip = Path(folder), lwip_source()
    (folder / "config.h").write_text(text)
    sources = [*(firmware / source for source in SOURCES if source not in _ON_TARGET),
               *DRIVER, *(_PROGRAMS / file for file in ("machine.c", "chip.c", f"{name}.c")),
               *(lwip / source for source in FILES)]
    headers = [f"-I{path}" for path in (folder, firmware, firmware / "lwip_port",
                                        DRIVER[0].parent)]
    done = subprocess.run(
        ["gcc", "-std=gnu11", "-O1", "-g", "-fsanitize=address,undefined",
         "-fno-sanitize-recover=all", "-DFIRMWARE_HOST", "-Wall", "-Wextra", "-Werror", *headers,
         "-isystem", lwip / "include", *sources, "-o", folder / name],
        capture_output=True, text=True)
    assert not done.returncode, done.stderr
    return folder / name

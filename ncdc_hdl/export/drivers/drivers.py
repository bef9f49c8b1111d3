"""Files for a host: register header, drivers in C, Python and Tcl, lenses, SystemRDL."""

import inspect
from dataclasses import replace
from importlib.resources import files

from ncdc_hdl.export.drivers.c_header import c_header, c_lenses, c_lenses_header
from ncdc_hdl.export.drivers.lenses import lenses_of
from ncdc_hdl.export.drivers.python_registers import python_lenses, python_registers
from ncdc_hdl.export.drivers.system_rdl import system_rdl
from ncdc_hdl.export.drivers.tcl_data import tcl_data
from ncdc_spec import white_balance
from ncdc_spec.registers.register_map import absent

__all__ = ["driver_files"]

# Files that are the same for every corrector.
_FIXED = ("ncdc.h", "ncdc.c", "ncdc_eeprom.h", "ncdc_eeprom.c", "ncdc_mapped.h", "ncdc_driver.py",
          "ncdc_backends.py", "ncdc_console.tcl")
_SYSTEM = ("ncdc_camera.py",)       # also for a system


def driver_files(corrector, named, system=()):
    """Text of each file, by name.

    Parameters
    ----------
    corrector : ncdc_hdl.corrector.Corrector
    named : sequence of (path, Descriptor)
        Lenses for it, also the one that it is made for.
    system : sequence of Register
        Registers of the system around it, if there is one.

    Raises
    ------
    InputError
        As in :func:`ncdc_hdl.export.drivers.lenses.lenses_of`.
    """
    lenses = lenses_of(corrector, named)
    table = corrector.registers.table
    # The drivers' code names registers of the lens, also where it is fixed.
    gone = absent(table, replace(corrector.hardware, fixed_lens=False))
    table = (*(row for row in table if row.name not in gone), *system)
    host = files("ncdc_hdl.export.drivers") / "host"
    return {
        "ncdc_registers.h": c_header(table),
        "ncdc_lenses.h": c_lenses_header(lenses), "ncdc_lenses.c": c_lenses(lenses),
        "ncdc_registers.py": python_registers(table), "ncdc_lenses.py": python_lenses(lenses),
        "ncdc_console_data.tcl": tcl_data(table, lenses, corrector.hardware.format),
        **{name: (host / name).read_text() for name in (*_FIXED, *(_SYSTEM if system else ()))},
        "ncdc_white_balance.py": inspect.getsource(white_balance),
        "ncdc.rdl": system_rdl(corrector.registers),
    }

"""What an ECP5 has: block RAMs and multipliers, by its size."""

import re

from ncdc_spec.errors import InputError

__all__ = ["BLOCKS", "DEVICE", "check_blocks"]

BLOCKS = {"DP16KD": {"25": 56, "45": 108, "85": 208}, "MULT18X18D": {"25": 28, "45": 72, "85": 156}}
"""Blocks of each kind that a device has, by its thousands of LUTs."""

DEVICE = re.compile(r"LFE5U-(\d+)F-(\d)BG(\d+)C")
"""A device as Lattice calls it: thousands of LUTs, speed grade, balls."""

_NAMES = {"DP16KD": "block RAMs", "MULT18X18D": "multipliers"}


def check_blocks(device, cells):
    """Check that a device has the blocks of a netlist.

    nextpnr only names a cell that it has no site for.

    Parameters
    ----------
    device : str
        As Lattice calls it.
    cells : dict
        Number of cells of each type, by its name.

    Raises
    ------
    InputError
        If the device has fewer.
    """
    size = DEVICE.fullmatch(device)[1]
    for kind, name in _NAMES.items():
        used, has = cells.get(kind, 0), BLOCKS[kind][size]
        if used > has:
            raise InputError(f"the design needs {used} {name}, the {device} has {has}: a smaller "
                             "network or interpolation may fit")

"""Names that gateware and constraints share."""

__all__ = ["CYCLONE_IV", "CYCLONE_V", "LOOPS", "USER"]

CYCLONE_IV, CYCLONE_V = "Cyclone IV E", "Cyclone V"
LOOPS = ("core_loop", "pixel_loop", "ethernet_loop")
"""Instances of the phase-locked loops: core, SDRAM and sensor; pixel; Ethernet, if there is one."""
USER = "ncdc_user"
"""Module, and file, of the user."""

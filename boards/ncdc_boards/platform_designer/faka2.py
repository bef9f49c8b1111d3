"""FAKA2, the paper's own board: Cyclone V and 256 MB of DDR3 SDRAM."""

from ncdc_boards.platform_designer.board import DesignerBoard

__all__ = ["BOARD"]

_UNPUBLISHED = "the board's pin-out was never published"

BOARD = DesignerBoard(
    name="faka2", title="FAKA2", family="Cyclone V", device="5CEFA7F31C7", core_mhz=100,
    data_width=128, multiplier_bits=27,
    sources=("Chen, Yao, Li, Kuo, section IV.C: a Cyclone V device and a 256 MB DDR3 SDRAM",),
    left_to_user={
        "device": "the paper names the family only; a 5CEFA7 stands for it",
        "every pin": _UNPUBLISHED,
        "memory_*": "the DDR3 controller has to be made for the board's chip and pins"})

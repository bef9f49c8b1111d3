"""Layouts between the parts of the USB side."""

from dataclasses import dataclass

from amaranth.lib import data, wiring
from amaranth.lib.wiring import In, Out

__all__ = ["CHIPS", "Chip", "ChipPins", "FT232H", "FT601", "word_layout"]


@dataclass(frozen=True)
class Chip:
    """A chip with the 245 synchronous FIFO mode.

    Parameters
    ----------
    name : str
    lanes : int
        Bytes of a word on its bus.
    clock_hz : int
        Frequency of the clock that it sends.
    """
    name: str
    lanes: int
    clock_hz: int

    @property
    def width(self):
        """Data lines."""
        return 8 * self.lanes


FT232H = Chip("FT232H", 1, 60_000_000)
FT601 = Chip("FT601", 4, 100_000_000)
CHIPS = {chip.name: chip for chip in (FT232H, FT601)}


def word_layout(lanes):
    """A word on the bus: ``enable`` has a bit for each valid byte of ``data``, and these are
    the lowest ones. The lowest byte is the first."""
    return data.StructLayout({"data": 8 * lanes, "enable": lanes})


class ChipPins(wiring.Signature):
    """Pins from the FPGA's side; ``_n``: active low.

    ``clock`` comes from the chip. The FPGA drives ``data_o`` and ``be_o`` while ``data_oe``. A chip
    of one lane has no ``be``: its ``be_i`` is 1.

    Parameters: ``lanes`` of the bus.
    """

    def __init__(self, lanes):
        super().__init__({
            "clock": In(1), "rxf_n": In(1), "txe_n": In(1),
            "data_i": In(8 * lanes), "be_i": In(lanes),
            "data_o": Out(8 * lanes), "be_o": Out(lanes), "data_oe": Out(1),
            "oe_n": Out(1, init=1), "rd_n": Out(1, init=1), "wr_n": Out(1, init=1)})

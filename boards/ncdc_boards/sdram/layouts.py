"""Layouts between the parts of the SDRAM controller, and its pins."""

from dataclasses import dataclass

from amaranth.lib import data, wiring
from amaranth.lib.wiring import In, Out
from amaranth.utils import exact_log2

__all__ = ["AddressMapping", "SdramPins", "command_layout"]


class SdramPins(wiring.Signature):
    """Pins of an SDR SDRAM but its clock; ``dq_oe`` high drives all of DQ."""

    def __init__(self, chip):
        super().__init__({
            "cke": Out(1), "cs_n": Out(1), "ras_n": Out(1), "cas_n": Out(1), "we_n": Out(1),
            "ba": Out(chip.bank_bits), "a": Out(max(chip.row_bits, 11)),
            "dqm": Out(chip.data_bits // 8), "dq_o": Out(chip.data_bits), "dq_oe": Out(1),
            "dq_i": In(chip.data_bits),
        })


@dataclass(frozen=True)
class AddressMapping:
    """Splits a word's number: column in the lowest bits, then bank, then row.

    Neighbouring rows are in different banks, so that the next one is opened while this one is
    read. A column here counts words of ``data_width`` bits, each of ``beats`` columns of the
    chip.

    Parameters: an :class:`~ncdc_boards.sdram.chips.SdramChip`; bits of a word; words of a burst,
    the maximum.
    """
    chip: object
    data_width: int
    max_burst: int

    @property
    def beats(self):
        """Clocks of data per word."""
        return self.data_width // self.chip.data_bits

    @property
    def column_bits(self):
        """Bits of a word's column."""
        return self.chip.column_bits - exact_log2(self.beats)

    @property
    def word_bits(self):
        """Bits of a word's number in the memory."""
        return self.column_bits + self.chip.bank_bits + self.chip.row_bits

    @property
    def words(self):
        """Shape of a number of words of a burst."""
        return range(self.max_burst + 1)

    @property
    def burst(self):
        """Layout of a burst: the number of its first word, and its words."""
        return data.StructLayout({"word": self.word_bits, "words": self.words})

    @property
    def segment(self):
        """Layout of a burst's words in one row; ``last``: no other segment follows."""
        return data.StructLayout({
            "column": self.column_bits, "bank": self.chip.bank_bits, "row": self.chip.row_bits,
            "words": self.words, "last": 1})


def command_layout(mapping):
    """One command to the chip: at most one flag, and the address.

    ``precharge_all`` closes all banks, ``refresh`` is AUTO REFRESH, ``mode`` LOAD MODE REGISTER.
    """
    return data.StructLayout({
        "active": 1, "precharge": 1, "precharge_all": 1, "read": 1, "write": 1, "refresh": 1,
        "mode": 1, "bank": mapping.chip.bank_bits, "row": mapping.chip.row_bits,
        "column": mapping.column_bits})

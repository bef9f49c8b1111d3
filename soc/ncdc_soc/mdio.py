"""The management wires of an Ethernet chip, bit by bit by the processor."""

from litex.gen import LiteXModule
from litex.soc.interconnect.csr import CSRField, CSRStatus, CSRStorage
from migen import Signal
from migen.genlib.cdc import MultiReg

__all__ = ["Mdio"]


class Mdio(LiteXModule):
    """MDC and MDIO as registers; unlike LiteEth's its pins are one way each.

    Attributes
    ----------
    mdc, data, enable : Signal
        To the pins: the clock, MDIO's level, and whether the processor drives it.
    pin : Signal
        MDIO's level at the pin.
    wires : CSRStorage
    level : CSRStatus
    """

    def __init__(self):
        self.mdc, self.data, self.enable, self.pin = (Signal() for _ in range(4))
        self.wires = CSRStorage(name="wires", fields=[
            CSRField("mdc", size=1), CSRField("enable", size=1), CSRField("data", size=1)])
        self.level = CSRStatus(1, name="level")
        fields = self.wires.fields
        self.comb += [self.mdc.eq(fields.mdc), self.enable.eq(fields.enable),
                      self.data.eq(fields.data)]
        self.specials += MultiReg(self.pin, self.level.status)

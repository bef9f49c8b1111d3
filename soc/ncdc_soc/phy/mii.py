"""GMII, eight wires each way at 1000 Mbit/s, and MII, four at 100 and 10."""

from liteeth.phy.common import LiteEthPHYMDIO
from litex.build.io import DDROutput
from litex.gen import ClockDomainsRenamer, LiteXModule
from migen import Cat, ClockSignal

from ncdc_soc.phy.clocks import PhyClocks
from ncdc_soc.phy.nibbles import Receiver, Sender

__all__ = ["GmiiPhy", "MiiPhy"]


class _Phy(LiteXModule):
    """Common part of GMII and MII: one edge of the clock, separate signals for valid and error."""
    dw = 8
    integrated_ifg_inserter = True

    def __init__(self, pads, receive, transmit, whole):
        self.clocks = PhyClocks(receive, transmit, pads)
        self.sender = sender = ClockDomainsRenamer("eth_tx")(Sender())
        self.receiver = receiver = ClockDomainsRenamer("eth_rx")(Receiver())
        self.sink, self.source = sender.sink, receiver.source
        self.comb += [sender.whole.eq(whole), receiver.whole.eq(whole)]
        self.sync.eth_rx += [
            Cat(receiver.low, receiver.high).eq(pads.rx_data),
            receiver.valid.eq(pads.rx_dv),
            receiver.error.eq(pads.rx_er),
        ]
        # From registers to the pins, and each from one.
        self.sync.eth_tx += [
            pads.tx_data.eq(Cat(sender.low, sender.high)),
            pads.tx_en.eq(sender.enable),
            pads.tx_er.eq(sender.error),
        ]
        if hasattr(pads, "mdc"):
            self.mdio = LiteEthPHYMDIO(pads)


class GmiiPhy(_Phy):
    """LiteEth's MAC to the pins of GMII, 1000 Mbit/s.

    Parameters
    ----------
    clock_pads, pads : Record
        ``rx``, ``gtx``; ``rx_data``, ``rx_dv``, ``rx_er``, ``tx_data``, ``tx_en``, ``tx_er``, and
        if they are wired ``rst_n``, ``mdc``, ``mdio``.
    transmit : Signal
        Clock of 125 MHz. Its copy at the pin rises half a clock after a change of the data.
    """
    tx_clk_freq = rx_clk_freq = 125e6

    def __init__(self, clock_pads, pads, transmit):
        super().__init__(pads, clock_pads.rx, transmit, whole=1)
        self.specials += DDROutput(0, 1, clock_pads.gtx, ClockSignal("eth_tx"))


class MiiPhy(_Phy):
    """LiteEth's MAC to the pins of MII, 100 and 10 Mbit/s: both clocks come from the PHY.

    Parameters
    ----------
    clock_pads, pads : Record
        ``rx``, ``tx``; the others as of :class:`GmiiPhy`, data of four bits.
    """
    tx_clk_freq = rx_clk_freq = 25e6

    def __init__(self, clock_pads, pads):
        super().__init__(pads, clock_pads.rx, clock_pads.tx, whole=0)

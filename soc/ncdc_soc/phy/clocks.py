"""Clocks and reset that the three interfaces share."""

from liteeth.phy.common import LiteEthPHYHWReset
from litex.gen import LiteXModule
from migen import ClockDomain
from migen.genlib.resetsync import AsyncResetSynchronizer

__all__ = ["RESET_CLOCKS", "PhyClocks"]

RESET_CLOCKS = 256      # of the system, as LiteEth has it


class PhyClocks(LiteXModule):
    """Domains ``eth_rx`` and ``eth_tx`` of an interface, in reset while the PHY's chip is.

    Parameters
    ----------
    receive, transmit : Signal
        Their clocks.
    pads : Record
        With ``rst_n`` if the chip's reset is wired.
    reset_clocks : int
        That the chip's reset takes, of the system's clock.
    """

    def __init__(self, receive, transmit, pads, reset_clocks=RESET_CLOCKS):
        self.cd_eth_rx = ClockDomain()
        self.cd_eth_tx = ClockDomain()
        self.hw_reset = LiteEthPHYHWReset(reset_clocks)
        self.comb += [self.cd_eth_rx.clk.eq(receive), self.cd_eth_tx.clk.eq(transmit)]
        if hasattr(pads, "rst_n"):
            self.comb += pads.rst_n.eq(~self.hw_reset.reset)
        self.specials += [AsyncResetSynchronizer(domain, self.hw_reset.reset)
                          for domain in (self.cd_eth_rx, self.cd_eth_tx)]

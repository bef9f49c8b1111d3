"""LiteEth's MAC for two senders: the processor and the packetiser."""

from liteeth.common import eth_phy_description
from liteeth.mac.core import LiteEthMACCore
from liteeth.mac.wishbone import LiteEthMACWishboneInterface
from liteeth.phy.model import LiteEthPHYModel
from litex.gen import ClockDomainsRenamer, LiteXModule
from litex.soc.interconnect import packet, stream

__all__ = ["SLOT_BYTES", "Mac", "ModelPhy", "mac_core"]

SLOT_BYTES = 2048       # of the processor's memory for one frame
_WIDTH = 32


class ModelPhy(LiteEthPHYModel):
    """LiteEth's model of a PHY, a byte per clock, with preamble and check sequence as on a wire."""
    with_preamble_crc = True

    def __init__(self, pads):
        super().__init__(pads)
        # Without it LiteEth's MAC checks no check sequence.
        self.comb += self.source.last_be.eq(self.source.last)


def mac_core(phy, in_words=False):
    """LiteEth's MAC with streams of 32 bits; ``phy`` and ``in_words`` as of :class:`Mac`."""
    # Words that cross to the other clock: no more than one LUT memory of an ECP5 holds.
    depth = {"tx_cdc_depth": 16, "rx_cdc_depth": 16} if in_words else {}
    core = LiteEthMACCore(phy, _WIDTH, with_sys_datapath=in_words, tx_cdc_buffered=in_words,
                          **depth)
    if in_words:
        # Of frames sent between the conversion to bytes and their end, of those received between
        # the conversion to words and the crossing: ``ready`` would go through both in one clock.
        for way, position, domain, width in ((core.tx_datapath, -2, "eth_tx", phy.dw),
                                             (core.rx_datapath, 3, "eth_rx", _WIDTH)):
            buffer = ClockDomainsRenamer(domain)(stream.Buffer(
                eth_phy_description(width), pipe_valid=True, pipe_ready=True))
            way.submodules += buffer
            way.pipeline.insert(position, buffer)
    return core


class Mac(LiteXModule):
    """Frames of the processor and of the packetiser, one whole frame at a time, in turn.

    Received frames go to the processor alone.

    Parameters
    ----------
    phy : LiteX PHY
    slots : int
        Frames received that may wait for the processor.
    in_words : bool
        Process preamble, padding and check sequence as words, with the system's clock, which must
        be above 31.25 MHz. Else as bytes, with the interface's clock; slow devices do not meet
        timing with it at 1000 Mbit/s.

    Attributes
    ----------
    frames : stream.Endpoint
        Frames of the packetiser, 32 bits, the first byte in the lowest.
    bus_rx, bus_tx : wishbone.Interface
        The processor's frames, ``SLOT_BYTES`` each.
    ev : EventManager
    """

    def __init__(self, phy, slots=4, in_words=False):
        self.core = core = mac_core(phy, in_words)
        self.interface = interface = LiteEthMACWishboneInterface(
            _WIDTH, nrxslots=slots, ntxslots=2, endianness="little",
            txslots_write_only=True)    # read by the MAC alone: one block RAM a slot, not two
        self.frames = stream.Endpoint(eth_phy_description(_WIDTH))
        self.arbiter = packet.Arbiter([interface.source, self.frames], core.sink)
        self.comb += core.source.connect(interface.sink)
        self.ev, self.bus_rx, self.bus_tx = interface.sram.ev, interface.bus_rx, interface.bus_tx

    def get_csrs(self):
        """Registers of the processor's side and of the MAC."""
        return self.interface.get_csrs() + self.core.get_csrs()

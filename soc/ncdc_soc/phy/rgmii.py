"""RGMII: four wires each way, two nibbles a clock at 1000 Mbit/s, one at 100 and 10."""

from liteeth.common import eth_phy_description
from liteeth.phy.common import LiteEthPHYMDIO
from litex.build.io import DDRInput, DDROutput
from litex.gen import ClockDomainsRenamer, LiteXModule
from litex.soc.interconnect import stream
from litex.soc.interconnect.csr import CSRField, CSRStatus, CSRStorage
from migen import Array, ClockDomain, ClockSignal, If, Signal
from migen.genlib.cdc import MultiReg

from ncdc_soc.phy.clocks import RESET_CLOCKS, PhyClocks
from ncdc_soc.phy.nibbles import SPEEDS, Receiver, Sender

__all__ = ["RgmiiPhy"]

_MHZ = 125          # of the transmit clock that is given, whatever the speed


class RgmiiPhy(LiteXModule):
    """LiteEth's MAC to the pins of RGMII 2.0, at the speed in a register.

    The line's transmit clock is divided from one of 125 MHz, by 1, 5 or 50. It must reach the chip
    some 2 ns after the data, and the chip's receive clock must come as late. The chip's own delays
    do so (the 88E1111 has both in its register 20), or ``transmit_late`` for the transmit clock.

    Parameters
    ----------
    clock_pads, pads : Record
        ``rx``, ``tx``; ``rx_data``, ``rx_ctl``, ``tx_data``, ``tx_ctl``, and if they are wired
        ``rst_n``, ``mdc``, ``mdio``.
    transmit : Signal
        Clock of 125 MHz.
    transmit_late : Signal or None
        The same, 2 ns later, for the transmit clock's pin.
    paired : bool
        Whether the device's input cell pairs a rising edge's bit with that of the next falling
        edge, as ECP5's IDDRX1F does. Altera's ALTDDIO_IN pairs it with the falling edge before.
    reset_clocks : int
        Parameter of :class:`PhyClocks`.
    buffered : bool
        A register each way between the MAC and the :class:`Sender`, for slow devices.

    Attributes
    ----------
    sink, source : stream.Endpoint
        Bytes in ``eth_tx`` and from ``eth_rx``.
    speed : CSRStorage
        Index in ``SPEEDS``.
    status : CSRStatus
        The chip's status on its idle wires, if it sends one: link, speed, duplex.
    """
    dw = 8
    tx_clk_freq = rx_clk_freq = 1e6 * _MHZ
    integrated_ifg_inserter = True

    def __init__(self, clock_pads, pads, transmit, transmit_late=None, *, paired,
                 reset_clocks=RESET_CLOCKS, buffered=False):
        self.clocks = PhyClocks(clock_pads.rx, transmit, pads, reset_clocks)
        self.speed = CSRStorage(2, reset=SPEEDS.index(1000), name="speed",
                                description="Line's speed: 0, 1, 2 are 10, 100, 1000 Mbit/s.")
        self.status = CSRStatus(name="status", fields=[
            CSRField("link", size=1), CSRField("speed", size=2), CSRField("duplex", size=1)])
        self.sender = sender = ClockDomainsRenamer("eth_tx")(Sender())
        self.receiver = receiver = ClockDomainsRenamer("eth_rx")(Receiver())
        self.sink, self.source = sender.sink, receiver.source
        if buffered:
            self.buffer = buffer = ClockDomainsRenamer("eth_tx")(stream.Buffer(
                eth_phy_description(8), pipe_valid=True, pipe_ready=True))
            self.comb += buffer.source.connect(sender.sink)
            self.sink = buffer.sink
        self._transmit(clock_pads, pads, transmit_late)
        self._receive(pads, paired)
        if hasattr(pads, "mdc"):
            self.mdio = LiteEthPHYMDIO(pads)

    def _transmit(self, clock_pads, pads, late):
        sender, speed = self.sender, Signal(2)
        self.specials += MultiReg(self.speed.storage, speed, "eth_tx", reset=SPEEDS.index(1000))
        # Of the indices of SPEEDS the upper bit is 1000 Mbit/s; 3, which is none, is taken for it.
        # A step is a clock of the line: of a byte at 1000 Mbit/s, below it of a nibble.
        steps = [_MHZ * (8 if mbits == 1000 else 4) // mbits for mbits in SPEEDS]
        self.sync.eth_tx += [sender.whole.eq(speed[1]),
                             sender.clocks.eq(Array([*(step - 1 for step in steps), 0])[speed])]
        # Registers that may lie near the pins, with no logic after them.
        low, high, valid, second = Signal(4), Signal(4), Signal(), Signal()
        clock, clock_domain = Signal(2), ClockSignal("eth_tx")
        self.sync.eth_tx += [
            low.eq(sender.low), high.eq(sender.high), valid.eq(sender.enable),
            second.eq(sender.enable ^ sender.error), clock.eq(sender.clock)]
        if late is not None:
            clock, clock_domain = self._step_to_late(clock), late
        self.specials += [DDROutput(low[k], high[k], pads.tx_data[k], ClockSignal("eth_tx"))
                          for k in range(4)]
        self.specials += [DDROutput(valid, second, pads.tx_ctl, ClockSignal("eth_tx")),
                          DDROutput(clock[0], clock[1], clock_pads.tx, clock_domain)]

    def _step_to_late(self, clock):
        """The clock's bits for an output cell that is 2 ns late.

        From their register they go to one of the falling edge, half a period later (4 ns), and
        from there to the late cell (6 ns). No step is shorter, and none has logic.
        """
        self.cd_eth_falling = ClockDomain(reset_less=True)
        self.comb += self.cd_eth_falling.clk.eq(~ClockSignal("eth_tx"))
        stepped = Signal(2)
        self.sync.eth_falling += stepped.eq(clock)
        return stepped

    def _receive(self, pads, paired):
        receiver, speed = self.receiver, Signal(2)
        rises, falls, first = Signal(5), Signal(5), Signal(5)
        self.specials += MultiReg(self.speed.storage, speed, "eth_rx", reset=SPEEDS.index(1000))
        self.specials += [
            DDRInput(pin, rises[k], falls[k], ClockSignal("eth_rx"))
            for k, pin in enumerate([*(pads.rx_data[k] for k in range(4)), pads.rx_ctl])]
        if paired:
            self.comb += first.eq(rises)
        else:
            self.sync.eth_rx += first.eq(rises)
        status = Signal(4)
        self.sync.eth_rx += [
            receiver.whole.eq(speed[1]),
            receiver.low.eq(first[:4]),
            receiver.high.eq(falls[:4]),
            receiver.valid.eq(first[4]),
            receiver.error.eq(first[4] ^ falls[4]),
            If(~first[4] & ~falls[4], status.eq(first[:4])),
        ]
        self.specials += MultiReg(status, self.status.status)

"""An FTDI chip in 245 synchronous FIFO mode, as two streams."""

from amaranth import *
from amaranth.lib import stream, wiring
from amaranth.lib.cdc import ResetSynchronizer
from amaranth.lib.fifo import AsyncFIFO, AsyncFIFOBuffered
from amaranth.lib.wiring import In, Out

from ncdc_hdl.usb.fifo_bus import FifoBus
from ncdc_hdl.usb.layouts import ChipPins, word_layout

__all__ = ["UsbFifo"]

_SPARE = 8          # words that may still come when the queue is full


class UsbFifo(wiring.Component):
    """Passes words from the core's clock to the chip's, and back.

    The core needs no clock above the chip's to keep its bus full, but none below it either.

    Parameters
    ----------
    chip : Chip
    depth : int
        Words of each queue, a power of two.
    turn : int
        As in :class:`FifoBus`.

    Members
    -------
    pins : ``Out(ChipPins(chip.lanes))``
    i : ``In(stream.Signature(word_layout(chip.lanes)))``
        Words to the host.
    o : ``Out(stream.Signature(word_layout(chip.lanes)))``
        Words from the host.

    Raises
    ------
    ValueError
        If ``depth`` is below 16.
    """

    def __init__(self, chip, depth=512, turn=512):
        if depth < 2 * _SPARE:
            raise ValueError(f"depth is {depth}, the limit is {2 * _SPARE}")
        self.chip, self.depth, self.turn = chip, depth, turn
        word = word_layout(chip.lanes)
        super().__init__({"pins": Out(ChipPins(chip.lanes)), "i": In(stream.Signature(word)),
                          "o": Out(stream.Signature(word))})

    def elaborate(self, platform):
        m = Module()
        m.domains.usb = ClockDomain(local=True)
        m.d.comb += ClockSignal("usb").eq(self.pins.clock)
        m.submodules.reset = ResetSynchronizer(ResetSignal(), domain="usb")
        width = word_layout(self.chip.lanes).size
        m.submodules.bus = bus = DomainRenamer("usb")(FifoBus(self.chip.lanes, self.turn))
        m.submodules.to_host = to_host = AsyncFIFOBuffered(
            width=width, depth=self.depth, w_domain="sync", r_domain="usb")
        # The buffered queue has logic before a synchroniser of its writer's level.
        m.submodules.from_host = from_host = AsyncFIFO(
            width=width, depth=self.depth, w_domain="usb", r_domain="sync")
        for name, member in ChipPins(self.chip.lanes).members.items():
            ours, theirs = getattr(self.pins, name), getattr(bus.pins, name)
            if name != "clock":
                m.d.comb += ours.eq(theirs) if member.flow is Out else theirs.eq(ours)
        m.d.usb += bus.space.eq(from_host.w_level <= self.depth - _SPARE)
        m.d.comb += [
            to_host.w_data.eq(self.i.payload), to_host.w_en.eq(self.i.valid),
            self.i.ready.eq(to_host.w_rdy),
            bus.to_host.payload.eq(to_host.r_data), bus.to_host.valid.eq(to_host.r_rdy),
            to_host.r_en.eq(bus.to_host.ready),
            from_host.w_data.eq(bus.from_host), from_host.w_en.eq(bus.push),
            self.o.payload.eq(from_host.r_data), self.o.valid.eq(from_host.r_rdy),
            from_host.r_en.eq(self.o.ready),
        ]
        return m

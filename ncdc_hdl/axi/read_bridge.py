"""An Avalon-MM read host's commands as AXI4 bursts."""

from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out
from amaranth.utils import exact_log2

from ncdc_hdl.avalon.bus import ADDRESS_BITS, PENDING, ReadHost
from ncdc_hdl.axi.bus import PAGE_BITS, ReadPort, burst_values

__all__ = ["ReadBridge"]


class ReadBridge(wiring.Component):
    """Makes one burst of each command, or two where it would cross the end of a page.

    All bursts have the same ID: their words come in the order of the requests, as on Avalon.
    There is no back-pressure, as the host has claimed space for them.

    A reset of the design cancels nothing. An offered command stays until it is accepted, and
    words under way still come, and the host drops them. ``memory_rst`` is the bus's own reset:
    from the next clock on nothing is offered and nothing expected.

    Timing: a command is offered 1 clock after the host gives it, and commands follow each other
    without a gap. A word reaches the host in the clock in which it comes.

    Parameters
    ----------
    data_width, max_burst : int
        Bits of a word; most words of a command.
    pending : int
        Most bursts offered or accepted whose last word has not come.

    Members
    -------
    host : ``In(ReadHost(data_width, max_burst))``
    memory_rst : ``In(1)``
    axi : ``Out(ReadPort(data_width))``
    failed : ``Out(1)``
        A word comes with an error.
    """

    latency = 1
    """Clocks from a command to the bus."""

    def __init__(self, data_width, max_burst, pending=PENDING):
        self.data_width, self.max_burst, self.pending = data_width, max_burst, pending
        super().__init__({
            "host": In(ReadHost(data_width, max_burst)), "memory_rst": In(1),
            "axi": Out(ReadPort(data_width)), "failed": Out(1),
        })

    def elaborate(self, platform):
        m = Module()
        host, axi = self.host, self.axi
        offered = Signal(reset_less=True)                   # a burst is offered
        address = Signal(ADDRESS_BITS, reset_less=True)     # its address
        beats = Signal(8, reset_less=True)                  # its words less one
        owed = Signal(range(self.pending + 1), reset_less=True)     # bursts counted by `pending`
        second = Signal(reset_less=True)    # the words after the page's end are to come
        to_end = self._to_end(host.address)
        crosses = host.burstcount > to_end
        load = Signal()                     # a burst is offered from the next clock on
        ended = axi.rvalid & axi.rlast & (owed != 0)
        m.d.comb += [
            load.eq(host.read & (~offered | axi.arready) & (owed != self.pending)),
            host.waitrequest.eq(~load | crosses & ~second),
            axi.arvalid.eq(offered), axi.araddr.eq(address), axi.arlen.eq(beats),
            *(getattr(axi, f"ar{name}").eq(value)
              for name, value in burst_values(self.data_width).items()),
            axi.rready.eq(1), host.readdata.eq(axi.rdata), host.readdatavalid.eq(axi.rvalid),
            self.failed.eq(axi.rvalid & axi.rresp[1]),
        ]
        m.d.sync += owed.eq(owed + load - ended)
        with m.If(load):
            words = Mux(second, host.burstcount - to_end, Mux(crosses, to_end, host.burstcount))
            page = host.address[PAGE_BITS:]
            m.d.sync += [
                offered.eq(1), beats.eq(words - 1), second.eq(crosses & ~second),
                address.eq(Mux(second, Cat(Const(0, PAGE_BITS), page + 1), host.address)),
            ]
        with m.Elif(axi.arready):
            m.d.sync += offered.eq(0)
        with m.If(self.memory_rst):
            m.d.sync += [offered.eq(0), owed.eq(0), second.eq(0)]
        return m

    def _to_end(self, address):
        """Words from ``address`` to the end of its page.

        A method of its own only so that proofs and tests can break it.
        """
        word_bits = exact_log2(self.data_width // 8)
        return (1 << (PAGE_BITS - word_bits)) - address[word_bits:PAGE_BITS]

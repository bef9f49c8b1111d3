"""AXI4-Lite accesses on an Avalon-MM agent of registers."""

from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from ncdc_hdl.avalon.bus import Agent
from ncdc_hdl.axi.bus import Lite

__all__ = ["LiteBridge"]

_OKAY, _SLVERR = 0b00, 0b10


class LiteBridge(wiring.Component):
    """Does one access at a time: reads and writes in turn where both wait.

    A write counts if all four bytes of its word are enabled; with none it changes nothing, with
    some it changes nothing and is answered by SLVERR, as the registers are words. The lowest two
    bits of an address are not looked at.

    Each access is answered, also one that a reset of the agent falls into, which begins anew behind
    it. ``memory_rst`` is the bus's own reset: with its next clock nothing is offered.

    Timing: an access reaches the agent 2 clocks after it is offered, its answer the bus 1 clock
    after the agent's.

    Parameters
    ----------
    address_bits : int
        Of the agent's word addresses.

    Members
    -------
    axi : ``In(Lite(address_bits + 2))``
    memory_rst : ``In(1)``
    bus : ``Out(Agent(address_bits))``
    """

    def __init__(self, address_bits):
        self.address_bits = address_bits
        super().__init__({"axi": In(Lite(address_bits + 2)), "memory_rst": In(1),
                          "bus": Out(Agent(address_bits))})

    def elaborate(self, platform):
        m = Module()
        axi, bus = self.axi, self.bus

        def kept(shape, name):
            return Signal(shape, name=name, reset_less=True)

        write_place = kept(self.address_bits, "write_place")    # word address of the write
        read_place = kept(self.address_bits, "read_place")      # word address of the read
        word, enable = kept(32, "word"), kept(4, "enable")      # what is to be written
        named = kept(1, "named")            # the address of a write is here
        given = kept(1, "given")            # its word is
        asked = kept(1, "asked")            # the address of a read is
        wrote = kept(1, "wrote")            # the last access was a write
        reading, writing = kept(1, "reading"), kept(1, "writing")   # the agent is asked
        awaiting = kept(1, "awaiting")      # the agent's word is to come
        done = kept(1, "done")              # the write is over, its answer is offered
        failed = kept(1, "failed")          # that answer is an error
        came = kept(1, "came")              # the read's word is offered
        result = kept(32, "result")         # that word
        m.d.comb += [
            axi.awready.eq(~named), axi.wready.eq(~given), axi.arready.eq(~asked),
            axi.bvalid.eq(done), axi.bresp.eq(Mux(failed, _SLVERR, _OKAY)),
            axi.rvalid.eq(came), axi.rresp.eq(_OKAY), axi.rdata.eq(result),
            bus.address.eq(Mux(writing, write_place, read_place)), bus.writedata.eq(word),
            bus.read.eq(reading), bus.write.eq(writing),
        ]
        with m.If(axi.awvalid & ~named):
            m.d.sync += [named.eq(1), write_place.eq(axi.awaddr[2:])]
        with m.If(axi.wvalid & ~given):
            m.d.sync += [given.eq(1), word.eq(axi.wdata), enable.eq(axi.wstrb)]
        with m.If(axi.arvalid & ~asked):
            m.d.sync += [asked.eq(1), read_place.eq(axi.araddr[2:])]

        may_write, may_read = named & given & ~done, asked & ~came
        with m.If(~reading & ~writing & ~awaiting):
            with m.If(may_write & ~(may_read & wrote)):
                m.d.sync += wrote.eq(1)
                with m.If(enable.all()):
                    m.d.sync += writing.eq(1)
                with m.Else():
                    m.d.sync += [done.eq(1), failed.eq(enable.any())]
            with m.Elif(may_read):
                m.d.sync += [reading.eq(1), wrote.eq(0)]
        with m.If(writing & ~bus.waitrequest):
            m.d.sync += [writing.eq(0), done.eq(1), failed.eq(0)]
        with m.If(reading & ~bus.waitrequest):
            m.d.sync += [reading.eq(0), awaiting.eq(1)]
        with m.If(awaiting & bus.readdatavalid):
            m.d.sync += [awaiting.eq(0), came.eq(1), result.eq(bus.readdata)]
        # A reset makes the agent forget a read, so that it is asked again.
        with m.If((reading | awaiting) & self._forgotten(ResetSignal())):
            m.d.sync += [reading.eq(1), awaiting.eq(0), came.eq(0)]
        with m.If(done & axi.bready):
            m.d.sync += [done.eq(0), named.eq(0), given.eq(0)]
        with m.If(came & axi.rready):
            m.d.sync += [came.eq(0), asked.eq(0)]
        with m.If(self.memory_rst):
            m.d.sync += [flag.eq(0) for flag in (named, given, asked, reading, writing, awaiting,
                                                 done, came)]
        return m

    @staticmethod
    def _forgotten(reset):
        """Whether the agent forgets what it was asked.

        A method of its own only so that proofs and tests can break it.
        """
        return reset

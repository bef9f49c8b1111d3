"""AXI4-Lite accesses on an Avalon-MM agent of registers."""

from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from ncdc_hdl.avalon.bus import Agent
from ncdc_hdl.axi.bus import Lite

__all__ = ["LiteBridge"]

_OKAY, _SLVERR = 0b00, 0b10


class LiteBridge(wiring.Component):
    """Does one access at a time: reads and writes alternate if both wait.

    A write counts if all four bytes of its word are enabled. With none it changes nothing. With
    some it changes nothing and gets SLVERR, as the registers are words. The lowest two
    bits of an address are ignored.

    Each access is answered. An access during a reset of the agent begins anew after
    it. ``memory_rst`` is the bus's own reset: from the next clock on nothing is offered.

    Timing: the agent gets an access 2 clocks after its offer, its answer is on the bus 1 clock
    after the agent's.

    Parameters
    ----------
    address_bits : int
        Bits of the agent's word addresses.

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

        def held(shape, name):
            return Signal(shape, name=name, reset_less=True)

        write_address = held(self.address_bits, "write_address")    # word address of the write
        read_address = held(self.address_bits, "read_address")      # word address of the read
        word, enable = held(32, "word"), held(4, "enable")      # what is to be written
        named = held(1, "named")            # the address of a write has come
        given = held(1, "given")            # its word has come
        asked = held(1, "asked")            # the address of a read has come
        wrote = held(1, "wrote")            # the last access was a write
        reading, writing = held(1, "reading"), held(1, "writing")   # the agent is accessed
        awaiting = held(1, "awaiting")      # the agent's word is to come
        done = held(1, "done")              # the write is over, its answer is offered
        failed = held(1, "failed")          # that answer is an error
        came = held(1, "came")              # the read's word is offered
        result = held(32, "result")         # that word
        m.d.comb += [
            axi.awready.eq(~named), axi.wready.eq(~given), axi.arready.eq(~asked),
            axi.bvalid.eq(done), axi.bresp.eq(Mux(failed, _SLVERR, _OKAY)),
            axi.rvalid.eq(came), axi.rresp.eq(_OKAY), axi.rdata.eq(result),
            bus.address.eq(Mux(writing, write_address, read_address)), bus.writedata.eq(word),
            bus.read.eq(reading), bus.write.eq(writing),
        ]
        with m.If(axi.awvalid & ~named):
            m.d.sync += [named.eq(1), write_address.eq(axi.awaddr[2:])]
        with m.If(axi.wvalid & ~given):
            m.d.sync += [given.eq(1), word.eq(axi.wdata), enable.eq(axi.wstrb)]
        with m.If(axi.arvalid & ~asked):
            m.d.sync += [asked.eq(1), read_address.eq(axi.araddr[2:])]

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
        # A reset makes the agent drop a read, so that it is repeated.
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
        """Whether the agent drops its access.

        A method of its own only so that proofs and tests can break it.
        """
        return reset

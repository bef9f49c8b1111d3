"""Avalon-MM hosts on native ports of LiteDRAM, which take a command per word."""

from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.fifo import SyncFIFOBuffered
from amaranth.lib.wiring import In, Out
from amaranth.utils import exact_log2

from ncdc_hdl.avalon.bus import ADDRESS_BITS, ReadHost, WriteHost

__all__ = ["NativePort", "NativeReader", "NativeWriter"]


class NativePort(wiring.Signature):
    """A native port of LiteDRAM, from its user's side; addresses count words.

    A word that is written must be there when the port asks for it, and a word that was read must
    be taken when it comes. The controller waits for neither.
    """

    def __init__(self, data_width):
        word_bits = exact_log2(data_width // 8)
        super().__init__({
            "cmd_valid": Out(1), "cmd_ready": In(1), "cmd_we": Out(1),
            "cmd_addr": Out(ADDRESS_BITS - word_bits),
            "wdata_valid": Out(1), "wdata_ready": In(1), "wdata_data": Out(data_width),
            "wdata_we": Out(data_width // 8),
            "rdata_valid": In(1), "rdata_data": In(data_width),
        })


class NativeReader(wiring.Component):
    """Burst reads as commands of one word each; the controller limits those under way.

    Timing: a burst's first command leaves one clock after the burst was accepted. The others follow
    in each clock in which the controller takes one. The next burst is accepted with the last
    command of the one before. Words have no latency.

    Parameters
    ----------
    data_width : int
    max_burst : int
        Most words of a burst.
    """

    def __init__(self, data_width, max_burst):
        self.word_bits = exact_log2(data_width // 8)
        super().__init__({"bus": In(ReadHost(data_width, max_burst)),
                          "port": Out(NativePort(data_width))})

    def elaborate(self, platform):
        m = Module()
        bus, port = self.bus, self.port
        left = Signal.like(bus.burstcount)      # commands of the burst that are not yet taken
        address = Signal.like(port.cmd_addr)    # word address of the next of them
        m.d.comb += [
            port.cmd_valid.eq(left != 0), port.cmd_addr.eq(address),
            bus.waitrequest.eq(~self._accepts(left, port.cmd_ready)),
            bus.readdata.eq(port.rdata_data), bus.readdatavalid.eq(port.rdata_valid),
        ]
        with m.If(port.cmd_valid & port.cmd_ready):
            m.d.sync += [left.eq(left - 1), address.eq(address + 1)]
        with m.If(bus.read & ~bus.waitrequest):
            m.d.sync += [left.eq(bus.burstcount), address.eq(bus.address[self.word_bits:])]
        return m

    @staticmethod
    def _accepts(left, ready):
        """Whether a burst may come; a method of its own so that a proof can break it."""
        return (left == 0) | (left == 1) & ready


class NativeWriter(wiring.Component):
    """Burst writes as commands of one word each, answered when the controller has the words.

    A word waits in a queue before its command leaves, so that the controller, which does not wait
    for words, never misses one. The answer to a burst comes when its last word was taken. The
    controller keeps the order of commands to a bank, so any later read returns the new
    words.

    Timing: a word's command leaves at least one clock after the word was accepted.

    Parameters
    ----------
    data_width : int
    max_burst : int
    pending : int
        Bursts that may wait for their answer.
    depth : int
        Words of the queue.
    """

    def __init__(self, data_width, max_burst, pending, depth=32):
        self.data_width, self.depth = data_width, depth
        self.word_bits = exact_log2(data_width // 8)
        super().__init__({"bus": In(WriteHost(data_width, max_burst, pending)),
                          "port": Out(NativePort(data_width))})

    def elaborate(self, platform):
        m = Module()
        bus, port = self.bus, self.port
        mask_bits = self.data_width // 8
        m.submodules.commands = commands = SyncFIFOBuffered(width=len(port.cmd_addr),
                                                            depth=self.depth)
        m.submodules.words = words = SyncFIFOBuffered(width=self.data_width + mask_bits + 1,
                                                      depth=self.depth)
        left = Signal.like(bus.burstcount)      # words of the burst that are still to come
        address = Signal.like(port.cmd_addr)    # word address of the next of them
        here = Signal.like(address)             # word address of the word at the host
        last = Signal()                         # it ends its burst
        taken = Signal()                        # it is accepted
        m.d.comb += [
            here.eq(Mux(left == 0, bus.address[self.word_bits:], address)),
            last.eq(Mux(left == 0, bus.burstcount == 1, left == 1)),
            bus.waitrequest.eq(~self._space(commands.w_rdy, words.w_rdy)),
            taken.eq(bus.write & ~bus.waitrequest),
            commands.w_en.eq(taken), commands.w_data.eq(here),
            words.w_en.eq(taken), words.w_data.eq(Cat(bus.writedata, bus.byteenable, last)),
        ]
        with m.If(taken):
            m.d.sync += [left.eq(Mux(left == 0, bus.burstcount, left) - 1), address.eq(here + 1)]
        word, mask, ends = (words.r_data[:self.data_width],
                            words.r_data[self.data_width:self.data_width + mask_bits],
                            words.r_data[-1])
        m.d.comb += [
            port.cmd_valid.eq(commands.r_rdy), port.cmd_we.eq(1),
            port.cmd_addr.eq(commands.r_data),
            commands.r_en.eq(port.cmd_valid & port.cmd_ready),
            port.wdata_valid.eq(words.r_rdy), port.wdata_data.eq(word), port.wdata_we.eq(mask),
            words.r_en.eq(port.wdata_valid & port.wdata_ready),
        ]
        m.d.sync += bus.writeresponsevalid.eq(self._answers(commands.r_en, words.r_en & ends))
        return m

    # Methods of their own only so that a proof can break them.

    @staticmethod
    def _space(for_command, for_word):
        """Whether a word may come."""
        return for_command & for_word

    @staticmethod
    def _answers(command_left, last_taken):
        """Whether a burst is answered in the next clock."""
        return last_taken

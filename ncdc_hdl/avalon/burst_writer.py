"""Burst writes of a word stream to memory."""

from amaranth import *
from amaranth.lib import data, stream, wiring
from amaranth.lib.fifo import SyncFIFOBuffered
from amaranth.lib.wiring import In, Out

from ncdc_hdl.avalon.bus import ADDRESS_BITS, WriteHost

__all__ = ["BurstWriter", "word_layout"]

_BURSTS = 4  # complete bursts that wait for the bus


def word_layout(data_width):
    """A word to write: its bytes, their enables, its byte address, whether the next one is
    elsewhere in memory (``end``), and whether it is the frame's ``last``. A ``void`` one is not
    written; it only marks the end of a frame."""
    return data.StructLayout({"data": data_width, "enable": data_width // 8,
                              "address": ADDRESS_BITS, "end": 1, "last": 1, "void": 1})


class BurstWriter(wiring.Component):
    """Writes words in bursts, which begin anew after each ``end``.

    A burst begins when all of its words are queued, so that it occupies the memory as shortly as
    possible. Bursts follow each other without a gap. All outputs to the bus are registers.

    A burst that has begun is always completed. A reset in its middle drops the words
    and the bursts that have not begun, but not the words that the bus still expects. Those have
    no byte enabled. A memory in reset expects none: ``memory_rst`` ends the burst, and
    prevents others. It comes with a reset of the writer, some clocks earlier or later.

    If the memory answers writes (``pending``), a frame is done with the answer to its last
    burst. Before it, another port of the memory might still read old data. Answers to bursts
    from before a reset are still counted, and end no frame after it.

    Parameters
    ----------
    data_width : int
        Bits of a word.
    burst : int
        Most words of a burst; the queue holds twice as many.
    pending : int
        Bursts that may wait for their answer; 0: the memory does not answer.

    Members
    -------
    i : ``In(stream.Signature(word_layout(data_width)))``
        Addresses are multiples of the word, ascending by a word up to an ``end``; the frame's last
        word is one, void or not.
    memory_rst : ``In(1)``
        The memory drops the burst that has begun.
    done : ``Out(1)``
        High for one clock when the memory has accepted the last word, or answered its burst.
    failed : ``Out(1)``
        High for one clock when the memory answers that a burst has failed.
    bus : ``Out(WriteHost(data_width, burst, pending))``
    """

    latency = 2 + 1
    """Clocks from a burst's last word at ``i`` to its first one on the bus: queues, registers."""

    def __init__(self, data_width, *, burst, pending=0):
        self.data_width, self.burst, self.pending = data_width, burst, pending
        super().__init__({
            "i": In(stream.Signature(word_layout(data_width))),
            "memory_rst": In(1),
            "done": Out(1), "failed": Out(1),
            "bus": Out(WriteHost(data_width, burst, pending)),
        })

    @staticmethod
    def queued(burst):
        """Words that a writer of bursts of so many words holds."""
        return 2 * burst

    def elaborate(self, platform):
        m = Module()
        words = data.StructLayout({"data": self.data_width, "enable": self.data_width // 8})
        bursts = data.StructLayout({"address": ADDRESS_BITS, "count": range(self.burst + 1),
                                    "last": 1})
        m.submodules.words = word_queue = SyncFIFOBuffered(width=words.size,
                                                           depth=self.queued(self.burst))
        m.submodules.bursts = burst_queue = SyncFIFOBuffered(width=bursts.size, depth=_BURSTS)
        self._gather(m, word_queue, burst_queue, bursts)
        self._send(m, word_queue, data.View(words, word_queue.r_data),
                   burst_queue, data.View(bursts, burst_queue.r_data))
        return m

    def _gather(self, m, word_queue, burst_queue, layout):
        """Queue words, and a burst whenever one is complete."""
        i = self.i.p
        count = Signal(range(self.burst))       # words gathered in the clocks before
        address = Signal(ADDRESS_BITS)          # byte address of the first of them
        taken = Signal()                        # the word at ``i`` is taken
        complete = Signal()                     # it completes the burst
        burst = Signal(layout)                  # the burst, that word included unless it is void
        m.d.comb += [
            self.i.ready.eq(word_queue.w_rdy & burst_queue.w_rdy),
            taken.eq(self.i.valid & self.i.ready),
            complete.eq(i.end | (count == self.burst - 1)),
            word_queue.w_data.eq(Cat(i.data, i.enable)),
            word_queue.w_en.eq(taken & ~i.void),
            burst.address.eq(Mux(count == 0, i.address, address)), burst.count.eq(count + ~i.void),
            burst.last.eq(i.last),
            burst_queue.w_data.eq(burst), burst_queue.w_en.eq(taken & complete),
        ]
        with m.If(taken):
            m.d.sync += [count.eq(Mux(complete, 0, count + 1)), address.eq(burst.address)]

    def _send(self, m, word_queue, word, burst_queue, burst):
        """Send one word after the other to the bus."""
        write = Signal(reset_less=True)                     # a word is on the bus
        beat = Signal(word.shape(), reset_less=True)        # the word
        command = Signal(burst.shape(), reset_less=True)    # the burst that it belongs to
        left = Signal(range(self.burst + 1), reset_less=True)   # words of the burst to come
        known = Signal()                             # the burst began after the reset
        frame_end = Signal()                         # the burst is the frame's last
        none = Signal()                              # the burst to come has no word
        nothing = Signal()                           # the burst had no word
        forgotten = (left != 0) & ~known
        m.d.comb += [
            self.bus.write.eq(write), self.bus.writedata.eq(beat.data),
            self.bus.byteenable.eq(beat.enable),
            self.bus.address.eq(command.address), self.bus.burstcount.eq(command.count),
            none.eq(burst.count == 0),
        ]
        accepted = write & ~self.bus.waitrequest & (left == 0)
        may_begin = self._answers(m, burst_queue, burst, write, frame_end, accepted, nothing)
        with m.If(self.memory_rst):
            m.d.sync += [write.eq(0), left.eq(0), frame_end.eq(0), nothing.eq(0)]
        with m.Elif(~write | ~self.bus.waitrequest):
            m.d.sync += [write.eq(0), nothing.eq(0), beat.eq(word)]
            with m.If(left == 0):
                m.d.comb += burst_queue.r_en.eq(may_begin)
                m.d.sync += frame_end.eq(0)
                with m.If(burst_queue.r_rdy & may_begin):
                    m.d.comb += word_queue.r_en.eq(~none)
                    m.d.sync += [command.eq(burst), left.eq(Mux(none, 0, burst.count - 1)),
                                 write.eq(~none), nothing.eq(none), known.eq(1),
                                 frame_end.eq(burst.last)]
            with m.Else():
                m.d.comb += word_queue.r_en.eq(~forgotten)
                m.d.sync += [write.eq(1), left.eq(left - 1)]
                with m.If(forgotten):
                    m.d.sync += beat.enable.eq(0)

    def _answers(self, m, burst_queue, burst, write, frame_end, accepted, nothing):
        """(A frame is done, the next burst may begin now).

        ``accepted``: the last word of the burst on the bus is. ``nothing``: there was a burst of no
        word. It begins only when no answer is due, as it gets none.
        """
        if not self.pending:
            m.d.comb += self.done.eq((accepted | nothing) & frame_end)
            return Const(1)
        due = Signal(range(self.pending + 1), reset_less=True)  # answers that the memory owes
        # Which of them end a frame, the oldest lowest. A reset clears this, but not the answers.
        ends = Signal(self.pending)
        answered = self.bus.writeresponsevalid & (due != 0)
        begun = burst_queue.r_en & burst_queue.r_rdy & (burst.count != 0)
        after = Signal.like(due)            # answers that are due after this clock
        m.d.comb += [
            after.eq(due - answered),
            self.done.eq(answered & ends[0] | nothing & frame_end),
            self.failed.eq(answered & (self.bus.response != 0)),
        ]
        m.d.sync += [due.eq(after + begun),
                     ends.eq((ends >> answered) | Mux(begun & burst.last, 1 << after, 0))]
        with m.If(self.memory_rst):
            m.d.sync += [due.eq(0), ends.eq(0)]
        return Mux(burst.count == 0, ~write & (due == 0), due != self.pending)

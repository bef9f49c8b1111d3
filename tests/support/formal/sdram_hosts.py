"""The SDRAM controller's hosts: whose turn it is, and bursts cut at the ends of rows."""

from amaranth import *
from amaranth.lib import data
from amaranth.lib.wiring import In

from formal.properties import always, given, inner, reached
from formal.wrapper import Wrapper
from ncdc_boards.sdram.arbiter import SdramArbiter
from ncdc_boards.sdram.chips import SdramChip
from ncdc_boards.sdram.layouts import AddressMapping
from ncdc_boards.sdram.segments import Segments

__all__ = ["CHIP", "BurstsCut", "TurnsCome"]

# The smallest chip that has all there is.
CHIP = SdramChip("small", data_bits=8, row_bits=2, column_bits=2, rcd=3, rp=2, ras=3, rc=6, rfc=3,
                 wr=2, rrd=2, mrd=2, ras_max=1000, refresh=100, cas=((2, 1),), source="",
                 pause=.002, refreshes=1)


class TurnsCome(Wrapper):
    """``SdramArbiter`` with hosts that want a turn when they like, and then until they have it.

    Asserts that everybody who waits has a turn after as many of the others' as
    ``SdramArbiter.others`` says, at most. For each host the number of others' turns that may still
    come is a function of the registers, which falls with each of these turns.
    """

    def __init__(self, kind=SdramArbiter, reads=3):
        self.dut = kind(reads)
        super().__init__({"wants": In(reads + 1), "take": In(1)})

    def elaborate(self, platform):
        m = Module()
        dut, count, run = self.dut, self.dut.reads - 1, SdramArbiter.RUN
        fragment = self.design(m, dut)
        video_run, write_run = inner(fragment, "video_run"), inner(fragment, "write_run")
        stays = Signal.like(self.wants, reset_less=True)
        m.d.comb += [dut.wants.eq(self.wants), dut.take.eq(self.take)]
        m.d.sync += stays.eq(self.wants & ~Mux(self.take, dut.grant, 0)
                             & ~ResetSignal().replicate(count + 2))
        given(m, (stays & ~self.wants) == 0)
        always(m, (dut.grant & (dut.grant - 1)) == 0, "one_turn")
        always(m, (dut.grant & ~self.wants) == 0, "who_wants")
        always(m, dut.grant.any() | ~self.wants.any(), "one_if_any")
        always(m, (video_run <= run) & (write_run <= run), "runs")
        most, full = SdramArbiter.others(dut.reads), run * (run + 2)
        video_left = run - video_run                # its turns before another's
        turns = {"video": (count, Mux(video_run == run, 1, 0)),
                 "write": (count + 1, video_left + (Mux(write_run == run, 1 + run, 0)
                                                    if count else 0))}
        if count:
            later = inner(fragment, "later")
            start = Signal(range(count + 1))        # the reader that is looked at first
            m.d.comb += start.eq(count - sum(later))
            always(m, (later == 0) | ((later >> start) << start == later)
                   & ((later >> start) + 1 == (Const(1, 4) << (count - start)[:3])), "later")
        for k in range(count):
            before = Signal(range(count + 1), name=f"before{k}")    # readers before this one
            m.d.comb += before.eq(Mux(start <= k, k - start, k + count - start))
            with m.If(later == 0):
                m.d.comb += before.eq(k)
            turns[f"read{k}"] = (k, video_left + (run - write_run) * (1 + run)
                                 + before * (1 + full))
        for name, (host, left) in turns.items():
            limit = most[name.rstrip("0123456789")]
            passed = Signal(range(limit + 2), name=f"passed_{name}")
            with m.If(~self.wants[host] | (self.take & dut.grant[host])):
                m.d.sync += passed.eq(0)
            with m.Elif(self.take & dut.grant.any()):
                m.d.sync += passed.eq(passed + 1)
            always(m, passed <= limit, f"turn_of_{name}")
            waits = Signal(name=f"waits_{name}")
            m.d.comb += waits.eq(self.wants[host])
            always(m, ~waits | (passed + left <= limit), f"left_of_{name}")
            reached(m, waits & (passed == limit), f"last_{name}")
        return m


class BurstsCut(Wrapper):
    """``Segments`` with any bursts, taken when the sequencer likes.

    Asserts that its segments are the words of the bursts, each once and in order, and that none
    leaves its row; that ``bursts`` is the number of those not over.
    """

    def __init__(self, kind=Segments):
        self.mapping = AddressMapping(CHIP, 8, 4)
        self.dut = kind(self.mapping)
        super().__init__({"valid": In(1), "burst": In(self.mapping.burst), "ready": In(1)})

    def elaborate(self, platform):
        m = Module()
        dut, mapping = self.dut, self.mapping
        fragment = self.design(m, dut)
        waits, valid, rest, end = (inner(fragment, name)
                                   for name in ("waits", "valid", "rest", "end_column"))
        inside = data.View(mapping.burst, inner(fragment, "burst"))
        given(m, (self.burst.words != 0) & (self.burst.words <= mapping.max_burst))
        m.d.comb += [dut.i.valid.eq(self.valid), dut.i.payload.eq(self.burst),
                     dut.o.ready.eq(self.ready)]
        # The bursts taken: the words of the oldest that are to come, and the one after it.
        count = Signal(2)
        first = Signal(mapping.burst)
        second = Signal(mapping.burst)
        taken, cut = dut.i.valid & dut.i.ready, dut.o.valid & dut.o.ready
        segment = dut.o.p
        number = Cat(segment.column, segment.bank, segment.row)
        over = Signal()
        m.d.comb += over.eq(cut & (segment.words == first.words))
        m.d.sync += count.eq(count + taken - over)
        with m.If(over):
            m.d.sync += first.eq(Mux(count == 2, second.as_value(), self.burst.as_value()))
        with m.Elif(cut):
            m.d.sync += [first.word.eq(first.word + segment.words),
                         first.words.eq(first.words - segment.words)]
        with m.Elif(taken & (count == 0)):
            m.d.sync += first.eq(self.burst)
        with m.If(taken):
            m.d.sync += second.eq(self.burst)
        here = dut.o.valid
        always(m, ~here | (count != 0) & (number == first.word), "word_in_turn")
        always(m, ~here | (segment.words != 0) & (segment.words <= first.words), "words")
        always(m, ~here | (segment.column + segment.words <= 1 << mapping.column_bits), "one_row")
        always(m, ~here | (segment.last == (segment.words == first.words)), "last")
        always(m, (count == dut.bursts) & (count == waits + valid), "bursts")
        oldest = Mux(valid, second.as_value(), first.as_value())
        always(m, ~waits | (inside.as_value() == oldest), "waiting")
        always(m, ~waits | (end == inside.word[:mapping.column_bits] + inside.words), "end_column")
        always(m, ~waits | (inside.words != 0) & (inside.words <= mapping.max_burst), "some_words")
        always(m, ~valid | segment.last | (segment.words + rest == first.words) & (rest != 0)
               & (rest < mapping.max_burst)
               & (segment.column + segment.words == 1 << mapping.column_bits), "rest")
        always(m, ~(dut.i.ready & waits), "free")
        reached(m, here & ~segment.last & waits & self.ready, "cut_while_another_waits")
        reached(m, here & (segment.words == mapping.max_burst) & segment.last, "whole_row")
        return m

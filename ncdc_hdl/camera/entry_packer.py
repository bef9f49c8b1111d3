"""Bytes of a row's window, as many as come in a clock, in entries of four."""

from amaranth import *
from amaranth.lib import data, wiring
from amaranth.lib.wiring import In, Out
from amaranth.utils import exact_log2

from ncdc_hdl.camera.layouts import SAMPLES

__all__ = ["EntryPacker"]


class EntryPacker(wiring.Component):
    """Gathers the bytes of each row, from its first one on, in entries of four.

    The bytes of a row that are ``inside`` follow each other without a byte between them. The last
    clock of a row gives two entries if its bytes do not fit one; the second one leaves a clock
    later, while the next row's first bytes may come.

    Timing: ``valid`` is high with the bytes that complete an entry.

    Parameters
    ----------
    count : int
        Bytes per clock: 1, 2 or 4.

    Members
    -------
    data, inside : ``In(ArrayLayout(8, count))``, ``In(count)``
        Bytes, and which of them belong to the row's window.
    turn : ``In(range(max(2, count)))``
        Number of the byte with which a row begins; constant.
    closes : ``In(1)``
        The row ends with these bytes, or has ended before them.
    clear : ``In(1)``
        Forget the bytes gathered before this clock.
    taken : ``In(1)``
        Entries of this clock are taken; of a row's last two both or the first are dropped.
    valid, row_end, o : ``Out(1)``, ``Out(1)``, ``Out(32)``
        An entry is there; it ends a row; its bytes, the first one lowest.
    """

    def __init__(self, count):
        self.count = count
        super().__init__({
            "data": In(data.ArrayLayout(8, count)), "inside": In(count),
            "turn": In(range(max(2, count))), "closes": In(1), "clear": In(1), "taken": In(1),
            "valid": Out(1), "row_end": Out(1), "o": Out(8 * SAMPLES)})

    def elaborate(self, platform):
        m = Module()
        gathered = Signal(data.ArrayLayout(8, SAMPLES - 1))
        have = Signal(range(SAMPLES))   # bytes gathered
        rest = Signal()                 # they are the second entry of a row's end
        older = Mux(self.clear | rest, 0, have)
        total = Signal(range(SAMPLES + self.count))
        more = Signal()                 # bytes are left after this clock's entry
        m.d.comb += [
            total.eq(older + sum(self.inside[k] for k in range(self.count))),
            more.eq(total > SAMPLES),
            self.valid.eq(rest | self.closes | (total >= SAMPLES)),
            self.row_end.eq(rest | self.closes & ~more)]
        for slot in range(SAMPLES):
            # A row's first byte is in slot 0, so each clock's bytes turn by the same number.
            byte = self.data[(self.turn + slot)[:exact_log2(self.count)]]
            new = Mux((slot < total) & ~rest, byte, 0)
            if slot < SAMPLES - 1:
                m.d.comb += self.o.word_select(slot, 8).eq(
                    Mux(slot < have, gathered[slot], new))
                with m.If(~(slot < older) | self.valid):
                    m.d.sync += gathered[slot].eq(byte)
            else:
                m.d.comb += self.o.word_select(slot, 8).eq(new)
        m.d.sync += [
            have.eq(Mux(self.closes & ~more, 0, total)),
            rest.eq(self.closes & more & self.taken)]
        return m

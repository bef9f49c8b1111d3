"""Forwarding between look-ups in the tag stage whose writes are not yet in the memory."""

from amaranth import *
from amaranth.lib import data, wiring
from amaranth.lib.wiring import In, Out

from ncdc_hdl.backend.cache.layouts import tiles_layout

__all__ = ["EARLIER", "Forwarding", "between_layout"]

EARLIER = 5       # earlier look-ups: one in each of the stages R, L, C, D and A


def between_layout(options):
    """For each bank, look-ups between this one and the earlier one with the same entry."""
    return data.ArrayLayout(range(EARLIER), options.tag_banks)


class Forwarding(wiring.Component):
    """Finds earlier look-ups that touch the same entries, and the entries' content after them.

    An entry leaves the memory when its look-up enters stage R. Its read misses what an earlier
    look-up writes later, when it leaves stage A. So each look-up that enters is compared
    with those in the stages R, L, C, D and A. The nearest one that touches an entry decides whether
    that entry will hold the tile, and the read is ignored.

    Timing: the outputs follow ``entering`` after 3 shifts.

    Parameters
    ----------
    options : CacheOptions

    Members
    -------
    shift : ``In(1)``
        All look-ups move on by one stage in this clock.
    entering : ``In(tiles_layout(options))``
        Tiles of the look-up that enters stage R with the next shift.
    r, l, c, d, a : ``In(tiles_layout(options))``
        Tiles of the look-ups in these stages; ``need`` is zero where there is none.
    r_valid, l_valid, c_valid, d_valid : ``In(1)``
        Whether there is a look-up in this stage.

    For the look-up in stage C, if there is one:

    touched : ``Out(tag_banks)``
        Whether an earlier look-up touches the entry.
    between : ``Out(between_layout())``
        Where ``touched``: how many look-ups are between the two.
    known : ``Out(tag_banks)``
        ``hit`` is valid, for any entry in the memory.
    hit : ``Out(tag_banks)``
        Where ``known``: no tile of this bank is needed, or it is in the entry when the look-up
        reaches stage A.
    """

    def __init__(self, options):
        self.options = options
        tiles = tiles_layout(options)
        super().__init__({
            "shift": In(1),
            "entering": In(tiles),
            "r": In(tiles),
            "l": In(tiles),
            "c": In(tiles),
            "d": In(tiles),
            "a": In(tiles),
            "r_valid": In(1),
            "l_valid": In(1),
            "c_valid": In(1),
            "d_valid": In(1),
            "touched": Out(options.tag_banks),
            "between": Out(between_layout(options)),
            "known": Out(options.tag_banks, init=-1),
            "hit": Out(options.tag_banks, init=-1),
        })

    def elaborate(self, platform):
        m = Module()
        # For the look-up in R and an earlier one: `touches`, the entries that the earlier one
        # also touches; `present`, whether both mean the same tile there; `between`, the number of
        # look-ups between the two.
        banks = self.options.tag_banks
        relation = data.StructLayout({"touches": banks, "present": banks,
                                      "between": range(EARLIER)})
        # R: a relation to each earlier look-up, the nearest one first.
        r_earlier = Signal(data.ArrayLayout(relation, EARLIER), reset_less=True)
        self._relate(m, r_earlier)

        # L: result of the nearest one that touches the entry, as in the members.
        l_touched = Signal(banks)
        l_between = Signal.like(self.between)
        l_known = Signal.like(self.known)
        l_hit = Signal.like(self.hit)
        with m.If(self.shift):
            for bank in range(banks):
                touched, present, between = self._nearest(r_earlier, bank)
                unneeded = ~self.r_valid | ~self.r.need[bank]
                m.d.sync += [
                    l_touched[bank].eq(touched),
                    l_between[bank].eq(between),
                    l_known[bank].eq(unneeded | touched),
                    l_hit[bank].eq(unneeded | present),
                ]
            # C: passed on.
            m.d.sync += [self.touched.eq(l_touched), self.between.eq(l_between),
                         self.known.eq(l_known), self.hit.eq(l_hit)]
        return m

    def _relate(self, m, r_earlier):
        """Compare the look-up that enters with those in all stages."""
        nearer = []         # whether there is a look-up in each of the stages so far
        for relation, other, valid in zip(
                r_earlier, (self.r, self.l, self.c, self.d, self.a),
                (self.r_valid, self.l_valid, self.c_valid, self.d_valid, None)):
            with m.If(self.shift):
                m.d.sync += relation.between.eq(sum(nearer, start=Const(0)))
                for bank in range(self.options.tag_banks):
                    px, py = bank & 1, bank >> 1
                    same_set = ((self.entering.set_x[px] == other.set_x[px])
                                & (self.entering.set_y[py] == other.set_y[py]))
                    same_pair = ((self.entering.pair_x[px] == other.pair_x[px])
                                 & (self.entering.pair_y[py] == other.pair_y[py]))
                    m.d.sync += [relation.touches[bank].eq(other.need[bank] & same_set),
                                 relation.present[bank].eq(same_pair)]
            nearer.append(valid)

    @staticmethod
    def _nearest(r_earlier, bank):
        """(Whether an earlier look-up touches the entry, ``present`` and ``between`` of the nearest
        one that does.)"""
        touched, present, between = Const(0, 1), Const(0, 1), Const(0, range(EARLIER))
        for relation in reversed(list(r_earlier)):
            touches = relation.touches[bank]
            touched = touched | touches
            present = Mux(touches, relation.present[bank], present)
            between = Mux(touches, relation.between, between)
        return touched, present, between

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
    with those in the stages R, L, C, D and A, coordinate by coordinate; in stage R, bank by bank.
    The nearest one that touches an entry decides whether that entry will hold the tile, and the
    read is ignored.

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
    l_valid, c_valid, d_valid, a_valid : ``In(1)``
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
            "l_valid": In(1),
            "c_valid": In(1),
            "d_valid": In(1),
            "a_valid": In(1),
            "touched": Out(options.tag_banks),
            "between": Out(between_layout(options)),
            "known": Out(options.tag_banks, init=-1),
            "hit": Out(options.tag_banks, init=-1),
        })

    def elaborate(self, platform):
        m = Module()
        # For the look-up in L and an earlier one: `touches`, the entries that the earlier one
        # also touches; `present`, whether both mean the same tile there; `between`, the number of
        # look-ups between the two. The nearest one first.
        banks = self.options.tag_banks
        relation = data.StructLayout({"touches": banks, "present": banks,
                                      "between": range(EARLIER)})
        l_earlier = Signal(data.ArrayLayout(relation, EARLIER), reset_less=True)
        self._relate(m, l_earlier, self._compare(m))

        # C: result of the nearest one that touches the entry, as in the members.
        with m.If(self.shift):
            for bank in range(banks):
                touched, present, between = self._nearest(l_earlier, bank)
                unneeded = ~self.l_valid | ~self.l.need[bank]
                m.d.sync += [
                    self.touched[bank].eq(touched),
                    self.between[bank].eq(between),
                    self.known[bank].eq(unneeded | touched),
                    self.hit[bank].eq(unneeded | present),
                ]
        return m

    def _compare(self, m):
        """Compare the look-up that enters with those in all stages.

        Returns, for the look-up in R and each earlier one, the nearest first, whether their sets
        and their pairs are the same, by column and by row of tiles.
        """
        tiles = tiles_layout(self.options).members
        same = data.StructLayout({name: tiles[name].length
                                  for name in ("set_x", "set_y", "pair_x", "pair_y")})
        r_same = Signal(data.ArrayLayout(same, EARLIER), reset_less=True)
        with m.If(self.shift):
            for relation, other in zip(r_same, (self.r, self.l, self.c, self.d, self.a)):
                m.d.sync += [relation[name][k].eq(self.entering[name][k] == other[name][k])
                             for name, shape in same.members.items() for k in range(shape)]
        return r_same

    def _relate(self, m, l_earlier, r_same):
        """Join the comparisons of the look-up in R bank by bank."""
        # The one that was in A when that look-up entered has left. The others are a stage on.
        gone_need = Signal.like(self.a.need)
        needs = self.l.need, self.c.need, self.d.need, self.a.need, gone_need
        nearer = []         # whether there is a look-up in each of the stages so far
        with m.If(self.shift):
            m.d.sync += gone_need.eq(self.a.need)
            for relation, same, need, valid in zip(
                    l_earlier, r_same, needs,
                    (self.l_valid, self.c_valid, self.d_valid, self.a_valid, None)):
                m.d.sync += relation.between.eq(sum(nearer, start=Const(0)))
                for bank in range(self.options.tag_banks):
                    px, py = bank & 1, bank >> 1
                    m.d.sync += [
                        relation.touches[bank].eq(need[bank] & same.set_x[px] & same.set_y[py]),
                        relation.present[bank].eq(same.pair_x[px] & same.pair_y[py])]
                nearer.append(valid)

    @staticmethod
    def _nearest(l_earlier, bank):
        """(Whether an earlier look-up touches the entry, ``present`` and ``between`` of the nearest
        one that does.)"""
        touched, present, between = Const(0, 1), Const(0, 1), Const(0, range(EARLIER))
        for relation in reversed(list(l_earlier)):
            touches = relation.touches[bank]
            touched = touched | touches
            present = Mux(touches, relation.present[bank], present)
            between = Mux(touches, relation.between, between)
        return touched, present, between

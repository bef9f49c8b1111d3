"""A pass: the views of a list, one after the other."""

from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from ncdc_spec.view_list import MAX_VIEWS

__all__ = ["ViewPass"]

class ViewPass(wiring.Component):
    """Begins each view of a list when the view before it is over and its entry is loaded.

    A pass with a number of views beyond its limits has one view, which the checks of its set
    reject. An abort ends the view under way, and with it the pass.

    Parameters
    ----------
    views : int
        Most views of a pass.

    Members
    -------
    start : ``In(1)``
        A pass begins; none is under way.
    count : ``In(4)``
        Its views; constant during a pass.
    load, entry, loaded : ``Out(1)``, ``Out(range(views))``, ``In(1)``
        To and from a :class:`ViewStore`.
    begin, first : ``Out(1)``, ``Out(1)``
        ``begin`` is high for one clock when a view begins, ``first`` during the first one.
    ended, cut : ``In(1)``, ``In(1)``
        The view is over, and lacks pixels.
    abort : ``In(1)``
    over, lacks : ``Out(1)``, ``Out(1)``
        In the clock of the last view's ``ended``: the pass is over, and a view of it lacks pixels.
    done : ``Out(range(views + 1))``
        Views that are over, of this pass or the last one.
    """

    def __init__(self, views):
        self.views = views
        super().__init__({
            "start": In(1), "count": In(range(MAX_VIEWS + 1)), "load": Out(1),
            "entry": Out(range(views)), "loaded": In(1), "begin": Out(1), "first": Out(1),
            "ended": In(1), "cut": In(1), "abort": In(1), "over": Out(1), "lacks": Out(1),
            "done": Out(range(views + 1))})

    def elaborate(self, platform):
        m = Module()
        last = Signal()                 # no view follows
        lacked = Signal()               # a view before this one lacks pixels
        m.d.comb += [self.first.eq(self.entry == 0), self.lacks.eq(lacked | self.cut)]
        m.d.sync += last.eq((self.entry + 1 >= self.count) | (self.count > self.views))
        with m.FSM():
            with m.State("REST"):
                with m.If(self.start):
                    m.d.sync += [self.entry.eq(0), self.done.eq(0), lacked.eq(0)]
                    m.next = "LOAD"
            with m.State("LOAD"):
                m.d.comb += self.load.eq(1)
                with m.If(self.loaded):
                    m.next = "BEGIN"
            with m.State("BEGIN"):
                m.d.comb += self.begin.eq(1)
                m.next = "VIEW"
            with m.State("VIEW"):
                with m.If(self.ended):
                    m.d.sync += [self.done.eq(self.done + 1), lacked.eq(self.lacks)]
                    with m.If(last | self.abort):
                        m.d.comb += self.over.eq(1)
                        m.next = "REST"
                    with m.Else():
                        m.d.sync += self.entry.eq(self.entry + 1)
                        m.next = "LOAD"
        return m

"""Properties, and the signals they speak of."""

from amaranth import *
from amaranth.hdl import Assert, Assume, Cover

__all__ = ["Property", "always", "constant", "given", "inner", "reached"]


def inner(fragment, *path):
    """The signal at ``path`` (parts of the design, then the name) inside an elaborated design.

    What a proof by induction says of the state needs signals that are no other module's concern.
    """
    for name in path[:-1]:
        fragment = fragment.find_subfragment(name)
    found = {id(signal): signal for statements in fragment.statements.values()
             for statement in statements for signal in statement._lhs_signals()
             if signal.name == path[-1]}
    if len(found) != 1:
        raise LookupError(f"the design has {len(found)} signals {'.'.join(path)}")
    return found.popitem()[1]


class Property(Elaboratable):
    """One assertion or cover, a part of the design so that the tools know its name."""

    only = None     # the name of the one assertion that is made, or None for all

    def __init__(self, kind, condition, name):
        self.kind, self.condition, self.name, self.holds = kind, condition, name, Signal()

    def elaborate(self, platform):
        m = Module()
        m.d.comb += self.holds.eq(self.condition)
        if self.kind is Cover or self.only in (None, self.name):
            m.d.comb += self.kind(self.holds)
        return m


def always(m, condition, name):
    """Assert ``condition`` in every clock."""
    m.submodules[name] = Property(Assert, condition, name)


def given(m, condition):
    """Assume ``condition`` in every clock."""
    holds = Signal()
    m.d.comb += [holds.eq(condition), Assume(holds)]


def reached(m, condition, name):
    """Cover ``condition``."""
    m.submodules[name] = Property(Cover, condition, name)


def constant(m, signal):
    """Assume that a free input is the same in all clocks."""
    before, later = Signal.like(signal, reset_less=True), Signal(reset_less=True)
    m.d.sync += [before.eq(signal), later.eq(1)]
    given(m, ~later | (signal == before))

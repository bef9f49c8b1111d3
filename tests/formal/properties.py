"""What the wrappers have in common."""

from unittest import mock

from amaranth import *
from amaranth.hdl import Assert, Assume, Cover, Fragment
from amaranth.lib import wiring
from amaranth.lib.fifo import SyncFIFOBuffered

__all__ = ["Property", "Wrapper", "always", "constant", "given", "inner", "reached"]


def inner(fragment, *path):
    """The signal at ``path`` (parts of the design, then the name) inside an elaborated design.

    What a proof by induction says of the state needs signals that are nobody else's concern.
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


class Wrapper(wiring.Component):
    """A design with its free inputs as members; ``elaborate`` adds what is assumed and asserted.

    Registers of a wrapper that belong to the world outside are not reset with the design.

    Attributes
    ----------
    queues : list of SyncFIFOBuffered
        The queues of the design, in the order in which it has them.
    initial : dict
        Values with which registers (paths as of :func:`inner`) begin, if not with their own.
    places_missing : int
        Planted error: each queue has fewer places by so many.
    forgotten : sequence of tuple of str
        Planted error: registers that a reset clears.
    """

    initial = {}
    places_missing = 0
    forgotten = ()

    def design(self, m, component):
        """Add ``component`` and return its elaborated form, for :func:`inner`.

        Each queue in it asserts that nothing is written into it while it is full.
        """
        self.queues = []
        create, elaborate = SyncFIFOBuffered.__init__, SyncFIFOBuffered.elaborate

        def smaller(queue, *, width, depth):
            create(queue, width=width, depth=depth - self.places_missing)

        def checked(queue, platform):
            within = elaborate(queue, platform)
            self.queues.append(queue)
            always(within, ~queue.w_en | queue.w_rdy, "no_overflow")
            # Its registers, for induction: what is in it is in the memory or at the output.
            kept = queue.level - queue.r_rdy
            always(within, (queue.level >= queue.r_rdy) & (kept <= max(1, queue.depth - 1)), "kept")
            always(within, queue.r_rdy | (kept <= 1), "output_first")
            if queue.depth > 1:
                rows = [within.submodules.storage.read_port(domain="comb")
                        for _ in range(queue.depth - 1)]
                within.d.comb += [port.addr.eq(row) for row, port in enumerate(rows)]
                queue.rows = [port.data for port in rows]
            within = Fragment.get(within, platform)
            queue.pointers = inner(within, "consume"), inner(within, "produce")
            return within

        with (mock.patch.object(SyncFIFOBuffered, "elaborate", checked),
              mock.patch.object(SyncFIFOBuffered, "__init__", smaller)):
            fragment = Fragment.get(component, None)
        for path, value in self.initial.items():
            inner(fragment, *path)._init = value
        for path in self.forgotten:
            inner(fragment, *path)._reset_less = False
        m.submodules.dut = fragment
        return fragment

    @staticmethod
    def items(m, queue):
        """(Whether it is there, item) of each place in a queue of at least three."""
        (consume, produce), rows = queue.pointers, queue.depth - 1
        kept = queue.level - queue.r_rdy
        end = consume + kept
        always(m, (consume < rows) & (produce == Mux(end >= rows, end - rows, end)),
               f"pointers{len(queue.r_data)}")
        places = [(queue.r_rdy, queue.r_data)]
        for row, item in enumerate(queue.rows):
            behind = Mux(consume <= row, row - consume, row + rows - consume)
            places.append((behind < kept, item))
        return places


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

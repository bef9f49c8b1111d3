"""What the wrappers around the designs have in common."""

from amaranth import *
from amaranth.hdl import Fragment
from amaranth.lib import wiring

from formal.properties import inner
from formal.queue_state import opened

__all__ = ["Wrapper"]


class Wrapper(wiring.Component):
    """A design with its free inputs as members; ``elaborate`` adds what is assumed and asserted.

    Registers of a wrapper that belong to the world outside are not reset with the design.

    Attributes
    ----------
    queues : list of SyncFIFOBuffered or Fifo
        The queues of the design, in the order in which it has them.
    initial : dict
        Values with which registers (paths as of :func:`inner`) begin, if not with their own.
    entries_missing : int
        Planted error: each queue has fewer entries by so many.
    forgotten : sequence of tuple of str
        Planted error: registers that a reset clears.
    """

    initial = {}
    entries_missing = 0
    forgotten = ()

    def design(self, m, component):
        """Add ``component`` and return its elaborated form, for :func:`inner`.

        Each queue in it asserts that nothing is written into it while it is full.
        """
        self.queues = []
        with opened(self.queues, self.entries_missing):
            fragment = Fragment.get(component, None)
        for path, value in self.initial.items():
            inner(fragment, *path)._init = value
        for path in self.forgotten:
            inner(fragment, *path)._reset_less = False
        m.submodules.dut = fragment
        return fragment

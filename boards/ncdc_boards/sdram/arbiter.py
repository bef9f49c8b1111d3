"""SdramArbiter of the controller's hosts."""

from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

__all__ = ["SdramArbiter"]


class SdramArbiter(wiring.Component):
    """Chooses among hosts that request a segment.

    The order is the video reader, the writer, then the other readers in turn. But with another
    host waiting the video reader has at most ``RUN`` turns in a row. With a reader waiting the
    writer has at most ``RUN`` until one of them has had one. So no host starves:
    :meth:`others` gives the most turns of others before its own.

    Timing: no latency.

    Parameters
    ----------
    reads : int
        Readers, the video reader among them.

    Members
    -------
    wants : ``In(reads + 1)``
        A bit for each reader, the video reader's after the others, then the writer's.
    take : ``In(1)``
        ``grant`` counts in this clock.
    grant : ``Out(reads + 1)``
        At most one bit: the host that has its turn.
    """

    RUN = 2

    def __init__(self, reads):
        self.reads = reads
        super().__init__({"wants": In(reads + 1), "take": In(1), "grant": Out(reads + 1)})

    @classmethod
    def others(cls, reads):
        """{host: most turns of others from the clock of its request to its own turn}.

        Hosts are "video", "write" and "read". While the video reader waits, one turn of another
        host may be due. Between two turns that are not the video reader's it has ``RUN``, between
        two of the other readers the writer has ``RUN``.
        """
        run, others = cls.RUN, reads - 1
        write = run + (1 + run if others else 0)
        round_ = run * (run + 1) + run      # turns before one of a reader
        return {"video": 1, "write": write, "read": others * round_ + others - 1}

    def elaborate(self, platform):
        m = Module()
        count = self.reads - 1              # readers but for the video's
        readers, video, write = self.wants[:count], self.wants[count], self.wants[count + 1]
        video_run = Signal(range(self.RUN + 1))     # turns of the video reader in a row
        write_run = Signal(range(self.RUN + 1))     # turns of the writer since a reader's
        later = Signal(count)               # readers after the one served last
        others = Signal()                   # a host other than the video reader waits
        following = Signal(count)              # the first of these that waits
        first = Signal(count)               # the first of all readers that wait
        m.d.comb += [others.eq(readers.any() | write), following.eq(_lowest(readers & later)),
                     first.eq(_lowest(readers))]
        video_now = Signal()                # it is the video reader's turn
        write_now = Signal()                # it is the writer's
        m.d.comb += [
            video_now.eq(video & ~(self._enough(video_run) & others)),
            write_now.eq(write & ~video_now & ~(self._enough(write_run) & readers.any())),
            self.grant[count].eq(video_now), self.grant[count + 1].eq(write_now),
        ]
        with m.If(~video_now & ~write_now):
            m.d.comb += self.grant[:count].eq(Mux(following.any(), following, first))
        with m.If(self.take):
            m.d.sync += video_run.eq(Mux(video_now & others, video_run + 1, 0))
            with m.If(write_now):
                m.d.sync += write_run.eq(Mux(readers.any(), write_run + 1, 0))
            with m.If(self.grant[:count].any()):
                m.d.sync += [write_run.eq(0), later.eq(_above(self.grant[:count]))]
        return m

    def _enough(self, run):
        """Whether a host has used its turns in a row.

        A method of its own only so that proofs and tests can break it.
        """
        return run == self.RUN


def _lowest(bits):
    """The lowest bit that is set; all others are 0."""
    return bits & -bits if len(bits) else bits


def _above(one):
    """Ones in all bits above the one that is set in ``one``."""
    return Cat(one[:k].any() if k else Const(0, 1) for k in range(len(one)))

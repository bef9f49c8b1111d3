"""Assigns buffers to a writer and to readers, so that no frame is torn."""

from functools import reduce
from operator import or_

from amaranth import *
from amaranth.lib import data, wiring
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

__all__ = ["FRAME", "FrameStore", "buffers_for"]

FRAME = data.StructLayout({"number": 32, "time": 64})
"""Number of a frame, from 1 on, and clocks from the reset to its beginning."""


def buffers_for(readers):
    """Number of buffers so that the writer always has one: the one it fills, the newest frame,
    and one that each of the ``readers`` may hold."""
    return readers + 2


class FrameStore(wiring.Component):
    """Gives buffers to one writer and to readers.

    The writer begins a frame in a free buffer, and ends it. A good frame becomes the
    newest; a bad one is dropped, and so is a good one that a newer one replaces before a claim. A
    reader always gets the newest, and may miss frames but never waits for one. The buffer stays
    the reader's until it releases it or claims anew, or until it has held it for ``limit`` clocks.
    Then it is ``lost``, and the data read may be of two frames.

    The first reader may start early: with ``follow`` its claim is for the frame that is being
    written, good or bad.

    Timing: a request takes effect in the next clock. The writer's ``buffer`` holds while
    ``busy``, a reader's while ``held``.

    Parameters
    ----------
    readers : int
    looks : int

    Members
    -------
    begins : ``In(1)``
        The writer begins a frame; it does not while it is ``busy``.
    ends, good : ``In(1)``, ``In(1)``
        The writer ends the frame, which is complete and correct if ``good``.
    about : ``In(FRAME)``
        Stored with the frame that begins.
    busy, buffer : ``Out(1)``, ``Out(range(buffers))``
    newest, some : ``Out(range(buffers))``, ``Out(1)``
        The newest complete frame, if there is one.
    came : ``Out(1)``
        High for one clock when ``newest`` has changed.
    readers : array of reader
        ``claim`` and ``release`` last for one clock; ``held`` says that the claimed ``buffer`` is
        this reader's, ``lost`` that it was taken away, until the next claim or release.
    follow : ``In(1)``
        The first reader's claim is for the frame that is being written, if there is one.
    limit : ``In(32)``
        Clocks that a reader may hold a buffer; 0: for ever.
    looks : array of look
        ``frame`` was stored with the frame begun last in ``buffer``; one clock later.
    begun, bad, taken : ``Out(32)``, ``Out(32)``, ``Out(32)``
        Frames begun, ended as bad, and buffers taken from readers since the reset.
    """
    def __init__(self, readers, looks=1):
        self.buffers = buffers_for(readers)
        index = range(self.buffers)
        reader = wiring.Signature({"claim": Out(1), "release": Out(1), "held": In(1),
                                   "buffer": In(index), "lost": In(1)})
        look = wiring.Signature({"buffer": Out(index), "frame": In(FRAME)})
        super().__init__({
            "begins": In(1), "ends": In(1), "good": In(1), "about": In(FRAME),
            "busy": Out(1), "buffer": Out(index),
            "newest": Out(index), "some": Out(1), "came": Out(1),
            "readers": In(reader).array(readers), "follow": In(1), "limit": In(32),
            "looks": In(look).array(looks),
            "begun": Out(32), "bad": Out(32), "taken": Out(32),
        })

    def elaborate(self, platform):
        m = Module()
        free = Signal(self.buffers)             # a bit for each free buffer
        first = Signal(range(self.buffers))     # the first of them
        used = [(self.some, self.newest), (self.busy, self.buffer),
                *((self._has(one, k), one.buffer) for k, one in enumerate(self.readers))]
        for k in range(self.buffers):
            m.d.comb += free[k].eq(~reduce(or_, (there & (at == k) for there, at in used)))
        for k in reversed(range(self.buffers)):
            with m.If(free[k]):
                m.d.comb += first.eq(k)

        begun, ended = Signal(), Signal()
        m.d.comb += [begun.eq(self.begins & ~self.busy), ended.eq(self.ends & self.busy)]
        m.d.sync += self.came.eq(ended & self.good)
        with m.If(begun):
            m.d.sync += [self.busy.eq(1), self.buffer.eq(first), self.begun.eq(self.begun + 1)]
        with m.If(ended):
            m.d.sync += self.busy.eq(0)
            with m.If(self.good):
                m.d.sync += [self.newest.eq(self.buffer), self.some.eq(1)]
            with m.Else():
                m.d.sync += self.bad.eq(self.bad + 1)
        taken = [self._reader(m, one, k) for k, one in enumerate(self.readers)]
        m.d.sync += self.taken.eq(self.taken + sum(taken))
        self._frames(m, begun, first)
        return m

    def _reader(self, m, one, number):
        """Claim, release and time of a reader; high when its buffer is taken away."""
        left = Signal(32, name=f"left{number}")         # clocks until the buffer is taken away
        taken = Signal(name=f"taken{number}")
        m.d.comb += taken.eq(one.held & (self.limit != 0) & (left == 0)
                             & ~one.claim & ~one.release)
        m.d.sync += left.eq(left - 1)
        with m.If(taken):
            m.d.sync += [one.held.eq(0), one.lost.eq(1)]
        with m.If(one.release):
            m.d.sync += [one.held.eq(0), one.lost.eq(0)]
        with m.If(one.claim):
            m.d.sync += [one.held.eq(self.some), one.lost.eq(0),
                         one.buffer.eq(self._claimed(self.newest, self.buffer)),
                         left.eq(self.limit - 1)]
            if number == 0:
                with m.If(self.follow):
                    m.d.sync += [one.held.eq(self.busy), one.buffer.eq(self.buffer)]
        return taken

    @staticmethod
    def _has(one, number):
        """Whether the reader has a buffer. A method of its own only so that proofs can break it."""
        return one.held

    @staticmethod
    def _claimed(newest, writers):
        """The buffer that a reader gets, of the newest frame and the one being written.

        A method of its own only so that proofs can break it.
        """
        return newest

    def _frames(self, m, begun, first):
        """Store number and time of the frame in each buffer."""
        m.submodules.frames = frames = Memory(shape=FRAME, depth=self.buffers, init=[])
        write = frames.write_port()
        m.d.comb += [write.addr.eq(first), write.en.eq(begun), write.data.eq(self.about)]
        for look in self.looks:
            read = frames.read_port()
            m.d.comb += [read.addr.eq(look.buffer), look.frame.eq(read.data)]

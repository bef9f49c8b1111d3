"""Search for the delay of each lane at which its bits are sampled in the middle of their eye."""

from amaranth import *
from amaranth.lib import data, wiring
from amaranth.lib.cdc import FFSynchronizer
from amaranth.lib.wiring import In, Out

from ncdc_hdl.lib.pipeline import register

__all__ = ["EYE", "EyeSearch"]

_MIN_STEPS = 3          # of an eye
_WATCHED = 256          # bursts
_MAX_BAD = 16           # of them, with which the delays stay

EYE = data.StructLayout({"step": 8, "width": 8})
"""The middle of the eye, and how many delays are right, in steps."""


class _LongestRun(wiring.Component):
    """The longest run of steps that are right.

    Members
    -------
    clear : ``In(1)``
    step, right : ``In(8)``, ``In(1)``
    valid : ``In(1)``
        ``right`` is known of this step.
    eye : ``Out(EYE)``
    """

    def __init__(self):
        super().__init__({"clear": In(1), "step": In(8), "right": In(1), "valid": In(1),
                          "eye": Out(EYE)})

    def elaborate(self, platform):
        m = Module()
        run = Signal(8)
        with m.If(self.clear):
            m.d.sync += [run.eq(0), self.eye.eq(0)]
        with m.Elif(self.valid):
            m.d.sync += run.eq(Mux(self.right, run + 1, 0))
            with m.If(self.right & (run >= self.eye.width)):
                m.d.sync += [self.eye.width.eq(run + 1), self.eye.step.eq(self.step - (run >> 1))]
        return m


class EyeSearch(wiring.Component):
    """Starts the deserialisers, then steps the delays of all lanes and counts good bursts.

    A step is right for a lane if all of ``bursts`` bursts begin with their sync byte. The middle of
    the longest run of right steps is chosen for each lane. A search begins anew if a lane has no
    such run, if no burst comes for ``timeout`` clocks, or if more than 16 of 256 bursts are bad
    later on. Each search begins with a stop and a reset of the deserialisers, so that all of them
    begin with the same edge of the lanes' clock.

    Parameters
    ----------
    lanes : int
    steps : int
        Delays that are tried, from 0 on; 256 at most.
    bursts : int
        Bursts of a step, after one that is ignored.
    stride : int
        Pulses of ``move`` from step to step.
    timeout : int
        In clocks of ``sync``; longer than the pause between two frames.
    domain : str
        Clock domain of the bursts.

    Members
    -------
    ended, good : ``In(lanes)``
        In ``domain``: as of :class:`BurstCheck`.
    stop, reset : ``Out(1)``
        Of the clock of the lanes, and of the deserialisers.
    load_n, move : ``Out(1)``, ``Out(lanes)``
        Low: all delays are 0. The end of a pulse: one more.
    ready : ``Out(1)``
        The delays are chosen.
    eyes : ``Out(EYE).array(lanes)``
    failures : ``Out(8)``
        Searches without a result, modulo 256.
    """

    def __init__(self, lanes, *, steps=128, bursts=16, stride=1, timeout=1 << 27,
                 domain="camera"):
        self.lanes, self.steps, self.bursts, self.stride = lanes, steps, bursts, stride
        self.timeout, self.domain = timeout, domain
        super().__init__({
            "ended": In(lanes), "good": In(lanes), "stop": Out(1, init=1),
            "reset": Out(1, init=1), "load_n": Out(1), "move": Out(lanes), "ready": Out(1),
            "eyes": Out(EYE).array(lanes), "failures": Out(8)})

    def elaborate(self, platform):
        m = Module()
        ended, good = self._crossed(m)
        step, position = Signal(range(self.steps)), Signal(range(self.steps))
        clocks, pulses = Signal(6), Signal(range(self.stride))
        phase = Signal(3)                       # of a pulse
        clear, measured = Signal(), Signal()    # of the eyes; a step is over
        done, right = self._measured(m, ended, good, clear)
        eyes = self._eyes(m, step, right, measured, clear)
        fine = Cat(eye.width >= _MIN_STEPS for eye in eyes).all()
        late, unstable = self._late(m, ended[0]), self._unstable(m, ended, good)
        m.d.sync += [clocks.eq(0), phase.eq(0), self.move.eq(0), self.ready.eq(0)]
        with m.FSM():
            with m.State("START"):
                m.d.comb += clear.eq(1)
                m.d.sync += [clocks.eq(clocks + 1), step.eq(0), self.stop.eq(clocks < 48),
                             self.reset.eq((clocks >= 16) & (clocks < 32)),
                             self.load_n.eq(clocks >= 16)]
                with m.If(clocks.all()):
                    m.next = "MEASURE"
            with m.State("MEASURE"):
                with m.If(late):
                    m.next = "START"
                with m.Elif(done):
                    m.d.comb += measured.eq(1)
                    m.next = "STEP"
            with m.State("STEP"):
                m.d.sync += [step.eq(step + 1), position.eq(0)]
                m.next = "MOVE"
                with m.If(step == self.steps - 1):
                    m.next = "LOAD"
                    with m.If(~fine):
                        m.d.sync += self.failures.eq(self.failures + 1)
                        m.next = "START"
            with m.State("MOVE"):
                m.d.sync += self.move.eq(~phase[2].replicate(self.lanes))
                with m.If(self._pulsed(m, phase, pulses)):
                    m.next = "MEASURE"
            with m.State("LOAD"):
                m.d.sync += [clocks.eq(clocks + 1), self.load_n.eq(clocks >= 16)]
                with m.If(clocks.all()):
                    m.next = "SET"
            with m.State("SET"):
                m.d.sync += self.move.eq(Cat((position < eye.step) & ~phase[2] for eye in eyes))
                with m.If(self._pulsed(m, phase, pulses)):
                    m.d.sync += position.eq(position + 1)
                    with m.If(position == self.steps - 1):
                        m.next = "READY"
            with m.State("READY"):
                m.d.sync += self.ready.eq(1)
                with m.If(unstable):
                    m.next = "START"
        return m

    def _crossed(self, m):
        """Whether a burst ended on each lane, in ``sync``; whether it was good, then."""
        ended, good = Signal(self.lanes), Signal(self.lanes)
        for k in range(self.lanes):
            change, seen = Signal(name=f"change{k}"), Signal(name=f"seen{k}")
            with m.If(self.ended[k]):
                m.d[self.domain] += change.eq(~change)
            m.submodules[f"change{k}"] = FFSynchronizer(change, seen)
            m.submodules[f"good{k}"] = FFSynchronizer(self.good[k], good[k])
            before = register(m, f"before{k}", seen, reset_less=False)
            # A clock later: `good` changes with `change`, and may cross a clock after it.
            m.d.sync += ended[k].eq(seen ^ before)
        return ended, good

    def _measured(self, m, ended, good, clear):
        """The bursts of a step have come; whether each lane's were all good."""
        count, done = Signal(range(self.bursts + 2)), Signal()
        some, bad = Signal(self.lanes), Signal(self.lanes)
        m.d.comb += done.eq(ended[0] & (count == self.bursts + 1))
        m.d.sync += [some.eq(some | ended & good), bad.eq(bad | ended & ~good)]
        with m.If(ended[0]):
            m.d.sync += count.eq(count + 1)
        with m.If(clear | done):
            m.d.sync += count.eq(0)
        # The first one was under way when the delay changed.
        with m.If(clear | ended[0] & (count == 0)):
            m.d.sync += [some.eq(0), bad.eq(0)]
        return done, some & ~bad

    def _eyes(self, m, step, right, measured, clear):
        """The eye of each lane, from the steps so far."""
        for k, eye in enumerate(self.eyes):
            m.submodules[f"run{k}"] = run = _LongestRun()
            m.d.comb += [run.clear.eq(clear), run.step.eq(step), run.right.eq(right[k]),
                         run.valid.eq(measured), eye.eq(run.eye)]
        return self.eyes

    def _pulsed(self, m, phase, pulses):
        """Go on with a pulse; whether the last one of a step ends."""
        m.d.sync += phase.eq(phase + 1)
        with m.If(phase.all()):
            m.d.sync += pulses.eq(Mux(pulses == self.stride - 1, 0, pulses + 1))
        return phase.all() & (pulses == self.stride - 1)

    def _late(self, m, ended):
        """No burst has come for a long time."""
        waited = Signal(range(self.timeout))
        m.d.sync += waited.eq(Mux(ended | (waited == self.timeout - 1), 0, waited + 1))
        return waited == self.timeout - 1

    def _unstable(self, m, ended, good):
        """More bursts are bad than a right delay leaves."""
        bursts, bad = Signal(range(_WATCHED)), Signal(range(_MAX_BAD + 1))
        with m.If(ended[0]):
            m.d.sync += bursts.eq(bursts + 1)
        with m.If(~self.ready | (ended[0] & bursts.all())):
            m.d.sync += bad.eq(0)
        with m.Elif((ended & ~good).any()):
            m.d.sync += bad.eq(bad + 1)
        return bad == _MAX_BAD

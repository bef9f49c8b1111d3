"""Wakes the sensor, and wakes it anew when it does not answer or no good frame comes."""

from dataclasses import dataclass

from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

__all__ = ["Times", "Waker"]

_DEAD_CLOCKS = 1 << 14      # of the core, without an edge of the sensor's pixel clock
_PATIENCE = 60              # watches without a good frame, whatever else happens


@dataclass(frozen=True)
class Times:
    """Of the sensor, in microseconds.

    Parameters
    ----------
    reset_us, rest_us : int
        Its reset, and from there until the set-up begins: see
        :func:`ncdc_spec.sensors.waking.wake_times`.
    watch_us : int
        Without a good frame, until it is woken anew; longer than a frame.
    """
    reset_us: int
    rest_us: int
    watch_us: int = 1_000_000


class Waker(wiring.Component):
    """Holds the sensor in reset, lets it rest, and does both again when it does not answer: no
    access comes without a reset and a rest before it. Likewise when no good frame comes.

    After a watch (a second) without a good frame the sensor is woken anew if its pixel clock stands
    or a frame ended badly: it was unplugged, or lost its registers. One whose clock runs without a
    bad frame exposes for long: it gets :data:`_PATIENCE` watches. Nothing is watched while no frame
    is asked for, and no program but the set-up is cut off.

    Parameters
    ----------
    times : Times
    clock_hz : int

    Members
    -------
    came, bad : ``In(1)``
        For one clock: a frame ended, as it has to be or not.
    edge : ``In(1)``
        A level that changes with the pixel clock, in this domain.
    enabled : ``In(1)``
        Frames are captured.
    again : ``In(1)``
        A button, high while pressed, of this clock.
    busy, failed : ``In(1)``
        A program runs, the set-up at first; it got no answer from the sensor.
    reset_n, ready : ``Out(1)``
        The sensor's reset; it may be talked to. Programs are in reset until then.
    trouble : ``Out(1)``
        The sensor did not answer, or is woken anew; low again when the set-up ends.
    """

    def __init__(self, times, clock_hz):
        self.times, self.clock_hz = times, clock_hz
        super().__init__({
            "came": In(1), "bad": In(1), "edge": In(1), "enabled": In(1), "again": In(1),
            "busy": In(1), "failed": In(1), "reset_n": Out(1), "ready": Out(1),
            "trouble": Out(1)})

    def _clocks(self, microseconds):
        return max(1, microseconds * self.clock_hz // 10**6)

    def elaborate(self, platform):
        m = Module()
        reset, rest, watch = map(self._clocks, (
            self.times.reset_us, self.times.rest_us, self.times.watch_us))
        waited = Signal(range(reset + rest + 1))
        restart = Signal()
        setting = Signal(init=1)            # the set-up is not over
        with m.If(restart):
            m.d.sync += waited.eq(0)
        with m.Elif(~self.ready):
            m.d.sync += waited.eq(waited + 1)
        # Registers: a pin with logic before it could end the sensor's reset too early.
        m.d.sync += [self.reset_n.eq((waited >= reset) & ~restart),
                     self.ready.eq((waited >= reset + rest - 1) & ~restart)]

        dead = self._dead(m)
        left = Signal(range(watch))         # clocks of the watch
        watches = Signal(range(_PATIENCE))  # that have ended without a good frame
        odd, due = Signal(), Signal()       # a frame ended badly; the watch has seen enough
        over = Signal()
        m.d.comb += over.eq((left == 0) & self.ready & (setting | self.enabled))
        with m.If(self.bad):
            m.d.sync += odd.eq(1)
        started = Signal()                  # the programs are out of their reset, and busy
        ends = Signal()                     # the set-up does
        m.d.sync += started.eq(self.ready & ~restart)
        m.d.comb += ends.eq(started & setting & ~self.busy & ~restart)
        with m.If(self.came | ~self.ready | ends):
            m.d.sync += [left.eq(watch - 1), watches.eq(0), odd.eq(0), due.eq(0)]
        with m.Elif(over):
            m.d.sync += [left.eq(watch - 1), watches.eq(watches + 1),
                         due.eq(setting | odd | dead | (watches == _PATIENCE - 1))]
        with m.Elif(setting | self.enabled):
            m.d.sync += left.eq(left - 1)

        pressed, before = Signal(), Signal(init=1)
        m.d.sync += before.eq(self.again)
        with m.If(self.again & ~before):
            m.d.sync += pressed.eq(1)
        silent = Signal()                   # the set-up got no answer
        m.d.comb += [silent.eq(setting & self.failed),
                     restart.eq((due | pressed | silent) & self.ready & (setting | ~self.busy))]
        with m.If(restart):
            m.d.sync += [setting.eq(1), pressed.eq(0),
                         self.trouble.eq(due | silent | self.trouble)]
        with m.If(ends):
            m.d.sync += [setting.eq(0), self.trouble.eq(0)]
        return m

    def _dead(self, m):
        """Whether the pixel clock stands."""
        before, still, dead = Signal(), Signal(range(_DEAD_CLOCKS)), Signal()
        m.d.sync += [before.eq(self.edge), dead.eq(still == _DEAD_CLOCKS - 1)]
        with m.If(self.edge != before):
            m.d.sync += still.eq(0)
        with m.Elif(still != _DEAD_CLOCKS - 1):
            m.d.sync += still.eq(still + 1)
        return dead

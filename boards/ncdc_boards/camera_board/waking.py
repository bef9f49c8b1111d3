"""Starts the sensor, and again if it does not answer or no good frame comes."""

from dataclasses import dataclass

from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

__all__ = ["Times", "Waker"]

_DEAD_CLOCKS = 1 << 14      # clocks of the core without an edge of the sensor's pixel clock
_MAX_WATCHES = 60              # most watches without a good frame


@dataclass(frozen=True)
class Times:
    """Times of the sensor in microseconds.

    Parameters
    ----------
    reset_us, rest_us : int
        Its reset; from there until the configuration begins, see
        :func:`ncdc_spec.sensors.waking.wake_times`.
    watch_us : int
        Longest time without a good frame before a restart; longer than a frame.
    """
    reset_us: int
    rest_us: int
    watch_us: int = 1_000_000


class Waker(wiring.Component):
    """Holds the sensor in reset, waits for its rest, and repeats both when it does not answer.
    It also does so when no good frame comes. Each access has a reset and a rest before it.

    After a watch (a second) without a good frame the sensor is restarted if its pixel clock stands
    or a frame ended badly. It was unplugged, or lost its registers. If the clock runs without a
    bad frame, its exposure is long: the limit is :data:`_MAX_WATCHES` watches. No time counts
    while capture is disabled. The only program that a restart interrupts is the configuration.

    Parameters
    ----------
    times : Times
    clock_hz : int

    Members
    -------
    came, bad : ``In(1)``
        High for one clock: a good or a bad frame ended.
    edge : ``In(1)``
        Level that changes with the pixel clock, synchronised to this domain.
    enabled : ``In(1)``
        Frames are captured.
    again : ``In(1)``
        Button, high while pressed, synchronised to this domain.
    busy, failed : ``In(1)``
        A program runs, first the configuration; it got no answer from the sensor.
    reset_n, ready : ``Out(1)``
        The sensor's reset; it accepts accesses. Programs are in reset until then.
    trouble : ``Out(1)``
        The sensor did not answer, or is restarted; low again when the configuration ends.
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
        setting = Signal(init=1)            # the configuration is not over
        with m.If(restart):
            m.d.sync += waited.eq(0)
        with m.Elif(~self.ready):
            m.d.sync += waited.eq(waited + 1)
        # Registers: a pin with logic before it could end the sensor's reset too early.
        m.d.sync += [self.reset_n.eq((waited >= reset) & ~restart),
                     self.ready.eq((waited >= reset + rest - 1) & ~restart)]

        dead = self._dead(m)
        left = Signal(range(watch))         # clocks of the watch
        watches = Signal(range(_MAX_WATCHES))  # that have ended without a good frame
        odd, due = Signal(), Signal()       # a frame ended badly; a restart is due
        over = Signal()
        m.d.comb += over.eq((left == 0) & self.ready & (setting | self.enabled))
        with m.If(self.bad):
            m.d.sync += odd.eq(1)
        started = Signal()                  # the programs are out of their reset, and busy
        ends = Signal()                     # the configuration ends
        m.d.sync += started.eq(self.ready & ~restart)
        m.d.comb += ends.eq(started & setting & ~self.busy & ~restart)
        with m.If(self.came | ~self.ready | ends):
            m.d.sync += [left.eq(watch - 1), watches.eq(0), odd.eq(0), due.eq(0)]
        with m.Elif(over):
            m.d.sync += [left.eq(watch - 1), watches.eq(watches + 1),
                         due.eq(setting | odd | dead | (watches == _MAX_WATCHES - 1))]
        with m.Elif(setting | self.enabled):
            m.d.sync += left.eq(left - 1)

        pressed, before = Signal(), Signal(init=1)
        m.d.sync += before.eq(self.again)
        with m.If(self.again & ~before):
            m.d.sync += pressed.eq(1)
        silent = Signal()                   # the configuration got no answer
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

"""An I2C controller, a byte per command."""

from amaranth import *
from amaranth.lib import data, stream, wiring
from amaranth.lib.cdc import FFSynchronizer
from amaranth.lib.wiring import In, Out

__all__ = ["COMMAND", "I2cController", "RESULT", "quarter_clocks"]

COMMAND = data.StructLayout({"data": 8, "start": 1, "write": 1, "read": 1, "nack": 1, "stop": 1})
RESULT = data.StructLayout({"data": 8, "nack": 1, "lost": 1, "timeout": 1})

_FAST_HZ = 400_000
_FAST_LOW_NS = 1300             # tLOW and tBUF of the I2C specification, fast mode
_START, _BYTE, _ACKNOWLEDGE, _STOP, _IDLE = 0, 1, 9, 10, 11      # steps of a command


def quarter_clocks(clock_hz, rate_hz):
    """Clocks of a quarter of a bit: for the highest rate up to ``rate_hz``.

    In fast mode (above 100 kHz) the low half of a bit is at least 1.3 us, so that a rate of 400 kHz
    is 385 kHz at most.
    """
    clocks = -(-clock_hz // (4 * rate_hz))
    if rate_hz > _FAST_HZ // 4:
        clocks = max(clocks, -(-clock_hz * _FAST_LOW_NS // (2 * 10**9)))
    return clocks


class I2cController(wiring.Component):
    """Controls an I2C bus: START, a byte with its acknowledge, STOP, each as the command requests.

    A line is pulled low or released, never driven high. START, STOP and a bit each have four
    quarters. In the second SDA takes its value while SCL is low, in the third SCL is released.
    In the fourth SDA takes the value that makes it a START or a STOP. A target may hold SCL
    low (clock stretching). The lines are seen after three equal clocks and two of
    synchronisation, which filters spikes.

    A command with ``read`` and ``nack`` and ``stop`` and no ``start`` lets a target that holds SDA
    send the rest of its byte. This frees a bus that a reset has left stuck.

    Members
    -------
    quarter : ``In(16)``
        Clocks of a quarter of a bit, at least 8; see :func:`quarter_clocks`.
    limit : ``In(32)``
        Clocks for which a target may hold SCL.
    i : ``In(stream.Signature(COMMAND))``
        Ready when the command before is over. ``write`` sends ``data``; ``read``, which excludes
        ``write``, receives a byte and acknowledges it unless ``nack``. SCL stays low
        after a command without ``stop``.
    done : ``Out(1)``
        High for one clock when a command is over.
    result : ``Out(RESULT)``
        Result of the last command: the byte received; whether the target did not acknowledge the
        one sent; whether the bus was busy or another controller took it (``lost``); whether SCL
        was held too long. The last two end a command at once, with both lines released.
    scl_low, sda_low : ``Out(1)``
        Pull the line low.
    scl, sda : ``In(1)``
        The lines, asynchronous.
    """
    def __init__(self):
        super().__init__({
            "quarter": In(16), "limit": In(32),
            "i": In(stream.Signature(COMMAND)),
            "done": Out(1), "result": Out(RESULT),
            "scl_low": Out(1), "sda_low": Out(1), "scl": In(1), "sda": In(1),
        })

    def elaborate(self, platform):
        m = Module()
        scl, sda = (_filtered(m, name, getattr(self, name)) for name in ("scl", "sda"))
        command = Signal(COMMAND)                       # its data shift left, bit by bit
        step = Signal(range(_IDLE + 1), init=_IDLE)     # step of the command
        quarter = Signal(2)                             # quarter of the step
        left = Signal(16)                               # clocks of the quarter to come
        held = Signal(32)                               # clocks for which SCL was held
        waits = Signal()                                # SCL is released and and a target holds it
        ends = Signal()                                 # the quarter ends
        late = Signal()                                 # SCL was held too long
        lost = Signal()                                 # another device holds SDA
        m.d.comb += [
            self.i.ready.eq(step == _IDLE),
            waits.eq((quarter == 2) & ~scl),
            ends.eq((step != _IDLE) & ~waits & (left == 0)),
            late.eq((step != _IDLE) & waits & (held == self.limit)),
        ]
        m.d.sync += held.eq(Mux(waits, held + 1, 0))
        with m.If(~waits):
            m.d.sync += left.eq(Mux(left == 0, self.quarter, left) - 1)
        self._lines(m, command, step, quarter, ends, sda, lost)
        self._bits(m, command, step, quarter, ends, sda)

        following = Signal.like(step)                   # the step after this one
        after_byte = Mux(command.stop, _STOP, _IDLE)
        with m.Switch(step):
            with m.Case(_START):
                m.d.comb += following.eq(Mux(command.write | command.read, _BYTE, after_byte))
            with m.Case(_ACKNOWLEDGE):
                m.d.comb += following.eq(after_byte)
            with m.Case(_STOP):
                m.d.comb += following.eq(_IDLE)
            with m.Default():
                m.d.comb += following.eq(step + 1)
        m.d.sync += self.done.eq(0)
        with m.If(ends):
            m.d.sync += quarter.eq(quarter + 1)
            with m.If(quarter == 3):
                m.d.sync += [step.eq(following), self.done.eq(following == _IDLE)]
        with m.If(late | lost):
            m.d.sync += [step.eq(_IDLE), self.done.eq(1), self.scl_low.eq(0), self.sda_low.eq(0),
                         self.result.timeout.eq(late), self.result.lost.eq(lost)]
        new = self.i.p
        with m.If(self.i.valid & self.i.ready):
            m.d.sync += [
                command.eq(new), self.result.eq(0), quarter.eq(0), left.eq(self.quarter - 1),
                step.eq(Mux(new.start, _START, Mux(new.write | new.read, _BYTE, _STOP))),
            ]
        return m

    def _lines(self, m, command, step, quarter, ends, sda, lost):
        """Drive SDA and SCL in the quarters, and detect arbitration loss on SDA."""
        early = Signal()        # SDA while SCL rises
        late = Signal()         # and in the last quarter
        ours = Signal()         # no other device may pull SDA low
        with m.Switch(step):
            with m.Case(_START):
                m.d.comb += [early.eq(1), late.eq(0), ours.eq(1)]
            with m.Case(_STOP):
                m.d.comb += [early.eq(0), late.eq(1), ours.eq(1)]
            with m.Case(_ACKNOWLEDGE):
                m.d.comb += [early.eq(command.write | command.nack), late.eq(early),
                             ours.eq(~command.write)]
            with m.Default():
                m.d.comb += [early.eq(~command.write | command.data[-1]), late.eq(early),
                             ours.eq(command.write)]
        with m.If(ends):
            with m.Switch(quarter):
                with m.Case(0):
                    m.d.sync += self.sda_low.eq(~early)
                with m.Case(1):
                    m.d.sync += self.scl_low.eq(0)
                with m.Case(2):
                    m.d.sync += self.sda_low.eq(~late)
                    m.d.comb += lost.eq(ours & early & ~sda)
                with m.Case(3):
                    m.d.sync += self.scl_low.eq(step != _STOP)
                    m.d.comb += lost.eq(ours & late & ~sda)

    def _bits(self, m, command, step, quarter, ends, sda):
        """Move a byte out or in; it is sampled before the last quarter."""
        with m.If(ends & (quarter == 2) & (step == _ACKNOWLEDGE)):
            m.d.sync += self.result.nack.eq(command.write & sda)
        with m.If(ends & (quarter == 3) & (step >= _BYTE) & (step < _ACKNOWLEDGE)):
            m.d.sync += command.data.eq(command.data << 1)
        with m.If(ends & (quarter == 2) & (step >= _BYTE) & (step < _ACKNOWLEDGE)):
            m.d.sync += self.result.data.eq(Cat(sda, self.result.data))


def _filtered(m, name, line):
    """A line of the bus in this clock domain, without pulses shorter than three clocks."""
    seen = Signal(name=f"{name}_seen", init=1)
    steady = Signal(name=f"{name}_steady", init=1)
    last = Signal(2, name=f"{name}_last", init=3)       # values seen in the clocks before
    m.submodules[f"{name}_cdc"] = FFSynchronizer(line, seen, init=1)
    m.d.sync += last.eq(Cat(seen, last))
    with m.If((last == 3) & seen):
        m.d.sync += steady.eq(1)
    with m.Elif((last == 0) & ~seen):
        m.d.sync += steady.eq(0)
    return steady

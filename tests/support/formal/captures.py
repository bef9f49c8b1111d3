"""A camera's samples, from a sensor's pins or several per clock, and what becomes of them."""

from amaranth import *
from amaranth.lib import data
from amaranth.lib.wiring import In

from formal.properties import always, constant, given, reached
from formal.wrapper import Wrapper
from ncdc_hdl.camera.camera_side import CameraSide
from ncdc_hdl.camera.layouts import REPORT, Kind
from ncdc_hdl.camera.samples import FRAME_GAP
from ncdc_hdl.camera.sensor_port import SensorPort

__all__ = ["Pins", "Samples"]


def _entries(m, dut, space, row_entries, height):
    """Assert what holds of the entries of any :class:`SensorPort`: a frame whose report is clean
    has all of its entries, and none is pushed without space. Returns the signals that a frame ends,
    that its report is clean, and that it shows a full queue.

    A monitor counts the entries that the queue took between the BEGIN and the END of a frame.
    """
    entry, report = dut.entry, data.View(REPORT, dut.entry.data)
    pushed = dut.push & space
    words, rows, inside = Signal(4), Signal(4), Signal()
    with m.If(pushed):
        with m.Switch(entry.kind):
            with m.Case(Kind.BEGIN):
                m.d.sync += [words.eq(0), rows.eq(0), inside.eq(1)]
            with m.Case(Kind.WORD):
                m.d.sync += words.eq(words + 1)
            with m.Case(Kind.ROW_END):
                m.d.sync += [words.eq(words + 1), rows.eq(rows + 1)]
            with m.Case(Kind.END):
                m.d.sync += inside.eq(0)
    ends = pushed & (entry.kind == Kind.END)
    clean = ~Cat(report.rows, report.overflow, report.bad, report.lines).any()
    always(m, ~(ends & clean) | (words == row_entries * height) & (rows == height), "nothing_lost")
    always(m, ~pushed | (inside == (entry.kind != Kind.BEGIN)), "in_order")
    always(m, ~dut.push | space, "no_overflow")
    return ends, clean, report.overflow


class Pins(Wrapper):
    """``SensorPort`` of a parallel sensor with any pins and a queue that is full at any time.

    Asserts that a frame whose report is clean has every byte of its window, in as many rows; that
    entries come between BEGIN and END alone.
    """

    WIDTH, HEIGHT = 5, 2        # of the window, the sensor sends no more

    def __init__(self, kind=CameraSide):
        self.dut = kind()
        super().__init__({"frame": In(1), "line": In(1), "space": In(1), "enable": In(1)})

    def elaborate(self, platform):
        m = Module()
        dut = self.dut
        self.design(m, dut)
        settings = dut.settings
        m.d.comb += [
            dut.camera.pins.frame_valid.eq(self.frame), dut.camera.pins.line_valid.eq(self.line),
            dut.space.eq(self.space), dut.enable.eq(self.enable),
            settings.sent_width.eq(self.WIDTH), settings.sent_height.eq(self.HEIGHT),
            settings.width.eq(self.WIDTH), settings.height.eq(self.HEIGHT),
        ]
        constant(m, self.enable)
        # No reset: what one does to a frame the writer after the queue sees.
        given(m, ~ResetSignal())
        ends, clean, overflow = _entries(m, dut, self.space, -(-self.WIDTH // 4), self.HEIGHT)
        reached(m, ends & clean, "clean")
        reached(m, ends & overflow, "overflow")
        return m


class Samples(Wrapper):
    """``SensorPort`` of ``count`` samples per clock, with a source that keeps to what
    :func:`~ncdc_hdl.camera.samples.samples` says, and a queue that is full at any time.

    The window of 5 samples begins in any of the first columns of the rows, whose lengths are any.
    Asserts the same as :class:`Pins`. A row's last clock may complete two entries.
    """

    WIDTH, HEIGHT, LEFT_MAX = 5, 2, 3

    def __init__(self, count, kind=SensorPort):
        self.count, self.dut = count, kind(count)
        super().__init__({"valid": In(count), "first": In(1), "last": In(1), "end": In(1),
                          "bad": In(1), "space": In(1), "enable": In(1), "left": In(2)})

    def elaborate(self, platform):
        m = Module()
        dut, settings = self.dut, self.dut.settings
        self.design(m, dut)
        m.d.comb += [
            dut.i.valid.eq(self.valid), dut.i.first.eq(self.first), dut.i.last.eq(self.last),
            dut.i.end.eq(self.end), dut.i.bad.eq(self.bad), dut.space.eq(self.space),
            dut.enable.eq(self.enable), settings.left.eq(self.left),
            settings.sent_width.eq(self.WIDTH + self.LEFT_MAX),
            settings.sent_height.eq(self.HEIGHT), settings.width.eq(self.WIDTH),
            settings.height.eq(self.HEIGHT)]
        for signal in (self.enable, self.left):
            constant(m, signal)
        given(m, ~ResetSignal())
        self._source(m)
        ends, clean, overflow = _entries(m, dut, self.space, -(-self.WIDTH // 4), self.HEIGHT)
        reached(m, ends & clean, "clean")
        reached(m, ends & overflow, "overflow")
        return m

    def _source(self, m):
        """What a source may give in a clock."""
        some, in_row, in_frame = self.valid.any(), Signal(), Signal()
        # From 0 on: registers take the settings before the first frame.
        quiet = Signal(range(FRAME_GAP + 1))
        # Those of a row are the lower ones, and all but in its last clock.
        given(m, (self.valid & (self.valid + 1)) == 0)
        given(m, ~some | self.last | self.valid.all())
        given(m, some | ~(self.first | self.last))
        given(m, ~some | self.first | in_frame)
        given(m, ~self.first | (quiet == FRAME_GAP))
        given(m, ~self.end | in_frame | self.first)
        # A frame that ends within a row is bad.
        given(m, ~self.end | self.bad | Mux(some, self.last, ~in_row))
        with m.If(some):
            m.d.sync += [quiet.eq(0), in_row.eq(~self.last)]
        with m.Elif(quiet != FRAME_GAP):
            m.d.sync += quiet.eq(quiet + 1)
        with m.If(self.end):
            m.d.sync += [in_frame.eq(0), in_row.eq(0)]
        with m.Elif(self.first):
            m.d.sync += in_frame.eq(1)

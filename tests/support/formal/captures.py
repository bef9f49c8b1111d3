"""A sensor's pins, and what becomes of its samples."""

from amaranth import *
from amaranth.lib import data
from amaranth.lib.wiring import In

from formal.properties import always, constant, given, reached
from formal.wrapper import Wrapper
from ncdc_hdl.camera.camera_side import CameraSide
from ncdc_hdl.camera.layouts import REPORT, Kind

__all__ = ["Pins"]


class Pins(Wrapper):
    """``SensorPort`` of a parallel sensor with any pins and a queue that is full at any time.

    A monitor counts the bytes in the entries that the queue took between the BEGIN and the END of a
    frame. Asserts that a frame whose report is clean has every byte of its window, in as many rows;
    that entries come between BEGIN and END alone.
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
        entry, report = dut.entry, data.View(REPORT, dut.entry.data)
        pushed = dut.push & self.space
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
        entries = -(-self.WIDTH // 4) * self.HEIGHT
        always(m, ~(ends & clean) | (words == entries) & (rows == self.HEIGHT), "nothing_lost")
        always(m, ~pushed | (inside == (entry.kind != Kind.BEGIN)), "in_order")
        always(m, ~dut.push | self.space, "no_overflow")
        reached(m, ends & clean, "clean")
        reached(m, ends & report.overflow, "overflow")
        return m

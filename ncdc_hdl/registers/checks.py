"""Checks of a set of registers before a frame begins with it."""

from amaranth import *
from amaranth.lib import data, wiring
from amaranth.lib.wiring import In, Out
from amaranth.utils import exact_log2

from ncdc_hdl.lib.pipeline import register
from ncdc_spec.frames import BGR8, BGRX8, MONO8, OUTPUT_FORMATS
from ncdc_spec.geometry import MAX_SIZE, MIN_SIZE, STRIP_UNIT
from ncdc_spec.interpolation import FAST
from ncdc_spec.registers.register_map import BAYER_MONO
from ncdc_spec.view_rows import ROWS_COUNT

__all__ = ["FAULTS", "Checks"]

FAULTS = data.StructLayout({"alignment": 1, "size": 1, "format": 1})


class Checks(wiring.Component):
    """Compares the active set with the limits of the hardware.

    Only these checks keep the counters of the scan, of the writer and of the
    fetcher within their ranges. Areas in memory have their own fences.

    Timing: ``faults`` follow ``active`` after ``latency`` clocks.

    Parameters
    ----------
    hardware : ncdc_spec.hardware.Hardware
        Made for a camera.
    max_width, max_height : int
        Largest corrected image for which the table of valid rows has entries.
    active : StructLayout
        The registers by name.

    Members
    -------
    active : ``In(active)``
    faults : ``Out(FAULTS)``
        A base, an offset or a pitch is no multiple of the memory word. A size, a pitch, or the
        number of views or matrices in use, is outside its limits. The format of pixels in memory is
        unknown, or loses colours.
    """

    latency = 2
    """Clocks from a set to its faults: each comparison, what they have in common."""

    def __init__(self, hardware, max_width, max_height, active):
        self.hardware, self.largest = hardware, (max_width, max_height)
        super().__init__({"active": In(active), "faults": Out(FAULTS)})

    def elaborate(self, platform):
        m = Module()
        active, hardware = self.active, self.hardware
        word_bits = exact_log2(hardware.data_width // 8)
        lane_bits, strip_bits = exact_log2(hardware.lanes), exact_log2(STRIP_UNIT)
        aligned = [active.SOURCE_BASE, active.SOURCE_PITCH]
        aligned += [] if hardware.stream else [active.TARGET_BASE]
        aligned += [active.TARGET_OFFSET, active.TARGET_PITCH] if hardware.views else []
        width, height = active.CORRECTED_WIDTH, active.CORRECTED_HEIGHT
        wrong = [
            *(size < MIN_SIZE for size in (width, height, active.DISTORTED_WIDTH,
                                           active.DISTORTED_HEIGHT)),
            width > self.largest[0], height > self.largest[1],
            active.DISTORTED_WIDTH > MAX_SIZE, active.DISTORTED_HEIGHT > MAX_SIZE,
            active.SOURCE_PITCH < active.DISTORTED_WIDTH,
            width[:lane_bits] != 0,
        ]
        if not hardware.stream:
            wrong.append(active.STRIP_WIDTH[:strip_bits] != 0)
        if hardware.view_rows:
            wrong.append(active[ROWS_COUNT] > hardware.view_rows)
        if hardware.cached:
            wrong.append(active.CACHE_SPLIT > hardware.cache.max_split)
        if hardware.views:
            wrong += [active.VIEWS == 0, active.VIEWS > hardware.views, self._overlaps(active)]
        low = Cat(value[:word_bits] for value in aligned)
        m.d.sync += [
            self.faults.alignment.eq(register(m, "low", low).any()),
            self.faults.size.eq(register(m, "wrong", Cat(wrong)).any()),
        ]
        if not hardware.stream:
            m.d.sync += self.faults.format.eq(register(m, "loses", self._loses(active)))
        return m

    @staticmethod
    def _overlaps(active):
        """Whether a row begins before the end of the one above."""
        width, form, pitch = active.CORRECTED_WIDTH, active.OUTPUT_FORMAT, active.TARGET_PITCH
        row = Mux(form == MONO8.code, width, Mux(form == BGR8.code, BGR8.pixel_bytes * width,
                                                 BGRX8.pixel_bytes * width))
        return (pitch != 0) & (pitch < row)

    def _loses(self, active):
        """Whether the pixels in memory would not be the corrected ones."""
        grey = (active.BAYER_PHASE & BAYER_MONO).any()
        if not self.hardware.cached or self.hardware.cache.interpolation == FAST:
            grey = Const(0)     # the fast interpolation ignores that bit
        form = active.OUTPUT_FORMAT
        known = Cat(form == one.code for one in OUTPUT_FORMATS.values()).any()
        return ~known | (form == MONO8.code) & ~grey

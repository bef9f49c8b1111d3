"""From a back-map coordinate to the raw window that the pixel is made from."""

from amaranth import *
from amaranth.lib import data, stream, wiring
from amaranth.lib.wiring import In, Out

from ncdc_hdl.backend.layouts import request_layout
from ncdc_hdl.frontend.layouts import SIZE, coordinate_layout, lanes_of
from ncdc_model.geometry import WINDOW

__all__ = ["WindowAddress"]


class WindowAddress(wiring.Component):
    """Origin of the 3x3 window and the place within it, per pixel and axis::

        x0, fx = floor(x' - 0.5), x' - 0.5 - x0
        blank  = the input's, or x0 outside -1 .. width - 2

    An origin of -1 or width - 2 is moved to the window's nearest place inside, see
    ``ncdc_model.picture.window_address``, to which this is equal bit for bit.
    Timing: a stream stage, latency 1, one group per clock.

    Parameters
    ----------
    formats : ncdc_model.descriptor.Formats
        ``coordinate`` is used.
    lanes : int
        Pixels of a group.

    Members
    -------
    width, height : ``In``
        Distorted image in pixels, constant during a frame.
    i : ``In(stream.Signature(coordinate_layout(formats, lanes)))``
    o : ``Out(stream.Signature(request_layout(formats.coordinate.f_bits, lanes)))``
    """

    def __init__(self, formats, lanes=1):
        self.q = formats.coordinate
        super().__init__({
            "width": In(SIZE), "height": In(SIZE),
            "i": In(stream.Signature(coordinate_layout(formats, lanes))),
            "o": Out(stream.Signature(request_layout(self.q.f_bits, lanes))),
        })

    def elaborate(self, platform):
        m = Module()
        o = Signal(self.o.payload.shape())
        m.d.comb += [o.first.eq(self.i.p.first), o.last.eq(self.i.p.last)]
        for i, window in zip(lanes_of(self.i.p), lanes_of(o)):
            self._address(m, i, window)
        with m.If(~self.o.valid | self.o.ready):
            m.d.comb += self.i.ready.eq(1)
            m.d.sync += [self.o.valid.eq(self.i.valid), self.o.payload.eq(o)]
        return m

    def _address(self, m, i, o):
        """The window ``o`` of the coordinate ``i``."""
        half = 1 << (self.q.f_bits - 1)
        inside = []
        for coordinate, size, origin, fraction in ((i.x, self.width, o.x0, o.fx),
                                                   (i.y, self.height, o.y0, o.fy)):
            shifted = Signal(signed(self.q.width + 1))
            whole, after = Signal(signed(self.q.i_bits + 1)), Signal(signed(self.q.i_bits + 1))
            m.d.comb += [
                shifted.eq(coordinate - half), whole.eq(shifted >> self.q.f_bits),
                after.eq(size - (WINDOW - 1)),
                origin.eq(whole), fraction.eq(shifted),
            ]
            with m.If(whole == -1):
                m.d.comb += [origin.eq(0), fraction.eq(0)]
            with m.Elif(whole == after):
                m.d.comb += [origin.eq(after - 1), fraction.eq(-1)]
            inside.append((whole >= -1) & (whole <= after))
        m.d.comb += o.blank.eq(i.blank | ~Cat(inside).all())

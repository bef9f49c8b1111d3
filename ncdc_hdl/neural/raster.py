"""Hidden neurons that track the scan by additions, without a multiplier."""

from amaranth import *
from amaranth.lib import data, enum, wiring
from amaranth.lib.wiring import In, Out

from ncdc_hdl.lib.fixed import saturate
from ncdc_hdl.lib.pipeline import delay
from ncdc_hdl.neural.layers import hidden_layer_ports, served
from ncdc_hdl.neural.layouts import pixel_layout
from ncdc_hdl.neural.neuron import hidden_sum

__all__ = ["RasterControl", "RasterLayer", "RasterNeuron"]


class Operand(enum.IntEnum, shape=4):
    """Operand of a neuron's addition; in the first four, bit 0 is the carry and bit 1 a new row."""
    X0 = 0
    X1 = 1
    Y0 = 2
    Y1 = 3
    WEIGHT_X = 4
    WEIGHT_Y = 5
    BIAS = 6
    HALF = 7
    ZERO = 8


# Use of the addition in a clock. `step`: its result becomes the sum. `double`: the operand
# was added to twice the sum before. `row`: it was added to the row's first sum instead. `save`: the
# result is the first sum of a row. `keep`: the result is the next of the four increments.
ADD = data.StructLayout({"step": 1, "double": 1, "row": 1, "save": 1, "keep": 1})


class RasterNeuron(wiring.Component):
    """Exact weighted sum of a hidden neuron, updated from pixel to pixel by one adder.

    The rounded coordinate x grows by d or d + 1 from pixel to pixel, so that the sum of equation
    (15) grows by one of two constants of the frame::

        X0 = weights[0] d        X1 = X0 + weights[0]

    and by Y0 or Y1 from row to row, starting at the row's first sum, which has a register of its
    own. The same adder computes these four at the start of a frame and the first sum of each
    strip, digit by digit. All is modulo 2**n, n bits being what the exact sum needs.

    Parameters
    ----------
    formats : ncdc_spec.descriptor.Formats

    Members
    -------
    choice : ``In(Operand)``
        Operand of the addition in the next clock.
    add : ``In(ADD)``
        Use of the addition in this clock.
    weights, bias : ``In``
        As in :class:`HiddenNeuron`.
    o : ``Out``
        Sum plus half a unit of the net, exact.
    """

    def __init__(self, formats):
        self.format = hidden_sum(formats)
        super().__init__({
            "choice": In(Operand), "add": In(ADD),
            "weights": In(data.ArrayLayout(signed(formats.hidden_weight.width), 2)),
            "bias": In(signed(formats.hidden_bias.width)),
            "o": Out(self.format.shape),
        })

    def elaborate(self, platform):
        m = Module()
        q = self.format

        def register(name):
            return Signal(q.shape, name=name, reset_less=True)

        increments = [register(name) for name in ("x0", "x1", "y0", "y1")]
        operand, total, row = register("operand"), register("total"), register("row")
        values = {**dict(zip(Operand, increments)),
                  Operand.WEIGHT_X: self.weights[0], Operand.WEIGHT_Y: self.weights[1],
                  Operand.BIAS: self.bias << q.bias_shift,
                  Operand.HALF: q.half}
        with m.Switch(self.choice):
            for choice, value in values.items():
                with m.Case(choice):
                    m.d.sync += operand.eq(value)
            with m.Default():
                m.d.sync += operand.eq(0)

        result = Signal(q.shape)
        m.d.comb += result.eq(
            Mux(self.add.double, total << 1, Mux(self.add.row, row, total)) + operand)
        with m.If(self.add.step):
            m.d.sync += total.eq(result)
        with m.If(self.add.save):
            m.d.sync += row.eq(result)
        with m.If(self.add.keep):
            m.d.sync += [a.eq(b) for a, b in zip(increments, [*increments[1:], result])]
        m.d.comb += self.o.eq(total)
        return m


class RasterControl(wiring.Component):
    """Controls the additions of all raster neurons: products at a frame's start, then increments.

    A product with a coordinate takes one doubling and addition per digit, highest first. The
    coordinate is extended to the sum's n bits, so that its sign needs no subtraction and what
    the sum held before is shifted out. The sum at the first pixel has its two products'
    digits alternate. A frame's start takes ``preset`` clocks from the pixel's appearance, another
    strip's ``restart``.

    Parameters
    ----------
    formats : ncdc_spec.descriptor.Formats
    lanes : int
        Pixels of the scan's groups.

    Members
    -------
    start, active, advance, pixel, ready :
        As in :func:`ncdc_hdl.neural.layers.hidden_layer_ports`.
    choice, add : ``Out(Operand)``, ``Out(ADD)``
        To the neurons.
    """

    def __init__(self, formats, lanes=1):
        self.bits = hidden_sum(formats).shape.width
        super().__init__({
            "start": In(1), "active": In(1), "advance": In(1),
            "pixel": In(pixel_layout(formats, lanes)),
            "ready": Out(1), "choice": Out(Operand), "add": Out(ADD),
        })

    @property
    def preset(self):
        """Clocks from a frame's first pixel being shown to its first turn."""
        return 1 + 2 * self.bits + 2 + self.restart

    @property
    def restart(self):
        """Clocks from a strip's first pixel being shown to its first turn."""
        return 2 * self.bits + 2

    def elaborate(self, platform):
        m = Module()
        bits = self.bits
        choice = Signal(Operand)                        # ``choice`` of the next clock
        add = Signal(ADD)                               # ``add``, two clocks before
        digit = Signal(range(bits), init=bits - 1)      # digit of the coordinate, highest first
        with m.FSM():
            with m.State("IDLE"):
                with m.If(self.start):
                    m.next = "WAIT"
            with m.State("WAIT"):
                with m.If(self.active):
                    m.next = "X0"
            self._increments(m, choice, add, digit)
            self._first_sum(m, choice, add, digit)
            with m.State("RUN"):
                self._run(m, choice, add)

        add_next = Signal(ADD)                          # ``add``, a clock before
        m.d.sync += [self.choice.eq(choice), add_next.eq(add), self.add.eq(add_next)]
        return m

    def _add_digit(self, m, choice, add, digit, value, weight):
        """Add ``weight`` if this digit of ``value`` is one."""
        extended = Cat(value, value[-1].replicate(self.bits - len(value)))
        m.d.comb += [choice.eq(Mux(extended.bit_select(digit, 1), weight, Operand.ZERO)),
                     add.step.eq(1)]

    def _next_digit(self, m, digit):
        """Go on to the digit below, and from the last to the highest; whether it is the last."""
        last = digit == 0
        m.d.sync += digit.eq(Mux(last, self.bits - 1, digit - 1))
        return last

    def _increments(self, m, choice, add, digit):
        """The four increments: for each axis the product with the step, and a weight more."""
        for axis, weight, step, after in (("X", Operand.WEIGHT_X, self.pixel.x_step, "Y0"),
                                          ("Y", Operand.WEIGHT_Y, self.pixel.y_step, "FIRST_X")):
            with m.State(f"{axis}0"):
                self._add_digit(m, choice, add, digit, step, weight)
                last = self._next_digit(m, digit)
                m.d.comb += [add.double.eq(1), add.keep.eq(last)]
                with m.If(last):
                    m.next = f"{axis}1"
            with m.State(f"{axis}1"):
                m.d.comb += [choice.eq(weight), add.step.eq(1), add.keep.eq(1)]
                m.next = after

    def _first_sum(self, m, choice, add, digit):
        """The sum at the first pixel of a strip: two products in turn, bias, half."""
        with m.State("FIRST_X"):
            self._add_digit(m, choice, add, digit, self.pixel.x, Operand.WEIGHT_X)
            m.d.comb += add.double.eq(1)
            m.next = "FIRST_Y"
        with m.State("FIRST_Y"):
            self._add_digit(m, choice, add, digit, self.pixel.y, Operand.WEIGHT_Y)
            last = self._next_digit(m, digit)
            m.next = "FIRST_X"
            with m.If(last):
                m.next = "BIAS"
        with m.State("BIAS"):
            m.d.comb += [choice.eq(Operand.BIAS), add.step.eq(1)]
            m.next = "HALF"
        with m.State("HALF"):
            m.d.comb += [choice.eq(Operand.HALF), add.step.eq(1), add.save.eq(1),
                         self.ready.eq(1)]
            m.next = "RUN"

    def _run(self, m, choice, add):
        """From pixel to pixel: one of the four increments with each advance."""
        pixel = self.pixel
        m.d.comb += [
            self.ready.eq(~(self.start | self.advance & pixel.new_strip)),
            choice.eq(Cat(Mux(pixel.new_row, pixel.y_carry, pixel.x_carry), pixel.new_row)),
            add.step.eq(self.advance),
            add.row.eq(pixel.new_row), add.save.eq(self.advance & pixel.new_row),
        ]
        with m.If(self.start):
            m.next = "WAIT"
        with m.Elif(self.advance & pixel.new_strip):
            # The sum computed now is shifted out later.
            m.next = "FIRST_X"


class RasterLayer(wiring.Component):
    """Hidden neurons without a multiplier; the pixels must come in the order of the scan.

    Equal bit for bit to :class:`ncdc_hdl.neural.layers.MultiplyLayer`, if the scan stays
    within the range of its coordinates. One pixel per clock, also from row to row; each strip
    begins with the ``restart`` clocks of :class:`RasterControl`.

    Parameters
    ----------
    hidden_neurons : int
        HN; one adder each.
    formats : ncdc_spec.descriptor.Formats
    share : int
        Neurons whose sums are rounded in turn.
    lanes : int
        Pixels of the scan's groups, one of which the layer takes.

    Members: :func:`ncdc_hdl.neural.layers.hidden_layer_ports`.
    """

    latency = 3
    """Clocks from a pixel's first turn to that turn's nets: control, operand, rounding.

    The sum itself has been there since the pixel before was taken.
    """

    @property
    def start_latency(self):
        """Clocks that a frame's first pixel waits for the layer: first sums."""
        return self.control.preset

    def __init__(self, hidden_neurons, formats, share=1, lanes=1):
        self.hidden_neurons, self.formats, self.share = hidden_neurons, formats, share
        self.control = RasterControl(formats, lanes)
        super().__init__(hidden_layer_ports(hidden_neurons, formats, share, lanes))

    def elaborate(self, platform):
        m = Module()
        m.submodules.control = control = self.control
        m.d.comb += [
            control.start.eq(self.start), control.active.eq(self.active),
            control.advance.eq(self.advance), control.pixel.eq(self.pixel),
            self.ready.eq(control.ready),
        ]
        sums = []
        for j in range(self.hidden_neurons):
            m.submodules[f"neuron{j}"] = neuron = RasterNeuron(self.formats)
            m.d.comb += [
                neuron.choice.eq(control.choice), neuron.add.eq(control.add),
                neuron.weights.eq(self.neurons[j].weights), neuron.bias.eq(self.neurons[j].bias),
            ]
            sums.append(neuron.o[neuron.format.shift:].as_signed())
        turn = delay(m, self.turn, self.latency - 1, "turn")
        for k in range(len(self.o)):
            group = [sums[j] for j in served(k, self.hidden_neurons, self.share)]
            o = Signal(signed(self.formats.net.width), name=f"r{k}_o", reset_less=True)
            m.d.sync += o.eq(saturate(Array(group)[turn] if self.share > 1 else group[0],
                                      self.formats.net))
            m.d.comb += self.o[k].eq(o)
        return m

"""Hidden and output neurons: pipelined multiply-accumulate with one rounding."""

from amaranth import *
from amaranth.lib import data, wiring
from amaranth.lib.wiring import In, Out
from amaranth.utils import ceil_log2

from ncdc_hdl.fixed import saturate

__all__ = ["HiddenNeuron", "OutputNeuron"]


class _Accumulator(wiring.Component):
    """Shared pipeline: products of inputs and weights, adder tree, bias, rounding, saturation.

    Two registers stand before and two after each product, which the multiplier blocks of the
    usual FPGAs take into themselves. The accumulator's width follows from the formats: no sum of
    any weights that fit them can wrap.
    """

    def __init__(self, inputs, xq, wq, bq, yq):
        self.inputs, self.xq, self.wq, self.bq, self.yq = inputs, xq, wq, bq, yq
        self.shift = xq.f_bits + wq.f_bits - yq.f_bits
        self.bias_shift = xq.f_bits + wq.f_bits - bq.f_bits
        if self.shift < 1:
            raise ValueError(f"{yq} keeps every fraction bit of the products {xq} x {wq}")
        if self.bias_shift < 0:
            raise ValueError(f"bias {bq} is finer than the products {xq} x {wq}")
        largest = inputs * xq.lo * wq.lo - (bq.lo << self.bias_shift) + (1 << (self.shift - 1))
        self.accumulator = signed(largest.bit_length() + 1)
        super().__init__({
            "i": In(data.ArrayLayout(signed(xq.width), inputs)),
            "weights": In(data.ArrayLayout(signed(wq.width), inputs)),
            "bias": In(signed(bq.width)),
            "o": Out(signed(yq.width)),
        })

    @property
    def latency(self):
        """Clocks from ``i`` to ``o``: 2 in, 2 products, adder tree, bias, rounding."""
        return 2 + 2 + ceil_log2(self.inputs) + 1 + 1

    def elaborate(self, platform):
        m = Module()

        def register(name, value, shape=None):
            r = Signal(shape or value.shape(), name=name, reset_less=True)
            m.d.sync += r.eq(value)
            return r

        x = [register(f"x0_{k}", self.i[k]) for k in range(self.inputs)]
        x = [register(f"x1_{k}", value) for k, value in enumerate(x)]
        w = [register(f"w_{k}", self.weights[k]) for k in range(self.inputs)]
        p = [register(f"p0_{k}", a * b) for k, (a, b) in enumerate(zip(x, w))]
        level, terms = 0, [register(f"p1_{k}", value) for k, value in enumerate(p)]
        while len(terms) > 1:
            pairs = [terms[k:k + 2] for k in range(0, len(terms), 2)]
            terms = [register(f"s{level}_{k}", sum(pair[1:], start=pair[0]))
                     for k, pair in enumerate(pairs)]
            level += 1
        # The bias carries the half that rounds: a static sum, off the data path.
        biased = register("b_bias", (self.bias << self.bias_shift) + (1 << (self.shift - 1)),
                          self.accumulator)
        total = register("a_total", terms[0] + biased, self.accumulator)
        m.d.comb += self.o.eq(register("r_o", saturate(total[self.shift:].as_signed(), self.yq),
                                       signed(self.yq.width)))
        return m


class HiddenNeuron(_Accumulator):
    """Two-input neuron up to its net, equation (15), on raw integers::

        acc = (bias << bias_shift) + weights[0] i[0] + weights[1] i[1]     exact
        o   = sat((acc + 2**(shift-1)) >> shift)

    Equal bit for bit to ``ncdc_model.network.hidden_neuron``. Timing: free-running, one net per
    clock, ``latency`` clocks. Weights and bias may change between frames only.

    Parameters
    ----------
    formats : ncdc_model.descriptor.Formats
        ``input``, ``hidden_weight``, ``hidden_bias`` and ``net`` are used.

    Members
    -------
    i, weights : ``In(ArrayLayout(signed(n), 2))``
    bias : ``In(signed(n))``
    o : ``Out(signed(formats.net.width))``

    Raises
    ------
    ValueError
        If the formats leave no bit to round, or the bias is finer than the products.
    """

    def __init__(self, formats):
        super().__init__(2, formats.input, formats.hidden_weight, formats.hidden_bias, formats.net)


class OutputNeuron(_Accumulator):
    """HN-input linear neuron with its adder tree, equations (15), (18) and Fig. 8.

    The same arithmetic as :class:`HiddenNeuron` over ``inputs`` activations; the result is a
    distorted coordinate in pixels, saturated, never wrapped. Equal bit for bit to
    ``ncdc_model.network.output_neuron``. Free-running, ``latency`` clocks.

    Parameters
    ----------
    inputs : int
        HN, the number of hidden neurons.
    formats : ncdc_model.descriptor.Formats
        ``tansig``, ``output_weight``, ``output_bias`` and ``coordinate`` are used.

    Members, Raises: as :class:`HiddenNeuron`, with ``inputs`` in place of 2.
    """

    def __init__(self, inputs, formats):
        super().__init__(inputs, formats.tansig, formats.output_weight, formats.output_bias,
                         formats.coordinate)

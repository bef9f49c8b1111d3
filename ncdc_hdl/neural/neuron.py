"""Hidden and output neurons: pipelined multiply-accumulate with one rounding."""

from dataclasses import dataclass

from functools import partial

from amaranth import *
from amaranth.lib import data, wiring
from amaranth.lib.wiring import In, Out
from amaranth.utils import ceil_log2

from ncdc_hdl import pipeline
from ncdc_hdl.fixed import saturate
from ncdc_hdl.neural.product import Product
from ncdc_hdl.pipeline import delay
from ncdc_model.fixed import Q

__all__ = ["HiddenNeuron", "OutputNeuron", "WeightedSum", "hidden_sum", "output_sum"]


@dataclass(frozen=True)
class WeightedSum:
    """Formats of a neuron's sum: products ``xq`` x ``wq``, a bias, one rounding to ``yq``.

    Parameters
    ----------
    terms : int
        Products in the sum.
    xq, wq, bq, yq : ncdc_model.fixed.Q
        Of the inputs, the weights, the bias, the result.

    Raises
    ------
    ValueError
        If the formats leave no bit to round, or the bias is finer than the products.
    """
    terms: int
    xq: Q
    wq: Q
    bq: Q
    yq: Q

    def __post_init__(self):
        if self.shift < 1:
            raise ValueError(f"{self.yq} keeps every fraction bit of the products "
                             f"{self.xq} x {self.wq}")
        if self.bias_shift < 0:
            raise ValueError(f"bias {self.bq} is finer than the products {self.xq} x {self.wq}")

    @property
    def shift(self):
        """Fraction bits that the rounding drops."""
        return self.xq.f_bits + self.wq.f_bits - self.yq.f_bits

    @property
    def half(self):
        """What rounding adds to the sum before it drops the bits."""
        return 1 << (self.shift - 1)

    @property
    def bias_shift(self):
        """Fraction bits that the products have beyond the bias."""
        return self.xq.f_bits + self.wq.f_bits - self.bq.f_bits

    @property
    def shape(self):
        """Shape of the accumulator: no sum of any weights that fit the formats can wrap."""
        largest = self.terms * self.xq.lo * self.wq.lo - (self.bq.lo << self.bias_shift) + self.half
        return signed(largest.bit_length() + 1)


def hidden_sum(formats):
    """The sum of a hidden neuron, in ``formats``."""
    return WeightedSum(2, formats.input, formats.hidden_weight, formats.hidden_bias, formats.net)


def output_sum(hidden_neurons, formats):
    """The sum of an output neuron over ``hidden_neurons``, in ``formats``."""
    return WeightedSum(hidden_neurons, formats.tansig, formats.output_weight, formats.output_bias,
                       formats.coordinate)


class _Accumulator(wiring.Component):
    """Shared pipeline: products of inputs and weights, adder tree, bias, rounding, saturation.

    A register more stands before each :class:`Product`, whose blocks have ``products`` bits. Of
    several turns, each brings ``inputs`` more terms of the same sum; ``first`` marks the one that
    begins it.
    """

    weights_clock = 1
    """Clocks from an input to its weights, if those change from turn to turn."""

    def __init__(self, inputs, format, turns=1, products=27):
        self.inputs, self.format, self.turns = inputs, format, turns
        self.products = [Product(format.xq.width, format.wq.width, products)
                         for _ in range(inputs)]
        super().__init__({
            "i": In(data.ArrayLayout(signed(format.xq.width), inputs)),
            "weights": In(data.ArrayLayout(signed(format.wq.width), inputs)),
            "bias": In(signed(format.bq.width)),
            "o": Out(signed(format.yq.width)),
        } | ({"first": In(1)} if turns > 1 else {}))

    @property
    def _summed(self):
        """Clocks from ``i`` to the sum of its products: 1 in, products, adder tree."""
        return 1 + self.products[0].latency + ceil_log2(self.inputs)

    @property
    def bias_clock(self):
        """Clocks from an input to its bias, if that changes from input to input."""
        return self._summed - 1

    @property
    def latency(self):
        """Clocks from the first turn's ``i`` to ``o``: sum, bias, rounding, further turns."""
        return self._summed + 1 + 1 + self.turns - 1

    def elaborate(self, platform):
        m = Module()
        q = self.format

        register = partial(pipeline.register, m)

        for k, product in enumerate(self.products):
            m.submodules[f"product{k}"] = product
            m.d.comb += [product.a.eq(register(f"x0_{k}", self.i[k])),
                         product.b.eq(self.weights[k])]
        level, terms = 0, [product.o for product in self.products]
        while len(terms) > 1:
            pairs = [terms[k:k + 2] for k in range(0, len(terms), 2)]
            terms = [register(f"s{level}_{k}", sum(pair[1:], start=pair[0]))
                     for k, pair in enumerate(pairs)]
            level += 1
        # The bias carries the half that rounds: a static sum, off the data path.
        biased = register("b_bias", (self.bias << q.bias_shift) + q.half, q.shape)
        total = Signal(q.shape, name="a_total", reset_less=True)
        before = biased
        if self.turns > 1:
            before = Mux(delay(m, self.first, self._summed, "first"), biased, total)
        m.d.sync += total.eq(terms[0] + before)
        m.d.comb += self.o.eq(register("r_o", saturate(total[q.shift:].as_signed(), q.yq),
                                       signed(q.yq.width)))
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
    products : int
        Bits of the multiplier blocks, 27 or 18.

    Members
    -------
    i, weights : ``In(ArrayLayout(signed(n), 2))``
    bias : ``In(signed(n))``
    o : ``Out(signed(formats.net.width))``

    Raises
    ------
    ValueError
        If the formats leave no bit to round, the bias is finer than the products, or a factor is
        too wide for the blocks.
    """

    def __init__(self, formats, products=27):
        super().__init__(2, hidden_sum(formats), products=products)


class OutputNeuron(_Accumulator):
    """HN-input linear neuron with its adder tree, equations (15), (18) and Fig. 8.

    The same arithmetic as :class:`HiddenNeuron` over ``inputs`` activations; the result is a
    distorted coordinate in pixels, saturated, never wrapped. Equal bit for bit to
    ``ncdc_model.network.output_neuron``. Free-running, ``latency`` clocks.

    Parameters
    ----------
    inputs : int
        Activations that arrive together; all HN of them if ``turns`` is 1.
    formats : ncdc_model.descriptor.Formats
        ``tansig``, ``output_weight``, ``output_bias`` and ``coordinate`` are used.
    turns : int
        Clocks over which the activations of one coordinate arrive. The weights of each turn
        follow its activations after ``weights_clock`` clocks.
    products : int
        As of :class:`HiddenNeuron`.

    Members, Raises: as :class:`HiddenNeuron`, with ``inputs`` in place of 2, and
    first : ``In(1)``
        With the activations of the first turn (``turns`` above 1 only).
    """

    def __init__(self, inputs, formats, turns=1, products=27):
        super().__init__(inputs, output_sum(inputs * turns, formats), turns, products)

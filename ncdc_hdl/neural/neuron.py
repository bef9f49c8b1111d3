"""Hidden and output neurons: pipelined multiply-accumulate with one rounding."""

from dataclasses import dataclass
from functools import partial

from amaranth import *
from amaranth.lib import data, wiring
from amaranth.lib.wiring import In, Out
from amaranth.utils import ceil_log2

from ncdc_hdl.lib import pipeline
from ncdc_hdl.lib.fixed import saturate
from ncdc_hdl.lib.pipeline import delay
from ncdc_hdl.neural.product import Product
from ncdc_spec.fixed import Q

__all__ = ["HiddenNeuron", "OutputNeuron", "WeightedSum", "hidden_sum", "output_sum"]


@dataclass(frozen=True)
class WeightedSum:
    """Formats of a neuron's sum: products ``xq`` x ``wq``, a bias, one rounding to ``yq``.

    The sum has the fraction bits of the products; with a skip path, those of the finer ones.

    Parameters
    ----------
    terms : int
        Products in the sum.
    xq, wq, bq, yq : ncdc_spec.fixed.Q
        Formats of the inputs, the weights, the bias, the result.
    skip : (Q, Q) or None
        Inputs and weights of the two further products of a skip path.

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
    skip: tuple | None = None

    def __post_init__(self):
        if self.shift < 1:
            raise ValueError(f"{self.yq} has all fraction bits of the products "
                             f"{self.xq} x {self.wq}")
        if self.bias_shift < 0:
            raise ValueError(f"bias {self.bq} is finer than the products {self.xq} x {self.wq}")

    def _finer(self, x, w):
        """Fraction bits that the sum has beyond the products of formats ``x`` and ``w``."""
        pairs = [(self.xq, self.wq)] + ([self.skip] if self.skip else [])
        return max(a.f_bits + b.f_bits for a, b in pairs) - x.f_bits - w.f_bits

    @property
    def product_shift(self):
        """Fraction bits that the sum has beyond its products."""
        return self._finer(self.xq, self.wq)

    @property
    def skip_shift(self):
        """Fraction bits that the sum has beyond the products of the skip path."""
        return self._finer(*self.skip)

    @property
    def shift(self):
        """Fraction bits that the rounding drops."""
        return self.product_shift + self.xq.f_bits + self.wq.f_bits - self.yq.f_bits

    @property
    def half(self):
        """Value that rounding adds to the sum before it drops the bits."""
        return 1 << (self.shift - 1)

    @property
    def bias_shift(self):
        """Fraction bits that the sum has beyond the bias."""
        return self.product_shift + self.xq.f_bits + self.wq.f_bits - self.bq.f_bits

    @property
    def shape(self):
        """Shape of the accumulator: no sum of any weights that fit the formats can wrap."""
        largest = (self.terms * self.xq.lo * self.wq.lo << self.product_shift) + self.half
        largest -= self.bq.lo << self.bias_shift
        if self.skip:
            largest += 2 * self.skip[0].lo * self.skip[1].lo << self.skip_shift
        return signed(largest.bit_length() + 1)


def hidden_sum(formats):
    """The sum of a hidden neuron, in ``formats``."""
    return WeightedSum(2, formats.input, formats.hidden_weight, formats.hidden_bias, formats.net)


def output_sum(hidden_neurons, formats):
    """The sum of an output neuron over ``hidden_neurons``, in ``formats``."""
    skip = formats.skip_weight and (formats.input, formats.skip_weight)
    return WeightedSum(hidden_neurons, formats.tansig, formats.output_weight, formats.output_bias,
                       formats.coordinate, skip)


class _Accumulator(wiring.Component):
    """Shared pipeline: products of inputs and weights, adder tree, bias, rounding, saturation.

    There is one more register before each :class:`Product`, of ``multiplier_bits`` blocks,
    and after each adder of the tree, for routing. Of several turns, each adds
    ``inputs`` more terms of the same sum; ``first`` marks the one that begins it. The two products
    of a skip path are added to the bias.
    """

    weights_clock = 1
    """Clocks from an input to its weights, if those change from turn to turn."""

    def __init__(self, inputs, format, turns=1, multiplier_bits=27):
        self.terms, self.format, self.turns = inputs, format, turns
        self.products = [Product(format.xq.width, format.wq.width, multiplier_bits)
                         for _ in range(inputs)]
        self.skip_products = [Product(*(q.width for q in format.skip), multiplier_bits)
                              for _ in range(2 if format.skip else 0)]
        super().__init__({
            "i": In(data.ArrayLayout(signed(format.xq.width), inputs)),
            "weights": In(data.ArrayLayout(signed(format.wq.width), inputs)),
            "bias": In(signed(format.bq.width)),
            "o": Out(signed(format.yq.width)),
        } | ({"first": In(1)} if turns > 1 else {}) | ({
            "inputs": In(data.ArrayLayout(signed(format.skip[0].width), 2)),
            "skip": In(data.ArrayLayout(signed(format.skip[1].width), 2)),
        } if format.skip else {}))

    @property
    def _summed(self):
        """Clocks from ``i`` to the sum of its products: 1 in, products, 2 per level of adders."""
        return 1 + self.products[0].latency + 2 * ceil_log2(self.terms)

    @property
    def bias_clock(self):
        """Clocks from an input to its bias, if that changes from input to input."""
        return self._summed - 1

    @property
    def inputs_clock(self):
        """Clocks from the first turn's ``i`` to ``inputs`` of a skip path; may be negative."""
        return self._summed - (1 + self.skip_products[0].latency + 1 + 1)

    @property
    def latency(self):
        """Clocks from the first turn's ``i`` to ``o``: sum, bias, rounding, further turns."""
        return self._summed + 1 + 1 + self.turns - 1

    def elaborate(self, platform):
        m = Module()
        q = self.format

        register = partial(pipeline.register, m)

        # X, and the stages of the products: multiply inputs and weights.
        for k, product in enumerate(self.products):
            m.submodules[f"product{k}"] = product
            m.d.comb += [product.a.eq(register(f"x0_{k}", self.i[k])),
                         product.b.eq(self.weights[k])]
        # S: add the products in pairs, a level of the tree in two clocks.
        level, terms = 0, [product.o for product in self.products]
        while len(terms) > 1:
            pairs = [terms[k:k + 2] for k in range(0, len(terms), 2)]
            terms = [delay(m, sum(pair[1:], start=pair[0]), 2, f"s{level}_{k}")
                     for k, pair in enumerate(pairs)]
            level += 1
        # B: the bias includes the half for rounding, a static sum outside the data path.
        biased = register("b_bias", (self.bias << q.bias_shift) + q.half, q.shape)
        # K: the products of a skip path are added to the bias.
        for k, product in enumerate(self.skip_products):
            m.submodules[f"skip{k}"] = product
            m.d.comb += [product.a.eq(register(f"k0_{k}", self.inputs[k])),
                         product.b.eq(self.skip[k])]
        if self.skip_products:
            skipped = register("k_sum", self.skip_products[0].o + self.skip_products[1].o)
            biased = register("k_bias", biased + (skipped << q.skip_shift), q.shape)
        # A: add the bias in the first turn, the sum of the turns before in the others.
        total = Signal(q.shape, name="a_total", reset_less=True)
        before = biased
        if self.turns > 1:
            before = Mux(delay(m, self.first, self._summed, "first"), biased, total)
        m.d.sync += total.eq((terms[0] << q.product_shift) + before)
        # R: drop the fraction bits, saturate.
        m.d.comb += self.o.eq(register("r_o", saturate(total[q.shift:].as_signed(), q.yq),
                                       signed(q.yq.width)))
        return m


class HiddenNeuron(_Accumulator):
    """Two-input neuron up to its net, equation (15), on raw integers::

        acc = (bias << bias_shift) + weights[0] i[0] + weights[1] i[1]     exact
        o   = sat((acc + 2**(shift-1)) >> shift)

    Equal bit for bit to ``ncdc_model.golden.network.hidden_neuron``. Timing: free-running, one net
    per clock, ``latency`` clocks. Weights and bias may change only between frames.

    Parameters
    ----------
    formats : ncdc_spec.descriptor.Formats
        ``input``, ``hidden_weight``, ``hidden_bias`` and ``net`` are used.
    multiplier_bits : int
        Width of the multiplier blocks, 27 or 18.

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

    def __init__(self, formats, multiplier_bits=27):
        super().__init__(2, hidden_sum(formats), multiplier_bits=multiplier_bits)


class OutputNeuron(_Accumulator):
    """HN-input linear neuron with its adder tree, equations (15), (18) and Fig. 8.

    The same arithmetic as :class:`HiddenNeuron` over ``inputs`` activations; the result is a
    distorted coordinate in pixels, saturated, never wrapped. Equal bit for bit to
    ``ncdc_model.golden.network.output_neuron``. Free-running, ``latency`` clocks.

    Parameters
    ----------
    inputs : int
        Activations that arrive together; all HN of them if ``turns`` is 1.
    formats : ncdc_spec.descriptor.Formats
        ``tansig``, ``output_weight``, ``output_bias`` and ``coordinate`` are used.
    turns : int
        Clocks over which the activations of one coordinate arrive. The weights of each turn
        follow its activations after ``weights_clock`` clocks.
    multiplier_bits : int
        As in :class:`HiddenNeuron`.

    Members, Raises: as :class:`HiddenNeuron`, with ``inputs`` instead of 2, and
    first : ``In(1)``
        High with the activations of the first turn (only with ``turns`` above 1).
    inputs, skip : ``In(ArrayLayout(signed(n), 2))``
        The hidden neurons' x and y, ``inputs_clock`` clocks after the first turn's activations,
        and their weights (only if ``formats`` has a skip path).
    """

    def __init__(self, inputs, formats, turns=1, multiplier_bits=27):
        super().__init__(inputs, output_sum(inputs * turns, formats), turns, multiplier_bits)

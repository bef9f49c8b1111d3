"""The fixed-point formats of the network."""

from dataclasses import dataclass, replace

from ncdc_spec.errors import InputError
from ncdc_spec.fixed import Q
from ncdc_spec.geometry import SCAN
from ncdc_spec.nodes import GUARD_BITS
from ncdc_spec.tansig import design_for

__all__ = ["Formats", "MAX_NEURONS", "REGISTER_BITS"]

MAX_NEURONS = 32
REGISTER_BITS = 32


@dataclass(frozen=True)
class Formats:
    """Fixed-point format of every signal of the network, input to output.

    ``tansig`` holds the tan-sigmoid's value with one bit more than its accuracy: the last bit is
    the constant one that stands for rounding (zero for the value 0), see ``tansig``.
    ``skip_weight`` is None where the network has no skip path.

    ``input`` has one integer bit in a descriptor, two in :meth:`at_nodes`.

    Raises
    ------
    InputError
        If a format does not fit a 32-bit register, the input does not hold the scan or has no bit
        less to round, coordinates have no fraction bit, a bias is finer than the products it is
        added to, or a sum has no fraction bit more than its result or more than 63 bits.
    """
    input: Q = Q(1, 23)             # normalised scan coordinate
    hidden_weight: Q = Q(4, 20)
    hidden_bias: Q = Q(5, 27)
    net: Q = Q(5, 19)               # weighted sum of a hidden neuron, input of the tan-sigmoid
    tansig: Q = Q(1, 21)            # 20 fraction bits and the last one
    output_weight: Q = Q(12, 12)    # pixels
    output_bias: Q = Q(14, 18)      # pixels
    coordinate: Q = Q(14, 10)       # pixels
    skip_weight: Q | None = None    # pixels

    def __post_init__(self):
        for name, q in self.items():
            if q.width > REGISTER_BITS:
                raise InputError(f"the format {name} {q} has {q.width} bits, "
                                 f"the limit is {REGISTER_BITS}")
        if not 1 <= self.input.i_bits <= 2 or not 8 <= self.input.f_bits < SCAN.f_bits:
            raise InputError(f"the format input {self.input} does not suit the scan, one integer "
                             f"bit and 8 to {SCAN.f_bits - 1} fraction bits are needed")
        if self.coordinate.f_bits < 1:
            raise InputError(f"coordinates {self.coordinate} have no fraction bit")
        self._check_sum(((2, self.input, self.hidden_weight),), self.hidden_bias, self.net)
        skip = () if self.skip_weight is None else ((2, self.input, self.skip_weight),)
        self._check_sum(((MAX_NEURONS, self.tansig, self.output_weight), *skip),
                        self.output_bias, self.coordinate)

    def _check_sum(self, products, bias, result):
        """Check a neuron's sum of ``products``, (number, input, weight) each, and ``bias``."""
        finest = max(x.f_bits + weight.f_bits for _, x, weight in products)
        number, x, weight = products[0]
        if bias.f_bits > finest or result.f_bits >= finest:
            raise InputError(f"products {x} x {weight} have {finest} fraction bits, too few "
                             f"for the bias {bias} or the result {result}")
        # The golden model computes in 64-bit integers.
        largest = (1 << finest) - (bias.lo << (finest - bias.f_bits)) + sum(
            number << (x.width + weight.width - 2 + finest - x.f_bits - weight.f_bits)
            for number, x, weight in products)
        if largest.bit_length() > 62:
            raise InputError(f"sums of {number} products {x} x {weight} and the bias {bias} "
                             f"need {largest.bit_length() + 1} bits, the limit is 63")

    def items(self):
        """(name, format) of every signal that the network has."""
        return [(name, q) for name, q in vars(self).items() if q is not None]

    def at_nodes(self):
        """The formats in which the network computes at nodes.

        The scan's normalised coordinates have one more integer bit, for the nodes outside the
        picture, so that nothing saturates there; the coordinates have guard bits.
        """
        x, q = self.input, self.coordinate
        return replace(self, input=Q(x.i_bits + 1, x.f_bits),
                       coordinate=Q(q.i_bits, q.f_bits + GUARD_BITS))

    def with_skip(self):
        """The same formats with a skip path."""
        return replace(self, skip_weight=Q(14, 12))

    def with_tansig_bits(self, fraction_bits):
        """The same formats with a tan-sigmoid of that many fraction bits."""
        return replace(self, tansig=Q(1, fraction_bits + 1))

    def tansig_design(self, variant="mmhbc"):
        """The :class:`~ncdc_spec.tansig.Design` of a variant from ``net`` to ``tansig``.

        Raises
        ------
        InputError
            If there is none.
        """
        if self.tansig.i_bits != 1:
            raise InputError(f"the tan-sigmoid's format is {self.tansig}, "
                             f"one integer bit is needed")
        return design_for(variant, self.tansig.f_bits - 1, self.net)

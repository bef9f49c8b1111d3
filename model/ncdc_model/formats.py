"""The fixed-point formats of the network."""

from dataclasses import dataclass, replace

from ncdc_model.errors import InputError
from ncdc_model.fixed import Q
from ncdc_model.tansig import design_for

__all__ = ["Formats"]


@dataclass(frozen=True)
class Formats:
    """Fixed-point format of every signal of the network, input to output.

    ``tansig`` holds the tan-sigmoid's value with one bit more than its accuracy: the last bit is
    the constant one that stands for rounding (zero for the value 0), see ``tansig``.
    """
    input: Q = Q(1, 23)             # normalised scan coordinate
    hidden_weight: Q = Q(4, 20)
    hidden_bias: Q = Q(5, 27)
    net: Q = Q(5, 19)               # weighted sum of a hidden neuron, input of the tan-sigmoid
    tansig: Q = Q(1, 21)            # 20 fraction bits and the last one
    output_weight: Q = Q(12, 12)    # pixels
    output_bias: Q = Q(14, 18)      # pixels
    coordinate: Q = Q(14, 10)       # pixels

    def with_tansig_bits(self, fraction_bits):
        """The same formats with a tan-sigmoid of that many fraction bits."""
        return replace(self, tansig=Q(1, fraction_bits + 1))

    def tansig_design(self, variant="mmhbc"):
        """The :class:`~ncdc_model.tansig.Design` of a variant from ``net`` to ``tansig``.

        Raises
        ------
        InputError
            If there is none.
        """
        if self.tansig.i_bits != 1:
            raise InputError(f"the tan-sigmoid's format is {self.tansig}, "
                             f"one integer bit is needed")
        return design_for(variant, self.tansig.f_bits - 1, self.net)

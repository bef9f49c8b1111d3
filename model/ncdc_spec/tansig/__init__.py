"""Tan-sigmoid in integers, in three variants with one interface.

Equation (17) of the paper, for n in a signed format::

    f(n) = 2 / (1 + exp(-gamma n)) - 1 = sign(n) (1 - e) / (1 + e),   e = exp(-gamma |n|)

The designs compute f with gamma = 1; another gamma is folded into the weights before the
tan-sigmoid, see :mod:`ncdc_spec.descriptor`. docs/explanation/tansig.md derives the error bounds.
"""

from functools import cache

from ncdc_spec.errors import InputError
from ncdc_spec.fixed import Q
from ncdc_spec.tansig.classic import ClassicDesign
from ncdc_spec.tansig.design import Design, tansig
from ncdc_spec.tansig.mmhbc import TansigDesign
from ncdc_spec.tansig.table import TableDesign

__all__ = ["ClassicDesign", "Design", "FRACTION_BITS", "TableDesign", "TansigDesign", "VARIANTS",
           "choose_variant", "design_for", "tansig"]

VARIANTS = {"mmhbc": TansigDesign, "classic": ClassicDesign, "table": TableDesign}
FRACTION_BITS = (16, 18, 20, 22)


@cache
def design_for(variant="mmhbc", fraction_bits=20, input=Q(5, 19)):
    """The design of a ``variant`` (a key of VARIANTS) with its parameters for ``fraction_bits``.

    Raises
    ------
    InputError
        If the variant is unknown, there are no parameters for that many bits, or they are not
        faithful with this input format.
    """
    if variant not in VARIANTS:
        raise InputError(f"tan-sigmoid variant is {variant!r}, one of {', '.join(VARIANTS)} "
                         f"is needed")
    return VARIANTS[variant].for_bits(fraction_bits, input)


def choose_variant(name, hidden_neurons, free_products=None):
    """The variant ``name``, or for "auto" the smaller one on the board.

    "auto" is ``table`` if ``free_products`` suffices for ``hidden_neurons`` tan-sigmoids, else
    ``mmhbc``. ``free_products``: multipliers of 27 bits that the neurons leave free on the board;
    without a board (None) the result is ``mmhbc``.
    """
    if name != "auto":
        return name
    enough = (free_products or 0) >= TableDesign.multipliers * hidden_neurons
    return TableDesign.variant if enough else TansigDesign.variant

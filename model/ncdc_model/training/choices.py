"""Options of a training, except its points and the number of hidden neurons."""

from dataclasses import dataclass, field

from ncdc_model.training.rounding import check_weight_bits
from ncdc_model.view_range import ViewRange
from ncdc_spec.errors import InputError
from ncdc_spec.float_network import check_gamma
from ncdc_spec.formats import Formats
from ncdc_spec.nodes import NODES
from ncdc_spec.view import check_view_nodes

__all__ = ["HELD_OUT", "TrainingChoices"]

HELD_OUT = 7       # one point in seven, by hash, is held out


@dataclass(frozen=True)
class TrainingChoices:
    """Options of training a network and rounding it to integers.

    Parameters
    ----------
    trainer : {"lm", "ebp"}
        Levenberg-Marquardt, or the paper's error back-propagation.
    seed : int
        The same seed gives the same network.
    held_out : int
        One point in ``held_out`` is used for measuring only; 0 trains on all.
    skip : bool
        With a linear path from the inputs directly to the outputs (trainer lm only).
    options : dict
        Further arguments of the trainer, such as ``starts`` of lm or ``stop`` of ebp.
    formats : Formats
        Formats of the descriptor.
    weight_bits : int or None
        Weights and inputs get formats of that many bits, fitted to the network
        (:func:`ncdc_model.training.rounding.fitted_formats`); None: those of ``formats``.
    variant : str
        Variant of the descriptor's tan-sigmoid.
    gamma : float
        gamma of equation (17); the hidden weights are rescaled to compensate.
    nodes : int or "auto"
        Distance of the nodes, see ``Descriptor.nodes``; auto: the largest whose curvature error
        on this map is within ``ncdc_model.golden.nodes.CURVATURE_LIMIT``.
    views : ViewRange, optional
        The error is to be within the limit in these views of the map too. If no distance is, auto
        is the smallest one above 1, as the network at every pixel has no view.

    Raises
    ------
    InputError
        If ``weight_bits``, ``gamma`` or ``nodes`` is out of range, or ``nodes`` is 1 and there are
        ``views``.
    """
    trainer: str = "lm"
    seed: int = 0
    held_out: int = HELD_OUT
    skip: bool = False
    options: dict = field(default_factory=dict)
    formats: Formats = Formats()
    weight_bits: int | None = None
    variant: str = "mmhbc"
    gamma: float = 1.0
    nodes: int | str = "auto"
    views: ViewRange | None = None

    def __post_init__(self):
        check_gamma(self.gamma)
        if self.views:
            check_view_nodes(self.nodes)
        if self.weight_bits is not None:
            check_weight_bits(self.weight_bits)
        if self.nodes != "auto" and self.nodes not in NODES:
            raise InputError(f"the distance of the nodes is {self.nodes!r}, one of "
                             f"{', '.join(map(str, NODES))}, auto is needed")

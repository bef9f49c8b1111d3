"""A trained map for pictures of another size, of which the planner states what they would cost."""

from dataclasses import dataclass, replace

import numpy as np

from ncdc_spec.descriptor import Descriptor
from ncdc_spec.errors import InputError
from ncdc_spec.fixed import Q
from ncdc_spec.formats import REGISTER_BITS
from ncdc_spec.geometry import MAX_SIZE, MIN_SIZE, Geometry, ValidRows

__all__ = ["PLANNED_SIZE", "hardware_takes", "scaled"]

PLANNED_SIZE = 8192     # pixels per side that can be planned


@dataclass(frozen=True, repr=False)
class _PlannedGeometry(Geometry):
    """A geometry that may be larger than the hardware's."""
    max_size = PLANNED_SIZE


def hardware_takes(geometry):
    """Whether hardware can be generated for pictures of a geometry."""
    return max(*geometry.corrected, *geometry.distorted) <= MAX_SIZE


def scaled(descriptor, size):
    """The :class:`Descriptor` of the same lens for corrected pictures of another size.

    The sensor has as many times more columns and rows as the corrected picture: each axis is
    stretched. A pixel shows the same point of the scene as the pixel of the trained picture at
    its position. Where a format does not hold a larger number, it has more integer bits.

    Parameters
    ----------
    descriptor : Descriptor
    size : (int, int)
        Width and height of the corrected picture.

    Raises
    ------
    InputError
        If a side of either picture is outside 8..8192, or the picture is too narrow for the
        nodes.
    """
    old = descriptor.geometry
    for name, value in zip(("width", "height"), size):
        if not MIN_SIZE <= value <= PLANNED_SIZE:
            raise InputError(f"the {name} to plan is {value}, the limits are {MIN_SIZE} and "
                             f"{PLANNED_SIZE}")
    times = np.array(size) / old.corrected
    sensor = tuple(round(side * factor) for side, factor in zip(old.distorted, times))
    geometry = _PlannedGeometry(*size, *sensor, old.bayer, old.fill, old.interpolation)
    real, factors = descriptor.network, np.array(sensor) / old.distorted
    # Normalised coordinates are of the outermost pixels' centres, which are nearer to the border
    # in a larger picture. Pixel centres are whole numbers: a picture begins half a pixel before.
    reach = (np.array(size) - 1) / (times * (np.array(old.corrected) - 1))
    network = replace(
        real, hidden_weights=real.hidden_weights * reach,
        output_weights=real.output_weights * factors[:, None],
        output_biases=(real.output_biases + .5) * factors - .5,
        skip_weights=(None if real.skip_weights is None
                      else real.skip_weights * factors[:, None] * reach))
    rows = ((np.arange(size[1]) + .5) / times[1]).astype(int)
    valid = ValidRows(np.rint(descriptor.valid.spans[rows] * times[0]).astype(np.int64))
    formats = replace(descriptor.formats, **{
        name: _holding(getattr(descriptor.formats, name), values)
        for name, values in (("hidden_weight", network.with_gamma(1).hidden_weights),
                             ("output_weight", network.output_weights),
                             ("output_bias", network.output_biases),
                             ("skip_weight", network.skip_weights),
                             ("coordinate", np.array([max(sensor) + 1.]))) if values is not None})
    return Descriptor.quantise(network, geometry, valid, formats, variant=descriptor.variant,
                               nodes=descriptor.nodes)


def _holding(q, values):
    """The format ``q``, with as many more integer bits as real ``values`` need."""
    while not q.holds(q.quantise(values)):
        q = Q(q.i_bits + 1, min(q.f_bits, REGISTER_BITS - q.i_bits - 1))
    return q

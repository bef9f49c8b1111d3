"""The simulated lenses on which the accuracy goals were set."""

from ncdc_bench.reference_lenses import ReferenceLens


def reference_lens(name):
    """The noisy calibration dots of the lens ``name``, and its exact map on a dense grid."""
    lens = ReferenceLens(name)
    return lens.dots(), lens.truth(4)

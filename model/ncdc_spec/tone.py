"""Tone curves of straight pieces, short near black: positions and limits of their nodes."""

from ncdc_spec.errors import InputError

__all__ = ["COMMON_TONES", "LINEAR", "NODE_BITS", "NODE_PLACES", "check_tone"]

NODE_PLACES = (0, 1, 2, 3, *(p << e for e in range(1, 7) for p in (2, 3)), 256)
"""Values at the curve's 17 nodes: two pieces in every octave, of the length 1 below 4."""

NODE_BITS = 9                           # of a node: 0..256

LINEAR = NODE_PLACES
"""Nodes of the straight curve, which changes nothing."""

COMMON_TONES = ("linear", "sRGB", "gamma:2.2")
"""Names of the curves that the drivers have."""


def check_tone(nodes):
    """Raises :class:`InputError` unless ``nodes`` are 17 integers of 0..256."""
    if len(nodes) != len(NODE_PLACES):
        raise InputError(f"the tone curve has {len(nodes)} nodes, it must have "
                         f"{len(NODE_PLACES)}")
    for node in nodes:
        if not 0 <= node <= 256 or node != int(node):
            raise InputError(f"a node of the tone curve is {node}, it must be an integer of 0 to "
                             f"256")

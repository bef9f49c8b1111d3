"""Tone curves of straight pieces, short near black: positions and limits of their nodes."""

from ncdc_spec.errors import InputError

__all__ = ["COMMON_TONES", "LINEAR", "NODE_BITS", "NODE_POSITIONS", "check_tone"]

NODE_POSITIONS = (0, 1, 2, 3, *(p << e for e in range(1, 7) for p in (2, 3)), 256)
"""Input values at the curve's 17 nodes: two pieces per octave, of length 1 below 4."""

NODE_BITS = 9                           # of a node: 0..256

LINEAR = NODE_POSITIONS
"""Nodes of the identity."""

COMMON_TONES = ("linear", "sRGB", "gamma:2.2")
"""Names of the curves in the drivers."""


def check_tone(nodes):
    """Raises :class:`InputError` unless ``nodes`` are 17 integers of 0..256."""
    if len(nodes) != len(NODE_POSITIONS):
        raise InputError(f"the tone curve has {len(nodes)} nodes, it must have "
                         f"{len(NODE_POSITIONS)}")
    for node in nodes:
        if not 0 <= node <= 256 or node != int(node):
            raise InputError(f"a node of the tone curve is {node}, it must be an integer of 0 to "
                             f"256")

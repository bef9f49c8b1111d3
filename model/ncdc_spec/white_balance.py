"""Gains of the white balance from a frame's sums. Stands alone: the drivers carry a copy of it."""

__all__ = ["GAIN_BITS", "GAIN_F_BITS", "LARGEST_GAIN", "UNITY", "grey_world"]

GAIN_F_BITS = 8                             # fraction bits of a gain
GAIN_BITS = 10                              # of a gain, which has no sign
UNITY = 1 << GAIN_F_BITS                    # the gain 1.0
LARGEST_GAIN = (1 << GAIN_BITS) - 1         # 3.99609375


def grey_world(sums):
    """Gains, as registers hold them, with which the colours of a frame have equal means.

    The colour with the largest sum S keeps the gain 1.0, so that white stays white where samples
    are full; another one with the sum s has round(256 S / s), at most 1023. A frame whose sums
    are all zero says nothing: all gains are 1.0.

    Parameters
    ----------
    sums : sequence of int
        Sums of red, green and blue, as read from RED_SUM, GREEN_SUM and BLUE_SUM.

    Returns
    -------
    tuple of int
        For GAIN_RED, GAIN_GREEN and GAIN_BLUE, in 256ths.
    """
    largest = max(sums)
    if not largest:
        return (UNITY,) * len(sums)
    return tuple(min(LARGEST_GAIN, (2 * UNITY * largest + s) // (2 * s)) if s else LARGEST_GAIN
                 for s in sums)

"""Gains of the white balance from a frame's sums. Stands alone: the drivers carry a copy of it."""

__all__ = ["GAIN_BITS", "GAIN_F_BITS", "LARGEST_GAIN", "UNITY", "gains_word", "grey_world"]

GAIN_F_BITS = 8                             # fraction bits of a gain
GAIN_BITS = 10                              # of a gain, which has no sign
UNITY = 1 << GAIN_F_BITS                    # the gain 1.0
LARGEST_GAIN = (1 << GAIN_BITS) - 1         # 3.99609375


def grey_world(sums, gains=(UNITY, UNITY, UNITY)):
    """Gains, as registers hold them, with which the colours of a frame have equal means.

    Each colour needs its gain in the ``sums`` over its sum, times a factor. The colour that needs
    least has the gain 1.0, so that white stays white where samples are full. With that colour's
    sum S and gain G, another one with the sum s and the gain g has round(256 g S / (s G)), at most
    1023; one without a sum has 1023. A frame whose sums are all zero says nothing: all
    gains are 1.0. A gain of 0 counts as 1.

    Parameters
    ----------
    sums : sequence of int
        Sums of red, green and blue, as read from RED_SUM, GREEN_SUM and BLUE_SUM.
    gains : sequence of int
        Gains that are in the sums, in 256ths: those before interpolation that the frame was made
        with. Gains after interpolation are not in them.

    Returns
    -------
    tuple of int
        For GAIN_RED, GAIN_GREEN and GAIN_BLUE, or the gains before interpolation, in 256ths.
    """
    seen = [(max(gain, 1), s) for gain, s in zip(gains, sums) if s]
    if not seen:
        return (UNITY,) * len(sums)
    least, largest = seen[0]
    for gain, s in seen:
        if gain * largest < least * s:
            least, largest = gain, s
    return tuple(
        min(LARGEST_GAIN, (2 * UNITY * max(gain, 1) * largest + s * least) // (2 * s * least))
        if s else LARGEST_GAIN for gain, s in zip(gains, sums))


def gains_word(gains):
    """The word that CAPTURE_GAINS holds: ``gains`` of red, green and blue in 256ths, red lowest."""
    return sum(gain << k * GAIN_BITS for k, gain in enumerate(gains))

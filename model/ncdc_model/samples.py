"""Bits of samples, declared by a file or by the user, and their upper eight bits."""

import numpy as np

from ncdc_spec.errors import InputError

__all__ = ["check_bits", "eight_bits", "scaled"]

BITS = 8, 16           # limits of the bits of a sample
_USUAL = 8, 10, 12, 14, 16


def check_bits(bits):
    """``bits`` of a sample; raises :class:`InputError` outside 8 to 16."""
    if not BITS[0] <= bits <= BITS[1]:
        raise InputError(f"samples of {bits} bits are asked for, the limits are {BITS[0]} and "
                         f"{BITS[1]}")
    return bits


def scaled(samples, white):
    """uint8 of integer ``samples`` of 0 to ``white``.

    If ``white`` is all ones in 8 to 16 bits, the upper eight bits; else 255 samples / white,
    rounded. Samples above ``white`` become 255.
    """
    bits = white.bit_length()
    if samples.dtype == np.uint8 and white == 255:
        return samples
    if white + 1 == 1 << bits and bits >= BITS[0]:
        return np.minimum(samples >> (bits - 8), 255).astype(np.uint8)
    table = (np.arange(white + 1) * 510 + white) // (2 * white)
    return table.astype(np.uint8)[np.minimum(samples, white)]


def eight_bits(samples, declared, bits, name, warn):
    """The upper eight of the bits of ``samples``, uint8 or uint16, as uint8.

    ``declared`` is the largest value of a sample that the file declares, or None if it declares 16
    bits only: such files hold samples of 10 or 12 bits with zeros above. Then ``bits`` decides. If
    that is None too, the smallest common number of bits for the brightest sample is taken, and
    ``warn`` is called with a sentence on it.

    Raises
    ------
    InputError
        If ``bits`` is out of range or not what is declared, or a sample is larger than declared.
    """
    peak = int(samples.max(initial=0))
    if bits is not None:
        check_bits(bits)
    if declared is not None:
        if bits not in (None, declared.bit_length()):
            raise InputError(f"{name} declares samples of {declared.bit_length()} bits (0 to "
                             f"{declared}), --bits says {bits}")
        if peak > declared:
            raise InputError(f"{name} holds a sample of {peak} and declares {declared} as the "
                             f"largest")
        return scaled(samples, declared)
    if bits is None:
        bits = next(count for count in _USUAL if peak < 1 << count)
        warn(f"{name} has 16-bit samples, the brightest is {peak}: taken as {bits}-bit; "
             f"--bits says otherwise")
    if peak >> bits:
        raise InputError(f"{name} holds a sample of {peak}, {bits} bits end at {(1 << bits) - 1}")
    return scaled(samples, (1 << bits) - 1)

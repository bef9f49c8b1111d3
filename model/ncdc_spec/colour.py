"""How colours of corrected pixels are made: gains before and after, crest, and tone curve."""

from dataclasses import dataclass

from ncdc_spec.errors import InputError
from ncdc_spec.raw_gains import NO_RAW_GAINS
from ncdc_spec.tone import LINEAR, check_tone
from ncdc_spec.white_balance import LARGEST_GAIN, UNITY

__all__ = ["COLOURS", "Colour"]

COLOURS = ("red", "green", "blue")


@dataclass(frozen=True)
class Colour:
    """Gains and tone curve for each corrected pixel with a source; by default the identity.

    Parameters
    ----------
    gains : tuple of int
        Gains of red, green and blue after interpolation in 256ths, 0..1023: unsigned Q2.8, 0 to
        3.996.
    tone : tuple of int
        Nodes of the tone curve for all three colours; see :mod:`ncdc_model.golden.tone`.
    crest : int
        Strength of the crest, one of :data:`ncdc_spec.interpolation.CRESTS`; 0 unless the
        interpolation is directional.
    raw_gains : tuple of int
        Gains of red, green and blue samples of the raw frame, before interpolation, likewise.

    Raises
    ------
    InputError
        If there are not three gains, one is outside the limits, or the curve is bad.
    """
    gains: tuple = (UNITY,) * 3
    tone: tuple = LINEAR
    crest: int = 0
    raw_gains: tuple = NO_RAW_GAINS

    def __post_init__(self):
        for gains in (self.gains, self.raw_gains):
            _check_gains(gains)
        check_tone(self.tone)


def _check_gains(gains):
    """Raise :class:`InputError` unless ``gains`` are three, each within the limits."""
    if len(gains) != len(COLOURS):
        raise InputError(f"there are {len(gains)} gains, {len(COLOURS)} are needed")
    for name, gain in zip(COLOURS, gains):
        if not 0 <= gain <= LARGEST_GAIN or gain != int(gain):
            raise InputError(f"the gain of {name} is {gain} 256ths, it must be an integer of 0 "
                             f"to {LARGEST_GAIN}")

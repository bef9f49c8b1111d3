"""What a user of a network changes of a sensor, and where in its registers it is."""

from dataclasses import dataclass, field

__all__ = ["Controls", "Gain", "Mirror", "Part", "number_in"]

_UNITY = 8              # eighths of gain


@dataclass(frozen=True)
class Part:
    """Bits of a number that lie in one register.

    Parameters
    ----------
    address : int
    shift : int
        Lowest of these bits in the register.
    width : int
    low : int
        Lowest of these bits in the number.
    """
    address: int
    shift: int = 0
    width: int = 16
    low: int = 0

    @property
    def mask(self):
        """The bits in the register."""
        return (1 << self.width) - 1 << self.shift

    def taken(self, word):
        """The number's bits that are in the register's ``word``."""
        return (word & self.mask) >> self.shift << self.low

    def placed(self, word, number):
        """The register's ``word`` with these bits of ``number``."""
        return word & ~self.mask | number >> self.low << self.shift & self.mask


def number_in(parts, read):
    """The number whose bits are in ``parts``; ``read(address)`` gives a register's word."""
    return sum(part.taken(read(part.address)) for part in parts)


@dataclass(frozen=True)
class Gain:
    """An analog gain of (m0 w + c0) / (m1 w + c1), where w is the number in ``parts``: the formula
    of MIPI's Camera Command Set.

    Parameters
    ----------
    parts : tuple of Part
    m0, c0, m1, c1 : int
        The gain rises with w.
    largest : int
        The largest w.
    """
    parts: tuple
    m0: int
    c0: int
    m1: int
    c1: int
    largest: int

    def word(self, eighths):
        """The w whose gain is nearest to ``eighths`` / 8, about."""
        over, under = eighths * self.c1 - _UNITY * self.c0, _UNITY * self.m0 - eighths * self.m1
        return (over + under // 2) // under

    def eighths(self, word):
        """The gain of a w, in eighths, rounded, at least 1.0."""
        over, under = _UNITY * (self.m0 * word + self.c0), self.m1 * word + self.c1
        return max(_UNITY, (over + under // 2) // under)

    @property
    def high(self):
        """The largest gain, in whole eighths."""
        return _UNITY * (self.m0 * self.largest + self.c0) // (self.m1 * self.largest + self.c1)


@dataclass(frozen=True)
class Mirror:
    """A direction in which the sensor mirrors.

    Parameters
    ----------
    parts : tuple of Part
    plain, mirrored : int
        The number in them without a mirror, and with it.
    """
    parts: tuple
    plain: int = 0
    mirrored: int = 1


@dataclass(frozen=True)
class Controls:
    """Settings that a user of a network changes while the sensor sends frames.

    Parameters
    ----------
    exposure : tuple of Part
        Where the exposure is, in lines.
    margin : int
        Lines of a frame beyond its longest exposure.
    stretches : bool
        Whether a longer exposure makes the frame longer by itself.
    gain : Gain
    mirror_columns, mirror_rows : Mirror or None
        None: the picture cannot be mirrored so without a change of its first colour's position.
    pattern : tuple of Part
        Where the test pattern is; empty: there is none.
    patterns : dict of str to int
        Name and number of each test pattern that users choose from; 0 is "Off".
    """
    exposure: tuple
    margin: int
    stretches: bool
    gain: Gain
    mirror_columns: Mirror = None
    mirror_rows: Mirror = None
    pattern: tuple = ()
    patterns: dict = field(default_factory=dict)

    @property
    def parts(self):
        """All :class:`Part` of these settings."""
        mirrors = [one.parts for one in (self.mirror_columns, self.mirror_rows) if one]
        return (*self.exposure, *self.gain.parts, *sum(mirrors, ()), *self.pattern)

    @property
    def addresses(self):
        """Addresses of their registers, each once, in this order."""
        return tuple(dict.fromkeys(part.address for part in self.parts))

    def pattern_named(self, number):
        """Name of the test pattern of that number; "Off" if it is none that users choose."""
        return next((name for name, one in self.patterns.items() if one == number), "Off")

"""Video modes of the boards: those of VESA's "Display Monitor Timing", and slow ones."""

from dataclasses import dataclass

from ncdc_spec.errors import InputError

__all__ = ["MODES", "VideoMode", "mode_for", "mode_holding", "mode_named"]


@dataclass(frozen=True)
class VideoMode:
    """A video mode.

    Parameters
    ----------
    horizontal, vertical : (int, int, int, int)
        Visible pixels or lines, front porch, sync pulse, back porch.
    high : bool
        Whether the sync pulses are high.
    ratio : (int, int)
        Ratio of pixel clock to 50 MHz, within 0.15 % of the standard's, with an oscillator of the
        phase-locked loop below 1.3 GHz.
    suffix : str
        Suffix of the name, if it is not the mode of its size with about 60 frames per second.
    """
    horizontal: tuple
    vertical: tuple
    high: bool
    ratio: tuple
    suffix: str = ""

    @property
    def size(self):
        """Width and height in pixels."""
        return self.horizontal[0], self.vertical[0]

    @property
    def name(self):
        """Name on the command line."""
        return f"{self.size[0]}x{self.size[1]}{self.suffix}"

    def holds(self, width, height):
        """Whether a picture of this size fits."""
        return width <= self.size[0] and height <= self.size[1]

    @property
    def pixel_mhz(self):
        """Pixel clock in MHz."""
        return 50 * self.ratio[0] / self.ratio[1]


MODES = (
    VideoMode((640, 16, 96, 48), (480, 10, 2, 33), False, (141, 280)),
    VideoMode((800, 40, 128, 88), (600, 1, 4, 23), True, (4, 5)),
    VideoMode((1024, 24, 136, 160), (768, 3, 6, 29), False, (13, 10)),
    VideoMode((1280, 110, 40, 220), (720, 5, 5, 20), True, (89, 60)),
    # No standard: a mode that a memory of 16 bits carries line by line, with a pixel clock just
    # above DVI's minimum, 25 MHz. Pulses and lines are those of VESA's reduced blanking.
    VideoMode((1280, 48, 32, 340), (720, 3, 5, 6), True, (101, 200), "@20"),
    VideoMode((1280, 48, 112, 248), (1024, 1, 3, 38), True, (54, 25)),
    VideoMode((1920, 88, 44, 148), (1080, 4, 5, 36), True, (89, 30)),
)


def mode_named(name):
    """The mode of that name, as in 640x480; :class:`InputError` if there is none."""
    for mode in MODES:
        if mode.name == name:
            return mode
    raise InputError(f"the mode is {name!r}, one of {', '.join(mode.name for mode in MODES)} is "
                     f"needed")


def mode_for(width, height):
    """The smallest mode that shows ``width`` x ``height`` pixels; :class:`InputError` if none."""
    for mode in MODES:
        if mode.holds(width, height):
            return mode
    raise InputError(f"the corrected picture has {width}x{height} pixels, the largest video mode "
                     f"has {MODES[-1].size[0]}x{MODES[-1].size[1]}")


def mode_holding(geometry, name=None):
    """The mode called ``name``, by default the smallest one, for the corrected pictures of a
    geometry; :class:`InputError` if they do not fit."""
    smallest = mode_for(*geometry.corrected)
    wanted = mode_named(name) if name else smallest
    if not wanted.holds(*geometry.corrected):
        raise InputError(f"the picture has {geometry.corrected_width}x"
                         f"{geometry.corrected_height} pixels, the mode {name} does not hold it: "
                         f"{smallest.name} does")
    return wanted

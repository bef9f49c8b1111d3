"""The raw frames that the Verilog model of a sensor sends, computed from its configuration."""

import numpy as np

from ncdc_spec.sensors.mt9p031 import TEST_COLOURS

__all__ = ["raw_frames"]

_WHITE = 4095
_BARS = ("RGB", "RG", "GB", "G", "RB", "R", "B", "")    # colours that are on, bar by bar
_BAR = 16               # pixels of a grey bar


def raw_frames(setup, light):
    """Frames (frames, height, width) of uint16, 12 bits, that a sensor sends of ``light``.

    With factor = floor(exposure * gain * 256 / nominal), in which a gain of 1 is 256, a sample s
    becomes min(4095, floor((s * factor + 32768) / 65536) + black). A test pattern replaces it. Bits
    that the sensor does not have are cleared. With binning, s is floor((sum + n / 2) / n) of its n
    pixels, of which those without light are 0.

    Parameters
    ----------
    setup : Setup
    light : Light
    """
    sensor = setup.sensor
    bins = setup.settings.bins
    # Of the first pixel of each mean, whose colour it keeps.
    u, v = np.array(setup.columns) - (bins - 1), np.array(setup.rows) - (bins - 1)
    count = len(light.frames)
    if setup.settings.test_pattern == "Off":
        samples = sum(_read(light, u + 2 * i, v + 2 * j) for i in range(bins) for j in range(bins))
        samples = (samples + bins * bins // 2) // bins**2
        factor = 1 << 16
        if light.nominal:
            factor = setup.exposure_clocks * setup.gain_256 * 256 // light.nominal
        samples = np.minimum(_WHITE, (samples * factor + (1 << 15) >> 16) + sensor.black)
    else:
        pattern = _pattern(setup.settings.test_pattern, sensor.bayer, u, v)
        samples = np.repeat(pattern[None], count, axis=0)
    return (samples & -1 << 12 - sensor.bits).astype(np.uint16)


def _read(light, u, v):
    """Samples (frames, rows, columns) of the active pixels of columns ``u`` and rows ``v``."""
    count, height, width = light.frames.shape
    samples = np.zeros((count, len(v), len(u)), np.int64)
    rows = (v >= light.top) & (v < light.top + height)
    columns = (u >= light.left) & (u < light.left + width)
    samples[np.ix_(range(count), rows, columns)] = light.frames[
        np.ix_(range(count), v[rows] - light.top, u[columns] - light.left)]
    return samples


def _pattern(name, bayer, u, v):
    """The test pattern as an array, for the active pixels of columns ``u`` and rows ``v``."""
    y, x = np.indices((len(v), len(u)))
    if name in ("ColorField", "ColorBar"):
        colour = np.array(list(bayer)).reshape(2, 2)[np.ix_(v % 2, u % 2)]
        if name == "ColorField":
            return sum((colour == key) * value for key, (_, value) in TEST_COLOURS.items())
        bars = np.array([[letter in bar for letter in "RGB"] for bar in _BARS])
        letter = np.searchsorted(["B", "G", "R"], colour)
        return _WHITE * bars[x * len(_BARS) // len(u), 2 - letter]
    return {
        "GreyHorizontalRamp": lambda: x * _WHITE // (len(u) - 1),
        "GreyVerticalRamp": lambda: y * _WHITE // (len(v) - 1),
        "GreyDiagonalRamp": lambda: (x + y) * _WHITE // (len(u) + len(v) - 2),
        "WalkingOnes": lambda: np.where(x % 16 < 12, 1 << x % 16, 0),
        "HorizontalBars": lambda: _WHITE * (y // _BAR % 2),
        "VerticalBars": lambda: _WHITE * (x // _BAR % 2),
    }[name]()

"""White balance and tone of pixels, of any gains and curves."""

import numpy as np

from ncdc_model.golden.colour import coloured
from ncdc_model.golden.corrector import Corrected
from ncdc_spec.colour import Colour
from ncdc_spec.tone import NODE_POSITIONS
from ncdc_spec.white_balance import LARGEST_GAIN, UNITY
from pipelines import run_pipeline

__all__ = ["check_colour"]


def _settings(rng, number):
    """Gains and a curve: any numbers, or their limits."""
    if number % 3 == 2:
        gains = rng.choice([0, UNITY, UNITY, UNITY, LARGEST_GAIN], 3)
        tone = rng.choice([0, 255, 256], len(NODE_POSITIONS))
    else:
        gains = rng.integers(0, LARGEST_GAIN + 1, 3) >> int(rng.integers(3))
        tone = rng.integers(0, 257, len(NODE_POSITIONS))
        if number % 3:
            tone = np.sort(tone)
    return Colour(tuple(gains.tolist()), tuple(tone.tolist()))


def check_colour(dut, settings=45, count=64):
    """Compare with the golden model.

    ``dut``: a :class:`ncdc_hdl.backend.colour.Colour`; ``count``: pixels of each of the
    ``settings``, which stay until the pixels have left.
    """
    rng, items, expected = np.random.default_rng(6), [], []
    for number in range(settings):
        colour = _settings(rng, number)
        pixels = rng.integers(0, 256, (count, 3)) >> rng.integers(0, 5, (count, 1))
        picture = pixels.astype(np.uint8)[None]
        expected += coloured(Corrected(picture, np.zeros(picture.shape[:2], bool), 0),
                             colour)[0].tolist()
        items += [(colour, pixel) for pixel in pixels.tolist()]
        items += [(colour, pixels[-1].tolist())] * dut.latency      # of which nothing is compared
        expected += [None] * dut.latency

    def drive(ctx, item):
        colour, pixel = item
        ctx.set(dut.colour, {"gains": colour.gains, "tone": colour.tone})
        ctx.set(dut.i, pixel)

    found = run_pipeline(dut, items, drive, lambda: list(dut.o))
    for one, wanted in zip(found, expected, strict=True):
        assert wanted is None or list(one) == wanted

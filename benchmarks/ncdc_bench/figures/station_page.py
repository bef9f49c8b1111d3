"""The page of a station, of ``docs/howto/production_lot.md``: a unit that passes, one that fails.

    python -m ncdc_bench.figures.station_page docs/figures/station.jpg

Needs Chromium. Half a minute.
"""

import subprocess
import sys
from pathlib import Path
from tempfile import TemporaryDirectory

import cv2
import numpy as np

from ncdc_bench.lot.processes import station
from ncdc_bench.lot.units import LIMITS, make_unit, write_photos

__all__ = ["draw", "screenshot"]

_SIZE = 1280, 800
_SCALE, _QUALITY = 0.6, 88          # of the figure, and of its JPEG
_TIME = 3000                        # milliseconds of the page's own clock


def screenshot(url, path, dark=False):
    """Picture of the page at ``url``, uint8 BGR, by way of the PNG file ``path``."""
    subprocess.run(["chromium", "--headless", "--no-sandbox", "--hide-scrollbars",
                    *(["--blink-settings=preferredColorScheme=0"] if dark else []),
                    f"--virtual-time-budget={_TIME}", f"--screenshot={path}",
                    "--window-size={},{}".format(*_SIZE), url], check=True,
                   stderr=subprocess.DEVNULL)
    return cv2.imread(str(path))


def draw(path):
    """Write the figure: PASS in the light colours, FAIL in the dark ones, next to each other."""
    limits = [part for name, value in LIMITS.items()
              for part in (f"--{name.replace('_', '-')}", value)]
    with TemporaryDirectory() as work:
        folder = Path(work, "photos")
        folder.mkdir()
        with station(folder, Path(work, "march"), "--neurons", 8, "--photos", 3,
                     "--station", "left", *limits) as running:
            shots = []
            for number, kind, word in ((1, "", "PASS"), (2, "rolled", "FAIL")):
                unit = make_unit(number, kind)
                write_photos(folder, unit)
                running.wait_for((word, unit.serial))
                shots.append(screenshot(running.url, Path(work, "shot.png"), dark=bool(kind)))
    cv2.imwrite(path, cv2.resize(np.hstack(shots), None, fx=_SCALE, fy=_SCALE,
                                 interpolation=cv2.INTER_AREA),
                [cv2.IMWRITE_JPEG_QUALITY, _QUALITY])


if __name__ == "__main__":
    draw(sys.argv[1])

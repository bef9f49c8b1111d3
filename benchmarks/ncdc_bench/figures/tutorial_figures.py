"""The pictures of ``docs/start/tutorial.md``, made by its commands.

    python -m ncdc_bench.figures.tutorial_figures docs/figures

A minute, of which the training takes most.
"""

import sys
from pathlib import Path
from tempfile import TemporaryDirectory

import cv2

from ncdc.cli import main
from ncdc_model.example import example_camera, target_photo
from ncdc_model.images import write_image

__all__ = ["PICTURES", "draw"]

PICTURES = {"points.overlay.png": "tutorial-points.jpg", "corrected.png": "tutorial-corrected.jpg"}
_WIDTH = 960        # pixels that a page shows
_QUALITY = 85       # of JPEG


def draw(folder):
    """Write the pictures into a folder; raise RuntimeError if a command fails."""
    with TemporaryDirectory() as work:
        names = [str(Path(work) / name) for name in ("photo.raw.png", "points.json", "net.toml",
                                                     "corrected.png")]
        photo, points, net, corrected = names
        write_image(photo, target_photo(example_camera()))
        for arguments in (["calibrate", photo, "--target", "dots", "-o", points],
                          ["train", points, "--neurons", "8", "--size", "640x480", "-o", net],
                          ["correct", net, photo, "-o", corrected]):
            if main(arguments):
                raise RuntimeError(f"ncdc {' '.join(arguments)} failed")
        for name, figure in PICTURES.items():
            picture = cv2.imread(str(Path(work) / name))
            height = round(picture.shape[0] * _WIDTH / picture.shape[1])
            smaller = cv2.resize(picture, (_WIDTH, height), interpolation=cv2.INTER_AREA)
            cv2.imwrite(str(Path(folder) / figure), smaller, [cv2.IMWRITE_JPEG_QUALITY, _QUALITY])


if __name__ == "__main__":
    draw(sys.argv[1])

"""``ncdc bench grid``: pictures of a sensor that skips or bins, its Bayer grid evened or not."""

import tempfile
from pathlib import Path

import numpy as np

from ncdc.cli.common import add_json, write_report
from ncdc.terminal import Progress, say
from ncdc_bench.grid.light import camera_of, photo_light, scene_light
from ncdc_bench.grid.measure import GRIDS, SAMPLINGS, measure
from ncdc_model.example import BAYER, example_camera
from ncdc_model.images import read_image
from ncdc_model.training.pipeline import train_camera
from ncdc_model.training.source import load_source
from ncdc_spec.errors import InputError

__all__ = ["EXAMPLE", "HELP", "add_arguments", "run", "table"]

HELP = ("correct pictures of a sensor that skips or bins, with its uneven Bayer grid as it is and "
        "evened, and compare both with an even grid")
EXAMPLE = "ncdc bench grid photo.jpg --blur 1.5 --json grid.json"


def add_arguments(parser):
    """Declare the command's arguments on an argparse parser."""
    parser.add_argument("pictures", nargs="*", metavar="FILE",
                        help="photos whose pixels are the sensor's active ones; the built-in scene "
                             "is always measured")
    parser.add_argument("--blur", type=float, default=1.0, metavar="PIXELS",
                        help="standard deviation of the lens's Gaussian blur in active pixels "
                             "(default: 1)")
    parser.add_argument("--neurons", type=int, default=8, metavar="N",
                        help="hidden neurons of the map (default: 8)")
    add_json(parser)


def run(args):
    """Train the map, correct, measure and report."""
    if not 0 <= args.blur <= 16:
        raise InputError(f"blur is {args.blur}, it must be 0 to 16")
    photos = [(Path(path).stem, read_image(path, warn=say)) for path in args.pictures]
    camera, rows, descriptors = example_camera(), [], {}
    jobs = [(photo, sampling) for photo in (None, *photos) for sampling in SAMPLINGS]
    progress = Progress("grid")
    for k, (photo, sampling) in enumerate(jobs):
        progress(k / len(jobs), f" {photo[0] if photo else 'built-in scene'}, {sampling}")
        reduction = SAMPLINGS[sampling][0]
        light = (photo_light(*photo, reduction, args.blur) if photo
                 else scene_light(camera, reduction, args.blur))
        if light.size not in descriptors:
            descriptors[light.size] = _descriptor(camera_of(camera, light.size), args.neurons)
        rows += measure(descriptors[light.size], light, sampling, BAYER)
    progress(1)
    if not write_report({"blur_px": args.blur, "rows": rows}, args.json):
        print(table(rows))


def _descriptor(camera, neurons):
    """The descriptor trained for ``camera``."""
    with tempfile.TemporaryDirectory(prefix="ncdc-") as folder:
        path = Path(folder) / "camera.toml"
        camera.save(path)
        return train_camera(load_source(path, bayer=BAYER), neurons).descriptor


def table(rows):
    """Rows as text: PSNR of the even grid, and how much more the others have.

    Several pictures have a row of their means as well.
    """
    lines = [f"{'':<45} at points of the light        its means over the pitch",
             f"{'picture':<20} {'sampling':<13} {'by':<10}  even, dB  uneven  evened    "
             "even, dB  uneven  evened"]
    pictures = list(dict.fromkeys(row["picture"] for row in rows))
    means = [("mean of all", pictures)] if len(pictures) > 1 else []
    for title, names in [*((name, [name]) for name in pictures), *means]:
        for sampling in dict.fromkeys(row["sampling"] for row in rows):
            for way in dict.fromkeys(row["interpolation"] for row in rows):
                some = [row for row in rows if row["picture"] in names and (
                    row["sampling"], row["interpolation"]) == (sampling, way)]
                lines.append(f"{title[:20]:<20} {sampling:<13} {way:<10}{_figures(some)}")
    return "\n".join(lines)


def _figures(rows):
    """The columns of figures, means of ``rows``."""
    def mean(grid, name):
        return float(np.mean([row[name] for row in rows if row["grid"] == grid]))

    even, uneven, evened = GRIDS
    return "  ".join(
        f"{mean(even, f'psnr{kind}_db'):10.2f} {mean(uneven, f'gain{kind}_db'):+7.2f} "
        f"{mean(evened, f'gain{kind}_db'):+7.2f}" for kind in ("", "_mean"))

"""``ncdc bench pictures``: quality of the corrected picture, compared with others' flows."""

import tempfile
from pathlib import Path

import numpy as np

from ncdc.cli.common import add_json, write_report
from ncdc.terminal import Progress, say
from ncdc_bench.pictures.measure import Subject, fitted, measure
from ncdc_bench.pictures.peers import PEER_PACKAGE
from ncdc_bench.pictures.plots import plot_crops
from ncdc_bench.pictures.sets import set_rows, synthetic_rows
from ncdc_model.example import BAYER, example_camera, scene_light
from ncdc_model.images import read_image
from ncdc_model.training.pipeline import train_camera
from ncdc_model.training.source import load_source
from ncdc_spec.errors import InputError
from ncdc_spec.files import check_outputs

__all__ = ["EXAMPLE", "HELP", "add_arguments", "run", "table"]

HELP = ("correct pictures by the map of the built-in example with each interpolation, and by "
        "the demosaicing of OpenCV and colour-demosaicing with OpenCV's remapping")
EXAMPLE = "ncdc bench pictures photo.jpg -o plots --json pictures.json"

# Flows that demosaic alike, or remap bicubically, are left out.
_SHOWN = ("reference", "fast", "gradient", "directional", "directional+crest",
          "opencv bilinear, bilinear", "opencv edge-aware, bilinear", "opencv vng, bilinear",
          "opencv vng, bicubic", "menon, bilinear")
_HEADS = "  false colour  at edges  overshoot"


def add_arguments(parser):
    """Declare the command's arguments on an argparse parser."""
    parser.add_argument("pictures", nargs="*", metavar="FILE",
                        help="colour pictures, of which the middle is taken; the built-in scene is "
                             "always measured")
    parser.add_argument("--neurons", type=int, default=8, metavar="N",
                        help="hidden neurons of the map (default: 8)")
    parser.add_argument("--set", action="append", default=[], metavar="DIR", dest="sets",
                        help="also a folder of colour pictures, without the map: means over them, "
                             "with noise, without white balance, and of linear light too; may be "
                             "given again; a set of synthetic pictures is always measured")
    parser.add_argument("-o", "--output", metavar="DIR",
                        help="also write each picture before and after, with an enlarged crop "
                             "of every flow")
    add_json(parser)


def run(args):
    """Train the map, correct, measure and report."""
    if args.output:
        check_outputs([Path(args.output) / "pictures.jpg"], [])
    camera = example_camera()
    scene = np.clip(np.floor(scene_light(camera) + .5), 0, 255).astype(np.uint8)
    size = scene.shape[1::-1]
    subjects = [Subject("built-in scene", scene), *(_photo(path, size) for path in args.pictures)]
    progress, rows = Progress("pictures"), []
    with tempfile.TemporaryDirectory(prefix="ncdc-") as folder:
        path = Path(folder) / "camera.toml"
        camera.save(path)
        descriptor = train_camera(load_source(path, bayer=BAYER), args.neurons).descriptor
    for k, subject in enumerate(subjects):
        progress((k + 1) / (len(subjects) + 1), f" {subject.name}")
        found, pictures = measure(descriptor, subject)
        rows += found
        if args.output:
            name = subject.name.replace(" ", "-")
            plot_crops(Path(args.output) / f"pictures-{name}.jpg", subject.colour,
                       {flow: pictures[flow] for flow in _SHOWN if flow in pictures}, found)
    done = len(subjects) / (len(subjects) + 1)
    rows += synthetic_rows(progress=lambda name: progress(done, f" synthetic: {name}"))
    for folder in args.sets:
        rows += set_rows(folder, progress=lambda name, folder=folder: progress(
            done, f" {folder}: {name}"))
    progress(1)
    if not write_report({"rows": rows}, args.json):
        print(table(rows))


def _photo(path, size):
    """The :class:`Subject` of a picture file.

    Raises
    ------
    InputError
        If it cannot be read, has no colour, or is smaller than ``size``.
    """
    colour = read_image(path, warn=say)
    if colour.ndim != 3:
        raise InputError(f"{path} has one channel, a colour picture is needed")
    if colour.shape[1] < size[0] or colour.shape[0] < size[1]:
        raise InputError(f"{path} has {colour.shape[1]}x{colour.shape[0]} pixels, at least "
                         f"{size[0]}x{size[1]} are needed")
    return Subject(Path(path).stem, fitted(colour, size))


def table(rows):
    """Rows as text."""
    lines = [f"{'picture':<20} {'flow':<30} PSNR, dB  to Lanczos    SSIM{_HEADS}"]
    for row in (row for row in rows if "picture" in row):
        lines.append(f"{row['picture'][:20]:<20} {row['flow']:<30} " + _figures(
            row, lambda row: f"{row['psnr_db']:8.2f} {row['psnr_lanczos_db']:11.2f} "
                             f"{row['ssim']:7.4f}"))
    lines.append(f"\n{'set':<20} {'flow':<20} noise  gains, light         PSNR, dB{_HEADS}")
    for row in (row for row in rows if "set" in row):
        gains = ("/".join(f"{gain:g}" for gain in row["gains"]) + " first" * row["balanced_first"]
                 + " linear" * row["linear"])
        lines.append(f"{row['set'][:20]:<20} {row['flow']:<20} {row['noise']:5g}  {gains:<20} "
                     + _figures(row, lambda row: f"{row['psnr_db']:10.2f}"))
    return "\n".join(lines)


def _figures(row, own):
    """A row's figures, the first ones by the function ``own``."""
    if row["psnr_db"] is None:
        return f"not installed: {PEER_PACKAGE}"
    return own(row) + (f" {row['false_colour']:13.2f} {row['edge_colour']:9.2f} "
                       f"{row['overshoot']:10.3f}")

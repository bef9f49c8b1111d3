"""A process that makes a lens of photos: calibrates, trains, and reports its progress.

    python -m ncdc_host.gui.calibration_job PHOTO ... FOLDER --neurons 8 --target auto ...

Each line of its output is a JSON object: {"step": text}, {"share": 0..1, "mse": px^2} or
{"points": count, "target": name, "overlay": path}. The last one is {"report": {...}, "lens": path}
or {"error": sentence}. A separate process can be ended at once, and does not block the window.
"""

import argparse
import json
import os
import sys
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np

from ncdc_model.calibration.detect import detect_points
from ncdc_model.calibration.frame import ideal_frame
from ncdc_model.calibration.overlay import draw_points
from ncdc_model.compare import difference_from
from ncdc_model.images import demosaic, is_raw, read_image, write_image
from ncdc_model.training.choices import TrainingChoices
from ncdc_model.training.pipeline import train_camera
from ncdc_model.training.source import load_source
from ncdc_spec.errors import InputError
from ncdc_spec.interpolation import DEFAULT, interpolation_of

__all__ = ["LENS", "main"]

LENS = "net.toml"


def main(arguments=None):
    """Run it; returns the exit status."""
    args = _parser().parse_args(arguments)
    if arguments is None and hasattr(os, "nice"):
        os.nice(10)         # the window and its pictures come first
    try:
        # What overflows becomes not-a-number, which the checks of the training name.
        with np.errstate(all="ignore"):
            _run(args)
    except InputError as error:
        _tell(error=str(error))
        return 2
    return 0


def _parser():
    parser = argparse.ArgumentParser(prog="calibration_job")
    parser.add_argument("photos", type=Path, nargs="+")
    parser.add_argument("folder", type=Path)
    parser.add_argument("--target", default="auto")
    parser.add_argument("--neurons", type=int, default=8)
    parser.add_argument("--bayer", default="RGGB")
    parser.add_argument("--size", type=int, nargs=2)
    parser.add_argument("--fill", type=int, nargs=3, default=(0, 0, 0))
    parser.add_argument("--nodes", type=lambda text: text if text == "auto" else int(text),
                        default="auto")
    parser.add_argument("--interpolation", default=DEFAULT.name)
    parser.add_argument("--previous", type=Path)
    return parser


def _tell(**about):
    print(json.dumps(about), flush=True)


def _run(args):
    _tell(step="Looking for the target")
    points = detect_points([(photo.name, partial(read_image, photo)) for photo in args.photos],
                           args.target).rounded
    overlay = args.folder / "points.png"
    try:
        frame = ideal_frame(points)
    except InputError:
        frame = None        # the picture shows the points without arrows; training says why
    replace(points, fits=() if frame is None else frame.fits).save(args.folder / "points.json")
    raw = read_image(next(photo for photo in args.photos if photo.name == points.photos[0].name))
    write_image(overlay, draw_points(demosaic(raw, args.bayer) if is_raw(raw) else raw,
                                     points.photos[0], frame))
    _tell(points=points.count, target=points.target, overlay=str(overlay))
    _tell(step=f"Training {args.neurons} hidden neurons")
    source = load_source(args.folder / "points.json", args.size, bayer=args.bayer,
                         fill=tuple(args.fill),
                         interpolation=interpolation_of(args.interpolation))
    trained = train_camera(source, args.neurons, TrainingChoices(nodes=args.nodes),
                           lambda share, mse: _tell(share=share, mse=float(mse)))
    lens = args.folder / LENS
    trained.descriptor.save(lens)
    report = trained.report
    errors = report["map_error_fixed_px"]
    _tell(lens=str(lens), report={
        "neurons": report["hidden_neurons"], "warnings": report["warnings"],
        "mean_px": errors["mean"], "max_px": errors["max"],
        "valid_percent": report["valid_percent"],
        "straightness_rms_px": report["straightness_rms_px"],
        "difference_px": None if args.previous is None else difference_from(
            source.frame.camera, args.previous)})


if __name__ == "__main__":
    sys.exit(main())

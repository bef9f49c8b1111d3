"""``ncdc train``: from points or a camera file to a descriptor."""

import argparse
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np

from ncdc.cli.common import add_camera, add_json, straightness_text, write_report
from ncdc.terminal import Progress
from ncdc_model.errors import InputError
from ncdc_model.evaluate import fixed_map
from ncdc_model.fixed import Q
from ncdc_model.formats import MAX_NEURONS, Formats
from ncdc_model.geometry import BAYER_PHASE
from ncdc_model.interpolation import FAST, INTERPOLATIONS, interpolation_of
from ncdc_model.plots import plot_error_map, plot_learning_curve, plot_point_errors
from ncdc_model.tansig import FRACTION_BITS, VARIANTS, choose_variant
from ncdc_model.training.backprop import Stop
from ncdc_model.training.choices import HELD_OUT, TrainingChoices
from ncdc_model.training.choose import choose_camera
from ncdc_model.training.pipeline import train_camera
from ncdc_model.training.problem import split
from ncdc_model.training.source import load_source
from ncdc_model.training.train import TRAINERS

__all__ = ["EXAMPLE", "HELP", "add_arguments", "error_table", "plot_training", "run",
           "training_progress"]

HELP = "train a camera's network and write its descriptor"
EXAMPLE = "ncdc train points.json --neurons 6 -o net.toml"


def add_arguments(parser):
    """Declare the command's arguments on an argparse parser."""
    parser.add_argument("source", metavar="FILE",
                        help="points.json of ncdc calibrate, or a camera file: OpenCV, ROS, "
                             "Kalibr, BoofCV (YAML, XML, JSON), or our own (TOML)")
    parser.add_argument("--neurons", type=_neurons, required=True, metavar="N",
                        help="hidden neurons, 4 to 12 are usual; auto: the fewest, up to 16, that "
                             "meet --max-error")
    parser.add_argument("--max-error", type=float, metavar="PX",
                        help="with --neurons auto: largest error, on the whole frame where a "
                             "camera file is the source, else at the held-out points")
    parser.add_argument("--skip", action="store_true",
                        help="add a linear path from the inputs straight to the outputs: four "
                             "products that save about one hidden neuron")
    parser.add_argument("--trainer", choices=list(TRAINERS), default="lm",
                        help="lm: Levenberg-Marquardt from many starts (default); ebp: the "
                             "paper's error back-propagation, for comparison")
    parser.add_argument("--epochs", type=int, metavar="E",
                        help="with --trainer ebp: most passes over the points (default: 5000)")
    parser.add_argument("--size", metavar="WxH",
                        help="corrected picture (default: as large as the camera's)")
    parser.add_argument("--zoom", metavar="Z",
                        help="fit: the camera's full width fills the picture (default); fill: no "
                             "pixel without a source; or a number: magnification in the middle")
    parser.add_argument("--seed", type=int, default=0, metavar="S",
                        help="same seed, same descriptor (default: 0)")
    parser.add_argument("--held-out", type=int, default=HELD_OUT, metavar="K",
                        help=f"one point in K only measures; 0: none (default: {HELD_OUT})")
    parser.add_argument("--bayer", choices=list(BAYER_PHASE), default="RGGB",
                        help="colour filter of the sensor, first two rows (default: RGGB)")
    parser.add_argument("--interpolation", choices=list(INTERPOLATIONS), default=FAST.name,
                        help="fast: the paper's, from 3x3 raw samples, for every fetcher and the "
                             "smallest core (default); gradient: gradient-corrected colour from "
                             "6x6, five decibels better, for the tile cache")
    parser.add_argument("--fill", default="0,0,0", metavar="R,G,B",
                        help="colour of pixels without a source (default: 0,0,0)")
    parser.add_argument("--tansig", choices=[*VARIANTS, "auto"], default="mmhbc",
                        help="tan-sigmoid: mmhbc: the paper's, no multiplier (default); classic: "
                             "plain CORDIC, for comparison; table: quadratics, two multipliers "
                             "each; auto: table where a board has multipliers free, else mmhbc")
    parser.add_argument("--tansig-bits", type=int, choices=FRACTION_BITS, default=20,
                        help="accuracy of the tan-sigmoid in fraction bits (default: 20)")
    parser.add_argument("--weight-bits", type=int, metavar="B",
                        help="bits of the weights and of the coordinates they multiply, 18 to 24, "
                             "in formats that fit this camera; 18 for boards with 18x18 "
                             "multipliers (default: 24 in formats that fit every camera)")
    parser.add_argument("--coordinate-bits", type=int, choices=range(6, 13), default=10,
                        help="fraction bits of the back-map coordinates (default: 10)")
    parser.add_argument("--gamma", type=float, default=1.0, metavar="G",
                        help="gamma of the tan-sigmoid, equation (17); the hidden weights make "
                             "good for it (default: 1)")
    parser.add_argument("-o", "--output", default="net.toml", metavar="FILE",
                        help="descriptor (default: net.toml); plots go beside it")
    add_camera(parser)
    add_json(parser)


def run(args):
    """Train, quantise, measure; write the descriptor, the plots and the report."""
    if Path(args.output).resolve() == Path(args.source).resolve():
        raise InputError(f"the output {args.output} would replace the input")
    if args.seed < 0:
        raise InputError(f"seed is {args.seed}, it must not be negative")
    if (args.neurons == "auto") != (args.max_error is not None):
        raise InputError("--neurons auto and --max-error belong together, one of them is missing")
    source = load_source(args.source, _size(args.size) if args.size else None, args.zoom,
                         args.bayer, _colour(args.fill), args.camera,
                         interpolation_of(args.interpolation))
    trained = _train(args, source)
    trained.descriptor.save(args.output)
    plots = plot_training(trained, source, args.output, args.held_out)
    report = trained.report | {"descriptor": str(args.output), "digest": trained.descriptor.digest,
                               "plots": plots}
    lost = report["valid_pixels_lost"]
    if lost:
        print(f"warning: {lost} pixels with a source are left blank, because their row has more "
              f"than two spans", file=sys.stderr)
    if write_report(report, args.json):
        return
    width, height = source.geometry.corrected
    skip = ", skip path" if args.skip else ""
    print(f"{report['hidden_neurons']} hidden neurons{skip}, {width}x{height} corrected pixels, "
          f"{report['valid_percent']:.1f} % with a source")
    if report.get("extrapolated_percent"):
        print(f"{report['extrapolated_percent']:.1f} % lie beyond the calibrated points: there the "
              f"network follows the smooth lens fitted to them")
    print(error_table({name: report[name] for name in ("training", "held_out", "frame")
                       if name in report}))
    print(f"fixed minus float: at most {report['fixed_minus_float_max_px']:.5f} px on an axis")
    if source.frame:
        print(straightness_text(report, "held-out points" if args.held_out else "points"))
        for reason, count in report["points_dropped"].items():
            print(f"  {count} points not used: {reason}")
    print(f"{args.output}; look at {' and '.join(plots)}")


def _train(args, source):
    choices = _choices(args)
    if args.neurons == "auto":
        return choose_camera(source, args.max_error, choices, training_progress(), _tried)
    return train_camera(source, args.neurons, choices, training_progress())


def _choices(args):
    options = {}
    if args.epochs is not None:
        if args.trainer != "ebp":
            raise InputError("--epochs is an option of the trainer ebp")
        if args.epochs < 1:
            raise InputError(f"{args.epochs} epochs are asked for, the least is 1")
        options["stop"] = Stop(epochs=args.epochs)
    return TrainingChoices(
        trainer=args.trainer, seed=args.seed, held_out=args.held_out, skip=args.skip,
        options=options, formats=_formats(args), weight_bits=args.weight_bits,
        variant=choose_variant(args.tansig, MAX_NEURONS), gamma=args.gamma)


def _tried(neurons, worst):
    print(f"{neurons} hidden neurons: at most {worst:.4g} px", file=sys.stderr)


def plot_training(trained, source, output, held_out=HELD_OUT):
    """Write OUTPUT.errors.png and OUTPUT.learning.png beside ``output``; return their names."""
    output = Path(output)
    errors, learning = (str(output.with_name(f"{output.stem}.{name}.png"))
                        for name in ("errors", "learning"))
    report = trained.report
    title = f"integer network, {report['hidden_neurons']} hidden neurons, "
    if trained.error_maps:
        plot_error_map(errors, trained.error_maps["fixed"], title + "against the true map")
    else:
        u, v, x, y = source.pairs
        width, height = source.geometry.corrected
        on = (u >= 0) & (u <= width - 1) & (v >= 0) & (v <= height - 1)
        a, b = fixed_map(trained.descriptor)(u[on], v[on])
        plot_point_errors(errors, source.geometry, u[on], v[on], np.hypot(a - x[on], b - y[on]),
                          split(len(u), held_out)[on], title + "at the calibrated points")
    steps = {"lm": "iterations, all starts together", "ebp": "epochs"}[report["trainer"]]
    plot_learning_curve(learning, trained.training.curve,
                        f"{report['trainer']}, seed {report['seed']}", steps)
    return [errors, learning]


def error_table(parts):
    """Text table of the float and fixed errors of each named part of a report."""
    lines = [f"{'':10} {'':6} {'MSE px²':>10} {'mean px':>9} {'max px':>9}"]
    for name, part in parts.items():
        for kind in ("float", "fixed"):
            errors = part[f"map_error_{kind}_px"]
            lines.append(f"{name.replace('_', ' '):10} {kind:6} {errors['mse']:10.6f} "
                         f"{errors['mean']:9.5f} {errors['max']:9.5f}")
    return "\n".join(lines)


def training_progress():
    """The trainer's progress callback: how far, and the error reached."""
    progress = Progress("training")
    return lambda done, mse: progress(done, f", MSE {mse:.5g} px²")


def _neurons(text):
    if text == "auto" or text.removeprefix("-").isdecimal():
        return text if text == "auto" else int(text)
    raise argparse.ArgumentTypeError(f"{text!r} is neither a whole number nor auto")


def _formats(args):
    formats = Formats().with_tansig_bits(args.tansig_bits)
    return replace(formats, coordinate=Q(formats.coordinate.i_bits, args.coordinate_bits))


def _size(text):
    parts = text.lower().split("x")
    if len(parts) != 2 or not all(part.isdecimal() for part in parts):
        raise InputError(f"size is {text!r}, WxH is needed, as in 1280x1024")
    return tuple(map(int, parts))


def _colour(text):
    parts = text.split(",")
    if len(parts) != 3 or not all(part.isdecimal() and int(part) < 256 for part in parts):
        raise InputError(f"fill is {text!r}, R,G,B is needed, each of 0..255")
    return tuple(map(int, parts))

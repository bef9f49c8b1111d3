"""``ncdc train``: from points, a camera file or a map to a descriptor."""

import argparse
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np

from ncdc.cli.common import add_camera, add_json, add_page, straightness_text, write_report
from ncdc.cli.renamed import add_renamed
from ncdc.cli.view_range import add_view_range, report_lines, view_range_of
from ncdc.terminal import Progress, say
from ncdc_model.evaluate import fixed_map
from ncdc_model.lens import parse_zoom
from ncdc_model.plots import (
    plot_error_map,
    plot_learning_curve,
    plot_neurons,
    plot_point_errors,
)
from ncdc_model.training.backprop import Stop
from ncdc_model.training.choices import HELD_OUT, TrainingChoices
from ncdc_model.training.choose import choose_camera
from ncdc_model.training.pipeline import train_camera
from ncdc_model.training.problem import split
from ncdc_model.training.source import load_source
from ncdc_model.training.train import TRAINERS, check_request
from ncdc_spec.errors import InputError
from ncdc_spec.fixed import Q
from ncdc_spec.formats import MAX_NEURONS, Formats
from ncdc_spec.geometry import BAYERS, MIN_SIZE, Geometry
from ncdc_spec.interpolation import DEFAULT, INTERPOLATIONS, interpolation_of
from ncdc_spec.tansig import FRACTION_BITS, VARIANTS, choose_variant

__all__ = ["EXAMPLE", "TABLES", "add_arguments", "error_table", "neurons_of", "nodes_text",
           "plot_training", "run", "size_of", "training_progress"]

_NEURONS = 8           # auto would train 16 networks of a page of dots: minutes, not seconds
_POOR = 1 / 640        # of the width: a map that is off by more at most is warned of
TABLES = "training", "held_out", "beyond_points", "region", "frame"

EXAMPLE = "ncdc train points.json --neurons 6 -o net.toml"


def add_arguments(parser) -> None:
    """Declare the command's arguments on an argparse parser."""
    parser.add_argument("source", metavar="FILE", nargs="+",
                        help="points.json of ncdc calibrate; points.csv of another detector; a "
                             "camera file: OpenCV, ROS, Kalibr, camodocal, COLMAP, mrcal, MATLAB, "
                             "RealSense, NeRF, BoofCV, or our own (TOML); or a map for OpenCV's "
                             "remap: one file with both tables (.npz, YAML, XML, JSON), or one "
                             "each (.npy, TIFF, OpenEXR too)")
    source = parser.add_argument_group("where the pairs come from")
    source.add_argument("--sensor-size", metavar="WxH",
                        help="size of the sensor's frames, where the file does not say it: a map, "
                             "a CSV of points, some camera files; a camera file of another size "
                             "of the same aspect is scaled to it")
    add_renamed(parser, "--sensor", "--sensor-size")
    add_camera(source)
    add_page(source)
    source.add_argument("--held-out", type=int, default=HELD_OUT, metavar="K",
                        help=f"one point in K only measures; 0: none (default: {HELD_OUT})")
    network = parser.add_argument_group("network and training")
    network.add_argument("--neurons", type=neurons_of, default=_NEURONS, metavar="N",
                         help=f"hidden neurons, 4 to 12 are usual (default: {_NEURONS}); auto: the "
                              f"fewest, up to 16, that meet --max-error, or 0.1 px without it, "
                              f"which takes minutes")
    network.add_argument("--max-error", type=float, metavar="PX",
                         help="with --neurons auto: largest error, on the whole frame where a "
                              "camera file or a map is the source, else at the held-out points; "
                              "without this option 0.1 is the goal, and if none of the networks "
                              "meets it, the smallest of the best ones is taken")
    network.add_argument("--skip", action="store_true",
                         help="add a linear path from the inputs straight to the outputs: four "
                              "products that save about one hidden neuron")
    network.add_argument("--trainer", choices=list(TRAINERS), default="lm",
                         help="lm: Levenberg-Marquardt from many starts (default); ebp: the "
                              "paper's error back-propagation, for comparison")
    network.add_argument("--epochs", type=int, metavar="E",
                         help="with --trainer ebp: maximum number of passes over the points "
                              "(default: 5000)")
    network.add_argument("--seed", type=int, default=0, metavar="S",
                         help="same seed, same descriptor (default: 0)")
    picture = parser.add_argument_group("picture")
    picture.add_argument("--size", metavar="WxH",
                         help="corrected picture (default: as large as the camera's)")
    picture.add_argument("--zoom", metavar="Z",
                         help="fit: the camera's full width fills the picture (default, except "
                              "for a file with a projection matrix, which says its frame); fill: "
                              "no pixel without a source; or a number: magnification in the middle")
    picture.add_argument("--blank-beyond", type=float, metavar="PX",
                         help="leave blank what the points determine less well than to so many "
                              "pixels: the picture beyond the outermost points, mostly (default: "
                              "nothing is left out, and a warning says how well it is known)")
    picture.add_argument("--bayer", choices=BAYERS, default="RGGB",
                         help="colour filter of the sensor, first two rows (default: RGGB); MONO: "
                              "a grey sensor, without one")
    picture.add_argument("--fill", default="0,0,0", metavar="R,G,B",
                         help="colour of pixels without a source (default: 0,0,0)")
    _add_hardware(parser.add_argument_group("hardware"))
    add_view_range(parser.add_argument_group(
        "range of views", "--nodes auto keeps to 0.001 px in these too"), "view-")
    parser.add_argument("-o", "--output", default="net.toml", metavar="FILE",
                        help="descriptor (default: net.toml); plots are written next to it")
    add_json(parser)


def _add_hardware(parser):
    """Declare what the descriptor fixes of the hardware."""
    parser.add_argument("--interpolation", choices=list(INTERPOLATIONS), default=DEFAULT.name,
                        help="directional: colour along edges, from 6x6 raw samples, for the "
                             "tile cache (default); gradient: from the same window without a "
                             "direction, smaller, some two decibels worse; fast: the paper's from "
                             "3x3, seven worse, for every fetcher and the smallest core")
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
    parser.add_argument("--nodes", type=_nodes, default="auto", metavar="S",
                        help="pixels from one evaluation of the network to the next: 1, 8, 16 or "
                             "32; auto (default): as many as add at most 0.001 px on this map")
    parser.add_argument("--gamma", type=float, default=1.0, metavar="G",
                        help="gamma of the tan-sigmoid, equation (17); the hidden weights make "
                             "good for it (default: 1)")


def run(args) -> None:
    """Train, quantise, measure; write the descriptor, the plots and the report."""
    if Path(args.output).resolve() in [Path(path).resolve() for path in args.source]:
        raise InputError(f"the output {args.output} would replace the input")
    if args.seed < 0:
        raise InputError(f"seed is {args.seed}, it must not be negative")
    if args.neurons != "auto" and args.max_error is not None:
        raise InputError(f"--max-error is an option of --neurons auto, {args.neurons} are asked "
                         f"for")
    choices, fill = _choices(args), _colour(args.fill)
    size, sensor = (size_of(text, name) if text else None
                    for text, name in ((args.size, "size"), (args.sensor_size, "sensor size")))
    check_request(1 if args.neurons == "auto" else args.neurons, choices)
    if args.zoom is not None:
        parse_zoom(args.zoom)
    source = load_source(args.source, size, args.zoom, args.camera, sensor, args.page,
                         bayer=args.bayer, fill=fill,
                         interpolation=interpolation_of(args.interpolation))
    source = _blanked(source, args)
    choices = replace(choices, views=view_range_of(args, source))
    _tell_map(source)
    trained = _train(args, source, choices)
    trained.descriptor.save(args.output)
    plots = plot_training(trained, source, args.output, args.held_out)
    report = trained.report | {"descriptor": str(args.output), "digest": trained.descriptor.digest,
                               "plots": plots}
    for sentence in report.get("warnings", ()):
        if sentence not in source.facts.get("warnings", ()):
            _warn(sentence)
    lost = report["valid_pixels_lost"]
    if lost:
        _warn(f"{lost} pixels with a source are left blank, because their row has more than two "
              f"spans")
    worst = report["map_error_fixed_px"]["max"]
    limit = max(1.0, source.geometry.distorted[0] * _POOR)
    learnt = source.region.learnt(fixed_map(trained.descriptor)) if source.region else worst
    if min(learnt, worst) > limit:
        _warn(f"the largest error of the map is {worst:.3g} px, more than {limit:.3g} px: more "
              f"hidden neurons (--neurons auto), or a zoom that leaves out what they cannot model")
    if not report.get("max_error_met", True):
        _warn(f"no network of 1 to {len(report['tried'])} hidden neurons has a largest error of "
              f"{report['max_error_px']:g} px or less: the smallest of the best ones is taken")
    if not write_report(report, args.json):
        _print_report(args, source, report)


def _blanked(source, args):
    """``source`` with the limit of ``--blank-beyond``."""
    limit = args.blank_beyond
    if limit is None:
        return source
    if not (np.isfinite(limit) and limit > 0):
        raise InputError(f"--blank-beyond is {limit:g}, a positive number of pixels is needed")
    if source.frame is None:
        raise InputError(f"--blank-beyond is for points, {args.source[0]} holds the map itself")
    source = replace(source, blank_beyond=limit)
    _ = source.region           # rejects a limit that leaves nothing, before the training
    return source


def _print_report(args, source, report):
    width, height = source.geometry.corrected
    skip = ", skip path" if args.skip else ""
    print(f"{report['hidden_neurons']} hidden neurons{skip}, {width}x{height} corrected pixels, "
          f"{report['valid_percent']:.1f} % with a source")
    if report.get("extrapolated_percent"):
        print(f"{report['extrapolated_percent']:.1f} % lie beyond the calibrated points: there the "
              f"network follows the smooth lens fitted to them")
    print(error_table({name: report[name] for name in TABLES if name in report}))
    if report["measured_on"] == "region":
        print(f"region: the whole valid region, as estimated from the points; "
              f"{report['beyond_points_percent']:.1f} % of it lies beyond the outermost ones"
              + (f", known to {report['beyond_points_known_px']:.2g} px at worst"
                 if report["beyond_points_percent"] else ""))
    if "page_sag" in report:
        print(_flat_text(report))
    print(nodes_text(report["nodes"]) + (f", which adds at most {report['nodes_curvature_px']:.5f} "
                                         f"px" if report["nodes"] > 1 else ""))
    for line in report_lines(report):
        print(line)
    print(f"fixed minus float: at most {report['fixed_minus_float_max_px']:.5f} px on an axis")
    if source.frame:
        print(straightness_text(report, "held-out points" if args.held_out else "points"))
        for reason, count in report["points_dropped"].items():
            print(f"  {count} points not used: {reason}")
    if "tried" in report:
        print(f"{report['hidden_neurons']} hidden neurons are proposed, of "
              f"{len(report['tried'])} numbers tried, by the largest error on "
              f"{_judged_on(report)}")
    *others, last = report["plots"]
    print(f"{args.output}; look at {', '.join(others)} and {last}")


def _flat_text(report):
    """What the errors take for granted of the page, which few photos do not show."""
    sag, most = report["page_sag"], report["map_error_fixed_px"]["max"]
    per = sag["max_px"] / sag["sag_percent"]
    return (f"these errors hold if the page is flat to {most / per:.2f} % of its extent, which one "
            f"or two photos do not show: each {sag['sag_percent']:.1f} % of sag adds up to "
            f"{sag['max_px']:.2f} px, {sag['rms_px']:.2f} px rms; three photos from different "
            f"sides show it")


def _tell_map(source):
    """Print what of the sensor a map reads, how a file was read, and what is odd about it."""
    if "source_columns" in source.facts:
        width, height = source.geometry.distorted
        (left, right), (top, bottom) = source.facts["source_columns"], source.facts["source_rows"]
        print(f"the map reads columns {left:.1f} to {right:.1f} of 0 to {width - 1} and rows "
              f"{top:.1f} to {bottom:.1f} of 0 to {height - 1}", file=sys.stderr)
    for sentence in source.facts.get("notes", ()):
        print(sentence, file=sys.stderr)
    for sentence in source.facts.get("warnings", ()):
        _warn(sentence)


def _warn(sentence):
    say(f"warning: {sentence}")


def _train(args, source, choices):
    if args.neurons == "auto":
        return choose_camera(source, args.max_error, choices, _choosing_progress(), _tried)
    return train_camera(source, args.neurons, choices, training_progress())


def _choices(args):
    options = {}
    if args.epochs is not None:
        if args.trainer != "ebp":
            raise InputError("--epochs is an option of the trainer ebp")
        if args.epochs < 1:
            raise InputError(f"{args.epochs} epochs are asked for, the minimum is 1")
        options["stop"] = Stop(epochs=args.epochs)
    return TrainingChoices(
        trainer=args.trainer, seed=args.seed, held_out=args.held_out, skip=args.skip,
        options=options, formats=_formats(args), weight_bits=args.weight_bits,
        variant=choose_variant(args.tansig, MAX_NEURONS), gamma=args.gamma,
        nodes=args.nodes)


def _tried(neurons, worst):
    say(f"{neurons} hidden neurons: at most {worst:.4g} px")


def plot_training(trained, source, output, held_out=HELD_OUT):
    """Write OUTPUT.errors.png and OUTPUT.learning.png next to ``output``; return their names.

    If several numbers of hidden neurons were tried, also OUTPUT.neurons.png.
    """
    output = Path(output)
    errors, learning, neurons = (str(output.with_name(f"{output.stem}.{name}.png"))
                                 for name in ("errors", "learning", "neurons"))
    report = trained.report
    title = f"integer network, {report['hidden_neurons']} hidden neurons, "
    if trained.error_maps:
        plot_error_map(errors, trained.error_maps["fixed"], title + "from the true map")
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
    if "tried" not in report:
        return [errors, learning]
    plot_neurons(neurons, report["tried"], report["hidden_neurons"], report["max_error_px"],
                 _judged_on(report))
    return [errors, learning, neurons]


def error_table(parts):
    """Text table of the float and fixed errors of each named part of a report."""
    lines = [f"{'':13} {'':6} {'MSE px²':>10} {'mean px':>9} {'max px':>9}"]
    for name, part in parts.items():
        for kind in ("float", "fixed"):
            errors = part[f"map_error_{kind}_px"]
            lines.append(f"{name.replace('_', ' '):13} {kind:6} {errors['mse']:10.6f} "
                         f"{errors['mean']:9.5f} {errors['max']:9.5f}")
    return "\n".join(lines)


def nodes_text(nodes):
    """Some words on where the network is evaluated."""
    return f"network at every {nodes}th pixel of a row" if nodes > 1 else "network at every pixel"


def training_progress():
    """The trainer's progress callback: how far, and the error reached."""
    progress = Progress("training")
    return lambda done, mse: progress(done, f", MSE {mse:.5g} px²")


def _judged_on(report):
    return {"frame": "the whole frame", "region": "the whole valid region"}.get(
        report["measured_on"], "held-out points")


def _choosing_progress():
    """The same of a row of trainings, called with the number of hidden neurons first."""
    shown = {}

    def progress(neurons, done, mse):
        if neurons not in shown:
            shown[neurons] = Progress(f"training {neurons} hidden neurons")
        shown[neurons](done, f", MSE {mse:.5g} px²")
    return progress


def neurons_of(text):
    """The number of hidden neurons that an option names, or auto."""
    if text == "auto" or text.removeprefix("-").isdecimal():
        return text if text == "auto" else int(text)
    raise argparse.ArgumentTypeError(f"{text!r} is neither a whole number nor auto")


def _nodes(text):
    if text == "auto" or text.isdecimal():
        return text if text == "auto" else int(text)
    raise argparse.ArgumentTypeError(f"{text!r} is neither a whole number nor auto")


def _formats(args):
    formats = Formats().with_tansig_bits(args.tansig_bits)
    return replace(formats, coordinate=Q(formats.coordinate.i_bits, args.coordinate_bits))


def size_of(text, name):
    """Width and height of the text ``WxH`` of an option; the error calls it ``name``."""
    parts = text.lower().split("x")
    if len(parts) != 2 or not all(part.isdecimal() for part in parts):
        raise InputError(f"{name} is {text!r}, WxH is needed, as in 1280x1024")
    width, height = map(int, parts)
    Geometry(width, height, MIN_SIZE, MIN_SIZE)     # names the side that is out of range
    return width, height


def _colour(text):
    parts = text.split(",")
    if len(parts) != 3 or not all(part.isdecimal() and int(part) < 256 for part in parts):
        raise InputError(f"fill is {text!r}, R,G,B is needed, each of 0..255")
    return tuple(map(int, parts))

"""``ncdc demo``: the whole chain on the built-in example camera."""

import sys
from pathlib import Path

import numpy as np

from ncdc.cli.common import add_json, write_report
from ncdc.cli.simulate import difference
from ncdc.cli.train import TABLES, error_table, training_progress
from ncdc.report.page import report_page
from ncdc.report.pictures import draw_lines, side_by_side
from ncdc.terminal import Progress
from ncdc_hdl.corrector import Corrector
from ncdc_hdl.export.size import design_size
from ncdc_hdl.export.verilog import corrector_verilog
from ncdc_model.calibration.detect import detect_points
from ncdc_model.calibration.frame import ideal_frame
from ncdc_model.calibration.overlay import draw_points
from ncdc_model.calibration.straightness import straightness
from ncdc_model.correction import correct, frame_coordinates
from ncdc_model.evaluate import evaluate_frame
from ncdc_model.example import (
    BAYER,
    example_camera,
    noise_picture,
    scene_light,
    scene_photo,
    target_photo,
    true_map,
)
from ncdc_model.images import demosaic, write_image
from ncdc_model.plots import plot_error_map
from ncdc_model.reference import bayer_psnr, correct_real, grey_level_difference
from ncdc_model.training.pipeline import train_camera
from ncdc_model.training.source import load_source
from ncdc_sim.system.corrector import simulate_correction
from ncdc_spec.descriptor import MAX_NEURONS
from ncdc_spec.errors import InputError
from ncdc_spec.files import check_outputs, write_text
from ncdc_spec.interpolation import INTERPOLATIONS

__all__ = ["EXAMPLE", "add_arguments", "run"]

EXAMPLE = "ncdc demo -o demo"
_STEPS = 6


def add_arguments(parser) -> None:
    """Declare the command's arguments on an argparse parser."""
    parser.add_argument("-o", "--output", default="demo", metavar="DIR",
                        help="folder to write to (default: demo)")
    parser.add_argument("--neurons", type=int, default=8, metavar="N",
                        help="hidden neurons (default: 8)")
    add_json(parser)


def run(args) -> int | None:
    """Run the chain; 1 if a pixel of the Verilog differs from the golden model."""
    if not 1 <= args.neurons <= MAX_NEURONS:
        raise InputError(f"neurons is {args.neurons}, the limits are 1 and {MAX_NEURONS}")
    folder = Path(args.output)
    check_outputs([folder / "report.json"], [])
    camera = example_camera()
    target, points = _photograph(folder, camera)
    trained = _train(folder, args.neurons)
    descriptor = trained.descriptor
    verilog = _generate(folder, descriptor)
    scene = scene_photo(camera)
    write_image(folder / "distorted.raw.png", scene)
    write_image(folder / "distorted.png", demosaic(scene, BAYER))
    _step(4, "running the Verilog on a whole raw frame (compiling it first takes half a minute)")
    simulation = simulate_correction(descriptor, scene, verilog=verilog, memory="sdram",
                                     progress=Progress("simulating"))
    write_image(folder / "corrected.png", simulation.picture)
    _say(f"{len(simulation.differing)} of {simulation.blank.size} pixels differ from the golden "
         "model")

    _step(5, "measuring the errors from the example's true camera")
    report = {"hidden_neurons": descriptor.hidden_neurons, "digest": descriptor.digest,
              **{f"{kind}_{side}": getattr(descriptor.geometry, f"{kind}_{side}")
                 for kind in ("distorted", "corrected") for side in ("width", "height")},
              **simulation.report(), "points_found": points.count,
              **_truth(folder, camera, points.photos[0], trained, simulation),
              **_pictures(folder, target, points, descriptor, scene, simulation),
              **_interpolation(camera, descriptor, scene, simulation),
              **design_size(Corrector(descriptor)), "verilog_lines": verilog.count("\n")}
    _step(6, "report")
    write_report(report, folder / "report.json")
    write_text(folder / "report.html", report_page(report, _sections(report, trained)))
    if not write_report(report, args.json):
        print(f"look at {folder / 'report.html'}")
        print("see it live: ncdc client gui --demo")
    message = difference(simulation)
    if message:
        print(f"ncdc demo: {message}", file=sys.stderr)
        return 1
    return 0


def _step(number, text):
    print(f"[{number}/{_STEPS}] {text}", file=sys.stderr, flush=True)


def _say(text):
    print("      " + text.replace("\n", "\n      "), file=sys.stderr, flush=True)


def _photograph(folder, camera):
    _step(1, "photo of a page of dots, through the example camera")
    raw = target_photo(camera)
    camera.save(folder / "camera.toml")
    write_image(folder / "photo.raw.png", raw)
    write_image(folder / "photo.png", demosaic(raw, BAYER))
    points = detect_points([("photo.raw.png", raw)], "dots")
    points.save(folder / "points.json")
    write_image(folder / "points.png", draw_points(
        demosaic(raw, BAYER), points.photos[0], ideal_frame(points)))
    _say(f"{points.count} dots found")
    return raw, points


def _train(folder, neurons):
    _step(2, f"training {neurons} hidden neurons, quantising to the fixed-point descriptor")
    source = load_source(folder / "points.json", bayer=BAYER)
    trained = train_camera(source, neurons, progress=training_progress())
    trained.descriptor.save(folder / "net.toml")
    _say(error_table({name: trained.report[name] for name in TABLES if name in trained.report}))
    return trained


def _generate(folder, descriptor):
    _step(3, "generating the Verilog")
    verilog = corrector_verilog(descriptor)
    write_text(folder / "ncdc.v", verilog)
    _say(f"{verilog.count(chr(10))} lines")
    return verilog


def _truth(folder, camera, photo, trained, simulation):
    """Errors of the map and of the blanking over the whole frame, compared with the true camera."""
    descriptor = trained.descriptor
    geometry = descriptor.geometry
    back_map = true_map(camera, photo, descriptor.provenance["homography"])
    maps = {}
    errors = evaluate_frame(descriptor, back_map, maps)
    plot_error_map(folder / "errors.png", maps["fixed"],
                   f"integer network and true camera, {descriptor.hidden_neurons} neurons")
    v, u = np.indices(geometry.corrected[::-1])
    x, y = back_map(u, v)
    has_source = geometry.window_inside(x, y)
    wrong = has_source == simulation.blank
    _say(error_table({"frame": errors}))
    return {**{name: errors[name] for name in ("map_error_float_px", "map_error_fixed_px",
                                               "fixed_minus_float_max_px")},
            "pixels_without_source": int((~has_source).sum()),
            "pixels_blank": int(simulation.blank.sum()),
            "blanking_differs": int(wrong.sum()),
            "blanking_differs_within_px": float(
                np.abs(geometry.inside_by(x, y)[wrong]).max(initial=0))}


def _pictures(folder, target, points, descriptor, scene, simulation):
    """The comparison picture, and how straight the target's rows and columns have become."""
    photo = points.photos[0].whole
    corrected = correct(descriptor, target).picture
    again = detect_points([("corrected", corrected)], "dots").photos[0].whole
    before, after = straightness(photo.xy, photo.index), straightness(again.xy, again.index)
    write_image(folder / "comparison.png", side_by_side([
        [("the target as the camera sees it, with straight lines", draw_lines(
            demosaic(target, BAYER), photo.xy, photo.index)),
         ("corrected", draw_lines(corrected, again.xy, again.index))],
        [("a scene as the camera sees it", demosaic(scene, BAYER)),
         ("corrected by the generated Verilog", simulation.picture)]]))
    return {"straightness_before_rms_px": before.rms, "straightness_before_max_px": before.max,
            "straightness_rms_px": after.rms, "straightness_max_px": after.max,
            "straight_lines": after.lines}


def _interpolation(camera, descriptor, scene, simulation):
    """Grey levels from floating point, on the scene and on noise, and the cost in PSNR."""
    noise = noise_picture(*descriptor.geometry.distorted)
    colour = np.clip(np.floor(scene_light(camera) + 0.5), 0, 255).astype(np.uint8)
    # The directional interpolation decides anew from sample to sample: at the float network's
    # coordinates some pixels would show the difference of the coordinates.
    at = [descriptor.formats.coordinate.real(raw) for raw in frame_coordinates(descriptor)]
    return {
        "interpolation": descriptor.geometry.interpolation.name,
        "grey_levels_from_float_max": max(
            grey_level_difference(simulation.picture, correct_real(descriptor, scene, at=at)),
            grey_level_difference(correct(descriptor, noise).picture,
                                  correct_real(descriptor, noise, at=at))),
        **bayer_psnr(descriptor, colour)}


def _sections(report, trained):
    def errors(name, part):
        return [[f"{name}, {kind}", *(f"{part[f'map_error_{kind}_px'][key]:.5f}"
                                      for key in ("mse", "mean", "max"))]
                for kind in ("float", "fixed")]

    return [
        {"title": "Before and after",
         "text": "Straight lines are fitted to the rows and columns of the dots found in the "
                 "photo and found again in the corrected photo: "
                 f"{report['straightness_before_rms_px']:.2f} px rms from straight before, "
                 f"{report['straightness_rms_px']:.3f} px after "
                 f"(at most {report['straightness_max_px']:.2f}), {report['straight_lines']} "
                 f"lines.",
         "pictures": ["comparison.png"]},
        {"title": "Calibration",
         "text": f"{report['points_found']} dots found on one photo; a few indices are written "
                 "next to their dots.", "pictures": ["points.png"]},
        {"title": "Error of the map",
         "text": "Distance in pixels of the distorted image: on the points, trained on and held "
                 "out, and over the whole frame from the true camera. The integers add at most "
                 f"{report['fixed_minus_float_max_px']:.4f} px on an axis.",
         "pictures": ["errors.png"],
         "rows": [["", "MSE px²", "mean px", "max px"],
                  *errors("training points", trained.report["training"]),
                  *errors("held-out points", trained.report["held_out"]),
                  *errors("whole valid region, estimated", trained.report["region"]),
                  *errors("whole frame", report)]},
        {"title": "Pixels without a source",
         "text": f"{report['pixels_without_source']} corrected pixels lie outside what the sensor "
                 f"sees, {report['pixels_blank']} are blanked; the two sets differ in "
                 f"{report['blanking_differs']} pixels, all within "
                 f"{report['blanking_differs_within_px']:.2f} px of the sensor's edge."},
        {"title": "Interpolation",
         "text": "Grey levels between the hardware and the same picture in floating point, at "
                 f"the same coordinates: at most {report['grey_levels_from_float_max']}, noise "
                 "included. PSNR to the remapped colour picture, in dB:",
         "rows": [["flow", "PSNR"],
                  *([name + " (this)" * (name == report["interpolation"]),
                     f"{report[f'psnr_{name}_db']:.2f}"] for name in INTERPOLATIONS),
                  ["demosaic, then remap", f"{report['psnr_demosaic_db']:.2f}"],
                  ["fast, without the half pixel", f"{report['psnr_uncompensated_db']:.2f}"]]},
        {"title": "Hardware",
         "text": f"Simulated with {report['simulator']} on the memory model "
                 f"\"{report['memory']}\", {report['data_width']}-bit ports, fetcher "
                 f"\"{report['fetch']}\". Counted before technology mapping.",
         "rows": [["figure", "value"],
                  ["clocks per pixel", f"{report['clocks_per_pixel']:.3f}"],
                  ["bytes read per pixel", f"{report['bytes_read_per_pixel']:.2f}"],
                  ["bytes written per pixel", f"{report['bytes_written_per_pixel']:.2f}"],
                  ["flip-flops", report["flip_flops"]], ["multipliers", report["multipliers"]],
                  ["memory bits", report["memory_bits"]],
                  ["lines of Verilog", report["verilog_lines"]]]},
    ]

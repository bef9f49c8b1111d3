"""The sections of a report on a user's own camera."""

import shlex
from dataclasses import replace

import cv2
import numpy as np

from ncdc.report.embedded import embedded, embedded_plot
from ncdc.report.lens_words import lens_rows
from ncdc_hdl.corrector import Corrector
from ncdc_hdl.export.size import design_size
from ncdc_model.calibration.overlay import draw_points
from ncdc_model.calibration.straightness import corrected_positions, straightness
from ncdc_model.compare import fitted_view
from ncdc_model.evaluate import evaluate_frame, fixed_map
from ncdc_model.lens import Frame
from ncdc_model.planner.plan import CLOCK_MHZ, plan
from ncdc_model.plots import plot_error_map, plot_point_errors
from ncdc_model.training.region import region_of
from ncdc_spec.hardware import Hardware

__all__ = ["accuracy_section", "commands_section", "hardware_section", "lens_section",
           "photo_section", "points_section", "region_of_points"]

_MEMORIES = {"sdram": 32, "ddr3": 128}      # bits of the ports


def photo_section(before, corrected):
    """The slider of a photo, RGB, and the :class:`Correction`'s picture of it."""
    share = 100 * float(corrected.blank.mean())
    return {"title": "Before and after",
            "text": f"Drag the border. The right part is what the hardware gives, bit by bit. "
                    f"{share:.1f} % of its pixels have no source in the photo.",
            "slider": (embedded(before), embedded(corrected.picture))}


def points_section(image, points, frame, number):
    """The photo ``number`` of the points with its points drawn over it."""
    photo, count = points.photos[number], len(points.photos)
    this = "The photo is" if count == 1 else f"With {len(photo.index)} of them, this is"
    return {"title": "Calibration",
            "text": f"{points.count} points of a target ({points.target}, {points.columns} "
                    f"columns, {points.rows} rows) on {count} photo{'s' * (count > 1)}. {this} "
                    f"{photo.name or 'the first'}. Lines join neighbours: one that crosses others "
                    f"shows a wrong number.",
            "pictures": [embedded(draw_points(image, photo, frame, number))]}


def lens_section(camera, frame=None):
    """The lens in words."""
    alone = ("" if frame is None or len(frame.names) > 1 else " One photo separates neither a "
             "short lens from a near page, nor a decentred lens from a tilted page: several from "
             "different sides do.")
    return {"title": "The lens",
            "text": "What the calibration found. Each flaw is measured by how far it moves points "
                    f"in the photo, whatever the view.{alone}",
            "rows": [("", "figure", "in words"), *lens_rows(camera, frame)]}


def region_of_points(descriptor, frame):
    """:class:`Region` of the points of a descriptor, over its valid pixels.

    ``frame``: the :class:`IdealFrame` of the points, for whatever zoom.
    """
    focal, *centre = descriptor.provenance["frame"]
    chosen = Frame(descriptor.geometry.corrected, focal, tuple(centre[:2]), *centre[2:])
    corrected = chosen.pixel(*frame.camera.frame.ideal(*frame.corrected.T))
    frame = replace(frame, camera=replace(frame.camera, frame=chosen),
                    corrected=np.stack(corrected, axis=1))
    return region_of(frame, descriptor.valid.mask(descriptor.geometry.corrected_width))


def accuracy_section(descriptor, camera, frame=None, region=None):
    """Error tables and maps; those of points and lines if the ``frame`` of training is known, and
    that of the whole ``region`` of the points."""
    errors = {name.replace("_", " "): part["map_error_fixed_px"]
              for name, part in descriptor.errors.items()
              if isinstance(part, dict) and "map_error_fixed_px" in part}
    text = "Distances in pixels of the photo, of the integer network that the hardware computes."
    pictures = []
    if frame is not None:
        text += " " + _straight(descriptor, frame)
        pictures.append(_point_errors(descriptor, frame))
    maps, lens = {}, "lens of the file" if frame is None else "smooth lens of the points"
    report = evaluate_frame(descriptor, fitted_view(descriptor, camera), maps)
    errors[f"every pixel, from the {lens}"] = report["map_error_fixed_px"]
    if region is None:
        pictures.append(embedded_plot(plot_error_map, maps["fixed"], f"integer network and {lens}"))
    else:
        text += (" The second picture has the largest error that is to be expected at each pixel, "
                 "with what the points leave open: beyond the outermost ones it is mostly that.")
        bound = region.bound(fixed_map(descriptor), descriptor.valid.mask(
            descriptor.geometry.corrected_width))
        pictures.append(embedded_plot(plot_error_map, bound, "integer network, largest error "
                                      "expected"))
    if frame is not None:
        text += (" The smooth lens has none of the lens's unevenness: the distance from it holds "
                 "what the network has learnt of that.")
    rows = [("measured on", "mean px", "max px"),
            *((name, f"{each['mean']:.4f}", f"{each['max']:.4f}") for name, each in errors.items())]
    return {"title": "Accuracy", "text": text, "rows": rows, "pictures": pictures}


def hardware_section(descriptor, progress):
    """Planned speed and size of the corrector with two usual memories."""
    rows = [("memory", "ports", "cache", "clocks per pixel", "frames per second",
             "bytes read per pixel", "flip-flops", "multipliers", "memory bits")]
    for number, (memory, width) in enumerate(_MEMORIES.items()):
        found = plan(descriptor, Hardware(data_width=width), memory,
                     lambda chosen: Corrector(descriptor, chosen).timing,
                     progress=lambda share, done=number: progress(
                         (done + .9 * share) / len(_MEMORIES)))
        size = design_size(Corrector(descriptor, found.hardware.made_for(descriptor)))
        rows.append((memory, f"{width} bits", f"{found.hardware.cache.bytes} bytes",
                     f"{found.clocks_per_pixel:.3f}", f"{found.frames_per_second:.1f}",
                     f"{found.report()['bytes_read_per_pixel']:.2f}", f"{size['flip_flops']:,}",
                     size["multipliers"], f"{size['memory_bits']:,}"))
    return {"title": "Hardware",
            "text": f"What the planner chooses and predicts at {CLOCK_MHZ:g} MHz. The size is "
                    f"counted before technology mapping, multipliers of any width.",
            "rows": rows}


def commands_section(net, photo=None, source=None):
    """The lines to type next."""
    net = shlex.quote(str(net))
    image = "photo.png" if photo is None else shlex.quote(str(photo))
    lines = [(f"ncdc correct {net} {image} -o corrected.png", "or a film, or camera:0"),
             *([(f"ncdc evaluate {net} --reference {shlex.quote(str(source))}", "its errors again")]
               if source else []),
             (f"ncdc plan {net} --memory ddr3 --min-fps 60", "cache, scan and speed"),
             (f"ncdc generate {net} -o hardware", "Verilog, drivers, test bench"),
             (f"ncdc simulate {net} {image} -o simulated.png", "compares every pixel"),
             (f"ncdc build {net} --board ulx3s", "a bitstream"),
             ("ncdc client gui --demo", "cameras in a window")]
    width = max(len(line) for line, _ in lines)
    return {"title": "Go on", "commands": [f"{line:<{width}}  # {what}" for line, what in lines]}


def _pairs(descriptor, frame):
    """Corrected and distorted pixels (n, 2) of the points of the ``frame`` of training, their
    index and photo: those inside the corrected picture, beyond which the integers saturate."""
    uv = np.empty_like(frame.distorted)
    for number, matrix in enumerate(np.reshape(descriptor.provenance["homography"], (-1, 3, 3))):
        on = frame.photo == number
        if on.any():
            index = frame.index[on].astype(np.float64)[:, None]
            uv[on] = cv2.perspectiveTransform(index, matrix)[:, 0]
    inside = ((uv >= 1) & (uv <= np.array(descriptor.geometry.corrected) - 2)).all(axis=1)
    return uv[inside], frame.distorted[inside], frame.index[inside], frame.photo[inside]


def _straight(descriptor, frame):
    uv, xy, index, photo = _pairs(descriptor, frame)
    before = straightness(xy, index, photo)
    after = straightness(corrected_positions(fixed_map(descriptor), uv, xy), index, photo)
    return (f"Rows and columns of the target are {before.rms:.2f} px rms from straight lines in "
            f"the photos, and {after.rms:.3f} px in the corrected pictures ({after.lines} lines).")


def _point_errors(descriptor, frame):
    uv, xy, _, _ = _pairs(descriptor, frame)
    far = np.hypot(*np.subtract(fixed_map(descriptor)(*uv.T), xy.T))
    return embedded_plot(plot_point_errors, descriptor.geometry, *uv.T, far, None,
                         "integer network at the points")

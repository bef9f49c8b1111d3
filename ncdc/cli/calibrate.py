"""``ncdc calibrate``: finds a target's points in real photos."""

import sys
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np

from ncdc.cli.common import (
    add_json,
    add_page,
    add_samples,
    read_photo,
    straightness_text,
    write_report,
)
from ncdc.cli.live import add_live, compared, pictures_of_live
from ncdc.terminal import Progress, say
from ncdc_model.calibration.detect import detect_points
from ncdc_model.calibration.judged import judged
from ncdc_model.calibration.overlay import Backdrop, draw_on
from ncdc_model.calibration.quality import Dropped
from ncdc_model.flaw_figures import flaws_of
from ncdc_model.images import write_image
from ncdc_model.photo.names import photos_of
from ncdc_spec.errors import InputError

__all__ = ["EXAMPLE", "add_arguments", "run"]

_LENS, _DRAWN = 0.7, 0.9    # parts of the work done before the lens, and before the pictures
_CACHED = 96 << 20          # bytes of pictures to draw on
_LISTED = 20                # dropped points that are printed

EXAMPLE = "ncdc calibrate left*.jpg --target chessboard:9x6 -o points.json"


def add_arguments(parser) -> None:
    """Declare the command's arguments on an argparse parser."""
    parser.add_argument("photos", nargs="*", metavar="PHOTO",
                        help="photo of the target: colour, grey, or the raw Bayer frame; a folder "
                             "of photos, or a pattern in quotes")
    parser.add_argument("--target", default="auto", metavar="KIND",
                        help="dots (a page of black dots that fills the picture), circles:CxR, "
                             "acircles:CxR (staggered: circles in a line, lines), "
                             "chessboard:CxR (inner corners), charuco:CxR (squares), "
                             "aprilgrid:CxR (Kalibr's: tags; :0.3 after them states their gap in "
                             "sides of a tag), or auto (default)")
    parser.add_argument("-o", "--output", default="points.json", metavar="FILE",
                        help="points file (default: points.json); each photo with its points "
                             "drawn over it goes next to it, as points.overlay.png")
    add_live(parser)
    add_page(parser.add_argument_group("shape of the page"))
    add_samples(parser.add_argument_group("samples of the file"))
    add_json(parser)


def run(args) -> None:
    """Detect, write the points file and the overlays, report."""
    live, missing = {}, []
    if args.live is not None:
        args.photos, live, missing = pictures_of_live(args)
    elif not args.photos:
        raise InputError("no photo is given: files, a folder, or --live camera:0 are needed")
    args.photos = photos_of(args.photos)
    progress, photos = Progress("calibrate"), _Photos(args)
    points = replace(detect_points(photos.readers(progress), args.target),
                     page=args.page or "").rounded
    output = Path(args.output)
    used = [name for name in dict.fromkeys(args.photos) if name not in points.rejected_photos]
    overlays = _overlays(output, used, args)
    progress(_LENS, " smooth lens")
    measured, frame, warnings = judged(points)
    warnings = missing + warnings
    different, difference_text = compared(frame, args.previous)
    # Training goes on with the lens.
    replace(points, fits=() if frame is None else frame.fits).save(output)
    for number, (name, overlay, photo) in enumerate(zip(used, overlays, points.photos)):
        progress(_DRAWN + (1 - _DRAWN) * number / len(used), f" {overlay}")
        write_image(overlay, draw_on(photos.backdrop(name), photo, frame, number))
    progress(1)
    report = {**_report(points, frame), **live, **measured, **different, "warnings": warnings,
              "points": str(output), "overlays": overlays}
    for name, reason in points.rejected_photos.items():
        # Sentences on files that cannot be read begin with their names.
        print(f"not used: {reason}" if name in reason else f"{name}: not used: {reason}",
              file=sys.stderr)
    for warning in warnings:
        print(f"warning: {warning}", file=sys.stderr)
    if not write_report(report, args.json):
        _print(report, len(args.photos), measured)
        if difference_text:
            print(difference_text)


# Title, name among the flaws, digits and unit of what is printed of a lens.
_FLAWS = (("focal length", "focal_px", 1, " px"), ("axis off the middle", "axis_px", 1, " px"),
          ("decentring", "decentring_px", 2, " px"), ("tilt of the sensor", "tilt_deg", 2, "°"),
          ("pixel aspect", "aspect", 4, ""))


def _overlays(output, used, args):
    """Paths of the overlays, next to ``output``; none may replace a photo."""
    tags = [""] if len(used) == 1 else [f"-{k}-{Path(name).stem}" for k, name in enumerate(used, 1)]
    overlays = [str(output.with_name(f"{output.stem}.overlay{tag}.png")) for tag in tags]
    inputs = {Path(name).resolve() for name in args.photos}
    for path in (args.output, *overlays):
        if Path(path).resolve() in inputs:
            raise InputError(f"the output {path} would replace the photo of that name, choose "
                             f"another -o")
    return overlays


def _report(points, frame):
    """Report: points found, points rejected by reason, and their agreement."""
    rejected = {}
    for photo in points.photos:
        for reason, count in photo.rejected.items():
            rejected[reason] = rejected.get(reason, 0) + count
    dropped = [{"photo": photo.name, "x": round(x, 1), "y": round(y, 1), "reason": reason}
               for photo in points.photos for x, y, reason in photo.dropped]
    for number, index in () if frame is None else frame.gross:
        photo = points.photos[frame.numbers[number]]
        x, y = photo.xy[(photo.index == index).all(axis=1)][0]
        dropped.append({"photo": photo.name, "x": round(float(x), 1), "y": round(float(y), 1),
                        "reason": Dropped.GROSS.value})
    return {
        "target": points.target, "target_chosen": points.choice, "columns": points.columns,
        "rows": points.rows, "tag_spacing": points.spacing, "points_found": points.count,
        "points_cut": points.count - points.whole,
        "points_outside_frame": 0 if frame is None else frame.rejected.get(Dropped.OUTSIDE, 0),
        "points_rejected": sum(rejected.values()),
        "points_rejected_by_reason": rejected, "points_dropped": dropped,
        "agreement_px": {photo.name: photo.agreement for photo in points.photos},
        "photos_used": len(points.photos), "photos_rejected": points.rejected_photos,
        "photos_in_part": _parts(points), "lens": {} if frame is None else _lens(frame),
        "lateral_colour": points.colour,
        "remarks": [f"{photo.name}: {text}" for photo in points.photos for text in photo.remarks]}


def _lens(frame):
    """The lens and its flaws in figures, each with its standard error, and the page's bend."""
    sag, error = frame.sag
    return vars(flaws_of(frame.camera, frame)) | {
        "sag_percent": 100 * sag, "sag_percent_error": 100 * error if sag else None}


def _parts(points):
    """Which photos show a part of the target only, and which part."""
    if points.target == "dots":
        return {}
    columns, rows = points.target_size or (points.columns, points.rows)
    if points.target == "charuco":
        columns, rows = columns - 1, rows - 1
    if points.target == "aprilgrid":
        columns, rows = 2 * columns, 2 * rows
    whole, parts = columns * rows, {}
    for photo in points.photos:
        if len(photo.index) < whole:
            across, down = np.ptp(photo.index, axis=0) + 1
            parts[photo.name] = (f"{len(photo.index)} of {whole} points, on {across} columns and "
                                 f"{down} rows")
    return parts


def _print(report, photos, measured):
    """The report as text."""
    print(f"{report['points_found']} points ({report['target']}, {report['columns']} columns x "
          f"{report['rows']} rows) in {report['photos_used']} of {photos} photos")
    if report["target_chosen"]:
        print(f"  target: {report['target_chosen']}; --target names another one")
    if report["tag_spacing"] is not None:
        print(f"  gap between tags: {report['tag_spacing']:.4f} of a tag's side")
    if report["points_outside_frame"]:
        print(f"  {report['points_outside_frame']} of them lie outside the flat picture of the "
              f"default zoom: the lens is fitted to them too, and a square marks them")
    if report["points_cut"]:
        print(f"  {report['points_cut']} of them are cut by the border: numbered, not used")
    for reason, count in report["points_rejected_by_reason"].items():
        print(f"  {count} rejected: {reason}")
    for point in report["points_dropped"][:_LISTED]:
        print(f"  {point['photo']}: point at ({point['x']:g}, {point['y']:g}) dropped: "
              f"{point['reason']}")
    if len(report["points_dropped"]) > _LISTED:
        print(f"  and {len(report['points_dropped']) - _LISTED} more points dropped: --json lists "
              f"all")
    for name, part in report["photos_in_part"].items():
        print(f"  {name}: {part}")
    if report["lateral_colour"]:
        print("  " + _colour_text(report["lateral_colour"]))
    for remark in report["remarks"]:
        print(f"  {remark}")
    worst = max(report["agreement_px"], key=lambda name: report["agreement_px"][name])
    print(f"points lie {report['agreement_px'][worst]:.2f} px or less, on each axis, from where "
          f"their neighbours predict them ({worst}, the least sure photo)")
    if report["lens"]:
        lens = report["lens"]
        print("lens: " + ", ".join(
            f"{title} {lens[name]:.{digits}f} ± {lens[f'{name}_error']:.{digits}f}{unit}"
            for title, name, digits, unit in _FLAWS))
    if measured:
        print(straightness_text(measured, "points that the lens was not fitted to"))
    first, *others = report["overlays"]
    print(f"{report['points']}; look at {first}" + (" and the others" if others else ""))


def _colour_text(colour):
    """One sentence on the lateral colour of raw frames."""
    return (f"raw frames, filter as {colour['pattern']} (by {colour['pattern_from']}): the points "
            f"are those of {colour['points_of']}; in the picture's corner red lies "
            f"{colour['red_px']:+.2f} +- {colour['red_error_px']:.2f} px farther out, blue "
            f"{colour['blue_px']:+.2f} +- {colour['blue_error_px']:.2f} px")


class _Photos:
    """Reads the photos of the command line, which may be too many for the memory.

    Some are cached as the :class:`Backdrop` of their drawing, and a single one whole.
    """

    def __init__(self, args):
        self._args, self._warn = args, _once()
        self._single, self._backdrops, self._free = None, {}, _CACHED

    def readers(self, progress):
        """Each name with the function that reads it, one after the other, with progress."""
        for done, name in enumerate(self._args.photos):
            progress(_LENS * done / len(self._args.photos), f" {Path(name).name}")
            yield name, partial(self._read, name)

    def backdrop(self, name):
        """The :class:`Backdrop` of a photo that was read before."""
        return self._backdrops.get(name) or Backdrop.of(self._read(name).image)

    def _read(self, name):
        if self._single is not None:
            return self._single
        photo = read_photo(name, self._args.raw, self._args.bits, self._warn)
        if len(self._args.photos) == 1:
            self._single = photo
        if name not in self._backdrops and self._free > 0:
            self._backdrops[name] = Backdrop.of(photo.image)
            self._free -= self._backdrops[name].picture.nbytes
        return photo


def _once():
    """Function that writes a sentence to stderr, each sentence once: photos are read again."""
    written = set()

    def warn(sentence):
        if sentence not in written:
            say(sentence)
        written.add(sentence)
    return warn

"""``ncdc calibrate``: finds a target's points in real photos."""

import sys
from pathlib import Path

from ncdc.cli.common import add_json, straightness_text, write_report
from ncdc.terminal import Progress
from ncdc_model.calibration.detect import detect_points
from ncdc_model.calibration.frame import ideal_frame
from ncdc_model.calibration.measure import measure_smooth
from ncdc_model.calibration.overlay import draw_points
from ncdc_model.calibration.quality import warnings_of
from ncdc_model.errors import InputError
from ncdc_model.images import read_image, write_image

__all__ = ["EXAMPLE", "HELP", "add_arguments", "judged", "run"]

HELP = "find a target's points in photos of it"
EXAMPLE = "ncdc calibrate left*.jpg --target chessboard:9x6 -o points.json"


def add_arguments(parser):
    """Declare the command's arguments on an argparse parser."""
    parser.add_argument("photos", nargs="+", metavar="PHOTO",
                        help="photo of the target: colour, grey, or the raw Bayer frame")
    parser.add_argument("--target", default="auto", metavar="KIND",
                        help="dots (a page of black dots that fills the picture), circles:CxR, "
                             "acircles:CxR (staggered: circles in a line, lines), "
                             "chessboard:CxR (inner corners), charuco:CxR (squares), or auto "
                             "(default)")
    parser.add_argument("-o", "--output", default="points.json", metavar="FILE",
                        help="points file (default: points.json); each photo with its points "
                             "drawn over it goes beside it as a PNG")
    add_json(parser)


def run(args):
    """Detect, write the points file and the overlays, report."""
    points = detect_points(_photos(args.photos), args.target)
    output = Path(args.output)
    used = [name for name in dict.fromkeys(args.photos) if name not in points.rejected_photos]
    tags = [""] if len(used) == 1 else [f"-{k}-{Path(name).stem}" for k, name in enumerate(used, 1)]
    overlays = [str(output.with_name(f"{output.stem}{tag}.png")) for tag in tags]
    inputs = {Path(name).resolve() for name in args.photos}
    for path in (args.output, *overlays):
        if Path(path).resolve() in inputs:
            raise InputError(f"the output {path} would replace the photo of that name, choose "
                             f"another -o")
    measured, frame, warnings = judged(points)
    points.save(output)
    for number, (name, overlay, photo) in enumerate(zip(used, overlays, points.photos)):
        write_image(overlay, draw_points(read_image(name), photo, frame, number))
    rejected = {}
    for photo in points.photos:
        for reason, count in photo.rejected.items():
            rejected[reason] = rejected.get(reason, 0) + count
    whole = max(len(photo.index) for photo in points.photos)
    report = {
        "target": points.target, "columns": points.columns, "rows": points.rows,
        "points_found": points.count, "points_cut": points.count - points.whole,
        "points_rejected": sum(rejected.values()),
        "points_rejected_by_reason": rejected, "photos_used": len(points.photos),
        "photos_rejected": points.rejected_photos, "photos_in_part": {
            photo.name: f"{len(photo.index)} of {whole} points" for photo in points.photos
            if points.target != "dots" and len(photo.index) < whole},
        **measured, "warnings": warnings, "points": str(output), "overlays": overlays,
    }
    for name, reason in points.rejected_photos.items():
        print(f"{name}: not used: {reason}", file=sys.stderr)
    for warning in warnings:
        print(f"warning: {warning}", file=sys.stderr)
    if write_report(report, args.json):
        return
    print(f"{points.count} points ({points.target}, {points.columns} columns x {points.rows} rows) "
          f"in {len(points.photos)} of {len(args.photos)} photos")
    if report["points_cut"]:
        print(f"  {report['points_cut']} of them are cut by the border: numbered, not used")
    for reason, count in rejected.items():
        print(f"  {count} rejected: {reason}")
    for name, part in report["photos_in_part"].items():
        print(f"  {name}: {part}")
    if measured:
        print(straightness_text(measured, "points that the lens was not fitted to"))
    print(f"{output}; look at {overlays[0]}" + (" and the others" if overlays[1:] else ""))


def _photos(names):
    """The photos, one after the other; with progress, if there are several."""
    progress = Progress("photos") if len(names) > 1 else lambda *args: None
    for done, name in enumerate(names):
        image = read_image(name)
        progress(done / len(names), f" {Path(name).name}")
        yield name, image
    progress(1)


def judged(points):
    """Straightness with a smooth lens, the frame it was measured in, and warnings.

    Without a lens that explains the points the first is empty, the second None, and the
    warning tells why.
    """
    try:
        try:
            frame = ideal_frame(points)
        except InputError:
            # A lens of 180 degrees fits no flat picture; its middle does.
            frame = ideal_frame(points, zoom=1.0)
    except InputError as error:
        return {}, None, [str(error)]
    measured = measure_smooth(frame)
    return measured, frame, warnings_of(points, frame, measured["repeatability_px"])

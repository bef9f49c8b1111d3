"""``ncdc report``: one page of HTML on a camera, from its descriptor and its calibration."""

import sys
from dataclasses import dataclass
from pathlib import Path

from ncdc.cli.common import add_json, raw_frame, read_photo, write_report
from ncdc.report.camera import (
    accuracy_section,
    commands_section,
    hardware_section,
    lens_section,
    photo_section,
    points_section,
    region_of_points,
)
from ncdc.report.page import camera_page
from ncdc.terminal import Progress
from ncdc_model.calibration.camera_file import load_camera_map
from ncdc_model.calibration.frame import IdealFrame, ideal_frame
from ncdc_model.calibration.points import TargetPoints
from ncdc_model.calibration.remap_file import are_remap_files
from ncdc_model.correction import correct
from ncdc_model.images import demosaic, is_raw
from ncdc_model.training.source import load_points
from ncdc_spec.descriptor import Descriptor
from ncdc_spec.errors import InputError
from ncdc_spec.files import check_outputs, write_text

__all__ = ["EXAMPLE", "add_arguments", "run"]

EXAMPLE = "ncdc report net.toml -o report.html"


def add_arguments(parser) -> None:
    """Declare the command's arguments on an argparse parser."""
    parser.add_argument("descriptor", metavar="NET", help="descriptor of ncdc train")
    parser.add_argument("-o", "--output", default="report.html", metavar="FILE",
                        help="page to write (default: report.html)")
    parser.add_argument("--calibration", metavar="FILE",
                        help="points or camera file that it was trained on (default: the file of "
                             "its name next to NET)")
    parser.add_argument("--photo", metavar="IMAGE",
                        help="photo by this camera, raw or in colour (default: the first of the "
                             "points, next to them or in the folder of a live calibration)")
    add_json(parser)


@dataclass(frozen=True)
class _Material:
    """What a report is made of; None for what is not there."""
    source: Path | None = None
    camera: object = None
    points: TargetPoints | None = None
    frame: IdealFrame | None = None


def run(args) -> None:
    """Collect, measure, write."""
    descriptor = Descriptor.load(args.descriptor)
    warnings, progress = [], Progress("report")
    material = _material(args, descriptor, warnings)
    photo, number = _photo(args, material, warnings)
    check_outputs([args.output], [path for path in (material.source, photo) if path])
    progress(.2, " lens")
    sections, lens = _photo_sections(descriptor, material, photo, number), None
    if material.camera is not None:
        lens = lens_section(material.camera, material.frame)
        region = None
        if material.frame is not None:
            region = region_of_points(descriptor, material.frame)
            warnings += filter(None, [region.warning(descriptor.geometry.distorted[0])])
        sections += [lens, accuracy_section(descriptor, material.camera, material.frame, region)]
    progress(.4, " hardware")
    sections += [hardware_section(descriptor, lambda share: progress(.4 + .6 * share)),
                 commands_section(args.descriptor, photo, material.source)]
    write_text(args.output, camera_page(f"The camera of {Path(args.descriptor).name}",
                                        _lead(descriptor), warnings, sections))
    progress(1)
    for sentence in warnings:
        print(f"warning: {sentence}", file=sys.stderr)
    report = {"digest": descriptor.digest, "page": args.output, "warnings": warnings,
              "lens_words": {name: [figure, words] for name, figure, words in lens["rows"][1:]}
              if lens else {}}
    if not write_report(report, args.json):
        print(f"look at {args.output}")


def _lead(descriptor):
    geometry, kinds = descriptor.geometry, descriptor.provenance
    return ("{}x{} pixels of the sensor ({}) become {}x{} corrected ones by {} hidden neurons, "
            "trained on {} ({}). Digest {}.".format(
                *geometry.distorted, geometry.bayer, *geometry.corrected,
                descriptor.hidden_neurons, kinds.get("source", "an unknown source"),
                kinds.get("source_kind", "of an unknown kind"), descriptor.digest))


def _material(args, descriptor, warnings):
    """:class:`_Material` of the calibration that is named, or that lies next to the descriptor."""
    named = descriptor.provenance.get("source", "")
    path = Path(args.calibration or Path(args.descriptor).with_name(named or "points.json"))
    if args.calibration is None and not path.is_file():
        warnings.append(f"{path} is not there: --calibration names the points or the camera file, "
                        f"without which there is nothing on the lens and its errors")
        return _Material()
    if are_remap_files(path)[1]:
        warnings.append(f"{path} is a map: there is nothing on the lens; ncdc evaluate measures "
                        f"its errors")
        return _Material(path)
    geometry = descriptor.geometry
    points = load_points(path, geometry.distorted)
    if points is None:
        return _Material(path, load_camera_map(path, geometry.corrected, None, None,
                                               geometry.distorted))
    if points.digest != descriptor.provenance.get("source_hash"):
        raise InputError(f"{path} holds other points than those that {args.descriptor} was trained "
                         f"on; ncdc evaluate measures a descriptor on them")
    frame = ideal_frame(points, geometry.corrected)
    return _Material(path, frame.camera, points, frame)


def _photo(args, material, warnings):
    """Path of the photo, None without one, and its number among the points' photos, or None."""
    names = [photo.name for photo in material.points.photos] if material.points else []
    if args.photo is not None:
        name = Path(args.photo).name
        return args.photo, names.index(name) if name in names else None
    for number, name in enumerate(names):
        folder = material.source.parent
        for candidate in (folder, folder / f"{material.source.stem}.photos", Path()):
            if name and (candidate / name).is_file():
                return str(candidate / name), number
    warnings.append("no photo of the calibration is found: --photo names one, without which there "
                    "is no picture before and after")
    return None, None


def _photo_sections(descriptor, material, photo, number):
    if photo is None:
        return []
    raw, note = raw_frame(photo, descriptor.geometry)
    if note:
        print(note, file=sys.stderr)
    image = read_photo(photo, warn=lambda sentence: None).image     # the first read has warned
    before = demosaic(raw, descriptor.geometry.bayer) if is_raw(image) else image
    sections = [photo_section(before, correct(descriptor, raw))]
    if number is not None:
        sections.append(points_section(before, material.points, material.frame, number))
    return sections

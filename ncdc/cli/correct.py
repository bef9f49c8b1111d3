"""``ncdc correct``: corrects pictures, films and a camera's frames with a bit-exact model."""

import sys
from functools import cache
from pathlib import Path

from ncdc.cli.colour import add_colour, colour_choice, colour_line, colour_report
from ncdc.cli.common import add_json, add_samples, raw_frame, write_report
from ncdc.cli.film_crop import add_film_crop
from ncdc.cli.sequence import (
    FILM_MODES,
    correct_camera,
    correct_files,
    correct_film,
    correct_stream,
    listed,
)
from ncdc.cli.view_angles import add_stabilisation, add_view, view_of
from ncdc.cli.view_list import ViewsFile, add_view_list, check_alone
from ncdc.terminal import Progress, percent, say
from ncdc_model.correction import MODELS, coloured, correct, default_model
from ncdc_model.images import check_suffix, is_film, is_film_name, write_image
from ncdc_model.pc_camera import is_pc_camera
from ncdc_spec.descriptor import Descriptor
from ncdc_spec.errors import InputError
from ncdc_spec.files import read_bytes
from ncdc_spec.interpolation import CRESTS
from ncdc_spec.raw_gains import NO_RAW_GAINS

__all__ = ["EXAMPLE", "add_arguments", "run"]

EXAMPLE = "ncdc correct net.toml frame.png -o corrected.png"


def add_arguments(parser) -> None:
    """Declare the command's arguments on an argparse parser."""
    parser.add_argument("descriptor", metavar="NET", help="descriptor of ncdc train")
    parser.add_argument("image", metavar="IMAGE", nargs="+",
                        help="raw Bayer frame (one channel), or a colour picture to be mosaiced; "
                             "several of them, a folder or a pattern as 'frames/*.png'; a film; "
                             "camera:0, a camera of this PC, until Ctrl-C; - for raw frames on "
                             "standard input, which need --raw")
    parser.add_argument("-o", "--output", required=True, metavar="OUT",
                        help="corrected picture; of several a folder; of a film or camera a "
                             "film; of raw frames on standard input a film, or - for bare RGB "
                             "bytes on standard output")
    parser.add_argument("--model", choices=MODELS,
                        help="compiled: C functions, which need a C compiler (default, if there is "
                             "one); reference: NumPy, which takes a hundred times as long; both "
                             "give the same bits")
    film = parser.add_argument_group("films")
    film.add_argument("--film", choices=FILM_MODES, default=FILM_MODES[0],
                      help="bilinear (default), lanczos: remapped in their colours, not by the "
                           "hardware's arithmetic; mosaic: mosaiced, then corrected as raw frames")
    add_film_crop(film)
    film.add_argument("--frames", type=int, metavar="N",
                      help="of a camera of this PC (default: until Ctrl-C)")
    film.add_argument("--fps", type=float, default=30.0, metavar="F",
                      help="frames per second of raw frames on standard input (default: 30)")
    view = parser.add_argument_group("view")
    add_view(view)
    add_view_list(view)
    add_stabilisation(parser.add_argument_group("stabilisation"))
    add_colour(parser.add_argument_group("colour"))
    add_samples(parser.add_argument_group("samples of the file"))
    add_json(parser)


def run(args) -> None:
    """Correct, write, report."""
    images = listed(args.image)
    if args.film_crop is not None and not any(
            is_pc_camera(path) or _film(args, path) for path in images):
        raise InputError(f"--film-crop is {args.film_crop}: it takes a film, {images[0]} is none")
    if args.view_list is not None:
        return _correct_views(args, images)
    if images == ["-"]:
        return correct_stream(args)
    for path in images:
        camera = is_pc_camera(path)
        if not camera and not _film(args, path):
            continue
        if len(images) > 1:
            raise InputError(f"{path} is a {'camera' if camera else 'film'}, which is corrected "
                             f"alone")
        return correct_camera(args, path) if camera else correct_film(args, path)
    if images != args.image or len(images) > 1:
        return correct_files(args, images)
    return _correct_one(args, images[0])


def _film(args, path):
    """Whether ``path`` is a film: by its content, but for raw frames, which may begin anyhow."""
    return is_film_name(path) if args.raw else is_film(path, is_film_name(args.output))


def _correct_one(args, path):
    if is_film_name(args.output):
        if not Path(path).is_file():
            read_bytes(path)        # raises the error that says why
        raise InputError(f"{path} holds no film, {args.output} would be one: an input is judged by "
                         f"its content, as Matroska, MP4, AVI, a transport stream, GIF, YUV4MPEG2")
    check_suffix(args.output)
    choice = colour_choice(args)
    descriptor = Descriptor.load(args.descriptor)
    chosen = view_of(args, descriptor)
    view = chosen.at() if chosen else None
    raw, note = raw_frame(path, descriptor.geometry, args.raw, args.bits)
    model = args.model or default_model(say)

    @cache
    def corrected_with(raw_gains):
        return correct(descriptor, raw, percent(Progress("correcting")),
                       crest=CRESTS[args.crest], raw_gains=raw_gains, model=model, view=view)

    colour = choice(corrected_with) if choice else None
    corrected = corrected_with(colour.raw_gains if colour else NO_RAW_GAINS)
    write_image(args.output, coloured(corrected, colour, model) if colour else
                corrected.picture)
    if note:
        print(note, file=sys.stderr)
    report = {"hidden_neurons": descriptor.hidden_neurons, "pixels": corrected.blank.size,
              "pixels_blank": int(corrected.blank.sum()), "windows_fetched": corrected.fetches,
              "fetch": "multiport", "model": model,
              **(colour_report(args, colour) if colour else {}),
              **(chosen.report if chosen else {})}
    if not write_report(report, args.json):
        share = 100 * corrected.blank.mean()
        size = chosen.size if chosen else descriptor.geometry.corrected
        print(f"{args.output}: {'x'.join(map(str, size))} pixels, "
              f"{share:.1f} % without a source")
        if colour:
            print(colour_line(args, colour))


def _correct_views(args, images):
    """Several views of one raw frame in one picture."""
    check_suffix(args.output)
    check_alone(args)
    if len(images) > 1 or images == ["-"] or is_pc_camera(images[0]) or _film(args, images[0]):
        raise InputError(f"--view-list is given with {args.image[0]}, it takes one picture")
    descriptor, views = Descriptor.load(args.descriptor), ViewsFile.load(args.view_list)
    raw, note = raw_frame(images[0], descriptor.geometry, args.raw, args.bits)
    model = args.model or default_model(say)
    write_image(args.output, views.picture(descriptor, raw, model))
    if note:
        print(note, file=sys.stderr)
    report = {"hidden_neurons": descriptor.hidden_neurons, "views": len(views.views),
              "pixels": views.size[0] * views.size[1], "model": model}
    if not write_report(report, args.json):
        count = len(views.views)
        print(f"{args.output}: {count} view{'s' * (count > 1)} in {views.size[0]}x{views.size[1]} "
              f"pixels")

"""Many pictures for ``ncdc correct``: files, a film, a camera, raw frames on standard input."""

import sys
import time
from contextlib import contextmanager
from fractions import Fraction
from functools import cache
from glob import glob
from pathlib import Path

import cv2

from ncdc.cli.colour import colour_choice, colour_line, colour_report
from ncdc.cli.common import raw_frame, write_report
from ncdc.cli.film_crop import film_crop
from ncdc.cli.view_angles import view_of
from ncdc.terminal import Progress, Steps, say
from ncdc_model.correction import coloured, correct, correction_of, default_model
from ncdc_model.images import FILMS, is_film_name, mosaic, write_image
from ncdc_model.pc_camera import is_pc_camera, opened_camera
from ncdc_model.raw_dump import RawDump
from ncdc_model.remap_tables import PlaneMaps, remap_tables
from ncdc_spec.descriptor import Descriptor
from ncdc_spec.errors import InputError
from ncdc_spec.interpolation import CRESTS
from ncdc_spec.raw_gains import NO_RAW_GAINS

__all__ = ["FILM_MODES", "correct_camera", "correct_film", "correct_files", "correct_stream",
           "listed"]

_KERNELS = {"bilinear": cv2.INTER_LINEAR, "lanczos": cv2.INTER_LANCZOS4}
_MOSAIC = "mosaic"
FILM_MODES = (*_KERNELS, _MOSAIC)


def listed(images):
    """Paths of the pictures that arguments name: files, the files of folders, patterns.

    Raises
    ------
    InputError
        If a folder is empty or a pattern matches no file.
    """
    paths = []
    for name in images:
        if is_pc_camera(name):
            found = [name]
        elif Path(name).is_dir():
            found = sorted(str(path) for path in Path(name).iterdir()
                           if path.is_file() and not path.name.startswith("."))
        elif Path(name).exists() or not any(sign in name for sign in "*?["):
            found = [name]
        else:
            found = sorted(glob(name))
        if not found:
            raise InputError(f"{name} names no file")
        paths += found
    return paths


class _Sequence:
    """Corrects frames by the options of the command, counts and times them."""

    def __init__(self, args):
        self.args, self._choice = args, colour_choice(args)
        self.descriptor = Descriptor.load(args.descriptor)
        self.view = view_of(args, self.descriptor)
        self.model = args.model or default_model(say)
        self.colour, self.crop, self.count, self._begin = None, None, 0, time.monotonic()

    @property
    def size(self):
        """Width and height of the corrected pictures."""
        geometry = self.descriptor.geometry
        if self.view:
            return self.view.size
        return self.crop.size(geometry) if self.crop else geometry.corrected

    @property
    def rate(self):
        """Frames per second so far."""
        return self.count / max(time.monotonic() - self._begin, 1e-9)

    def picture(self, raw, seconds=0.0):
        """The corrected picture of a raw frame that began at ``seconds``.

        One white balance, the first frame's, is for all.
        """
        view = self.view.at(seconds) if self.view else None

        @cache
        def corrected_with(raw_gains):
            return correct(self.descriptor, raw, crest=CRESTS[self.args.crest],
                           raw_gains=raw_gains, model=self.model, view=view)

        if self._choice and not self.count:
            self.colour = self._choice(corrected_with)
        self.count += 1
        corrected = corrected_with(self.colour.raw_gains if self.colour else NO_RAW_GAINS)
        return (coloured(corrected, self.colour, self.model) if self.colour else
                corrected.picture)

    def report(self, how, show=print):
        """Write the report; ``how``: keys and values on how the pictures were made."""
        report = {"hidden_neurons": self.descriptor.hidden_neurons, "pictures": self.count,
                  "frames_per_second": self.rate, **how,
                  **(self.view.report if self.view else {})}
        if self.colour:
            report |= colour_report(self.args, self.colour)
        if not write_report(report, self.args.json):
            show(f"{self.args.output}: {self.count} pictures, "
                 f"{'x'.join(map(str, self.size))} pixels, "
                 f"{self.rate:.1f} frames per second")
            if self.colour:
                show(colour_line(self.args, self.colour))


def correct_files(args, paths):
    """Correct picture files into the folder ``args.output``, each as PNG of its own name."""
    folder = Path(args.output)
    targets = [folder / f"{Path(path).stem}.png" for path in paths]
    for path, target in zip(paths, targets):
        if targets.count(target) > 1:
            raise InputError(f"{target} would be written for {path} and for another picture")
        if target.exists() and any(target.samefile(one) for one in paths if Path(one).exists()):
            raise InputError(f"the output {target} would replace an input")
    if folder.exists() and not folder.is_dir():
        raise InputError(f"{folder} is no folder, several pictures need one")
    if args.gyro is not None:
        raise InputError(f"{paths[0]} and other files have no times, --gyro needs a film, raw "
                         f"frames on standard input or one picture")
    sequence, progress, notes = _Sequence(args), Progress("correcting"), set()
    for path, target in zip(paths, targets):
        raw, note = raw_frame(path, sequence.descriptor.geometry, args.raw, args.bits)
        if note and (text := note.removeprefix(path)) not in notes:
            say(note)                   # once a kind, not once a file
            notes.add(text)
        write_image(target, sequence.picture(raw))
        progress(sequence.count / len(paths))
    sequence.report({"model": sequence.model})


def correct_film(args, path):
    """Correct the film ``path``, in its colours or as raw frames."""
    from ncdc_model.film import change_film, frame_shape
    sequence, changed = _film_change(args, path, *frame_shape(path))
    made = change_film(path, args.output, sequence.size, changed, say, Progress("correcting"))
    if args.film == _MOSAIC and made.source_bits > made.bits:
        say(f"--film {_MOSAIC} corrects samples of 8 bits, as the hardware does: the "
            f"{made.source_bits} bits of {path} are rounded")
    return _film_state(args, path, sequence, made)


def _film_state(args, path, sequence, made):
    """Write the report, and say what is damaged; the exit status."""
    if made.skipped or made.repaired:
        say(f"{path} is damaged: packets that gave no picture and are skipped: {made.skipped}; "
            f"pictures that are kept as the decoder has repaired them: {made.repaired}")
    if made.cut_off:
        of = f" of {made.expected}" if made.expected > made.pictures else ""
        say(f"{path} is cut off: {made.pictures}{of} pictures are written")
    _report_film(args, sequence, {"bits": made.bits, "packets_skipped": made.skipped,
                                  "pictures_repaired": made.repaired, "cut_off": made.cut_off})
    return int(made.cut_off)


def correct_camera(args, name):
    """Correct what a camera of the PC sends into a film, for ``args.frames`` or until Ctrl-C."""
    from ncdc_model.film import writing_film
    if args.gyro is not None:
        raise InputError(f"{name} is a camera, --gyro needs a film")
    if args.frames is not None and args.frames < 1:
        raise InputError(f"--frames is {args.frames}, 1 is the limit")
    sequence, changed = _film_change(args, name, None, 1)
    shown, size = Steps("correcting", quiet=True), sequence.size
    with opened_camera(name) as camera, writing_film(args.output, size, _rate(camera.rate)) as film:
        try:
            while args.frames is None or sequence.count < args.frames:
                picture = camera.read()
                film.write(changed(picture, 0.0) if changed.rgb else changed(
                    [picture], 0.0, lambda colour: (colour,))[0])
                shown(f"{sequence.count} frames, {sequence.rate:.1f} per second")
        except KeyboardInterrupt:
            if not sequence.count:
                raise
    _report_film(args, sequence)


def _film_change(args, name, size, aspect):
    """:class:`_Sequence`, and the function that corrects a picture of a film or a camera, as of
    :func:`ncdc_model.film.changing.change_film`.

    ``size`` and ``aspect``: of the film's pictures and pixels; size None of a camera.
    """
    if not is_film_name(args.output):
        what = "a camera, whose pictures become a film" if is_pc_camera(name) else "a film"
        raise InputError(f"{name} is {what}, {args.output} is none: films are written as one of "
                         f"{', '.join(FILMS)}")
    if args.film != _MOSAIC and colour_choice(args):
        raise InputError(f"the film is remapped in its colours ({args.film}): --raw-balance, "
                         f"--crest, --white-balance and --tone need --film {_MOSAIC}")
    if args.film_crop is not None and (args.film == _MOSAIC or size is None):
        raise InputError(f"--film-crop is {args.film_crop}: it takes a film that is remapped in "
                         f"its colours, " + (f"{name} is a camera" if size is None else
                                             f"--film {_MOSAIC} has the descriptor's pixels"))
    sequence = _Sequence(args)
    geometry = sequence.descriptor.geometry
    if size is not None:
        sequence.crop = film_crop(args, name, size, aspect, geometry)
    camera, size = size is None, size or geometry.distorted
    if args.film == _MOSAIC:
        def change(picture, seconds):
            _check_size(name, picture, size, camera)
            return sequence.picture(mosaic(picture, geometry.bayer), seconds)
    else:
        remapped = _remapping(sequence, _KERNELS[args.film])

        def change(planes, seconds, samples_of):
            _check_size(name, planes[0], size, camera)
            return remapped(planes, seconds, samples_of(geometry.fill))
    change.rgb = args.film == _MOSAIC
    say(f"{name}: its pictures are " + (
        f"mosaiced as {geometry.bayer} and corrected as the hardware does" if args.film == _MOSAIC
        else f"remapped in their colours ({args.film}), not by the hardware's arithmetic"))
    return sequence, change


def _check_size(name, picture, size, camera):
    """Raise :class:`InputError` if a ``picture`` has not the ``size`` of the others, or a camera's
    not that of the descriptor."""
    if picture.shape[1::-1] == size:
        return
    if camera:
        raise InputError("{0} has {1}x{2} pixels, the descriptor is for {3}x{4}: measure the lens "
                         "with the camera, ncdc calibrate --live {0}".format(
                             name, *picture.shape[1::-1], *size))
    raise InputError("{} has a picture of {}x{} pixels among those of {}x{}".format(
        name, *picture.shape[1::-1], *size))


def _report_film(args, sequence, state=None):
    how = {"model": sequence.model} if args.film == _MOSAIC else {}
    sequence.report({"film": args.film, **how, **(state or {})})


def _remapping(sequence, kernel):
    """Function that remaps the planes of a picture of finished colours by the map of a descriptor
    or a view; each has its own sample where there is no source."""
    still, crop = None, sequence.crop
    if not sequence.view:
        still = PlaneMaps(*(crop.maps(sequence.descriptor) if crop else (
            *remap_tables(sequence.descriptor),
            correction_of(sequence.descriptor, sequence.model).blank)), kernel)

    def remapped(planes, seconds, fills):
        sequence.count += 1
        if still:
            return still(planes, fills)
        maps = sequence.view.maps(seconds)
        return PlaneMaps(*(crop.of_film(*maps) if crop else maps), kernel)(planes, fills)
    return remapped


def correct_stream(args):
    """Correct raw frames on standard input into a film, or into bare RGB on standard output."""
    if args.raw is None:
        raise InputError("raw frames on standard input need --raw, as in --raw 1280x1024:RGGB:8")
    if args.output == "-" == args.json:
        raise InputError("-o - and --json - are given, standard output holds one of them")
    if not args.fps > 0:
        raise InputError(f"--fps is {args.fps:g}, it must be positive")
    dump, sequence = RawDump.parse(args.raw), _Sequence(args)
    geometry, shown = sequence.descriptor.geometry, Steps("correcting", quiet=True)
    if dump.bayer != geometry.bayer:
        raise InputError(f"the raw frames have the pattern {dump.bayer}, the descriptor "
                         f"{geometry.bayer}")
    with _sink(args, sequence.size) as write:
        while content := sys.stdin.buffer.read(dump.frame_bytes):
            if len(content) < dump.frame_bytes:
                say(f"the last frame is left out, it has {len(content)} of {dump.frame_bytes} "
                    f"bytes")
                break
            raw = dump.unpacked(content, "standard input", say)
            write(sequence.picture(raw, sequence.count / args.fps))
            shown(f"{sequence.count} frames, {sequence.rate:.1f} per second")
    if not sequence.count:
        raise InputError("standard input holds no frame")
    sequence.report({"model": sequence.model}, say if args.output == "-" else print)


@contextmanager
def _sink(args, size):
    """Yield the function that takes the corrected pictures of a stream."""
    if args.output == "-":
        yield lambda picture: sys.stdout.buffer.write(picture.tobytes())
        sys.stdout.buffer.flush()
        return
    from ncdc_model.film import writing_film
    with writing_film(args.output, size, _rate(args.fps)) as film:
        yield film.write


def _rate(frames_per_second):
    """The rate of a film as a fraction, such as 30000/1001."""
    return Fraction(frames_per_second).limit_denominator(1001)

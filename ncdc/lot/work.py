"""The work on one unit, as a worker does it: photos to points, a network, figures."""

import hashlib
import socket
import time
import traceback
from contextlib import suppress
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory

import cv2
import numpy as np

from ncdc.lot.agreement import mixed
from ncdc.lot.identity import identity
from ncdc.lot.photo_checks import bad_lines, blur_ratio, level_picture, soft_half
from ncdc.lot.units import local_photos
from ncdc_model.calibration.boards import grey_picture
from ncdc_model.calibration.detect import detect_points, parse_target
from ncdc_model.calibration.judged import judged
from ncdc_model.calibration.overlay import draw_points
from ncdc_model.flaw_figures import flaws_of
from ncdc_model.images import demosaic, is_raw
from ncdc_model.lens import parse_zoom
from ncdc_model.photo.read import decode_photo
from ncdc_model.threads import one_thread
from ncdc_model.training.choices import TrainingChoices
from ncdc_model.training.choose import GOAL, choose_camera
from ncdc_model.training.pipeline import train_camera
from ncdc_model.training.source import load_source
from ncdc_model.training.train import check_request
from ncdc_spec.errors import InputError
from ncdc_spec.files import read_bytes
from ncdc_spec.interpolation import DEFAULT, interpolation_of

__all__ = ["Outcome", "Request", "process"]

_PICTURE, _QUALITY = 480, 80        # columns, and quality of the JPEG that shows a unit


@dataclass(frozen=True)
class Request:
    """What is done with every unit; the options of ``ncdc calibrate`` and ``ncdc train``.

    ``neurons``: a number, or None for the fewest whose largest error is ``goal`` pixels or less.
    """
    target: str = "auto"
    page: str = ""
    neurons: int | None = None
    goal: float = GOAL
    seed: int = 0
    size: tuple | None = None
    zoom: str | None = None
    bayer: str = "RGGB"
    interpolation: str = DEFAULT.name

    def check(self):
        """Raise :class:`InputError` for what no unit could meet."""
        parse_target(self.target)
        check_request(self.neurons or 1, TrainingChoices())
        if self.seed < 0:
            raise InputError(f"seed is {self.seed}, it must not be negative")
        if self.zoom is not None:
            parse_zoom(self.zoom)
        interpolation_of(self.interpolation)


@dataclass
class Outcome:
    """Everything that is known of a unit after the work.

    Parameters
    ----------
    figures : dict
        Values by name of :data:`ncdc.lot.figures.FIGURES`.
    warnings : list of str
    error : str
        Why there is no network; empty if there is one.
    photo_hashes : list of str
        SHA-256 of the content of each photo.
    descriptor : str
        Text of the descriptor.
    digest : str
        Of the descriptor.
    picture : bytes
        JPEG of the first photo with its points.
    seconds : float
    worker : str
        Name of the machine.
    made_by : dict
        :func:`ncdc.lot.identity.identity` of the worker.
    """
    figures: dict = field(default_factory=dict)
    warnings: list = field(default_factory=list)
    error: str = ""
    photo_hashes: list = field(default_factory=list)
    descriptor: str = ""
    digest: str = ""
    picture: bytes = b""
    seconds: float = 0.0
    worker: str = ""
    made_by: dict = field(default_factory=dict)


def process(addresses, request):
    """:class:`Outcome` of the photos at ``addresses``, by a :class:`Request`.

    Bad photos, and an error of the software, are in the outcome: no unit stops the others.
    """
    start = time.monotonic()
    outcome = Outcome(worker=socket.gethostname(), made_by=identity())
    try:
        with np.errstate(all="ignore"), one_thread(), local_photos(addresses) as paths:
            _measure(outcome, paths, request)
    except InputError as error:
        outcome.error = str(error)
    except Exception as error:
        *_, last = traceback.extract_tb(error.__traceback__)
        outcome.error = (f"the software failed: {type(error).__name__}: {error} "
                         f"({Path(last.filename).name}, line {last.lineno})")
    outcome.seconds = time.monotonic() - start
    return outcome


def _measure(outcome, paths, request):
    """Fill ``outcome`` step by step, so that it has what was known when an error came."""
    if not paths:
        raise InputError("the unit has no photo")
    for path in paths:
        outcome.photo_hashes.append(_hash(read_bytes(path)))
    outcome.figures["photos_used"] = 0
    images = dict(zip(_names(paths), map(partial(partial, _image), paths, outcome.photo_hashes)))
    outcome.picture = _first_picture(images.values(), request.bayer)
    points = detect_points(list(images.items()), request.target)
    outcome.figures |= {"points": points.count, "photos_used": len(points.photos)}
    outcome.warnings += [reason if name in reason else f"{name}: {reason}"
                         for name, reason in points.rejected_photos.items()]
    outcome.warnings += _checked(outcome, images, points)
    measured, frame, warnings = judged(points)
    first = points.photos[0]
    shown = _shown(images[first.name](), request.bayer)
    outcome.picture = _jpeg(draw_points(shown, first, frame, 0))
    if frame is None:
        raise InputError(warnings[0])
    outcome.warnings += warnings
    outcome.figures |= {name: value if np.isfinite(value) else None
                        for name, value in vars(flaws_of(frame.camera, frame)).items()}
    outcome.figures["straightness_px"] = measured["straightness_rms_px"]
    outcome.figures["disagreement_px"], text = mixed(frame)
    outcome.warnings += filter(None, [text])
    _train(outcome, points, request)


def _checked(outcome, images, points):
    """Sentences on bad rows and soft halves of the photos; notes the largest ratio of blur."""
    photos, found, ratios = {photo.name: photo for photo in points.photos}, [], []
    for name, image in images.items():
        with suppress(InputError):      # a photo that cannot be read has its sentence
            image = image()
            texts = bad_lines(level_picture(image))
            if name in photos:
                blur = blur_ratio(grey_picture(image), photos[name])
                ratios.append(blur[0])
                texts.append(soft_half(*blur))
            found += [f"{name}: {text}" for text in texts if text]
    outcome.figures["blur_ratio"] = max(filter(np.isfinite, ratios), default=None)
    return found


def _train(outcome, points, request):
    choices = TrainingChoices(seed=request.seed)
    with TemporaryDirectory(prefix="ncdc-lot-") as folder:
        path = Path(folder) / "points.json"
        points.save(path)
        source = load_source(path, request.size, request.zoom, page=request.page,
                             bayer=request.bayer,
                             interpolation=interpolation_of(request.interpolation))
        if request.neurons is None:
            trained = choose_camera(source, choices=choices, goal=request.goal)
        else:
            trained = train_camera(source, request.neurons, choices)
        trained.descriptor.save(Path(folder) / "net.toml")
        outcome.descriptor = (Path(folder) / "net.toml").read_text()
    report, errors = trained.report, trained.report["map_error_fixed_px"]
    outcome.warnings += [sentence for sentence in report.get("warnings", ())
                         if sentence not in outcome.warnings]
    outcome.digest = trained.descriptor.digest
    outcome.figures |= {
        "neurons": report["hidden_neurons"], "max_error_px": errors["max"],
        "mean_error_px": errors["mean"],
        "coverage_percent": 100 * (1 - report["extrapolated_percent"] / report["valid_percent"])}


def _image(path, known):
    """The picture in a file, whose hash is ``known``: what was hashed is what is measured.

    A file is read as often as its picture is needed, for only one is in memory.
    """
    content = read_bytes(path)
    if _hash(content) != known:
        raise InputError(f"{path} has changed since the work on the unit began")
    return decode_photo(path, content).image


def _hash(content):
    return hashlib.sha256(content).hexdigest()


def _names(paths):
    """Names of photos: those of the files, numbered where two are equal."""
    names = [Path(path).name for path in paths]
    return names if len(set(names)) == len(names) else [
        f"{number}-{name}" for number, name in enumerate(names, 1)]


def _shown(image, bayer):
    """A picture for people, uint8 RGB."""
    return demosaic(image, bayer) if is_raw(image) else image


def _first_picture(images, bayer):
    """JPEG of the first photo that can be read; empty without one."""
    for image in images:
        with suppress(InputError):
            return _jpeg(_shown(image(), bayer))
    return b""


def _jpeg(picture):
    height, width = picture.shape[:2]
    if width > _PICTURE:
        size = _PICTURE, max(1, round(height * _PICTURE / width))
        picture = cv2.resize(picture, size, interpolation=cv2.INTER_AREA)
    quality = cv2.IMWRITE_JPEG_QUALITY, _QUALITY
    return cv2.imencode(".jpg", picture[:, :, ::-1], quality)[1].tobytes()

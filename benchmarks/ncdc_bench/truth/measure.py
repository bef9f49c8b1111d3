"""Calibration and training on a photographed page, compared with the true lens."""

import tempfile
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from scipy.optimize import least_squares

from ncdc_bench.photos.measure import judge
from ncdc_bench.truth.boards import BOARDS, Board, board_of, photograph_board
from ncdc_bench.truth.lenses import SIZE
from ncdc_bench.truth.render import POSES, Page, photograph
from ncdc_bench.truth.synthetic import points_of
from ncdc_bench.truth.true_flaws import tilt_figures
from ncdc_model.calibration.detect import detect_points
from ncdc_model.calibration.judged import judged
from ncdc_model.evaluate import fixed_map
from ncdc_model.mask_border import border_mask
from ncdc_model.training.choices import TrainingChoices
from ncdc_model.training.pipeline import train_camera
from ncdc_model.training.source import load_source

__all__ = ["Dots", "detect", "found_points", "measure", "page_in_front", "page_of",
           "true_errors"]

_COLUMNS = 40          # dots across the picture's width
_FILLED = 64, 48       # dots of a page that goes on beyond the picture
_WIDE = 60.0           # degrees from the axis: no page fills the picture of a wider lens
_STEP = 4              # pixels between those on which map and truth are compared


@dataclass(frozen=True)
class Dots:
    """Dots of one photo: ``visible`` whole ones, ``used`` of them, ``false`` points."""
    visible: int
    used: int
    false: int


def page_of(lens, number):
    """The :class:`Page` in front of ``lens`` on photo ``number``.

    It fills the picture; with a very wide lens its 28 columns only reach from side to side.
    """
    edge = np.hypot(*lens.angles_at(np.array([[0.0, (SIZE[1] - 1) / 2]])).T).item()
    if np.degrees(edge) < _WIDE:
        return Page(*_FILLED, _COLUMNS / 2 / np.tan(edge), POSES[number])
    return Page(28, 20, 14 / np.tan(edge), POSES[number])


def page_in_front(lens, target, number):
    """The :class:`Page` of dots, or of the corners of a board, that fills photo ``number``."""
    if target == "dots":
        return page_of(lens, number)
    board = board_of(lens, target, number)
    return Page(board.columns, board.rows, board.distance, board.turns)


def detect(lens, photos, seed=0):
    """(:class:`TargetPoints`, a :class:`Dots` per photo) of so many ``photos`` of the page."""
    shots = [photograph(lens, page_of(lens, k), seed + k) for k in range(photos)]
    points = detect_points([(f"{k}.png", shot.image) for k, shot in enumerate(shots)], "dots")
    found = {photo.name: photo for photo in points.photos}
    dots = []
    for k, shot in enumerate(shots):
        photo = found.get(f"{k}.png")
        visible, false, *_ = judge(shot, photo) if photo else (
            int(shot.truths[0].visible.sum()), 0)
        dots.append(Dots(visible, len(photo.whole.index) - false if photo else 0, false))
    return points, dots


def found_points(lens, pages, target, exact, seed=0):
    """:class:`TargetPoints` of photos of ``pages`` of a ``target`` through ``lens``.

    ``exact``: the true points with noise instead of those that are detected on rendered photos.
    """
    if exact:
        return points_of(lens, pages, target, seed=seed)
    if target == "dots":
        shots = [photograph(lens, page, seed + k) for k, page in enumerate(pages)]
    else:
        shots = [photograph_board(lens, Board(target, page.columns, page.rows, page.distance,
                                              page.turns), seed + k)
                 for k, page in enumerate(pages)]
        target = "{}:{}x{}".format(target, *BOARDS[target])
    return detect_points([(f"{k}.png", shot.image) for k, shot in enumerate(shots)], target)


def measure(lens, points, neurons, choices=TrainingChoices()):
    """Row of the report: errors of the trained map as they are and as they are reported."""
    points = points.rounded
    _, frame, said = judged(points)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "points.json"
        replace(points, fits=frame.fits if frame else ()).save(path)
        source = load_source(path, bayer="MONO")
    trained = train_camera(source, neurons, choices)
    rms, worst = true_errors(lens, trained.descriptor)
    report, beyond = trained.report, trained.report.get("beyond_points")
    said = list(dict.fromkeys([*said, *report.get("warnings", ())]))
    return {"lens": lens.name, "target": points.target, "photos": len(points.photos),
            "hidden_neurons": neurons, **tilt_figures(lens, source.frame),
            **_sag_figures(source.frame, report),
            "warned": bool(said), "warnings": said,
            "relief_px": report["relief_rms_px"], "true_rms_px": rms, "true_max_px": worst,
            "reported_rms_px": report["map_error_fixed_px"]["mse"]**.5,
            "reported_max_px": report["map_error_fixed_px"]["max"],
            "reported_beyond_max_px": beyond["map_error_fixed_px"]["max"] if beyond else None,
            "beyond_percent": report.get("beyond_points_percent"),
            "held_out_max_px": report["held_out"]["map_error_fixed_px"]["max"]}


def _sag_figures(frame, report):
    """``sag_percent`` of the page that was taken off the points, and ``sag_error_percent``; and
    ``per_sag_px``, stated pixels by which each percent of sag moves the map at most."""
    sag, error = frame.sag
    stated = report.get("page_sag")
    return {"sag_percent": 100 * sag, "sag_error_percent": 100 * error if error > 0 else None,
            "per_sag_px": stated["max_px"] / stated["sag_percent"] if stated else 0.0}


def true_errors(lens, descriptor, step=_STEP):
    """Root mean square and largest distance, in distorted pixels, of a descriptor's map from the
    true lens over its valid pixels.

    A flat picture is known up to a homography. The one from corrected pixels to the true ideal
    plane is chosen to minimise the squared distances. ``step``: compared are the pixels of each
    so many rows and columns, and those of the border.
    """
    width, height = descriptor.geometry.corrected
    valid = descriptor.valid.mask(width)
    v, u = np.nonzero(_sampled(valid, step))
    found = np.stack(fixed_map(descriptor)(u, v), axis=1)
    rows = np.column_stack([(u - width / 2) / width, (v - height / 2) / width, np.ones(len(u))])

    def distances(parameters):
        rays = rows @ np.append(parameters, 1.0).reshape(3, 3).T
        return lens.project(rays) - found
    best = least_squares(lambda p: distances(p).ravel(), _first(lens, rows, found), x_scale="jac",
                         xtol=1e-14, ftol=1e-14, gtol=1e-14)
    far = np.linalg.norm(distances(best.x), axis=1)
    return float(np.sqrt(np.mean(far**2))), float(far.max())


def _sampled(valid, step):
    """Pixels of each so many rows and columns, and the border, of the valid region."""
    some = border_mask(valid)
    some[::step, ::step] |= valid[::step, ::step]
    return some


def _first(lens, rows, found):
    """The homography's eight numbers by a linear fit to the pixels near the middle."""
    near = np.linalg.norm(found - lens.centre, axis=1) < 300
    near = np.flatnonzero(near)[::max(1, int(near.sum() / 500))]
    at = lens.angles_at(found[near])
    theta = np.linalg.norm(at, axis=1)
    ideal = at * (np.tan(theta) / theta)[:, None]
    plane, nothing = rows[near], np.zeros((len(near), 3))
    system = np.vstack([np.hstack([plane, nothing, -ideal[:, :1] * plane]),
                        np.hstack([nothing, plane, -ideal[:, 1:] * plane])])
    matrix = np.linalg.svd(system, full_matrices=False)[2][-1]
    return matrix[:8] / matrix[8]

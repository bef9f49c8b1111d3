"""Points of pages through a :class:`TrueLens` as a detector would give them, without a picture."""

import numpy as np

from ncdc_bench.truth.lenses import SIZE
from ncdc_bench.truth.render import POSES, RADIUS, Page, area, centroid, seen, whole
from ncdc_model.calibration.points import PhotoPoints, TargetPoints

__all__ = ["NOISE", "page_at", "points_of", "poses"]

NOISE = {"dots": 0.04, "chessboard": 0.05}     # pixels on an axis: standard deviation of a point
_MARGIN = 0.4          # of a square, about a corner: so much of the board is in the picture
_TILT, _TURN = 18.0, 12.0      # degrees: most of a random pose


def poses(count, seed=0):
    """Rotation vectors, degrees, of ``count`` photos: those of the rendered pages, then random."""
    rng = np.random.default_rng(seed)
    return [*POSES[:count], *(tuple(rng.uniform(-1, 1, 3) * (_TILT, _TILT, _TURN))
                              for _ in range(count - len(POSES)))]


def page_at(lens, share, turns, cells=(32, 24), bend=None):
    """:class:`Page` of ``cells`` columns and rows that fills a ``share`` of the picture's width.

    So far away is it that its middle row, not turned, spans this share about the optical axis.
    """
    ends = lens.centre[0] + np.array([-.5, .5]) * share * SIZE[0]
    across = lens.angles_at(np.column_stack([np.clip(ends, 0, SIZE[0] - 1),
                                             np.full(2, lens.centre[1])]))
    return Page(*cells, cells[0] / np.tan(np.linalg.norm(across, axis=1)).sum(), tuple(turns),
                bend)


def points_of(lens, pages, target="dots", noise=None, seed=0):
    """:class:`TargetPoints` of a photo of each of ``pages`` through ``lens``.

    ``target``: ``dots``, centres of gravity of whole dots, with their areas; else corners.
    ``noise``: pixels on an axis, standard deviation; by default that of :data:`NOISE`.
    """
    rng = np.random.default_rng(seed)
    noise = NOISE[target] if noise is None else noise
    dots, photos = target == "dots", []
    for number, page in enumerate(pages):
        index, outline, inside = seen(lens, page, RADIUS if dots else _MARGIN)
        xy = centroid(outline) if dots else lens.project(page.rays(index))
        use = whole(lens, page, index, xy, inside)
        index, xy = index[use], xy[use] + rng.normal(0, noise, (int(use.sum()), 2))
        photos.append(PhotoPoints(index=index, xy=xy, name=f"{number}.png",
                                  area=area(outline[use]) if dots else np.zeros(len(xy))))
    return TargetPoints(target, SIZE, tuple(photos))

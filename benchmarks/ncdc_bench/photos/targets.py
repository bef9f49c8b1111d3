"""Photos of calibration targets whose every point is known: rendered, or real ones found before."""

from dataclasses import dataclass, replace
from pathlib import Path

import cv2
import numpy as np

from ncdc_bench.photos.lens import Lens, Plane
from ncdc_model.example import example_camera, page_dots, page_to_distorted, target_photo
from ncdc_model.images import read_image
from ncdc_spec.errors import InputError

__all__ = ["Bank", "Photo", "Pose", "Truth", "side_by_side"]

_SUBSAMPLES = 3        # per pixel and axis
_SQUARE = 60           # texture pixels of a square of a ChArUco board
_FAMILY = cv2.aruco.DICT_5X5_250
# Real photos, their kind, and columns and rows (None: all that are there).
_REAL = {
    "page": ("dots/dot_pattern_05.jpg", "dots"), "barrel": ("dots/dot_pattern_06.jpg", "dots"),
    "circles": ("circles/circle_regular/image00000.jpg", "circles"),
    "circles2": ("circles/circle_regular/image00001.jpg", "circles"),
    "hexagonal": ("circles/circle_hexagonal/image04.jpg", "acircles"),
    **{f"wide{k}": (f"chessboard_wide/GOPR00{n}.jpg", "chessboard")
       for k, n in enumerate((32, 34, 36, 38), 1)},
    **{f"mild{k}": (f"opencv/left0{k}.jpg", "chessboard") for k in (1, 2, 3, 4)},
    **{f"fisheye{k}": (f"fisheye/{k}.jpg", "chessboard") for k in (1, 2, 3, 5)},
}


@dataclass(frozen=True)
class Truth:
    """One target in a photo: ``index`` (n, 2) and pixels ``xy`` (n, 2) of all its points.

    ``visible`` (n,): in the picture and not covered; ``lens``: the :class:`Lens`, if known.
    """
    kind: str
    index: np.ndarray
    xy: np.ndarray
    visible: np.ndarray
    lens: Lens | None = None

    def moved(self, move, size):
        """The same with its points moved by ``move``; points outside the picture are invisible.

        The lens is unknown then, unless ``move`` is None.
        """
        xy = self.xy if move is None else move(self.xy)
        inside = ((xy >= 0) & (xy <= np.array(size) - 1)).all(axis=1)
        return replace(self, xy=xy, visible=self.visible & inside,
                       lens=self.lens if move is None else None)


@dataclass(frozen=True)
class Photo:
    """A uint8 picture, grey (h, w) or RGB (h, w, 3), and the targets that it shows."""
    image: np.ndarray
    truths: tuple

    @property
    def size(self):
        """Width and height."""
        return self.image.shape[1], self.image.shape[0]


@dataclass(frozen=True)
class Pose:
    """Pose of a rendered target: its middle in the ideal plane, one step's length there, its turn
    in the picture, its two tilts in degrees, and its curvature. The curvature is 1 / radius,
    in steps, of a page bent round a cylinder along its columns. A page of two sheets has the axis
    across their seam (0: it lies right of a column, 1: below a row), that column or row in the
    middle, and the shift of the second sheet in steps (columns, rows)."""
    middle: tuple = (0.0, 0.0)
    step: float = 0.16
    turn: float = 5.0
    tilts: tuple = (8.0, -6.0)
    bend: float = 0.0
    sheets: tuple | None = None


def _discs(x, y, radius, columns, rows, parity=None):
    """Signed distance to the nearest disc of a grid whose first centre is (0, 0)."""
    best = np.full(x.shape, np.inf)
    i, j = np.rint(x), np.rint(y)
    for di in (0, -1, 1) if parity is not None else (0,):
        for dj in (0, -1, 1) if parity is not None else (0,):
            a, b = np.clip(i + di, 0, columns - 1), np.clip(j + dj, 0, rows - 1)
            distance = np.hypot(x - a, y - b)
            if parity is not None:
                distance = np.where((a + b) % 2 == parity, distance, np.inf)
            best = np.minimum(best, distance)
    return best - radius


def _pattern(kind, columns, rows):
    """(paint, index, extent): ``paint(x, y)`` gives the grey of target coordinates whose unit is
    the index's, not-a-number beyond the target's rim."""
    if kind in ("dots", "circles", "acircles"):
        lines, parity = (2 * columns, 0) if kind == "acircles" else (columns, None)
        radius = {"dots": 0.24, "circles": 0.28, "acircles": 0.5}[kind]
        margin = 1.6 if kind == "acircles" else 0.9

        def paint(x, y):
            grey = np.where(_discs(x, y, radius, lines, rows, parity) < 0, 18.0, 215.0)
            inside = (x > -margin) & (x < lines - 1 + margin) & (y > -margin)
            return np.where(inside & (y < rows - 1 + margin), grey, np.nan)
        i, j = np.meshgrid(np.arange(lines), np.arange(rows))
        index = np.stack([i.ravel(), j.ravel()], axis=1)
        return paint, index[index.sum(axis=1) % 2 == 0] if parity == 0 else index, (lines, rows)
    if kind == "charuco":
        columns, rows = columns - 1, rows - 1
        board = cv2.aruco.CharucoBoard((columns + 1, rows + 1), 1.0, 0.7,
                                       cv2.aruco.getPredefinedDictionary(_FAMILY))
        texture = board.generateImage(((columns + 1) * _SQUARE, (rows + 1) * _SQUARE))
        texture = np.pad(texture, _SQUARE // 2, constant_values=255).astype(np.float32)

        def paint(x, y):
            at = [((value + 1.5) * _SQUARE - 0.5).astype(np.float32) for value in (x, y)]
            grey = cv2.remap(texture, *at, cv2.INTER_LINEAR, borderValue=np.nan)
            return 18 + 197 / 255 * grey
    else:
        def paint(x, y):
            black = (np.floor(x) + np.floor(y)) % 2 == 0
            on = (x > -1) & (x < columns) & (y > -1) & (y < rows)
            inside = (x > -1.7) & (x < columns + 0.7) & (y > -1.7) & (y < rows + 0.7)
            return np.where(inside, np.where(on & black, 18.0, 215.0), np.nan)
    i, j = np.meshgrid(np.arange(columns), np.arange(rows))
    return paint, np.stack([i.ravel(), j.ravel()], axis=1), (columns, rows)


class Bank:
    """Clean photos by name, each made once.

    Parameters
    ----------
    data : path
        Folder of the real photos and of ``truth.npz``, their points.
    scale : float
        Scale of rendered pictures, 1 for 1280x960.
    """

    def __init__(self, data, scale=1.0):
        self.data, self.scale, self._cached, self._truth = Path(data), scale, {}, None

    def real(self, name):
        """The real photo ``name`` with its known points."""
        file, kind = _REAL[name]
        if name not in self._cached:
            if self._truth is None:
                path = self.data / "truth.npz"
                if not path.is_file():
                    raise InputError(f"{path} is missing: --data needs the folder tests/data of "
                                     f"the repository")
                self._truth = np.load(path)
            index, xy = self._truth[f"{file}:index"], self._truth[f"{file}:xy"].astype(np.float64)
            image = read_image(self.data / file)
            self._cached[name] = Photo(image, (Truth(kind, index, xy, np.ones(len(xy), bool)),))
        return self._cached[name]

    def street(self, size):
        """RGB picture of a street, without a target, in ``size``."""
        image = read_image(self.data / "scenes/figueroa.jpg")
        image = np.dstack([image] * 3) if image.ndim == 2 else image
        return cv2.resize(image, size, interpolation=cv2.INTER_CUBIC)

    def example(self):
        """The built-in example's page of dots, a raw frame of 640x480."""
        if "example" not in self._cached:
            camera = example_camera()
            dots = page_to_distorted(camera, page_dots())
            j, i = np.indices(dots.shape[:2])
            truth = Truth("dots", np.stack([i.ravel(), j.ravel()], axis=1), dots.reshape(-1, 2),
                          np.ones(i.size, bool))
            photo = Photo(target_photo(camera), (truth,))
            self._cached["example"] = replace(photo, truths=(truth.moved(None, photo.size),))
        return self._cached["example"]

    def render(self, *targets, size=(1280, 960), view=0.42, clutter=False, seed=1, shutter=None):
        """Photo by a wide :class:`Lens` of ``targets``, each (kind, columns, rows, :class:`Pose`).

        Its focal length is ``view`` widths. The background is a street, or grey. ``shutter``: a
        function of the part 0..1 of the height, a rolling shutter's shift of that row to the
        right, in pixels of a picture 1280 wide.
        """
        width, height = (int(value * self.scale) for value in size)
        lens = Lens(view * width, ((width - 1) / 2 + 6, (height - 1) / 2 - 4))
        offset = (np.arange(_SUBSAMPLES) + 0.5) / _SUBSAMPLES - 0.5
        x, y = np.meshgrid(*(((np.arange(n)[:, None] + offset).ravel()).astype(np.float32)
                             for n in (width, height)))

        def late(y):
            return 0 if shutter is None else shutter(y / height) * width / 1280
        rays = lens.plane(x - late(y), y)
        picture = self.street((width, height)).astype(np.float32) if clutter else np.full(
            (height, width, 3), 120, np.float32)
        truths = []
        for kind, columns, rows, pose in targets:
            paint, index, extent = _pattern(kind, columns, rows)
            plane = Plane(pose, extent)
            grey = paint(*plane.cells(*rays))
            blocks = grey.reshape(height, _SUBSAMPLES, width, _SUBSAMPLES)
            share = np.isfinite(blocks).mean(axis=(1, 3))[:, :, None]
            light = np.nan_to_num(blocks).sum(axis=(1, 3))[:, :, None] / _SUBSAMPLES**2
            picture = picture * (1 - share) + light * np.array([1.0, 0.97, 0.9])
            xy = lens.pixels(plane.rays(index))
            xy[:, 0] += late(xy[:, 1])
            truths.append(Truth(kind, index, xy, plane.whole(index), lens))
        lamp = 1 - 0.25 * (np.hypot(*np.meshgrid(np.linspace(-1, 1, width),
                                                 np.linspace(-1, 1, height))))[:, :, None]**2
        noise = np.random.default_rng(seed).normal(0, 1.5, picture.shape)
        image = np.clip(np.rint(picture * lamp + noise), 0, 255).astype(np.uint8)
        return Photo(image, tuple(truth.moved(None, (width, height)) for truth in truths))


def side_by_side(left, right):
    """One photo of both pictures, of the same height."""
    images = [photo.image if photo.image.ndim == 3 else np.dstack([photo.image] * 3)
              for photo in (left, right)]
    moved = tuple(replace(truth, xy=truth.xy + (left.size[0], 0)) for truth in right.truths)
    return Photo(np.hstack(images), left.truths + moved)

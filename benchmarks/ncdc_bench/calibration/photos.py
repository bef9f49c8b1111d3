"""Large photos of targets through a known lens, rendered once."""

from pathlib import Path

import cv2
import numpy as np

from ncdc_bench.photos.targets import Bank, Pose

__all__ = ["SETS", "PhotoSet", "rendered"]

_BOARDS = 13


class PhotoSet:
    """Photos of one calibration.

    Parameters
    ----------
    target : str
        As of ``ncdc calibrate --target``.
    size : (int, int)
        Width and height of each photo.
    poses : sequence of Pose
        One for each photo.
    """

    def __init__(self, target, size, poses):
        self.target, self.size, self.poses = target, size, tuple(poses)
        self.kind, _, lattice = target.partition(":")
        self.lattice = tuple(map(int, lattice.split("x"))) if lattice else (44, 33)


def _board_poses():
    random = np.random.default_rng(3)
    yield Pose(step=.22, tilts=(0, 0), turn=0)
    for _ in range(_BOARDS - 1):
        yield Pose(middle=tuple(random.uniform(-.5, .5, 2)), step=float(random.uniform(.13, .2)),
                   turn=float(random.uniform(-25, 25)), tilts=tuple(random.uniform(-28, 28, 2)))


_SIZES = {"8 Mpx": (3264, 2448), "12 Mpx": (4000, 3000)}
SETS = {
    **{f"dots, {name}": PhotoSet("dots", size, [Pose(step=.07, tilts=(4, -3), turn=2)])
       for name, size in _SIZES.items()},
    **{f"ChArUco, {name}": PhotoSet("charuco:14x10", size, [Pose(step=.2)])
       for name, size in _SIZES.items()},
    "13 chessboards, 8 Mpx": PhotoSet("chessboard:9x6", _SIZES["8 Mpx"], _board_poses()),
}


def rendered(name, folder):
    """Paths of the photos of the set ``name`` in ``folder``, where they stay, and of their truths.

    A truth (.npz) has ``index`` (n, 2), ``xy`` (n, 2) in pixels, ``focal`` and ``middle`` of the
    :class:`ncdc_bench.photos.lens.Lens`.
    """
    chosen, bank, paths = SETS[name], Bank("."), []
    for number, pose in enumerate(chosen.poses):
        path = Path(folder) / f"{name.replace(', ', '-').replace(' ', '-')}-{number:02}.png"
        if not path.is_file():
            photo = bank.render((chosen.kind, *chosen.lattice, pose), size=chosen.size,
                                seed=number + 1)
            truth, = photo.truths
            np.savez(path.with_suffix(".npz"), index=truth.index, xy=truth.xy,
                     focal=truth.lens.focal, middle=truth.lens.middle)
            cv2.imwrite(str(path), photo.image[:, :, ::-1])
        paths.append(path)
    return paths

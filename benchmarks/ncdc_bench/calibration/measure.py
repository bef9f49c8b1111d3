"""Processor time and errors of ``ncdc calibrate`` and ``ncdc train`` on large photos."""

import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np

from ncdc_bench.calibration.photos import SETS, rendered
from ncdc_bench.photos.lens import Lens
from ncdc_bench.truth.measure import true_errors
from ncdc_spec.descriptor import Descriptor
from ncdc_spec.errors import InputError

__all__ = ["ROOT", "rows"]

ROOT = Path(__file__).resolve().parents[3]
_NEURONS = 8
_STEP = 24              # pixels between those on which map and truth are compared
_FOLDERS = ".", "benchmarks", "model", "host", "sim", "soc", "boards"       # of packages
_RUN = "import sys; from ncdc.cli import main; sys.exit(main())"


def rows(folder, names=tuple(SETS), reference=None, progress=lambda name: None):
    """A row for each command on each set of photos.

    Parameters
    ----------
    folder : Path
        Of the rendered photos and of the commands' files.
    names : sequence of str
        Of :data:`ncdc_bench.calibration.photos.SETS`.
    reference : Path, optional
        Checkout of another version, which is run on the same photos.

    Yields
    ------
    dict
        ``photos``, ``command`` (calibrate, train), ``seconds`` of processor time. Of calibrate
        ``points`` and ``points_rms_px`` from their true positions; of train ``true_rms_px`` and
        ``true_max_px`` of the map from the lens. With a reference all but the first two also as
        ``reference_...``, and ``ratio`` of the seconds.

    Raises
    ------
    InputError
        If a command fails.
    """
    for name in names:
        progress(f"{name}: photos")
        photos = rendered(name, folder)
        found = {}
        for label, root in (("reference_", reference), ("", ROOT)):
            if root is None:
                continue
            progress(f"{name}: {root.name}")
            for command in ("calibrate", "train"):      # compiles what an installed package has
                _seconds(root, command, "--help")
            points, net = (folder / f"{label}{file}" for file in ("points.json", "net.toml"))
            calibrate = {"seconds": _seconds(root, "calibrate", *photos, "--target",
                                             SETS[name].target, "-o", points)}
            train = {"seconds": _seconds(root, "train", points, "--neurons", _NEURONS, "-o", net)}
            found[label] = [calibrate | _of_points(points, photos), train | _of_map(net, photos)]
        for number, command in enumerate(("calibrate", "train")):
            row = {"photos": name, "command": command}
            for label, values in found.items():
                row |= {label + key: value for key, value in values[number].items()}
            if reference:
                row["ratio"] = row["seconds"] / row["reference_seconds"]
            yield row


def _seconds(root, *command):
    """Processor time of a command of the checkout ``root``, on one thread."""
    environment = os.environ | {
        "OPENBLAS_NUM_THREADS": "1", "PYTHONDONTWRITEBYTECODE": "",
        "PYTHONPATH": os.pathsep.join(str(root / part) for part in _FOLDERS)}
    process = subprocess.Popen([sys.executable, "-c", _RUN, *map(str, command)], cwd=root,
                               env=environment, stdout=subprocess.DEVNULL,
                               stderr=subprocess.PIPE)
    said = process.stderr.read().decode()
    _, status, usage = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    process.stderr.close()
    if process.returncode:
        raise InputError(f"ncdc {command[0]} of {root} failed: {said.strip().splitlines()[-1]}")
    return usage.ru_utime + usage.ru_stime


def _of_points(path, photos):
    """Number of whole points, and how far they are from the truth."""
    count, square = 0, 0.0
    for photo, table in zip(photos, json.loads(path.read_text())["photos"]):
        truth = np.load(photo.with_suffix(".npz"))["xy"]
        points = np.array(table["points"], np.float64)
        points = points[points[:, -1] == 0, 2:4] if points.shape[1] > 5 else points[:, 2:4]
        nearest = np.linalg.norm(points[:, None] - truth[None], axis=2).min(axis=1)
        count, square = count + len(points), square + float((nearest**2).sum())
    return {"points": count, "points_rms_px": (square / count)**.5}


def _of_map(path, photos):
    """Errors of a descriptor's map from the true lens."""
    truth = np.load(photos[0].with_suffix(".npz"))
    lens = _TrueLens(float(truth["focal"]), tuple(truth["middle"]))
    rms, worst = true_errors(lens, Descriptor.load(path), _STEP)
    return {"true_rms_px": rms, "true_max_px": worst}


class _TrueLens(Lens):
    """The rendered photos' lens with what :func:`true_errors` asks of one."""

    @property
    def centre(self):
        """Pixel of the axis."""
        return np.array(self.middle)

    def project(self, rays):
        """Pixels (n, 2) of directions (n, 3)."""
        return self.pixels(rays)

    def angles_at(self, xy):
        """Angles (n, 2) from the axis, along x and y, in radians, of pixels (n, 2)."""
        off = (xy - self.centre) / self.focal
        radius = np.maximum(np.linalg.norm(off, axis=1, keepdims=True), 1e-12)
        return 2 * np.arcsin(radius / 2) * off / radius

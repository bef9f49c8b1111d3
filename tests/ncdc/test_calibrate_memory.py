"""Peak memory of ``ncdc calibrate``, of the command as its own process."""

import subprocess
import sys
from pathlib import Path

import cv2
import numpy as np
import pytest

DATA = Path(__file__).resolve().parents[1] / "data"
LIMIT = 600             # MB
COMMAND = "import sys; from ncdc.cli import main; sys.exit(main(['calibrate', *sys.argv[1:]]))"
# A child starts as a copy of its parent and counts its memory: so the parent is a small process.
MEASURE = f"""import resource, subprocess, sys
done = subprocess.run([sys.executable, "-c", {COMMAND!r}, *sys.argv[1:]], stdout=sys.stderr)
print(resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss / 1024)
sys.exit(done.returncode)"""


def peak(*words):
    """Peak memory in MB, and what the command wrote."""
    done = subprocess.run([sys.executable, "-c", MEASURE, *map(str, words)], capture_output=True,
                          text=True)
    assert done.returncode == 0, done.stderr
    return float(done.stdout), done.stderr


def enlarged(source, path, size, noise=8):
    """Write the photo ``source`` in colour, ``size`` large, with the noise of its new pixels."""
    photo = cv2.resize(cv2.imread(str(DATA / source)), size, interpolation=cv2.INTER_CUBIC)
    grain = cv2.randn(np.empty(photo.shape, np.float32), 0, noise)
    cv2.imwrite(str(path), np.clip(photo + grain, 0, 255).astype(np.uint8))
    return path


@pytest.mark.longer
@pytest.mark.parametrize("source, size, points", [
    ("dots/dot_pattern_06.jpg", (4000, 3000), "points (dots,"),
    ("chessboard_wide/GOPR0032.jpg", (2856, 2142), "48 points (chessboard,"),
    ("opencv/left01.jpg", (4000, 3000), "54 points (chessboard,")],
    ids=["dots", "board", "blurred"])
def test_one_large_photo(source, size, points, tmp_path):
    megabytes, text = peak(enlarged(source, tmp_path / "photo.png", size), "-o",
                           tmp_path / "points.json")
    assert points in text and megabytes < LIMIT


@pytest.mark.longer
def test_many_large_photos_take_no_more_than_one(tmp_path):
    photos = [enlarged(f"opencv/left0{k}.jpg", tmp_path / f"{k}.png", (4000, 3000), noise=0)
              for k in (1, 2, 3, 4)]
    megabytes, text = peak(*photos, "-o", tmp_path / "points.json")
    assert "in 4 of 4 photos" in text and megabytes < LIMIT

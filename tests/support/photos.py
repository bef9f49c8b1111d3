"""The real photos and camera files beside the repository, for tests that use them."""

from pathlib import Path

import pytest

__all__ = ["real_photos"]

_DATA = Path(__file__).resolve().parents[3] / "shared" / "data"


def real_photos(pattern):
    """Sorted files of ``pattern`` in the data folder; skips the test if there is none."""
    files = sorted(_DATA.glob(pattern))
    if not files:
        pytest.skip(f"the files {pattern} of the real photos are not beside the repository")
    return files

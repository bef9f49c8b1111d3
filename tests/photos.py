"""The real photos beside the repository, for tests that use them."""

from pathlib import Path

import pytest

__all__ = ["real_photos"]

_DATA = Path(__file__).resolve().parents[2] / "shared" / "data"


def real_photos(pattern):
    """Sorted files of ``pattern`` in the data folder; skips the test if there is none."""
    files = sorted(_DATA.glob(pattern))
    if not files:
        pytest.skip(f"the real photos {pattern} are not beside the repository")
    return files

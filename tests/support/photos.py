"""Real photos and camera files: small ones in tests/data, the full set next to the repository."""

from pathlib import Path

import pytest

__all__ = ["full_photos", "photos"]

_TESTS = Path(__file__).resolve().parents[1]
_FULL = _TESTS.parents[1] / "shared" / "data"


def photos(pattern):
    """Sorted files of ``pattern`` in tests/data."""
    return _sorted(_TESTS / "data", pattern)


def full_photos(pattern):
    """Sorted files of ``pattern`` in full size; skips the test if they are not there."""
    if not _FULL.is_dir():
        pytest.skip("the photos in full size are not in ../shared/data next to the repository; "
                    "tests/data/README.md says where they come from")
    return _sorted(_FULL, pattern)


def _sorted(folder, pattern):
    files = sorted(folder.glob(pattern))
    assert files, f"{folder} has no {pattern}"
    return files

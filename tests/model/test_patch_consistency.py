"""A dot must look as the dots around it do: touched and half covered ones are not believed."""

import cv2
import numpy as np
import pytest

from ncdc_model.calibration.blobs import find_blobs
from ncdc_model.calibration.patch_consistency import REASON, consistent_patches
from ncdc_model.calibration.points import PhotoPoints

STEP, RADIUS, VICTIM = 40, 11, 6 * 15 + 7      # pixels, pixels, the dot in row 6 and column 7


def page(columns=15, rows=11):
    """A grey picture of a tilted page of dots; index and true centres."""
    j, i = np.indices((rows, columns))
    index = np.stack([i.ravel(), j.ravel()], axis=1)
    image = np.full((rows * STEP * 4, columns * STEP * 4), 215, np.uint8)
    for x, y in (index + 0.5) * STEP * 4:
        cv2.circle(image, (int(x), int(y)), RADIUS * 4, 20, -1, cv2.LINE_AA)
    small = cv2.resize(image, None, fx=0.25, fy=0.25, interpolation=cv2.INTER_AREA)
    size = small.shape[1::-1]
    ends = np.float32([[0, 0], [size[0], 0], [size[0], size[1]], [0, size[1]]])
    moved = ends * 0.9 + np.float32([[20, 5], [0, 30], [0, 0], [0, -40]])
    matrix = cv2.getPerspectiveTransform(ends, moved)
    seen = cv2.warpPerspective(small, matrix, size, flags=cv2.INTER_AREA, borderValue=215)
    xy = cv2.perspectiveTransform((index + 0.5)[None] * STEP - 0.375, matrix)[0]
    return cv2.GaussianBlur(seen, (0, 0), 0.8), index, xy


def found(image, index, xy):
    """Detected blobs as PhotoPoints, each with the number of the true centre it is nearest to."""
    blobs = find_blobs(image)
    far = np.linalg.norm(blobs.xy[None] - xy[:, None], axis=2)
    near = far.argmin(axis=1)
    there = far.min(axis=1) < RADIUS
    return PhotoPoints(index=index[there], xy=blobs.xy[near[there]], area=blobs.area[near[there]])


def half_covered(image, at):
    # Skin hardly darker than the page: the rest of the dot is as dark as before.
    image[at[1] - 14:at[1] + 14, at[0] + 3:at[0] + 18] = 190


def blot_next_to(image, at):
    cv2.circle(image, (at[0] + 9, at[1] + 3), 7, 25, -1, cv2.LINE_AA)


def test_a_clean_tilted_page_keeps_all():
    image, index, xy = page()
    photo = found(image, index, xy)
    assert len(photo.index) == len(index)
    assert consistent_patches(image, photo) is photo


@pytest.mark.parametrize("degrade", [half_covered, blot_next_to])
def test_a_dot_that_is_not_seen_whole_is_dropped(degrade):
    image, index, xy = page()
    degrade(image, np.rint(xy[VICTIM]).astype(int))
    photo = found(image, index, xy)
    off = np.linalg.norm(photo.xy - xy[[(index == key).all(axis=1).argmax()
                                        for key in photo.index]], axis=1)
    assert off.max() > 1                    # else there would be nothing to find
    checked = consistent_patches(image, photo)
    away = np.linalg.norm(checked.xy - xy[[(index == key).all(axis=1).argmax()
                                           for key in checked.index]], axis=1)
    assert away.max() < 0.5
    assert 1 <= checked.rejected[REASON] == len(checked.dropped) <= 3

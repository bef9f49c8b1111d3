"""A page that is bent, and a rolling shutter, are warned of; a flat page is not."""

import numpy as np
import pytest

from ncdc_bench.photos.lens import Lens, Plane
from ncdc_bench.photos.targets import Pose
from ncdc_model.calibration.frame import ideal_frame
from ncdc_model.calibration.points import PhotoPoints, TargetPoints
from ncdc_model.calibration.quality import uneven

SIZE = 640, 480
LENS = Lens(0.42 * SIZE[0], (322.0, 237.0))


def sentences(bend=0.0, late=0.0):
    """What is said of a page bent round a cylinder, and scanned from top to bottom while it moves
    in waves of ``late`` pixels; and how far the points are off a flat page's."""
    index = np.stack(np.meshgrid(np.arange(14), np.arange(10)), axis=-1).reshape(-1, 2)
    xy = LENS.pixels(Plane(Pose((0, 0), 0.13, 4.0, (9.0, -7.0), bend), (14, 10)).rays(index))
    xy[:, 0] += late * np.sin(xy[:, 1] / SIZE[1] * 9)
    xy += np.random.default_rng(0).normal(0, 0.03, xy.shape)
    photo = PhotoPoints(index=index, xy=xy, area=np.zeros(len(xy)), name="a.png")
    points = TargetPoints(target="chessboard", size=SIZE, photos=(photo,))
    return uneven(points, ideal_frame(points)), LENS.off_flat(index, xy).max()


def test_a_flat_page_is_not_warned_of():
    found, off = sentences()
    assert found == [] and off < 0.2


@pytest.mark.longer
@pytest.mark.parametrize("what", [{"bend": 0.06}, {"bend": -0.06}, {"late": 3.0}])
def test_a_bent_page_and_a_rolling_shutter_are_warned_of(what):
    (text,), off = sentences(**what)
    assert off > 1
    assert text.startswith("a.png: the points lie ") and " px around (" in text
    assert "The page may be bent or of two sheets" in text

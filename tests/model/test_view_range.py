"""Ranges of views: the search for the worst one, and the error of nodes in it."""

from dataclasses import replace

import cv2
import numpy as np
import pytest

from ncdc_model.evaluate import float_map
from ncdc_model.golden.nodes import sums_between
from ncdc_model.golden.view import in_spans, view_coordinates
from ncdc_model.view_map import plane_points
from ncdc_model.view_nodes import NodeErrors, node_errors, worst_node_errors
from ncdc_model.view_range import ViewRange
from ncdc_spec.errors import InputError
from ncdc_spec.view import View
from ncdc_spec.view_matrix import Angles
from plane_lens import seen_lens

WIDE = {"pan": (-30.0, 30.0), "tilt": (-20.0, 20.0), "zoom": (.8, 4.0)}


def test_a_climb_finds_a_peak_inside():
    views, best = ViewRange.of(seen_lens(), WIDE), Angles(7.3, -13, 0, 1.7)

    def score(angles):
        return -sum(((getattr(angles, name) - getattr(best, name)) / (high - low))**2
                    for name, (low, high) in WIDE.items())
    found = views.climb(score, max(views.scan(), key=score))
    for name, (low, high) in WIDE.items():
        assert abs(getattr(found, name) - getattr(best, name)) < (high - low) / 100


def test_the_scan_fills_the_range():
    views = ViewRange.of(seen_lens(), WIDE, (48, 32))
    scan = views.scan()
    assert scan == views.scan() and len(set(scan)) == len(scan) == 27 + 96
    assert {(angles.pan, angles.tilt, angles.zoom) for angles in scan} >= {
        (pan, tilt, zoom) for pan in (-30, 0, 30) for tilt in (-20, 0, 20) for zoom in (.8, 4)}
    # Each quarter of the range has about as many of the views between.
    quarters = [(angles.pan > 0, angles.tilt > 0) for angles in scan[27:]]
    assert all(16 <= quarters.count(one) <= 32 for one in set(quarters))
    assert len(set(quarters)) == 4 and views.view(scan[0]).size == (48, 32)


def test_a_range_of_one_view():
    views = ViewRange.of(seen_lens(), {"pan": (5.0, 5.0), "zoom": (2.0, 2.0)})
    one = Angles(pan=5.0, zoom=2.0)
    assert views.scan() == [one] and views.climb(lambda angles: 3, one) == one
    assert list(views.random(2)) == [one] * 2


def test_random_views_are_in_the_range():
    views = list(ViewRange.of(seen_lens(), WIDE).random(300, seed=4))
    for name, (low, high) in WIDE.items():
        values = [getattr(angles, name) for angles in views]
        assert low <= min(values) < low + (high - low) / 20 and max(values) <= high
    zooms = sorted(angles.zoom for angles in views)
    assert zooms[150] == pytest.approx((.8 * 4)**.5, rel=.1)
    assert {angles.roll for angles in views} == {0.0}


@pytest.mark.parametrize("intervals,message", [
    ({"tilt": (5.0, -5.0)}, "tilt is 5 to -5, the first number must be the smaller one"),
    ({"zoom": (.1, 4.0)}, "zoom is 0.1, the limits are 0.25 and 8")])
def test_what_is_no_range(intervals, message):
    with pytest.raises(InputError, match=message):
        ViewRange.of(seen_lens(), intervals)


def test_a_range_beyond_the_registers():
    lens = seen_lens()
    lens = replace(lens, provenance={"frame": [9000.0, *lens.provenance["frame"][1:]]})
    with pytest.raises(InputError, match="pan -90, tilt 0, roll 0, zoom 1 is too far off the axis"):
        ViewRange.of(lens, {"pan": (-90.0, 0.0)})


def around(lens, view, nodes):
    """Errors of interpolation at all pixels of a view, by OpenCV's transform and the formula."""
    width, height = view.size

    def source(u, v):
        points = cv2.perspectiveTransform(np.stack([u, v], axis=-1).astype(float), view.real)
        return np.stack(float_map(lens.exact_network, lens.geometry)(*np.moveaxis(points, -1, 0)))
    v, u = np.mgrid[0:height, 0:width].astype(float)
    first = u // nodes * nodes
    four = [source(first + step * nodes, v) for step in (-1, 0, 1, 2)]
    return np.abs(sums_between(*four, u - first, nodes) / (4 * nodes**2) - source(u, v)).max(axis=0)


def test_errors_of_nodes_are_those_of_the_formula():
    lens = replace(seen_lens(), nodes=1)
    view = ViewRange.of(lens, {}).view(Angles(pan=4, tilt=-3, roll=20, zoom=2.5))
    found = NodeErrors(lens, every=1).of(view, (8, 16))
    for nodes in (8, 16):       # a magnified view shows nothing but what has a source
        assert found[nodes] == pytest.approx(around(lens, view, nodes).max(), rel=1e-6)
    assert found[16] > 4 * found[8] > 0


def test_only_pixels_that_the_integers_show_count():
    """Where a view shrinks much, nodes beyond the picture do not fit their formats."""
    lens = replace(seen_lens(), nodes=16)
    view = ViewRange.of(lens, {}).view(Angles(pan=20, zoom=.3))
    v, u = np.mgrid[0:64, 0:96]
    *_, shown = view_coordinates(lens, view, u, v)
    error = around(lens, view, 16)
    found = NodeErrors(lens, every=1).of(view, [16])[16]
    assert found == pytest.approx(error[shown].max(), rel=1e-6)
    column, row = plane_points(view.real, u, v)
    inside = in_spans(lens.valid, np.rint(column).astype(int), np.rint(row).astype(int))
    assert error[inside].max() > 1.5 * found > 0


def test_pixels_without_a_source_have_no_error():
    far_right = View.of([[1, 0, 500], [0, 1, 0], [0, 0, 1]], (96, 64))
    behind = View.of([[1, 0, 0], [0, 1, 0], [0, 0, -1]], (96, 64))
    for view in (far_right, behind):
        assert node_errors(seen_lens(), view, (8, 16)) == {8: 0, 16: 0}


def test_the_worst_errors_of_a_range_hold_for_other_views():
    lens = seen_lens()
    views = ViewRange.of(lens, WIDE)
    found = worst_node_errors(lens, views)
    assert list(found) == [8, 16]       # nodes 32 apart do not fit 96 columns
    for nodes, (error, at) in found.items():
        assert NodeErrors(lens).of(views.view(at), [nodes])[nodes] == error
    for angles in views.random(40):
        for nodes, error in node_errors(lens, views.view(angles), list(found)).items():
            assert error <= 1.05 * found[nodes][0]

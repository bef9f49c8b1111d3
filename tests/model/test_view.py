"""Views: golden model compared with exact arithmetic, float maps, OpenCV and SciPy."""

from dataclasses import replace
from fractions import Fraction

import cv2
import numpy as np
import pytest

from cameras import barrel_descriptor
from ncdc_bench.nodes.measure import descriptor_of
from ncdc_bench.reference_lenses import ReferenceLens
from ncdc_model.correction import correct, correction_of
from ncdc_model.evaluate import float_map
from ncdc_model.golden.corrector import valid_coordinates
from ncdc_model.golden.view import homogeneous, node_positions, reciprocal
from ncdc_spec.errors import InputError
from ncdc_spec.fixed import Q
from ncdc_spec.geometry import ValidRows
from ncdc_spec.hardware import Hardware
from ncdc_spec.reciprocal import RECIPROCAL_BITS
from ncdc_spec.registers.host_values import host_values
from ncdc_spec.view import FORMATS, PLANE, View
from views import nonsense_view, pinhole_matrix, random_view

FOCAL = 300     # pixels of the trained picture, 640 pixels wide
EDGE = .02      # pixels; a position between nodes is this precise where it selects a valid span


def lens(nodes=8, size=(640, 480)):
    return replace(barrel_descriptor(size, size, hidden_neurons=6), nodes=nodes)


def noise(d):
    return np.random.default_rng(1).integers(0, 256, d.geometry.distorted[::-1], np.uint8)


@pytest.mark.parametrize("nodes,size", [(8, (72, 40)), (16, (145, 67)), (32, (640, 35))])
def test_the_identity_is_the_trained_picture_bit_for_bit(nodes, size):
    d = lens(nodes, size)
    v, u = np.indices(size[::-1])
    trained = valid_coordinates(d, u, v)
    assert trained[2].any() and not trained[2].all()
    for own, viewed in zip(trained, valid_coordinates(d, u, v, View.identity(size))):
        np.testing.assert_array_equal(viewed, own)


def test_reciprocals_are_within_their_bound_and_exact_of_powers_of_two():
    top, worst = FORMATS[2][0].f_bits, 0
    rng = np.random.default_rng(1)
    steps = np.arange(128) << top - 7
    z = np.concatenate([(1 << top) + steps, (2 << top) - 1 - steps, (1 << top) + steps + 1,
                        rng.integers(1 << top, 2 << top, 20000)])
    for shift in (0, 3, 7):
        found, n, inside = reciprocal(z >> shift)
        assert inside.all() and (n == shift).all()
        for one, depth in zip(found[::7].tolist(), (z >> shift << shift)[::7].tolist()):
            worst = max(worst, abs(Fraction(one, 1 << RECIPROCAL_BITS)
                                   - Fraction(1 << top, depth)))
        assert reciprocal(np.array([1 << top - shift]))[0] == 1 << RECIPROCAL_BITS
    assert worst <= 2**-23.5
    outside = np.array([-1, 0, (1 << top - 7) - 1, 2 << top, -1 << 45])
    assert not reciprocal(outside)[2].any()
    assert reciprocal(np.array([1 << top - 7, (2 << top) - 1]))[2].all()


def test_positions_of_nodes_are_within_the_derived_bound():
    """That of docs/explanation/view.md, in exact fractions, for the rounded matrix."""
    d, rng = lens(), np.random.default_rng(2)
    u, v = rng.integers(-8, 660, 40), rng.integers(0, 480, 40)
    for _ in range(25):
        view = random_view(rng, d.geometry, FOCAL, pan=60, tilt=40, roll=180, zoom=(.25, 8))
        *numerators, depth = homogeneous(view, u, v)
        positions, _, fits = node_positions(d, view, u, v)
        for numerator, position in zip(numerators, positions):
            for k in np.flatnonzero(fits):
                exact = Fraction(int(numerator[k]) << 8, int(depth[k]))
                error = abs(Fraction(int(position[k]), 1 << PLANE.f_bits) - exact)
                assert error <= 2**-12 + abs(exact) * 2**-22.5 + 2**-14


def test_the_rounded_matrix_is_within_its_bound():
    rng, (width, height) = np.random.default_rng(3), (1920, 1080)
    corners = np.array([(u, v, 1) for u in (0, width - 1) for v in (0, height - 1)]).T
    for _ in range(50):
        exact = pinhole_matrix(900, (width, height), (width, height), *rng.uniform(-60, 60, 3),
                               2**rng.uniform(-2, 3))
        view = View.of(exact, (width, height))
        scale = 2**np.rint(np.log2(np.linalg.norm(view.real[2]) / np.linalg.norm(exact[2])))
        missed = np.abs(view.real / scale - exact) @ corners
        far = (width + height) / 2 + 2
        assert (np.abs((view.real / scale - exact) @ corners) * scale <= np.array(
            [[far * 2**-28 + 2**-18]] * 2 + [[far * 2**-36 + 2**-31]])).all(), missed


def true_positions(matrix, u, v):
    """(x, y, depth) of view pixels in the trained picture, by OpenCV, and the depth's sign."""
    points = np.stack([u, v], axis=-1).reshape(-1, 1, 2).astype(np.float64)
    with np.errstate(all="ignore"):
        x, y = cv2.perspectiveTransform(points, matrix).reshape(*u.shape, 2).transpose(2, 0, 1)
    return x, y, matrix[2, 0] * u + matrix[2, 1] * v + matrix[2, 2]


def near_an_edge(mask, x, y, reach):
    """Whether some position within ``reach`` of (x, y) has the other answer, bool."""
    height, width = mask.shape
    answers = []
    for right, down in ((0, 0), (-1, -1), (-1, 1), (1, -1), (1, 1)):
        column = np.floor(x + right * reach + .5).astype(np.int64)
        row = np.floor(y + down * reach + .5).astype(np.int64)
        inside = (column >= 0) & (column < width) & (row >= 0) & (row < height)
        answers.append(inside & mask[np.where(inside, row, 0), np.where(inside, column, 0)])
    return answers[0], np.logical_or.reduce(answers) & ~np.logical_and.reduce(answers)


def compare(d, focal, views, rng, every=7, **limits):
    """(Largest error in px, pixels wrongly filled, wrongly blank, valid ones) of random views.

    Compared with the float network at positions by OpenCV. Wrongly filled or blank are pixels
    beyond ``EDGE`` of a pixel whose nearest trained one has the other answer.
    """
    true_map = float_map(d.exact_network, d.geometry)
    size = d.geometry.corrected
    v, u = np.indices(size[::-1])
    v, u = v[::every], u[::every]
    mask, scale = d.valid.mask(size[0]), 2.0**-d.formats.coordinate.f_bits
    worst, filled, blank, valid = 0, 0, 0, 0
    for _ in range(views):
        view = random_view(rng, d.geometry, focal, **limits)
        x, y, has_source = valid_coordinates(d, u, v, view)
        true_x, true_y, depth = true_positions(view.real, u, v)
        seen = depth > 0
        near = np.where(seen, true_x, -1e6), np.where(seen, true_y, -1e6)
        truth, edge = near_an_edge(mask, *near, EDGE)
        filled += int((has_source & ~truth & ~edge).sum())
        blank += int((truth & ~has_source & ~edge).sum())
        valid += int(has_source.sum())
        if has_source.any():
            real = true_map(true_x[has_source], true_y[has_source])
            worst = max(worst, *(np.abs(raw[has_source] * scale - one).max()
                                 for raw, one in zip((x, y), real)))
    return worst, filled, blank, valid


def own_error(d):
    """Largest difference of the trained picture's coordinates from the float network's."""
    width, height = d.geometry.corrected
    v, u = np.nonzero(d.valid.mask(width))
    x, y, _ = valid_coordinates(d, u, v)
    scale = 2.0**-d.formats.coordinate.f_bits
    return max(np.abs(raw * scale - real).max() for raw, real in zip(
        (x, y), float_map(d.exact_network, d.geometry)(u, v)))


def test_random_views_equal_the_float_map_and_blank_what_has_no_source():
    d = lens()
    worst, filled, blank, valid = compare(d, FOCAL, 12, np.random.default_rng(4), every=23,
                                          pan=50, tilt=30, roll=180, zoom=(.5, 8))
    assert valid > 12 * 2000
    assert worst <= own_error(d) + .01
    assert (filled, blank) == (0, 0)


@pytest.mark.regress
@pytest.mark.parametrize("name", ["PC105", "105br", "120kb", "120dbr"])
def test_200_views_of_reference_lenses(name):
    d = replace(descriptor_of(name, 12), nodes=16)
    focal = ReferenceLens(name).camera.frame.focal
    worst, filled, blank, valid = compare(d, focal, 200, np.random.default_rng(5), every=7)
    assert valid > 200 * 10000
    assert worst <= own_error(d) + .01
    assert (filled, blank) == (0, 0)


def test_opencv_warps_the_lens_map_to_that_of_the_view():
    """By its linear interpolation at 32nds of a pixel, of the float map at the trained pixels."""
    d, rng = lens(), np.random.default_rng(6)
    size = d.geometry.corrected
    v, u = np.indices(size[::-1])
    maps = [one.astype(np.float32) for one in float_map(d.exact_network, d.geometry)(u, v)]
    view = random_view(rng, d.geometry, FOCAL, pan=20, tilt=10, roll=30, zoom=(1, 2))
    warped = [cv2.warpPerspective(one, view.real, size, flags=cv2.INTER_LINEAR
                                  | cv2.WARP_INVERSE_MAP, borderValue=np.nan) for one in maps]
    x, y, valid = valid_coordinates(d, u, v, view)
    valid &= np.isfinite(warped[0])
    assert valid.mean() > .5
    for raw, one in zip((x, y), warped):
        assert np.abs(d.formats.coordinate.real(raw) - one)[valid].max() < 1 / 32


def test_both_models_correct_views_of_another_size():
    d, rng = lens(8, (144, 100)), np.random.default_rng(7)
    for size in ((60, 40), (200, 131)):
        view = random_view(rng, d.geometry, 80, size)
        one, other = (correct(d, noise(d), model=model, view=view)
                      for model in ("reference", "compiled"))
        assert one.picture.shape == (*size[::-1], 3) and not one.blank.all()
        np.testing.assert_array_equal(one.picture, other.picture)
        np.testing.assert_array_equal(one.blank, other.blank)
        assert one.fetches == other.fetches


def test_no_window_leaves_the_frame_whatever_the_registers_hold():
    d, rng, used = lens(8, (72, 40)), np.random.default_rng(8), 0
    width, height = d.geometry.distorted
    core = d.geometry.interpolation.core
    for _ in range(100):
        x0, y0, used_ones = correction_of(d, "reference", nonsense_view(rng, (72, 40))).corners()
        used += used_ones.sum()
        assert ((x0 >= 0) & (x0 <= width - core) & (y0 >= 0) & (y0 <= height - core)).all()
    assert used > 10000


@pytest.mark.parametrize("matrix", [
    np.diag([1, 1, -1.]), [[1, 0, 0], [0, 1, 0], [0, 0, 0.001]],            # behind, too shallow
    [[0, 0, 0], [0, 0, 0], [0, 0, 1]]])                                     # one point
def test_singular_matrices_and_those_behind_the_camera(matrix):
    """The first two show nothing, the third the trained picture's corner everywhere."""
    d = lens(8, (72, 40))
    v, u = np.indices((40, 72))
    raw = View(tuple(int(q.quantise(value)) for value, q in zip(
        np.ravel(matrix), [q for row in FORMATS for q in row])), (72, 40))
    valid = valid_coordinates(replace(d, valid=ValidRows.everything(72, 40)), u, v, raw)[2]
    assert valid.all() if np.ravel(matrix)[0] == 0 else not valid.any()


@pytest.mark.parametrize("matrix,size,sentence", [
    (np.diag([1, 1, 0.]), (64, 48), "largest depth of the view's matrix is 0, the limits are"),
    (np.full((3, 3), 1e308), (64, 48), "largest depth of the view's matrix is inf, the limits"),
    (np.diag([300, 1, 1.]), (64, 48), "has 300 in row 0, column 0, the limit is 128 times"),
    (np.full((3, 3), np.nan), (64, 48), "3x3 finite numbers are needed"),
    (np.eye(2), (64, 48), "3x3 finite numbers are needed"),
    (np.eye(3), (64, 5000), "the view's height is 5000, the limits are 8 and 4096")])
def test_matrices_that_cannot_be_views_are_named(matrix, size, sentence):
    with pytest.raises(InputError, match=sentence):
        View.of(matrix, size)


def test_raw_elements_are_checked():
    with pytest.raises(InputError, match=r"VIEW_Z_U is 2147483648, the limits of Q-3.35"):
        View((0,) * 6 + (1 << 31, 0, 0), (64, 48))
    with pytest.raises(InputError, match="has 8 elements, 9 are needed"):
        View((0,) * 8, (64, 48))
    assert View((Q(5, 27).lo,) * 2 + (0,) * 7, (64, 48)).real[0, 0] == -16


def test_a_view_needs_nodes_and_its_registers_hold_it():
    d = lens(1, (72, 40))
    with pytest.raises(InputError, match="evaluated at every pixel, a view needs nodes"):
        correct(d, noise(d), view=View.identity((72, 40)))
    with pytest.raises(InputError, match="evaluated at every pixel, a view needs nodes"):
        Hardware(view=True).made_for(d)
    view = View.of(np.diag([2, 2, 1.]), (32, 16))
    values = host_values(lens(8, (72, 40)), Hardware(view=True), view=view)
    assert [values[name] for name in ("VIEW_X_U", "VIEW_Y_V", "VIEW_Z_0", "PLANE_HEIGHT",
                                      "CORRECTED_WIDTH", "CORRECTED_HEIGHT")] == [
        2 << 27, 2 << 27, 1 << 30, 40, 32, 16]
    assert values["TARGET_LIMIT"] - values["TARGET_BASE"] == 4 * 32 * 16
    assert "VIEW_X_U" not in host_values(lens(8, (72, 40)))

"""Tables of matrices down the raw frame: the golden model, and how near it is to exact rows."""

from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

from ncdc_model.compiled.view import view_sources
from ncdc_model.correction import correction_of
from ncdc_model.golden.corrector import valid_coordinates
from ncdc_model.golden.view_rows import added, next_rows
from ncdc_model.stabilise.orientation import Gyroscope
from ncdc_model.stabilise.stabiliser import Stabiliser
from ncdc_model.view_map import view_map
from ncdc_spec.errors import InputError
from ncdc_spec.fixed import Q
from ncdc_spec.hardware import Hardware
from ncdc_spec.registers.host_values import host_values
from ncdc_spec.view import View
from ncdc_spec.view_matrix import Angles, PlaneCamera
from ncdc_spec.view_rows import (
    ROW_FORMATS,
    ROWS_TABLE,
    STEPS,
    RowTable,
    row_view,
    rows_values,
    rows_words,
)
from plane_lens import SIZE, seen_lens, shaking
from views import nonsense_table, nonsense_view, turning_view

READOUT = .016


def stabiliser(d, degrees=4, angles=Angles(), **options):
    """Of a camera that shakes, one of `plane_lens`."""
    times = np.arange(0, 1, .001)
    _, rotations = shaking(times, degrees)
    rates = (rotations[:-1].inv() * rotations[1:]).as_rotvec() / .001
    trained = PlaneCamera.of(d)
    return Stabiliser(Gyroscope(times[:-1] + .0005, rates), trained,
                      trained.view(SIZE, angles.zoom), angles.rotation, SIZE[1], READOUT,
                      **options)


def all_coordinates(d, view):
    v, u = np.indices(view.size[::-1])
    return valid_coordinates(d, u, v, view)


@pytest.mark.parametrize("angles", [Angles(), Angles(pan=8, roll=20, zoom=1.4)])
def test_a_view_is_near_that_of_exact_rows(angles):
    """Within the movement of two raw rows; one matrix for all rows is ten times as far off."""
    d = seen_lens()
    held, scale = stabiliser(d, angles=angles), 2.0**-d.formats.coordinate.f_bits
    for begin in (.1, .6):
        matrices = held.matrices(begin)
        maps = view_map(d, SIZE, matrices)
        view, seen = held.row_view(begin), ~maps[2]
        errors = []
        for one in (view, View.of(matrices[SIZE[1] // 2], SIZE)):
            x, y, valid = all_coordinates(d, one)
            seen &= valid
            errors.append([scale * raw - real for raw, real in zip((x, y), maps)])
        assert seen.mean() > .4
        near, frame = (np.hypot(*error)[seen] for error in errors)
        assert near.max() < .2 and np.sqrt((near**2).mean()) < .1 * np.sqrt((frame**2).mean())


def test_a_table_of_zeros_is_none_bit_for_bit():
    d = seen_lens()
    view = PlaneCamera.of(d).looking(Angles(pan=10, roll=4))
    still = replace(view, rows=RowTable(8, ((0,) * 9,) * 3))
    for own, other in zip(all_coordinates(d, view), all_coordinates(d, still)):
        np.testing.assert_array_equal(own, other)


def test_the_compiled_model_and_parts_of_a_picture():
    d, rng = seen_lens(), np.random.default_rng(1)
    for view in (turning_view(rng, d.geometry, 60, roll=180),
                 replace(nonsense_view(rng, (50, 30)), rows=nonsense_table(rng))):
        whole = all_coordinates(d, view)
        for own, other in zip(whole, view_sources(d, view)):
            np.testing.assert_array_equal(own * whole[2], other * whole[2])
        u, v = rng.integers(0, view.size, (20, 2)).T
        for own, other in zip(whole, valid_coordinates(d, u, v, view)):
            np.testing.assert_array_equal(own[v, u] * whole[2][v, u], other * whole[2][v, u])


def test_what_is_added_is_within_its_bound():
    """That of docs/explanation/view.md, in exact fractions of the table's own numbers."""
    rng = np.random.default_rng(2)
    table = RowTable(16, tuple(tuple(int(number) for number in rng.integers(-1 << 17, 1 << 17, 9))
                               for _ in range(5)))
    u, v, row = rng.integers(-8, 2000, 50), rng.integers(0, 1000, 50), rng.integers(0, 90, 50)
    found = added(table, u, v, row)
    for k in range(50):
        at = min(Fraction(int(row[k]), 16), Fraction(4))
        first = min(int(at), 3)
        for axis, formats in enumerate(ROW_FORMATS):
            sums = [sum(Fraction(number * int(factor), 1 << q.f_bits) for number, factor, q in zip(
                table.matrices[m][3 * axis:3 * axis + 3], (u[k], v[k], 1), formats))
                for m in (first, first + 1)]
            exact = sums[0] + (at - first) * (sums[1] - sums[0])
            last_bit = Fraction(1, 1 << formats[2].f_bits)
            value = Fraction(int(found[axis][k]), 1 << formats[2].f_bits + 12)
            assert -2 * last_bit < value - exact < last_bit


def test_raw_rows_round_and_have_limits():
    q = Q(13, 4)
    y = np.array([-100, -8, 0, 7, 8, 4093 << 4, q.hi])
    np.testing.assert_array_equal(next_rows(y, y != 0, q), [0, 1, 0, 1, 2, 4094, 4095])


def test_the_real_matrices_of_a_table():
    """Base and table together, at each of their rows, are the matrices but for a factor."""
    matrices = stabiliser(seen_lens()).matrices(.2)
    view = row_view(matrices, SIZE, 5)
    assert (view.rows.step, len(view.rows.matrices)) == (16, 5)
    beyond = matrices[63] + matrices[63] - matrices[62]     # of row 64, which the frame lacks
    corners = np.array([(u, v, 1) for u in (0, 95) for v in (0, 63)]).T
    for k, numbers in enumerate(view.rows.matrices):
        real = view.real + np.reshape([q.real(raw) for raw, q in zip(
            numbers, [q for row in ROW_FORMATS for q in row])], (3, 3))
        found, wanted = real @ corners, (matrices[16 * k] if k < 4 else beyond) @ corners
        np.testing.assert_allclose(found[:2] / found[2], wanted[:2] / wanted[2], atol=1e-3)


def test_no_window_leaves_the_frame_whatever_the_table_holds():
    d, rng, used = seen_lens(), np.random.default_rng(8), 0
    width, height = d.geometry.distorted
    core = d.geometry.interpolation.core
    for k in range(6):
        view = turning_view(rng, d.geometry, 60) if k % 2 else nonsense_view(rng, (72, 40))
        view = replace(view, rows=nonsense_table(rng))
        x0, y0, used_ones = correction_of(d, "reference", view).corners()
        used += used_ones.sum()
        assert ((x0 >= 0) & (x0 <= width - core) & (y0 >= 0) & (y0 <= height - core)).all()
    assert used > 200


def test_a_global_shutter_needs_no_table():
    d = seen_lens()
    held = replace(stabiliser(d), readout=0.0)
    assert held.row_view(.2) == View.of(held.matrices(.2)[0], SIZE)


def test_values_and_words_of_a_host():
    d = seen_lens()
    table = RowTable(32, (tuple(range(1, 10)), (-5,) * 9))
    view = replace(View.identity(SIZE), rows=table)
    names = "VIEW_ROWS", "VIEW_ROWS_STEP", "VIEW_ROWS_BANK"
    values = host_values(d, Hardware(view=True, view_rows=4), view=view)
    assert [values[name] for name in names] == [2, STEPS.index(32), 0]
    assert list(rows_values(None, 1).values()) == [0, 0, 1]
    assert names[0] not in host_values(d, Hardware(view=True))
    words = dict(rows_words(table, 1))
    assert len(words) == 18
    assert words[ROWS_TABLE + 1024 + 8] == 7 and words[ROWS_TABLE + 1024 + 16] == -5


@pytest.mark.parametrize("make,sentence", [
    (lambda: RowTable(9, ((0,) * 9,)), "the step of the table of matrices is 9 rows, one of 8, 16"),
    (lambda: RowTable(8, ()), "the table has 0 matrices, the limits are 1 and 64"),
    (lambda: RowTable(8, ((0,) * 8,)), "matrix 0 of the table has 8 elements, 9 are needed"),
    (lambda: RowTable(8, ((0,) * 9, (1 << 26, *(0,) * 8))),
     "matrix 1 of the table has 67108864 for VIEW_X_U, the limits of Q2.25 are"),
    (lambda: row_view(np.tile(np.eye(3), (300, 1, 1)), SIZE, 4),
     "the raw frame has 300 rows, a table of 4 matrices is for 193"),
    (lambda: row_view(np.array([np.eye(3)] * 20 + [np.diag([-2, 1, 1.])]), SIZE),
     "matrix 3 of the table has -503316480 for VIEW_X_U"),
    (lambda: Hardware(view=True, view_rows=1), "the view's table has 1 matrices, the limits are 2"),
    (lambda: Hardware(view_rows=8), "the view's table has 8 matrices, it needs a view")])
def test_tables_that_cannot_be(make, sentence):
    with pytest.raises(InputError, match=sentence):
        make()

"""The network at nodes: golden model compared with exact arithmetic, choice, what is rejected."""

from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

from cameras import barrel_descriptor
from ncdc_model.evaluate import fixed_map, float_map
from ncdc_model.golden.network import coordinates, frame_coordinates, network, normalised_scan
from ncdc_model.golden.nodes import curvature, interpolated_map, largest_nodes, sums_between
from ncdc_spec.descriptor import Descriptor
from ncdc_spec.errors import InputError
from ncdc_spec.geometry import ValidRows
from ncdc_spec.hardware import Hardware
from ncdc_spec.nodes import NODES, row_nodes


def at_nodes(nodes, size=(144, 20), neurons=5):
    return replace(barrel_descriptor(size, size, hidden_neurons=neurons), nodes=nodes)


@pytest.mark.parametrize("nodes", NODES[1:])
def test_equals_the_formula_in_exact_fractions(nodes):
    """The equation of the page, in Python's fractions, rounded once: half up, as everywhere."""
    d = at_nodes(nodes)
    width, height = d.geometry.corrected
    rng = np.random.default_rng(nodes)
    # Both ends of a row are among the pixels: their nodes lie outside the picture.
    u, v = np.append(rng.integers(0, width, 60), [0, width - 1]), rng.integers(0, height, 62)
    got = coordinates(d, u, v)
    fine, q = d.network_formats.coordinate, d.formats.coordinate
    for n in range(len(u)):
        k, j = divmod(int(u[n]), nodes)
        columns = np.arange(k - 1, k + 3) * nodes
        nets = network(d, *normalised_scan(columns, np.full(4, v[n]), d.geometry,
                                           d.network_formats))
        for axis in range(2):
            p0, p1, p2, p3 = (Fraction(int(p), 1 << fine.f_bits) for p in nets[axis])
            x = (p1 + j * (p2 - p1) / nodes
                 - Fraction(j * (nodes - j), 4 * nodes**2) * ((p3 - p2) - (p1 - p0)))
            assert got[axis][n] == (x * 2**q.f_bits + Fraction(1, 2)).__floor__()


@pytest.mark.parametrize("nodes", NODES[1:])
def test_a_parabola_is_met_exactly(nodes):
    u = np.arange(3 * nodes)
    true = 7 * u**2 - 31 * u + 5
    k = u // nodes
    corners = (7 * c**2 - 31 * c + 5 for c in ((k + step) * nodes for step in (-1, 0, 1, 2)))
    np.testing.assert_array_equal(sums_between(*corners, u % nodes, nodes), 4 * nodes**2 * true)


@pytest.mark.parametrize("nodes", NODES[1:])
def test_nothing_saturates_next_to_the_narrowest_picture(nodes):
    d = at_nodes(nodes, (4 * nodes + 1, 20))
    width = d.geometry.corrected_width
    columns = np.arange(-1, row_nodes(width, nodes) - 1) * nodes
    q = d.network_formats.input
    x, _ = normalised_scan(columns, np.zeros_like(columns), d.geometry, d.network_formats)
    assert q.lo < x.min() and x.max() < q.hi
    np.testing.assert_allclose(q.real(x), d.geometry.normalise(columns, 0)[0], atol=2.0**-24)
    with pytest.raises(InputError, match=f"the corrected width is {4 * nodes}, nodes {nodes} "
                                         f"pixels apart need more than {4 * nodes}"):
        at_nodes(nodes, (4 * nodes, 20))


def test_whole_pixels_of_the_real_map_are_those_of_the_hardware():
    d = at_nodes(16)
    v, u = np.indices(d.geometry.corrected[::-1])
    for real, raw in zip(fixed_map(d)(u, v), frame_coordinates(d)):
        np.testing.assert_array_equal(real, d.formats.coordinate.real(raw))


@pytest.mark.parametrize("nodes", NODES[1:])
def test_interpolation_without_rounding_is_what_the_integers_approach(nodes):
    d = at_nodes(nodes)
    v, u = np.indices(d.geometry.corrected[::-1])
    near = interpolated_map(float_map(d.exact_network, d.geometry), nodes)(u, v)
    for real, raw in zip(near, frame_coordinates(d)):
        assert np.abs(d.formats.coordinate.real(raw) - real).max() < .0015
    # Pixels here and there take another way through the code.
    some = np.array([0, 77, 143]), np.array([0, 11, 19])
    for part, whole in zip(interpolated_map(float_map(d.exact_network, d.geometry), nodes)(*some),
                           near):
        np.testing.assert_allclose(part, whole[some[::-1]], rtol=0, atol=1e-9)


def test_curvature_is_the_largest_miss_on_a_valid_pixel():
    d = at_nodes(1)
    width, height = d.geometry.corrected

    def cubic(u, v):
        # The interpolation misses u^3 by j (j - S) (j - S / 2) and y by nothing.
        return np.asarray(u, np.float64)**3 * 1e-5 + 0 * v, np.asarray(v, np.float64) + 0 * u
    found = curvature(cubic, d.geometry, ValidRows.everything(width, height))
    for nodes in (8, 16, 32):
        j = np.arange(nodes)
        assert found[nodes] == pytest.approx(
            1e-5 * np.abs(j * (j - nodes) * (j - nodes / 2)).max())
    assert found[1] == 0 and largest_nodes({1: 0, 8: .001, 16: .0011, 32: .0005}) == 32
    # Where only columns 16 and 32 are valid, which are nodes, nothing is missed.
    rows = ValidRows(np.tile([16, 17, 32, 33], (height, 1)))
    assert curvature(cubic, d.geometry, rows)[16] == pytest.approx(0, abs=1e-9)


def test_is_saved_loaded_and_part_of_the_digest(tmp_path):
    plain, d = at_nodes(1), at_nodes(16)
    d.save(tmp_path / "net.toml")
    again = Descriptor.load(tmp_path / "net.toml")
    assert again.nodes == 16 and again.digest == d.digest != plain.digest
    plain.save(tmp_path / "plain.toml")
    assert "nodes" not in (tmp_path / "plain.toml").read_text()
    assert Descriptor.load(tmp_path / "plain.toml").nodes == 1


@pytest.mark.parametrize("value", ["12", "0", "true", '"16"'])
def test_bad_distances_are_named(tmp_path, value):
    path = tmp_path / "net.toml"
    at_nodes(16).save(path)
    path.write_text(path.read_text().replace("nodes = 16 ", f"nodes = {value} "))
    with pytest.raises(InputError, match="distance of the nodes is .*one of 1, 8, 16, 32"):
        Descriptor.load(path)


def test_a_descriptor_must_not_claim_the_format_at_nodes(tmp_path):
    path = tmp_path / "net.toml"
    at_nodes(16).save(path)
    path.write_text(path.read_text().replace("input = [1, 23]", "input = [2, 23]"))
    with pytest.raises(InputError, match="the format input Q2.23 does not suit the scan"):
        Descriptor.load(path)


@pytest.mark.parametrize("neurons,width,nodes,lanes,strip,share,units", [
    # 123 nodes for 1920 columns: a node may take 15 clocks; four lanes leave it 3.
    (16, 1920, 16, 1, 0, 8, 2), (16, 1920, 16, 4, 0, 3, 6), (12, 1920, 16, 1, 0, 12, 1),
    # 63 nodes for 1920 columns: 30 clocks, and 7.
    (16, 1920, 32, 1, 0, 16, 1), (16, 1920, 32, 4, 0, 6, 3),
    # 7 nodes for the 64 columns of a strip: 9 clocks.
    (12, 1920, 16, 1, 64, 6, 2), (12, 1920, 1, 4, 0, 1, 12)])
def test_the_fewest_units_that_keep_the_rate(neurons, width, nodes, lanes, strip, share, units):
    d = replace(barrel_descriptor((width, 16), (64, 16), hidden_neurons=neurons), nodes=nodes)
    hardware = Hardware(lanes=lanes, strip=strip).made_for(d)
    assert (hardware.share, hardware.units(neurons)) == (share, units)
    assert hardware.keeps_rate(d)
    columns = strip or width
    if nodes > 1:
        assert lanes * share * row_nodes(columns, nodes) <= columns
        if units > 1:
            fewer = -(-neurons // (units - 1))
            assert not Hardware(lanes=lanes, strip=strip, share=fewer).keeps_rate(d)


def test_a_share_that_is_asked_for_is_taken():
    d = replace(barrel_descriptor((1920, 16), (64, 16), hidden_neurons=8), nodes=16)
    assert Hardware(share=2).made_for(d).share == 2
    assert not Hardware(lanes=4, share=8).keeps_rate(d)
    # A node takes 2 clocks at least.
    narrow = replace(barrel_descriptor((36, 16), (64, 16), hidden_neurons=1), nodes=8)
    assert not Hardware(lanes=4).keeps_rate(narrow)


def test_nodes_further_apart_keep_the_rate_of_four_lanes():
    """83 nodes of 2 clocks for 160 groups; 43 and 23 nodes are soon enough."""
    d = replace(barrel_descriptor((640, 16), (64, 16), hidden_neurons=1), nodes=8)
    four = Hardware(lanes=4)
    assert four.row_clocks(d) == (160, 166) and not four.keeps_rate(d)
    assert four.nodes_at_rate(d) == [16, 32]
    assert Hardware(lanes=2).row_clocks(d) == (320, 166)
    # As with a share of 8, each of whose nodes takes 8 clocks.
    assert Hardware(lanes=4, share=8).row_clocks(replace(d, nodes=16)) == (160, 8 * 43)
    # A narrow picture has no nodes 32 pixels apart.
    assert four.nodes_at_rate(replace(barrel_descriptor((100, 16), (64, 16), hidden_neurons=1),
                                      nodes=8)) == [16]

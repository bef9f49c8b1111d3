"""Views of the compiled model have the golden model's bits."""

from dataclasses import replace

import numpy as np
import pytest

from ncdc_model.compiled.view import view_sources
from ncdc_model.golden.view import view_coordinates
from ncdc_spec.errors import InputError
from ncdc_spec.view import View
from plane_lens import seen_lens
from views import nonsense_view, random_view


def descriptors():
    """Of every distance of nodes, one with a row of few nodes."""
    for nodes, size in ((8, (96, 64)), (16, (104, 60)), (32, (136, 24))):
        yield replace(seen_lens(size, 60, (size[0] / 2 - 2, size[1] / 2 + 1)), nodes=nodes)


def test_sources_are_the_golden_model_s():
    rng, compared = np.random.default_rng(1), 0
    for lens in descriptors():
        views = [random_view(rng, lens.geometry, 60, size, pan=60, roll=180, zoom=(.3, 6))
                 for size in (lens.geometry.corrected, (33, 71), (8, 8)) for _ in range(4)]
        views += [nonsense_view(rng, (40, 30)) for _ in range(20)]
        for view in [View.identity(lens.geometry.corrected), *views]:
            width, height = view.size
            v, u = np.mgrid[0:height, 0:width]
            x, y, valid = view_sources(lens, view)
            wanted = view_coordinates(lens, view, u, v)
            assert (valid == wanted[2]).all()
            assert (x == wanted[0])[valid].all() and (y == wanted[1])[valid].all()
            compared += valid.sum()
    assert compared > 30_000


def test_a_network_at_every_pixel_has_no_views():
    with pytest.raises(InputError, match="nodes"):
        view_sources(replace(seen_lens(), nodes=1), View.identity((96, 64)))

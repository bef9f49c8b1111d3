"""Window address: gateware compared with the golden model, over the image's edges."""

import pytest

from ncdc_hdl.backend.window import WindowAddress
from ncdc_model.golden.picture import window_address
from ncdc_spec.descriptor import Formats
from ncdc_spec.geometry import Geometry
from ncdc_spec.interpolation import FAST, GRADIENT
from units.windows import check_window_address

FORMATS = Formats()
Q = FORMATS.coordinate
G = Geometry(16, 16, 40, 24)


@pytest.mark.longer
@pytest.mark.parametrize("needs", [FAST, GRADIENT], ids=lambda each: each.name)
@pytest.mark.parametrize("gap,stall", [(.3, .7), *(
    pytest.param(*case, marks=pytest.mark.regress) for case in ((0, 0), (.5, 0), (0, .5)))])
def test_equals_model(needs, gap, stall):
    check_window_address(WindowAddress(FORMATS, interpolation=needs), [G.distorted], [(gap, stall)])


def test_edges_keep_their_pixels_and_beyond_is_blank():
    """A source on the edge's own samples is valid; one more than a pixel outside is not."""
    one = 1 << Q.f_bits
    for size, axis in ((G.distorted_width, 0), (G.distorted_height, 1)):
        for value, inside, origin in ((-one // 2 - 1, False, 0), (-one // 2, True, 0),
                                      (0, True, 0), (one // 2, True, 0), (one, True, 0),
                                      ((size - 1) * one, True, size - 3),
                                      ((size - 1) * one + one // 2 - 1, True, size - 3),
                                      ((size - 1) * one + one // 2, False, 0)):
            point = [5 * one, 5 * one]
            point[axis] = value
            result = window_address(*point, G, Q)
            assert result[4] == inside and (not inside or result[axis] == origin), (axis, value)

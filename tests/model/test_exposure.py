"""An overexposed board is warned of, a bright one is not."""

from pathlib import Path

import pytest

from ncdc_bench.photos import spoil
from ncdc_bench.photos.targets import Bank
from ncdc_model.calibration.boards import find_boards

DATA = Path(__file__).resolve().parents[1] / "data"


@pytest.mark.parametrize("gain,warned", [(0.6, False), (1.0, False), (2.5, True)])
def test_clipped_white_is_warned_of(gain, warned):
    photo = spoil.brighten(Bank(DATA).real("mild1"), gain)
    warnings = find_boards(photo.image)[0].warnings
    assert any("overexposed" in text for text in warnings) == warned

"""Gains of raw samples on their way into the tile cache: equal to the golden model's."""

import numpy as np
import pytest

from cameras import barrel_descriptor
from fetchers import Pauses, check_windows
from ncdc_hdl.backend.cache.cache import Cache
from ncdc_hdl.backend.cache.raw_balance import RawBalance
from ncdc_hdl.corrector import Corrector
from ncdc_hdl.export.verilog import corrector_verilog
from ncdc_spec.cache_options import CacheOptions
from ncdc_spec.errors import InputError
from ncdc_spec.geometry import BAYER_PHASE
from ncdc_spec.hardware import Hardware
from ncdc_spec.interpolation import DIRECTIONAL, FAST
from ncdc_spec.raw_gains import NO_RAW_GAINS, balanced_raw, gained, sample_gains
from ncdc_spec.registers.register_map import BAYER_MONO, RAW_GAINS
from ncdc_spec.white_balance import LARGEST_GAIN, UNITY
from pipelines import run_pipeline

F = 10
PHASES = [*BAYER_PHASE.values(), None]


def balance(phase, gains):
    """Of the layout ``BALANCE``."""
    number = BAYER_MONO if phase is None else phase[0] | phase[1] << 1
    return {"gains": list(gains), "phase": number}


@pytest.mark.parametrize("phase", PHASES)
@pytest.mark.parametrize("width", [32, 128])
def test_equals_model(width, phase):
    """Every value at every byte, in even and odd rows; gains at their ends and at random."""
    rng = np.random.default_rng(width)
    columns = width // 8
    values = np.stack([rng.permutation(256) for _ in range(columns)], axis=1)
    for gains in (NO_RAW_GAINS, (0, 1, LARGEST_GAIN), (UNITY - 1, UNITY + 1, 397),
                  tuple(rng.integers(0, 1024, 3).tolist())):
        dut = RawBalance(width)

        def drive(ctx, item, gains=gains, dut=dut):
            row, odd = item
            ctx.set(dut.balance, balance(phase, gains))
            ctx.set(dut.odd_row, odd)
            ctx.set(dut.i, int.from_bytes(bytes(row.tolist()), "little"))

        items = [(row, k % 2) for k, row in enumerate(values)]
        found = run_pipeline(dut, items, drive, lambda dut=dut: [dut.o])
        rows = [list(word.to_bytes(columns, "little")) for word, in found]
        wanted = gained(values, sample_gains((columns, 256), phase, gains), 255)
        assert np.array_equal(rows, wanted), gains


def test_unity_changes_nothing_and_full_samples_stay_white():
    values = np.arange(256)
    assert np.array_equal(gained(values, UNITY, 255), values)
    assert {int(gained(255, gain, 255)) for gain in range(UNITY, LARGEST_GAIN + 1)} == {255}
    assert gained([1, 3], UNITY // 2, 255).tolist() == [1, 2]     # halves are rounded up


def test_model_of_a_frame():
    """Each 2 x 2 cell by hand."""
    geometry = barrel_descriptor((64, 24), (64, 24), hidden_neurons=2, bayer="GRBG").geometry
    raw = np.full((24, 64), 100, np.uint8)
    cells = balanced_raw(raw, geometry, (512, 256, 128)).reshape(12, 2, 32, 2)
    assert np.unique(cells[:, 0, :, 0]).tolist() == [100] == np.unique(cells[:, 1, :, 1]).tolist()
    assert np.unique(cells[:, 0, :, 1]).tolist() == [200]       # red is right of the first green
    assert np.unique(cells[:, 1, :, 0]).tolist() == [50]


@pytest.mark.parametrize("data_width,needs,pauses", [
    (32, FAST, Pauses(.3, 0, .5, (1, 20))),
    pytest.param(64, DIRECTIONAL, Pauses(0, .5, .3, (8, 8)), marks=pytest.mark.longer),
    pytest.param(128, FAST, Pauses(0, 0, 0, (1, 1)), marks=pytest.mark.longer),
    pytest.param(32, DIRECTIONAL, Pauses(.1, .1, .7, (1, 60)), marks=pytest.mark.longer)])
def test_windows_of_the_cache(data_width, needs, pauses):
    """With gaps, stalls and waits, and with tiles in every row and column of the frame."""
    rng = np.random.default_rng(data_width)
    width, height = 93, 70
    pitch = -(-width // 16) * 16
    raw = rng.integers(0, 256, (height, pitch), np.uint8)
    options = CacheOptions(tiles=32, pending=8, outstanding=3, sequence_bits=5,
                           interpolation=needs)
    count, phase, gains = 80, (1, 0), (499, 256, 397)
    positions = (rng.integers(0, width - needs.core + 1, count),
                 rng.integers(0, height - needs.core + 1, count), rng.random(count) < .1)
    held = gained(raw, sample_gains((pitch, height), phase, gains), 255)
    dut = Cache(F, data_width, options, raw_balance=True)
    check_windows(dut, raw, positions, rng, pauses, margin=4 * pitch, needs=needs, width=width,
                  held=held, split=1, balance=balance(phase, gains))


@pytest.mark.longer
def test_without_the_option_there_is_nothing_of_it():
    d = barrel_descriptor((64, 24), (64, 24), hidden_neurons=2)
    assert "raw_gain" in corrector_verilog(d, Hardware(raw_balance=True))
    assert "raw_gain" not in corrector_verilog(d, Hardware())


def test_latency_is_counted():
    d = barrel_descriptor((64, 24), (64, 24), hidden_neurons=2)
    plain, balanced = (Corrector(d, Hardware(raw_balance=one)).timing for one in (False, True))
    for name in ("fill_to_claim", "fill_to_retire"):
        assert getattr(balanced, name) - getattr(plain, name) == RawBalance.latency


def test_a_corrector_says_whether_it_has_gains():
    d = barrel_descriptor((64, 24), (64, 24), hidden_neurons=2)
    for has in (False, True):
        made = Corrector(d, Hardware(raw_balance=has)).registers
        assert bool(made.constants["CAPABILITIES"] & 1 << 22) == has
        assert (set(RAW_GAINS) <= {r.name for r in made.table}) == has
    assert [made.values[name] for name in RAW_GAINS] == [UNITY] * 3


def test_the_multiport_fetcher_has_none():
    with pytest.raises(InputError, match="fetch is multiport, gains of raw samples need cache"):
        Hardware(fetcher="multiport", raw_balance=True)

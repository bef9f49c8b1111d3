"""The tile cache of the corrector, alone: windows that jump about, tiles that replace each other.

The frames of the other benches rarely replace a tile that is in use.
"""

from mutation.core import HARDWARE, corrector
from ncdc_bench.mutation.designs import Design, PlayedBench
from ncdc_hdl.backend.cache.cache import Cache
from simulations.cache_stress import stress_cache

__all__ = ["DESIGN"]


def make():
    """The cache, as the corrector has it."""
    return Cache(corrector().fetch.f_bits, HARDWARE.data_width,
                 HARDWARE.cache, raw_balance=True)


def random_windows(groups, **settings):
    """The bench of so many windows; settings as of
    :func:`simulations.cache_stress.stress_cache`."""
    def bench(verilog, transcripts):
        result = stress_cache(make(), groups=groups, verilog=verilog, transcripts=transcripts,
                              **settings)
        assert result["wrong"] == 0 and result["windows"] >= groups and result["tiles"] > 1000
        assert result["frames"] > 4 and (result["resets"] > 4) == ("resets" in settings)
    return bench


DESIGN = Design("cache", "cache", make, (
    PlayedBench("small frames", random_windows(8000, frame_bits=7)),
    PlayedBench("large frames", random_windows(8000, frame_bits=12, seed=2)),
    PlayedBench("resets", random_windows(4000, frame_bits=7, resets=128, seed=3)),
    PlayedBench("far", random_windows(6000, frame_bits=7, seed=4, far=1)),
    PlayedBench("long", random_windows(60_000, frame_bits=10, seed=5))),
    leaves=("fills.fence",))

"""The planner compared with the Verilog, for every combination of what a network can be built
with."""

from dataclasses import dataclass, replace
from itertools import product

import numpy as np

from ncdc_bench.throughput.lenses import Lens, trained
from ncdc_hdl.corrector import Corrector
from ncdc_hdl.export.verilog import verilog_of
from ncdc_model.planner.lookups import frame_windows, lookups
from ncdc_model.planner.plan import Fixed, plan
from ncdc_model.planner.tags import accesses, misses
from ncdc_sim.system.corrector import simulate_correction
from ncdc_spec.errors import InputError
from ncdc_spec.hardware import DATA_WIDTHS, LANES, Hardware
from ncdc_spec.interpolation import FAST, GRADIENT
from ncdc_spec.nodes import NODES

__all__ = ["CROSS", "LIMIT", "Combination", "cross_rows", "worst_split"]

LIMIT = .01             # by which the Verilog may take more or fewer clocks than are planned
_SIZE = 208, 156
_DEGREES = 105
_CACHE_BYTES = 8192     # of which a bad split evicts tiles all the time
_MEMORY = "ddr3"


@dataclass(frozen=True)
class Combination:
    """Parameters of one corrector.

    Parameters
    ----------
    lanes, nodes : int
        Pixels per clock; pixels from node to node.
    interpolation : str
    data_width : int
        Bits of the memory port.
    """
    lanes: int
    nodes: int
    interpolation: str
    data_width: int

    @property
    def descriptor(self):
        """The descriptor of a small lens, trained once for each interpolation."""
        lens = Lens(_DEGREES, _SIZE, interpolation=self.interpolation)
        return replace(trained(lens), nodes=self.nodes)

    @property
    def hardware(self):
        """A video stream out, the tile cache left open."""
        return Hardware(data_width=self.data_width, output="stream", lanes=self.lanes)

    def __str__(self):
        return (f"{self.interpolation}, {self.lanes} pixels per clock, nodes {self.nodes}, "
                f"{self.data_width} bits")


CROSS = [Combination(lanes, nodes, needs.name, width) for lanes, nodes, needs, width in
         product(LANES, NODES, (FAST, GRADIENT), DATA_WIDTHS)]


def worst_split(descriptor, hardware):
    """The split of the tile cache of ``hardware`` that reads the most tiles."""
    accessed = accesses(lookups(frame_windows(descriptor), hardware.strip, hardware.lanes))
    return max(range(hardware.cache.max_split + 1),
               key=lambda split: len(misses(accessed, hardware.cache, split)))


def cross_rows(combinations, progress=lambda combination: None):
    """Two rows for each of ``combinations``, with the planned split and with the worst one.

    Yields
    ------
    dict
        ``lanes``, ``nodes``, ``interpolation``, ``data_width``, ``split``, ``which`` ("planned",
        "worst"), ``clocks_per_pixel``, ``predicted_clocks_per_pixel``, ``misses``,
        ``misses_expected``, ``pixels_different``, ``holds``. ``off``: measured over predicted,
        less one. ``rejected``: a sentence if the combination cannot be built, without figures.
    """
    for each in combinations:
        show = progress(each)
        descriptor, hardware = each.descriptor, each.hardware
        settings = {"lanes": each.lanes, "nodes": each.nodes,
                    "interpolation": each.interpolation, "data_width": each.data_width}
        planned, verilog = None, None
        raw = np.random.default_rng(1).integers(0, 256, _SIZE[::-1], np.uint8)
        for which in ("planned", "worst"):
            try:
                split = worst_split(descriptor, planned.hardware) if planned else None
                planned = plan(descriptor, hardware, _MEMORY,
                               lambda chosen: Corrector(descriptor, chosen).timing,
                               fixed=Fixed(_CACHE_BYTES, split, 0))
            except InputError as error:
                yield settings | {"which": which, "rejected": str(error), "holds": True}
                break
            if verilog is None:
                built = replace(planned.hardware, split=None, strip=0)
                verilog = verilog_of(Corrector(descriptor, built))
            simulation = simulate_correction(descriptor, raw, planned.hardware, verilog=verilog,
                                             progress=show, memory=_MEMORY)
            yield settings | _compared(which, planned, simulation)


def _compared(which, planned, simulation):
    """Figures of a row, without its settings."""
    report = simulation.report()
    off = report["clocks"] / planned.clocks - 1
    wrong = report["pixels_different"]
    found, expected = report["windows_fetched"], report["windows_fetched_expected"]
    return {"which": which, "split": planned.hardware.split, "rejected": None,
            "clocks_per_pixel": report["clocks_per_pixel"],
            "predicted_clocks_per_pixel": planned.clocks_per_pixel, "off": off,
            "misses": found, "misses_expected": expected, "pixels_different": wrong,
            "holds": abs(off) <= LIMIT and found == expected and wrong == 0}

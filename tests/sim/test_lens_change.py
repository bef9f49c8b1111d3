"""Another lens with every frame: no pixel of a wrong set, no clock lost between frames."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from cameras import barrel_descriptor
from ncdc_hdl.corrector import Corrector
from ncdc_hdl.export.verilog import verilog_of
from ncdc_hdl.registers.agent import Registers
from ncdc_sim.tools import SimulationError
from ncdc_spec.hardware import Hardware
from ncdc_spec.interpolation import FAST, GRADIENT
from simulations.lens_change import simulate_lens_change

BETWEEN = 2     # clocks from a frame's last to the next one's first


def cameras(corrected=(96, 72), distorted=(104, 80), hidden_neurons=3, nodes=1, needs=FAST):
    """Two cameras that differ in everything a host can set, sizes and Bayer phase included."""
    wide = barrel_descriptor(corrected, distorted, hidden_neurons, bayer="GBRG", strength=0.4,
                             fill=(200, 100, 50), interpolation=needs)
    other = (corrected[0] - 8, corrected[1] - 6), (distorted[0] - 11, distorted[1] - 9)
    tele = barrel_descriptor(*other, hidden_neurons, seed=8, bayer="RGGB", strength=0.1,
                             interpolation=needs)
    rng = np.random.default_rng(4)
    return [(replace(d, nodes=nodes), rng.integers(0, 256, d.geometry.distorted[::-1], np.uint8))
            for d in (wide, tele)]


@cache
def hardware(fetcher, output):
    """Corrector made for the first camera, and its Verilog."""
    corrector = Corrector(cameras()[0][0], Hardware(output=output, fetcher=fetcher))
    return corrector, verilog_of(corrector)


@pytest.mark.longer
@pytest.mark.many_clocks
@pytest.mark.parametrize("fetcher,output,memory,intruder", [
    ("cache", "memory", "hostile", False), ("cache", "memory", "sdram", True),
    pytest.param("cache", "stream", "hostile", True, marks=pytest.mark.regress),
    pytest.param("multiport", "memory", "hostile", True, marks=pytest.mark.regress)])
def test_twenty_frames_of_two_lenses(fetcher, output, memory, intruder):
    pair = cameras()
    result = simulate_lens_change(*hardware(fetcher, output), pair, 20, memory=memory,
                                  intruder=intruder)
    assert result.differing == (0,) * 20
    assert result.pixels == 10 * (96 * 72 + 88 * 66)
    assert len(result.idle) == 19 and max(result.idle) <= BETWEEN


def three_frames(fault, monkeypatch):
    """Three frames of a corrector that takes some of the host's writes without a commit."""
    def take_over(self, m, when, held):
        for name, _ in self.active.shape():
            torn = fault == name or fault == "all of the network" and "PUT_" in name
            with m.If(torn | when):
                m.d.sync += self.active[name].eq(held[name])

    monkeypatch.setattr(Registers, "_take_over", take_over)
    pair = cameras((48, 40), (56, 44))
    torn = Corrector(pair[0][0])
    return simulate_lens_change(torn, verilog_of(torn), pair, 3, memory="sdram")


@pytest.mark.longer
@pytest.mark.parametrize("fault", ["all of the network", *(
    pytest.param(name, marks=pytest.mark.regress) for name in ("SCAN_STEP_Y", "FILL"))])
def test_a_tear_is_seen(fault, monkeypatch):
    result = three_frames(fault, monkeypatch)
    # The last frame has no successor that could disturb it.
    assert result.differing[0] > 0 and result.differing[1] > 0 and result.differing[2] == 0


@pytest.mark.regress
def test_a_torn_address_is_a_fault(monkeypatch):
    """The frame's rows are then outside its buffer: bit 7 of STATUS is more than was expected."""
    with pytest.raises(SimulationError, match="register-compare word 4 reads 000000a1 instead of "
                                              "00000021"):
        three_frames("SOURCE_BASE", monkeypatch)


@pytest.mark.many_clocks
@pytest.mark.regress
@pytest.mark.parametrize("fetcher,data_width,size", [("cache", 128, (640, 480)),
                                                     ("multiport", 64, (160, 120))])
def test_lenses_change_at_full_size(fetcher, data_width, size):
    pair = cameras(size, (size[0] + 16, size[1] + 12), hidden_neurons=8)
    corrector = Corrector(pair[0][0], Hardware(data_width=data_width, fetcher=fetcher))
    result = simulate_lens_change(corrector, verilog_of(corrector), pair, 20, memory="hostile",
                                  intruder=True)
    assert result.differing == (0,) * 20 and max(result.idle) <= BETWEEN


@pytest.mark.many_clocks
@pytest.mark.regress
@pytest.mark.parametrize("size,neurons,needs,settings", [
    ((1280, 1024), 12, FAST, dict()), ((1280, 1024), 16, GRADIENT, dict(output="stream")),
    ((1920, 1080), 16, GRADIENT, dict(output="stream", lanes=4))])
def test_lenses_of_real_size_at_nodes(size, neurons, needs, settings):
    pair = cameras(size, size, neurons, 16, needs)
    corrector = Corrector(pair[0][0], Hardware(data_width=128, **settings))
    result = simulate_lens_change(corrector, verilog_of(corrector), pair, 3, memory="ddr3",
                                  intruder=True)
    assert result.differing == (0,) * 3 and max(result.idle) <= BETWEEN

"""Words both ways between the core and an FTDI chip: none lost, none late, no rule broken."""

from dataclasses import replace

import pytest
from amaranth import *
from amaranth.lib import fifo as amaranth_fifo

from ncdc_hdl.export.verilog import module_verilog
from ncdc_hdl.usb.fifo import UsbFifo
from ncdc_hdl.usb.fifo_bus import FifoBus
from ncdc_hdl.usb.layouts import FT232H, FT601
from ncdc_sim.tools import SimulationError
from simulations import usb_bus as bus
from simulations.metastability import Metastability, metastable_verilog
from simulations.usb_bus import simulate_bus

regress = pytest.mark.regress
CORE = {"FT232H": 10_000, "FT601": 9_000}       # ps; the core's clock is the faster one
ROUGH = {"rx_stall": 60, "tx_stall": 60, "gap": 60, "stall": 60, "up_stall": 30, "down_gap": 60}
MEGABYTE = 1_000_000


def run(chip, words=(1500, 1500), **options):
    return simulate_bus(UsbFifo(chip), up=words[0], down=words[1], clk_period=CORE[chip.name],
                        **options)


@pytest.mark.parametrize("chip", [FT232H, FT601], ids=lambda chip: chip.name)
def test_random_pauses_with_the_pins_as_late_as_they_may_be(chip):
    run(chip, simulator="icarus", timed=True, **ROUGH)


@pytest.mark.parametrize("direction", ["up", "down"])
def test_a_word_per_clock_but_for_the_chips_own_pauses(direction):
    words = (2500, 0) if direction == "up" else (0, 2500)
    assert run(FT232H, words, simulator="icarus", timed=True).rate(direction) >= .999
    paused = run(FT232H, words, simulator="icarus", timed=True, rx_stall=80, tx_stall=80)
    assert paused.rate(direction) < .8 and paused.rate_unpaused(direction) >= .999


@pytest.mark.many_clocks
@regress
@pytest.mark.parametrize("chip,least", [(FT232H, .98), (FT601, .9)],
                         ids=lambda value: getattr(value, "name", ""))
@pytest.mark.parametrize("pauses", [{}, {"rx_stall": 60, "tx_stall": 60}, ROUGH],
                         ids=["smooth", "pauses", "rough"])
def test_ten_megabytes(chip, least, pauses):
    words = 10 * MEGABYTE // chip.lanes
    for direction, counts in (("up", (words, 0)), ("down", (0, words))):
        result = run(chip, counts, **pauses)
        assert pauses is ROUGH or result.rate_unpaused(direction) >= least
    result = run(chip, (words, words), **pauses)
    assert pauses or result.rate("up") + result.rate("down") >= least


def test_crossings_with_metastable_flops():
    fifo = UsbFifo(FT232H, depth=16)
    verilog = metastable_verilog(module_verilog(fifo, "dut", Metastability()))
    # Nearly equal clocks: each edge meets every phase of the other one.
    periods = {"clk_period": 10_000, "extclk_period": 9_990}
    result = simulate_bus(fifo, up=3000, down=3000, simulator="icarus", verilog=verilog,
                          metastable_ps=4495, metastable_seed=1, **periods, **ROUGH)
    assert result.results["different"] == 0


@pytest.mark.parametrize("simulator,resets", [("icarus", 3), pytest.param(
    "verilator", 300, marks=regress)])
def test_resets_of_the_core_in_the_midst_of_words(simulator, resets):
    """What comes after one is in order again, and nothing of before is among it. Words of 32 bits:
    bytes would not show where the row goes on."""
    words = 3000 * (resets + 1)
    result = run(FT601, (1000, words), simulator=simulator, resets=resets, **ROUGH)
    assert result.results["different"] == 0


@regress
def test_a_queue_of_which_one_side_is_not_reset_is_found(monkeypatch):
    class Never(Elaboratable):
        """A planted error: the queue's reader does not know of its writer's reset."""

        def __init__(self, i, o, **_):
            self.o = o

        def elaborate(self, platform):
            m = Module()
            m.d.comb += self.o.eq(0)
            return m

    monkeypatch.setattr(amaranth_fifo, "AsyncFFSynchronizer", Never)
    with pytest.raises(SimulationError, match="went wrong"):
        run(FT601, (1000, 12_000), simulator="icarus", resets=3, **ROUGH)


def test_pins_that_are_too_late_are_found(monkeypatch):
    late = replace(bus.TIMINGS["FT232H"], fpga_out=9200)
    monkeypatch.setitem(bus.TIMINGS, "FT232H", late)
    with pytest.raises(SimulationError, match="USB-ERROR setup"):
        run(FT232H, (50, 50), simulator="icarus", timed=True)


@pytest.mark.longer
def test_a_bus_that_does_not_look_at_txe_loses_words(monkeypatch):
    monkeypatch.setattr(FifoBus, "_accepted", staticmethod(lambda pins: ~pins.wr_n))
    with pytest.raises(SimulationError, match="DIFFERENT up"):
        run(FT232H, (2000, 0), simulator="icarus", tx_stall=60)


def test_a_queue_without_spare_words_is_rejected():
    with pytest.raises(ValueError, match="depth is 8, the limit is 16"):
        UsbFifo(FT232H, depth=8)

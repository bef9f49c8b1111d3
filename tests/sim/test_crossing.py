"""Every synchroniser metastable, at any ratio of the two clocks."""

import re

import pytest
from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.cdc import FFSynchronizer
from amaranth.lib.wiring import In, Out

from cocotb_run import run_cocotb
from ncdc_hdl.camera.capture import Capture
from ncdc_hdl.camera.i2c import I2cController
from ncdc_sim.tools import SimulationError
from simulations.metastability import Metastability, metastable_counts, metastable_design

regress = pytest.mark.regress

# Of the sensor, in ps; the core's is 10,000. None is a whole multiple: each edge meets every phase.
PERIODS = {"8:1": 1_253, "3:1": 3_330, "1:1": 9_990, "1:3": 30_010, "1:8": 79_990}
CORE = 10_000


class BinaryCounters(Metastability):
    """A planted error: a bus crosses as a binary number, not in Gray code.

    The queue itself forgives that, as each of its sides only asks whether two counters are equal
    and moves by one entry; what it says of its level is wrong.
    """

    def get_ff_sync(self, synchroniser):
        width = len(synchroniser.i)
        if width == 1:
            return super().get_ff_sync(synchroniser)
        m = Module()
        sent, seen = Signal(width), Signal(width)
        m.d.comb += [sent[k].eq(synchroniser.i[k:].xor()) for k in range(width)]
        binary = FFSynchronizer(sent, seen, o_domain=synchroniser._o_domain,
                                stages=synchroniser._stages)
        m.submodules.binary = super().get_ff_sync(binary)
        m.d.comb += synchroniser.o.eq(seen ^ seen >> 1)
        return m


class Bus(wiring.Component):
    """A synchroniser of four bits, and nothing else."""
    i: In(4)
    o: Out(4)

    def elaborate(self, platform):
        m = Module()
        m.submodules.cdc = FFSynchronizer(self.i, self.o)
        return m


def window(period):
    """The time before and after an edge that is too near: together nine tenths of the faster
    clock's period. What is left is one bit of a Gray counter in it at most."""
    return min(period, CORE) * 45 // 100


def captured(period, seed, simulator="icarus", platform=None, metastable=True):
    """The log of capture's bench; a fast sensor has a queue and a memory that keep up with it."""
    fast = period < CORE // 2
    component = Capture(128, burst=4, depth=64) if fast else Capture(32, burst=4, depth=16)
    design = metastable_design(component, f"dut_crossing{'_fast' if fast else ''}", platform)
    return run_cocotb(
        design, "capture", simulator, camera_period_ps=period, phase_ps=1234 * seed % period,
        wait=.2 if fast else .1, seed=seed, plusargs=[
            f"+metastable_ps={window(period) if metastable else 0}", f"+metastable_seed={seed}"])


def synchronisers(log):
    """Names of those that were metastable, and of each the numbers of its bits that were."""
    found = {}
    for path in metastable_counts(log):
        name, _, bit = path.partition(".first.flop")
        name = re.sub(r"_\d+$", "", name.split(".")[-1])
        found.setdefault(name, set()).add(int(re.sub(r"\D", "", bit) or 0))
    return found


@pytest.mark.longer
def test_capture_with_nearly_equal_clocks():
    found = synchronisers(captured(PERIODS["1:1"], seed=2))     # with which a reset is, too
    # The queue's own reset never comes.
    found.pop("rst_cdc", None)
    assert found == {"reset": {0}, "enable": {0}, "active": {0}, "consume_buffered_cdc": {0},
                     "asked_cdc": {0}, "taken_cdc": {0},
                     "produce_cdc": {0, 1, 2, 3, 4}, "consume_cdc": {0, 1, 2, 3, 4}}


@regress
@pytest.mark.parametrize("seed,simulator", [(1, "icarus"), (2, "icarus"), (3, "verilator")])
@pytest.mark.parametrize("ratio", PERIODS)
def test_capture_at_any_ratio(ratio, seed, simulator):
    found = synchronisers(captured(PERIODS[ratio], seed, simulator))
    # The time about an edge is a ninth of the core's clock at 8:1, and `active` changes seldom. A
    # slow sensor's queue is read some clocks after its edge, seldom near the next one.
    assert "produce_cdc" in found
    assert "active" in found or ratio == "8:1"
    assert "consume_cdc" in found or ratio == "1:8"


@pytest.mark.longer
def test_a_counter_that_is_not_gray_is_found():
    with pytest.raises(SimulationError, match="failed: half_full"):
        captured(PERIODS["1:1"], seed=1, platform=BinaryCounters())


@regress
def test_a_counter_that_is_not_gray_is_found_by_metastability_alone():
    captured(PERIODS["1:1"], seed=1, platform=BinaryCounters(), metastable=False)


@pytest.mark.parametrize("period", [9_990, pytest.param(3_330, marks=regress),
                                    pytest.param(30_010, marks=regress)])
def test_a_bus_in_gray_code_is_seen_as_it_was_sent(period):
    log = crossed(period, gray=True)
    counts = metastable_counts(log)
    assert synchronisers(log) == {"cdc": {0, 1, 2, 3}}
    assert all(count["early"] and count["late"] for count in counts.values())


@pytest.mark.longer
def test_a_bus_that_is_not_is_not():
    with pytest.raises(SimulationError, match="is seen, it was not sent"):
        crossed(9_990, gray=False)
    assert not metastable_counts(crossed(9_990, gray=False, metastable=False))


def crossed(period, gray, metastable=True):
    """The log of a bus through a synchroniser."""
    return run_cocotb(
        metastable_design(Bus(), "dut_bus"), "synchroniser", "icarus", period_ps=period, gray=gray,
        count=600, seed=1, plusargs=[f"+metastable_ps={window(period) if metastable else 0}"])


@pytest.mark.longer
@pytest.mark.parametrize("simulator", ["icarus", pytest.param("verilator", marks=regress)])
def test_i2c_with_lines_that_change_at_any_time(simulator):
    log = run_cocotb(metastable_design(I2cController(), "dut_i2c_crossing"), "i2c", simulator,
                     quarter=8, wander=True, plusargs=[f"+metastable_ps={window(CORE)}"])
    assert synchronisers(log) == {"scl_cdc": {0}, "sda_cdc": {0}}

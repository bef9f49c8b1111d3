"""Parameters of the memories."""

from fractions import Fraction

import pytest

from ncdc_model.planner.memory_timing import (
    MEMORIES,
    LatencyMemory,
    ddr3,
    ddr3_1066,
    memory_timing,
    sdram,
)
from ncdc_spec.errors import InputError


def test_sdram_in_clocks_of_10_ns():
    m = sdram()
    assert (m.ratio, m.rcd, m.rp, m.ras, m.rc, m.rrd) == (1, 2, 2, 5, 7, 2)
    assert (m.refresh, m.refresh_interval, m.write_to_precharge) == (7, 781, 2)
    assert m.row_bytes * m.banks * 8192 == 128 << 20        # two parts of 512 Mbit


def test_ddr3_in_clocks_of_2500_ps():
    m = ddr3()
    assert (m.ratio, m.rcd, m.rp, m.ras, m.rc, m.rrd, m.faw) == (4, 6, 6, 15, 21, 4, 20)
    assert (m.refresh, m.refresh_interval, m.write_to_precharge) == (64, 3125, 11)
    assert (m.read_to_write, m.write_to_read) == (3, 9)
    assert m.row_bytes * m.banks * 16384 * 8 == 2 << 30


def test_ddr3_1066_has_four_clocks_of_its_controllers():
    assert ddr3_1066(100) == ddr3(100)
    m = memory_timing("ddr3-1066@125")                      # 2 ns
    assert (m.ratio, m.cas_latency, m.rcd, m.rp, m.ras, m.rc, m.rrd, m.faw) == (
        4, 8, 8, 8, 19, 27, 5, 25)
    assert (m.refresh, m.refresh_interval, m.write_to_precharge) == (80, 3906, 14)
    assert (m.read_to_write, m.write_to_read, m.controller_clocks) == (4, 10, 14)


def test_the_hard_processors_memory():
    """Two chips of 4 Gbit side by side: twice the bytes of a burst and of a row, 1 GB."""
    one, m = MEMORIES["ddr3"], MEMORIES["hps"]
    assert (m.access_bytes, m.row_bytes) == (2 * one.access_bytes, 2 * one.row_bytes)
    assert m.row_bytes * m.banks * 32768 == 1 << 30
    assert (m.refresh, m.max_pending, m.controller_clocks) == (104, 8, 24)
    assert memory_timing("hps@150").ratio == Fraction(8, 3)


def test_other_clocks():
    assert [memory_timing(f"ddr3@{f}").controller_clocks for f in (100, 150, 200)] == [12, 16, 20]
    assert memory_timing("ddr3@150").ratio == Fraction(8, 3)
    assert memory_timing("sdram@50").rc == 4 and memory_timing("sdram@133.3").rc == 9


def test_names():
    assert memory_timing("fixed:100:4") == LatencyMemory(latency=(100, 100), bytes_per_clock=4)
    assert memory_timing(MEMORIES["sdram"]) is MEMORIES["sdram"]


@pytest.mark.parametrize("memory,message", [
    ("sram", "memory is 'sram', one of ideal, sdram, ddr3, ddr3-1066, hps, hostile, sdram@MHZ, "
     "ddr3@MHZ, ddr3-1066@MHZ, hps@MHZ or fixed"),
    ("fixed:100", "memory is 'fixed:100'"),
    ("fixed:0:4", r"latency is 0\.\.0 clocks, the limits are 1 and 10000"),
    ("fixed:10:65", "rate is 65 bytes per clock, the limits are 0.01 and 64"),
    ("sdram@150", "clock of sdram is 150 MHz, the limits are 20 and 143"),
    ("ddr3@10", "clock of ddr3 is 10 MHz, the limits are 20 and 400"),
    ("ddr3-1066@150", "clock of ddr3-1066 is 150 MHz, the limits are 76 and 133")])
def test_bad_names(memory, message):
    with pytest.raises(InputError, match=message):
        memory_timing(memory)


@pytest.mark.parametrize("options,message", [
    ({"max_pending": 65}, "max_pending is 65, the limits are 1 and 64"),
    ({"wait_probability": 256}, "wait_probability is 256, the limits are 0 and 255")])
def test_bad_values(options, message):
    with pytest.raises(InputError, match=message):
        LatencyMemory(**options)

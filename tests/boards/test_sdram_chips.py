"""The SDRAM chips' times in clocks, and what the controller rejects."""

from dataclasses import replace
from math import ceil

import pytest

from ncdc_boards.sdram.chips import (
    AS4C16M16SA_6,
    AS4C16M16SA_7,
    CHIPS,
    IS42S16160G_7,
    IS42S16320D_7,
    MT48LC16M16A2_7E,
    ULX3S_32MB,
    W9825G6KH_6,
    clocks_of,
    slowest,
)
from ncdc_boards.sdram.controller import SdramController
from ncdc_spec.errors import InputError

MINIMUMS = ("rcd", "rp", "ras", "rc", "rfc", "wr", "rrd", "mrd")


@pytest.mark.parametrize("mhz", (50, 100, 133, 142.857))
@pytest.mark.parametrize("chip", CHIPS.values(), ids=CHIPS)
def test_clocks_hold_the_times_and_no_more(chip, mhz):
    if mhz * dict(chip.cas)[3] > 1000:
        return
    clocks, period = clocks_of(chip, mhz * 1e6), 1000 / mhz
    for name in MINIMUMS:
        count, time = getattr(clocks, name), getattr(chip, name)
        assert count * period >= time - 1e-9
        assert count == max(ceil(time / period - 1e-9), getattr(chip, f"{name}_clocks", 1))
    assert clocks.refresh * period <= chip.refresh < (clocks.refresh + 1) * period
    assert clocks.ras_max * period <= chip.ras_max and clocks.pause * period >= 1000 * chip.pause


def test_a_clock_that_divides_a_time_is_not_rounded_up():
    """16 ns are two periods of 8 ns, and 16.01 ns are three."""
    assert clocks_of(replace(AS4C16M16SA_6, rcd=16), 125e6).rcd == 2
    assert clocks_of(replace(AS4C16M16SA_6, rcd=16.01), 125e6).rcd == 3


def test_the_slowest_is_none_of_them_and_slower_than_each():
    for chip in (IS42S16160G_7, AS4C16M16SA_7, W9825G6KH_6, MT48LC16M16A2_7E):
        assert all(getattr(ULX3S_32MB, name) >= getattr(chip, name) for name in MINIMUMS)
        assert ULX3S_32MB.ras_max <= chip.ras_max and ULX3S_32MB.refresh <= chip.refresh
        assert dict(ULX3S_32MB.cas)[3] >= dict(chip.cas)[3]


@pytest.mark.parametrize("changes,message", [
    ({"clock_hz": 170e6}, "the SDRAM's clock is 170 MHz; with CAS latency 3 AS4C16M16SA-6 goes up "
                          "to 166.7 MHz"),
    ({"cas": 2}, "the SDRAM's clock is 133 MHz; with CAS latency 2 AS4C16M16SA-6 goes up to "
                 "100.0 MHz"),
    ({"cas": 4}, "the CAS latency is 4; AS4C16M16SA-6 has 2 and 3"),
    ({"clock_hz": 0}, "the SDRAM's clock is 0 Hz; it must be above 0"),
    ({"data_width": 24}, "data_width is 24, not 1, 2, 4 or 8 times the 16 bits of AS4C16M16SA-6"),
    ({"data_width": 256}, "data_width is 256, not 1, 2, 4 or 8 times the 16 bits of "
                          "AS4C16M16SA-6"),
    ({"reads": 0}, "reads is 0, the controller needs 1 read port or more"),
    ({"max_burst": 0}, "max_burst is 0, the limits are 1 and the 256 words of a row"),
    ({"max_burst": 257}, "max_burst is 257, the limits are 1 and the 256 words of a row"),
    ({"max_burst": 256}, "max_burst is 256: two bursts and a refresh take up to 1076 clocks, the "
                         "limit is half of the 1037 clocks between refreshes"),
    ({"late": -2}, "late is -2, the limit is -1: a clock early"),
    ({"chip": replace(AS4C16M16SA_6, column_bits=11)},
     "AS4C16M16SA-6 has 11 column bits, the controller has 10 at most")])
def test_rejected_in_one_sentence(changes, message):
    parameters = {"chip": AS4C16M16SA_6, "clock_hz": 133e6, "data_width": 32, "reads": 3,
                  "max_burst": 16} | changes
    with pytest.raises(InputError) as rejected:
        SdramController(**parameters)
    assert str(rejected.value) == message


def test_chips_of_another_size_do_not_stand_for_each_other():
    with pytest.raises(InputError, match="chips of different size cannot stand for each other"):
        slowest("any", AS4C16M16SA_6, IS42S16320D_7)


def test_latency_is_a_sum():
    """CAS latency and beats add up; see the docstrings of the parts."""
    slow = SdramController(IS42S16320D_7, 100e6, 32, 3, 16)
    fast = SdramController(IS42S16320D_7, 100e6, 32, 3, 16, cas=2)
    wide = SdramController(IS42S16320D_7, 100e6, 64, 3, 16, late=1)
    assert (slow.latency - fast.latency, wide.latency - slow.latency) == (1, 2 + 1)

"""The memory model with rows and banks: every word comes in the clock that the rules give it."""

from dataclasses import replace

import pytest

from memory_model import beats
from ncdc_model.planner.memory_timing import ddr3, sdram
from ncdc_sim.tools import SIMULATORS, SimulationError

SDRAM_ROW = 4096 * 4        # bytes from a row to the next one of its bank
DDR3_ROW = 2048 * 8


# Times below: the sdram's controller schedules a command taken at clock t at t + 3. The memory
# has the first command at t + 4, and a read's word is on the port 4 clocks after the read.
@pytest.mark.parametrize("simulator", SIMULATORS)
def test_sdram_reads(simulator):
    row = SDRAM_ROW
    assert beats(sdram(), [
        [0, 20, 0, 1],                  # no row open: activate 24, read 26
        [0, 40, 4092, 1],               # the row is open: read 44
        [0, 60, row, 1],                # another row: precharge 64, activate 66, read 68
        [0, 80, row + 16, 4],           # a burst
        # Two closed banks: activate 104, read 106; the second's activate waits for rrd to 106,
        # finds the read there, and goes at 107; read 109.
        [0, 100, 8192, 1], [0, 101, 12288, 1],
        # Two rows of one bank: activate 124, read 126; precharge 129 (ras), activate 131 (rc too),
        # read 133.
        [0, 120, 4096, 1], [0, 121, row + 4096, 1],
    ], clocks=160, simulator=simulator)[0] == [30, 48, 72, 88, 89, 90, 91, 110, 113, 130, 137]


def test_sdram_ports_take_turns():
    # All rows are opened first. Bursts of both ports, offered at once and without end: one word
    # per clock altogether, four at a time.
    reads = [[p, 20, 4096 * p, 1] for p in (0, 1)]
    reads += [[p, 60, 4096 * p, 4] for p in (0, 1) for _ in range(4)]
    got = beats(sdram(), reads)
    assert got[0][1:] == [68 + 8 * k + j for k in range(4) for j in range(4)]
    assert got[1][1:] == [72 + 8 * k + j for k in range(4) for j in range(4)]


@pytest.mark.parametrize("look_ahead,lost", [(1, 1), (2, 0), (4, 0)])
def test_look_ahead_hides_the_rows(look_ahead, lost):
    # Bursts of 8 words, each from another bank and a row that is not open, without a pause. With
    # look_ahead 1 an access is scheduled when the one before it is read: precharge 1 clock later,
    # activate 3, read 5, of which the data of that one hides 4.
    reads = [[0, 20, 0, 1], [0, 20, 4096, 1], [0, 20, 8192, 1], [0, 20, 12288, 1]]
    reads += [[0, 60, SDRAM_ROW + 4096 * bank, 8] for bank in range(4)]
    got = beats(replace(sdram(), look_ahead=look_ahead), reads)[0][4:]
    assert (got[0], got[-1]) == (72, 72 + 31 + 3 * lost)


def test_sdram_turnaround():
    memory = replace(sdram(), write_batch=1)
    got = beats(memory, [
        [0, 20, 0, 1],
        [0, 41, 0, 1],                  # the write at 44 delays the read after it by nothing
        # Read 64; write 69 (bus turned); read 70.
        [0, 60, 0, 1], [0, 61, 4, 1],
        # A write to the open row, 84; another row: precharge 87, activate 89, read 91.
        [0, 81, SDRAM_ROW, 1],
    ], [[0, 40, 8, 1], [0, 61, 8, 1], [0, 80, 8, 1]])[0]
    assert got == [30, 49, 68, 74, 95]


@pytest.mark.longer
def test_writes_wait_for_a_batch():
    """Reads go on while fewer writes than a batch are queued, then the batch goes as a whole."""
    memory = replace(sdram(), write_batch=4)
    reads = [[0, 20, 0, 1]] + [[0, 40, 16 * k, 4] for k in range(24)]
    few = beats(memory, reads, [[0, 44, 512, 12]])[0]
    assert few[1:] == list(range(48, 144))
    many = beats(memory, reads, [[0, 44, 512, 16]])[0]
    # One gap of the bus: 16 words written and the turnaround of 4 clocks.
    gaps = [b - a for a, b in zip(many[1:], many[2:])]
    assert sorted(gaps)[-2:] == [1, 1 + 16 + 4]


def test_sdram_refresh():
    # Due at memory clock 100, clock 99: precharge 100, refresh 102, activate 109, read 111.
    memory = replace(sdram(), refresh_interval=100)
    got = beats(memory, [[0, 20, 0, 1], [0, 97, 0, 1], [0, 130, 0, 1]])[0]
    assert got == [30, 115, 138]


@pytest.mark.parametrize("width", [32, 128])
def test_ddr3_reads(width):
    """At 4 memory clocks per clock: T = 4 clock + 4 when a command is scheduled, 12 after taken."""
    row = DDR3_ROW
    one = 16 * 8 // width               # words of an access
    got = beats(ddr3(), [
        [0, 20, 0, 1],                  # scheduled 32: T + 1 activate, + 6 read, + 10 data: 17 more
        [0, 50, 16, one],               # open: data at T + 11; a narrow port takes 4 clocks
        [0, 80, row, 1],                # precharge T + 1, + 6 activate, + 6 read, + 10: T + 23
        # Two rows of one bank: activate T + 1, read T + 7; precharge T + 16 (ras), activate
        # T + 22, read T + 28, data T + 38, ten clocks.
        [0, 110, 2048, 1], [0, 110, row + 2048, 1],
    ], width=width, clocks=150)[0]
    assert got == [37, *range(65, 65 + one), 98, 127, 132]


def test_ddr3_turnaround():
    # The write is scheduled at 52, T + 1; the read after it 13 clocks later, T + 14, data T + 24.
    memory = replace(ddr3(), write_batch=1)
    got = beats(memory, [[0, 20, 0, 1], [0, 41, 0, 1]], [[0, 40, 16, 1]], width=128)[0]
    assert got == [37, 58]


def test_ddr3_four_activates():
    # Five closed banks: activates at T + 1, + 5, + 9, + 13 (rrd), the fifth at + 21 (faw), if no
    # read takes its slot; reads 6 later. One slot further where the bus has a command.
    got = beats(ddr3(), [[0, 20, 2048 * bank, 1] for bank in range(5)], width=128)[0]
    assert got == [37, 38, 39, 40, 42]


def test_ddr3_at_150_mhz():
    # 8/3 memory clocks per clock: taken 20, scheduled 36, T = floor(37 * 8/3) = 98; data 98 + 17 =
    # 115, which is T at (clock + 1) * 8/3 >= 115: clock 43.
    assert beats(ddr3(150), [[0, 20, 0, 1]], width=128)[0] == [43]


def test_ddr3_streams_a_word_per_clock():
    got = beats(ddr3(), [[0, 20, 256 * k, 16] for k in range(6)], width=128)[0]
    assert len(got) == 96 and got[-1] - got[0] == 95


def test_wide_port_of_a_narrow_memory():
    """A word of 128 bits is four accesses of 4 bytes."""
    got = beats(sdram(), [[0, 20, 0, 1], [0, 40, 16, 4]], width=128)[0]
    assert got == [33, 51, 55, 59, 63]


@pytest.mark.parametrize("rule,planted", [
    ("rcd", ("at + rcd;", "at + rcd - 1;")),
    ("rp", ("activate_from[bank], at + rp)", "activate_from[bank], at + rp - 1)")),
    ("ras", ("at + ras;", "at + 1;")),
    ("rc", ("at + rc;", "at;")),
    ("rrd", ("at + rrd;", "at + rrd - 1;")),
    ("faw", ("at + faw;", "at + faw - 1;")),
    ("column", ("(write ? write_to_read : 0)", "0")),
    ("column", ("(write ? 0 : read_to_write)", "0")),
    ("column", ("read_from = at + length", "read_from = at + 1")),
    ("write-precharge", ("write ? write_to_precharge :", "write ? 1 :")),
    ("read-precharge", ("at + length + (write ? write_to_precharge : 0));",
                        "at + (write ? length + write_to_precharge : 0));")),
    ("row", ("row_of[bank] != row", "row_of[bank] > row")),
    ("refresh", ("at + refresh;", "at + refresh - 1;")),
    ("refresh-open", ("issue(PRECHARGE_ALL, 0, 0, 0);", "")),
    ("refresh-late", ("refresh_due + refresh_interval", "refresh_due + 3 * refresh_interval")),
])
def test_the_checker_sees_a_planted_violation(rule, planted):
    with pytest.raises(SimulationError, match=f"AVALON-ERROR memory {rule} "):
        busy(rule, planted=planted)


@pytest.mark.parametrize("rule", ["", "rc", "rrd"])
def test_the_checker_is_silent_otherwise(rule):
    assert len(busy(rule)) == 16


def busy(rule, **options):
    """Accesses that run into every limit; rc and rrd only if they are longer than their rivals."""
    row = DDR3_ROW
    reads = [[0, 20, 0, 1], [0, 50, row, 1], [0, 50, 2 * row, 1], [0, 51, row, 1], [0, 70, 0, 1]]
    reads += [[0, 100, 2048 * bank, 1] for bank in range(1, 6)]
    reads += [[0, 130, 0, 2], [0, 131, 32, 1], [0, 132, row, 1], [0, 172, 0, 1], [0, 173, 16, 1]]
    writes = [[0, 131, 64, 2], [0, 135, row + 64, 1], [0, 150, 0, 1], [0, 171, 64, 1]]
    memory = replace(ddr3(), refresh_interval=200, write_batch=1, rc=30 if rule == "rc" else 21,
                     rrd=6 if rule == "rrd" else 4)
    return beats(memory, reads, writes, width=128, clocks=400, **options)[0]

"""Parameters of memory timing for the prediction and the simulation of corrected frames.

The Verilog model (``sim/ncdc_sim/hdl``) and the predictor have separate code for them.
"""

import math
import re
from dataclasses import dataclass, replace
from fractions import Fraction

from ncdc_spec.errors import InputError

__all__ = ["DramMemory", "LatencyMemory", "MEMORIES", "MEMORY_NAMES", "ddr3", "ddr3_1066", "hps",
           "memory_at", "memory_timing", "sdram"]

MAX_PENDING = 64        # read commands that the port's model can queue


@dataclass(frozen=True)
class LatencyMemory:
    """A memory that is a latency and a rate, without rows and banks.

    A read command accepted at clock edge t delivers its first word at edge t + latency at the
    earliest, and at most one word per clock. Words consume a credit of ``bytes_per_clock``, which
    is limited to two words or a granule.

    Parameters
    ----------
    latency : (int, int)
        Range of clocks, both ends included, drawn at random for each command; 1..10000.
    bytes_per_clock : float or None
        Bytes per clock of all ports together; None: every port moves a word per clock.
    granule : int
        Minimum cost of a read in bytes.
    wait_probability : int
        Probability in 256ths that a port stalls commands in a clock; 0..255.
    max_pending : int
        Read commands that one port queues before it stalls more, 1..64.

    Raises
    ------
    InputError
        If a value is out of its range.
    """
    latency: tuple = (1, 1)
    bytes_per_clock: float | None = None
    granule: int = 1
    wait_probability: int = 0
    max_pending: int = MAX_PENDING

    def __post_init__(self):
        low, high = self.latency
        if not 1 <= low <= high <= 10000:
            raise InputError(f"the memory's latency is {low}..{high} clocks, "
                             "the limits are 1 and 10000")
        if self.bytes_per_clock is not None and not 0.01 <= self.bytes_per_clock <= 64:
            raise InputError(f"the memory's rate is {self.bytes_per_clock:g} bytes per clock, "
                             "the limits are 0.01 and 64")
        if not 0 <= self.wait_probability <= 255:
            raise InputError(f"wait_probability is {self.wait_probability}, "
                             "the limits are 0 and 255")
        _check_pending(self.max_pending)


@dataclass(frozen=True)
class DramMemory:
    """A dynamic memory with rows, banks and refresh, and its controller.

    Intervals are in clocks of the memory (MC); the corrector's clock edge k falls on memory clock
    T(k) = floor(k * ratio). Rules:

    - The byte address is row, bank, column from the top: bank = address / row_bytes mod banks.
    - An *access* is a column command; it moves bytes of one block of ``access_bytes`` aligned
      bytes. A read command is split into the accesses that hold its bytes. The data of an access
      occupies ``word_clocks`` for each of the words of ``word_bytes`` that it touches, n in all.
    - A command accepted at edge t may be scheduled from edge t + ``controller_clocks`` on. At each
      edge at most one access is scheduled, and only if the column command of the access
      ``look_ahead`` earlier has been issued: column(n - look_ahead) <= T(k).
    - Its commands go to the memory at the first free memory clocks after T(k), one command per
      memory clock: precharge (if another row is open) no earlier than activate + ``ras``,
      read + n and write + n + ``write_to_precharge`` of that bank; activate (if
      its row is not open) no earlier than precharge + ``rp``, activate of that bank + ``rc``,
      activate of any bank + ``rrd``, fourth last activate + ``faw``; column command no earlier
      than activate + ``rcd`` and, after the previous column command, n (same direction),
      n + ``read_to_write`` or n + ``write_to_read``. Column commands keep the order of scheduling;
      rows stay open.
    - Data that ends with the j-th word (1, 2 ...) that a read touches is on the port at the first
      edge k with T(k) >= read + ``cas_latency`` + j ``word_clocks`` that is also after the port's
      previous word.
    - Each ``refresh_interval`` a refresh is scheduled before other accesses: all banks are
      precharged by one command (under the bounds above, and after all scheduled commands), ``rp``
      later the refresh, and activates wait ``refresh`` clocks from it.
    - Read ports are served round-robin by command. Writes start when ``write_batch`` accesses are
      queued and no read can be scheduled or as many have been since the last write; or at once
      while no port holds a read command. Reads start again when one can be scheduled and
      ``write_batch`` writes have been scheduled or none can be.

    Parameters
    ----------
    period : Fraction
        Memory clock, ns.
    clock : Fraction
        The corrector's clock, MHz.
    banks, row_bytes, access_bytes, word_bytes, word_clocks, cas_latency : int
    rcd, rp, ras, rc, rrd, faw, read_to_write, write_to_read, write_to_precharge, refresh,
    refresh_interval : int
    controller_clocks : int
        Latency in clocks of the corrector.
    look_ahead, write_batch, max_pending : int

    Raises
    ------
    InputError
        If a value is out of its range.
    """
    period: Fraction
    clock: Fraction
    banks: int
    row_bytes: int
    access_bytes: int
    word_bytes: int
    word_clocks: int
    cas_latency: int
    rcd: int
    rp: int
    ras: int
    rc: int
    rrd: int
    faw: int
    read_to_write: int
    write_to_read: int
    write_to_precharge: int
    refresh: int
    refresh_interval: int
    controller_clocks: int
    look_ahead: int
    write_batch: int
    max_pending: int

    def __post_init__(self):
        _check_pending(self.max_pending)

    @property
    def ratio(self):
        """Memory clocks per clock of the corrector, a Fraction."""
        return 1000 / (self.clock * self.period)


def _check_pending(value):
    if not 1 <= value <= MAX_PENDING:
        raise InputError(f"max_pending is {value}, the limits are 1 and {MAX_PENDING}")


def sdram(clock=100):
    """Two IS42S16320 (512 Mbit, x16) side by side, as on the DE2-115: single data rate, 32 bit,
    4 banks of 4 KB rows, CAS latency 3, clocked with the corrector at ``clock`` MHz.

    20 ns, 20 ns and 70 ns for rcd, rp and refresh: LiteDRAM's table of this part. 42, 63 and
    14 ns for ras, rc and rrd, write recovery 14 ns, 8192 refreshes in 64 ms: data sheets of
    512 Mbit parts of the speed grade -7 (Alliance AS4C32M16SB). Bursts of four words, truncated by
    the next command where fewer are needed; the bus is idle for one clock between read and written
    data. With the controller's 3 clocks a read of an open row has its first word after 8 clocks,
    as measured on LiteDRAM's native port.

    Raises
    ------
    InputError
        If the memory cannot be clocked that fast.
    """
    clock = _clock(clock, 20, 143, "sdram")
    period, cas = 1000 / clock, 3

    def clocks(ns):
        return math.ceil(ns / period)

    return DramMemory(
        period=period, clock=clock, banks=4, row_bytes=4096, access_bytes=16, word_bytes=4,
        word_clocks=1, cas_latency=cas, rcd=clocks(20), rp=clocks(20), ras=clocks(42),
        rc=clocks(63), rrd=clocks(14), faw=0, read_to_write=cas + 1, write_to_read=0,
        write_to_precharge=clocks(14), refresh=clocks(70),
        refresh_interval=math.floor(Fraction(64_000_000, 8192) / period),
        controller_clocks=3, look_ahead=4, write_batch=16, max_pending=8)


def ddr3(clock=100):
    """One DDR3-800 of 2 Gbit, x16, with a controller at ``clock`` MHz: 400 MHz, bursts of 8
    (16 bytes), 8 banks of 2 KB rows.

    Controller: 12, 16 and 20 clocks at 100, 150 and 200 MHz. Intervals as of :func:`_ddr3`.

    Raises
    ------
    InputError
        If the clock is out of its range.
    """
    return _ddr3(_clock(clock, 20, 400, "ddr3"), Fraction(5, 2))


def ddr3_1066(clock=100):
    """One DDR3-1066 of 2 Gbit, x16, whose clock is four times that of its controller, ``clock``
    MHz: each burst of 8 (16 bytes) takes one clock of the controller.

    Speed bin 1066G (8-8-8), whose intervals in nanoseconds are those of :func:`ddr3`. At 100 MHz
    the two memories have the same timing.

    Raises
    ------
    InputError
        If the clock is out of its range: the memory's period must be 1.875 to 3.3 ns.
    """
    clock = _clock(clock, 76, 133, "ddr3-1066")
    return _ddr3(clock, 250 / clock)


def _ddr3(clock, period):
    """A DDR3 of 2 Gbit, x16, with a memory clock of ``period`` ns, its controller at ``clock``
    MHz.

    JESD79-3, speed bins 800E and 1066G, 2 KB pages: rcd and rp 15 ns, ras 37.5 ns, rc 52.5 ns,
    rrd 10 ns but at least 4 clocks, faw 50 ns, write recovery 15 ns, write to read 7.5 ns but at
    least 4 clocks, refresh 160 ns, 8192 in 64 ms. CAS latency and CAS write latency are 6 and 5
    for periods of 2.5 ns and more, 8 and 6 for shorter ones.
    """
    def clocks(ns, minimum=0):
        return max(minimum, math.ceil(Fraction(ns) / period))

    cas, write = (6, 5) if period >= Fraction(5, 2) else (8, 6)
    return DramMemory(
        period=period, clock=clock, banks=8, row_bytes=2048, access_bytes=16, word_bytes=16,
        word_clocks=4, cas_latency=cas, rcd=clocks(15), rp=clocks(15), ras=clocks(37.5),
        rc=clocks(52.5), rrd=clocks(10, 4), faw=clocks(50), read_to_write=cas - write + 2,
        write_to_read=write + clocks(7.5, 4), write_to_precharge=write + clocks(15),
        refresh=clocks(160), refresh_interval=math.floor(Fraction(64_000_000, 8192) / period),
        controller_clocks=4 + round(clock * 8 / 100), look_ahead=8, write_batch=16,
        max_pending=32)


def hps(clock=100):
    """The DDR3 of a Cyclone V SoC at the ports from the FPGA to its hard memory controller, as on
    the DE10-Nano: two DDR3-800 of 4 Gbit, x16, side by side, ports at ``clock`` MHz.

    Chips as :func:`ddr3`'s, except for the refresh of 4 Gbit, 260 ns (JESD79-3); a burst of 8 moves
    32 bytes. The "Cyclone V Hard Processor System Technical Reference Manual" (683126, version
    21.2) states these rules for the ports: bursts have 1 to 1024 words, a power of two at most
    (12.12.1.1); a full command queue stalls the next command (12.5.1); ports of equal priority are
    served round-robin by SDRAM burst (12.6.2), reads before writes, the oldest first (12.6.3).
    It does not state latency and queue depth: assumed are 24 clocks to the controller and back at
    100 MHz, twice those of :func:`ddr3`, and 8 commands.

    Raises
    ------
    InputError
        If the clock is out of its range.
    """
    one = ddr3(clock)
    return replace(one, row_bytes=2 * one.row_bytes, access_bytes=2 * one.access_bytes,
                   word_bytes=2 * one.word_bytes, refresh=math.ceil(260 / one.period),
                   controller_clocks=2 * one.controller_clocks, max_pending=8)


def _clock(clock, lowest, highest, name):
    clock = Fraction(clock).limit_denominator(1000)
    if not lowest <= clock <= highest:
        raise InputError(f"the clock of {name} is {float(clock):g} MHz, "
                         f"the limits are {lowest} and {highest}")
    return clock


# ``hostile`` models no real memory: it is for finding faults.
MEMORIES = {
    "ideal": LatencyMemory(),
    "sdram": sdram(),
    "ddr3": ddr3(),
    "ddr3-1066": ddr3_1066(),
    "hps": hps(),
    "hostile": LatencyMemory(latency=(1, 60), bytes_per_clock=6, granule=4, wait_probability=128,
                             max_pending=4),
}
_FIXED = re.compile(r"fixed:(\d+):(\d+(?:\.\d+)?)")
# Those whose timing in clocks depends on the corrector's clock.
_BY_CLOCK = {"sdram": sdram, "ddr3": ddr3, "ddr3-1066": ddr3_1066, "hps": hps}
_CLOCKED = re.compile(rf"({'|'.join(_BY_CLOCK)})@(\d+(?:\.\d+)?)")
MEMORY_NAMES = (f"{', '.join(MEMORIES)}, {', '.join(f'{name}@MHZ' for name in _BY_CLOCK)}, "
                "fixed:LATENCY:BYTES (clocks, bytes per clock)")
"""Names that :func:`memory_timing` accepts, for people."""


def memory_timing(memory, others=()):
    """The memory of a name; a memory is returned as it is.

    Names: those of :data:`MEMORIES`; ``sdram@MHZ``, ``ddr3@MHZ`` and so on at another clock of the
    corrector; ``fixed:LATENCY:BYTES`` with a fixed latency in clocks and bytes per clock.
    ``others`` are further names of the caller, for the error message.

    Raises
    ------
    InputError
        If there is none of that name, or a value is out of its range.
    """
    if not isinstance(memory, str):
        return memory
    if memory in MEMORIES:
        return MEMORIES[memory]
    if match := _FIXED.fullmatch(memory):
        latency = int(match[1])
        return LatencyMemory(latency=(latency, latency), bytes_per_clock=float(match[2]))
    if match := _CLOCKED.fullmatch(memory):
        return _BY_CLOCK[match[1]](Fraction(match[2]))
    names = [*MEMORIES, *others, *(f"{name}@MHZ" for name in _BY_CLOCK)]
    raise InputError(f"memory is {memory!r}, one of {', '.join(names)} or fixed:LATENCY:BYTES is "
                     "needed")


def memory_at(memory, clock_mhz):
    """The memory of a name, as :func:`memory_timing`, for a corrector of ``clock_mhz``."""
    clocked = isinstance(memory, str) and memory in _BY_CLOCK
    return memory_timing(f"{memory}@{clock_mhz:g}" if clocked else memory)

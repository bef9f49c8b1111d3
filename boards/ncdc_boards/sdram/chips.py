"""SDR SDRAM chips as data: their sizes, and their times in ns, each with its source.

How to add one: docs/reference/sdram.md.
"""

from dataclasses import dataclass, replace
from fractions import Fraction

from ncdc_spec.errors import InputError

__all__ = ["AS4C16M16SA_6", "AS4C16M16SA_7", "CHIPS", "IS42S16160B_7", "IS42S16160G_7",
           "IS42S16320D_6", "IS42S16320D_7", "M12L64322A_7", "MT48LC16M16A2_75",
           "MT48LC16M16A2_7E", "SdramChip", "SdramTiming", "ULX3S_32MB", "W9825G6KH_6",
           "clocks_of", "in_parallel", "slowest"]


@dataclass(frozen=True)
class SdramChip:
    """A chip of four banks, or several side by side that share their command pins.

    Parameters
    ----------
    name : str
        With its speed grade.
    data_bits, row_bits, column_bits : int
        Width of DQ; bits of a row's and of a column's number.
    rcd, rp, ras, rc, rfc, wr, rrd, mrd : number
        Minimum times in ns, by the data sheet's names (tRCD ...): ACTIVE to READ or WRITE;
        PRECHARGE to ACTIVE; ACTIVE to PRECHARGE; ACTIVE to ACTIVE of a bank; AUTO REFRESH to the
        next command; last data written to PRECHARGE; ACTIVE to ACTIVE of another bank; LOAD MODE
        REGISTER to the next command.
    ras_max : number
        Longest time that a row may stay open, in ns.
    refresh : number
        Longest average time in ns between two AUTO REFRESH commands (tREFI).
    cas : tuple of (int, number)
        CAS latency, and its shortest clock period in ns.
    source : str
    wr_clocks, mrd_clocks : int
        Minimum clocks of ``wr`` and ``mrd`` where the data sheet counts them in clocks.
    pause : number
        Time in us from power and clock to the first command.
    refreshes : int
        AUTO REFRESH commands of the initialisation.
    refresh_cycles : int
        AUTO REFRESH commands that reach every row; so many must come within 64 ms.
    """
    name: str
    data_bits: int
    row_bits: int
    column_bits: int
    rcd: float
    rp: float
    ras: float
    rc: float
    rfc: float
    wr: float
    rrd: float
    mrd: float
    ras_max: float
    refresh: float
    cas: tuple
    source: str
    wr_clocks: int = 2
    mrd_clocks: int = 2
    pause: float = 200
    refreshes: int = 8
    refresh_cycles: int = 8192

    bank_bits = 2

    @property
    def bytes(self):
        """Size of the memory."""
        return self.data_bits // 8 << self.bank_bits + self.row_bits + self.column_bits


@dataclass(frozen=True)
class SdramTiming:
    """The times of a chip in clocks, by the names of :class:`SdramChip`.

    Minimum times are rounded up, ``ras_max`` and ``refresh`` down. ``cas`` is the CAS latency.
    """
    rcd: int
    rp: int
    ras: int
    rc: int
    rfc: int
    wr: int
    rrd: int
    mrd: int
    ras_max: int
    refresh: int
    pause: int
    cas: int


def clocks_of(chip, clock_hz, cas=None):
    """:class:`SdramTiming` of the ``chip`` at a clock.

    ``cas`` is the CAS latency; None: the chip's longest, which has the shortest access time and
    so leaves most time for the board's delays.

    Raises
    ------
    InputError
        If the chip has no such CAS latency, or not at this clock, or the clock is no positive
        number.
    """
    if not clock_hz > 0:
        raise InputError(f"the SDRAM's clock is {clock_hz} Hz; it must be above 0")
    period = Fraction(10**9) / Fraction(clock_hz)       # ns
    latencies = dict(chip.cas)
    cas = max(latencies) if cas is None else cas
    if cas not in latencies:
        raise InputError(f"the CAS latency is {cas}; {chip.name} has "
                         + " and ".join(map(str, latencies)))
    if period < Fraction(str(latencies[cas])):
        raise InputError(f"the SDRAM's clock is {clock_hz / 1e6:g} MHz; with CAS latency {cas} "
                         f"{chip.name} goes up to {1000 / latencies[cas]:.1f} MHz")

    def at_least(time, clocks=1):
        return max(clocks, -(-Fraction(str(time)) // period))

    def at_most(time):
        return int(Fraction(str(time)) // period)

    return SdramTiming(
        rcd=at_least(chip.rcd), rp=at_least(chip.rp), ras=at_least(chip.ras), rc=at_least(chip.rc),
        rfc=at_least(chip.rfc), wr=at_least(chip.wr, chip.wr_clocks), rrd=at_least(chip.rrd),
        mrd=at_least(chip.mrd, chip.mrd_clocks), ras_max=at_most(chip.ras_max),
        refresh=at_most(chip.refresh), pause=at_least(1000 * chip.pause), cas=cas)


def in_parallel(chip, count):
    """``count`` equal chips with common commands and ``count`` times the data."""
    return chip if count == 1 else replace(chip, name=f"{count} x {chip.name}",
                                           data_bits=count * chip.data_bits)


def slowest(name, *chips):
    """Slowest timing of all ``chips``, for a board that is made with any of them.

    Raises
    ------
    InputError
        If they differ in size, or in how often their rows are refreshed.
    """
    if len({(chip.data_bits, chip.row_bits, chip.column_bits, chip.refresh_cycles)
            for chip in chips}) != 1:
        raise InputError(f"{name}: chips of different size cannot stand for each other: "
                         + ", ".join(chip.name for chip in chips))
    largest = {key: max(getattr(chip, key) for chip in chips) for key in
               ("rcd", "rp", "ras", "rc", "rfc", "wr", "rrd", "mrd", "wr_clocks", "mrd_clocks",
                "pause", "refreshes")}
    cas = tuple((latency, max(dict(chip.cas)[latency] for chip in chips))
                for latency, _ in chips[0].cas if all(latency in dict(chip.cas) for chip in chips))
    return replace(chips[0], name=name, cas=cas,
                   ras_max=min(chip.ras_max for chip in chips),
                   refresh=min(chip.refresh for chip in chips),
                   source="the slowest of " + ", ".join(chip.name for chip in chips), **largest)


_16M = {"data_bits": 16, "row_bits": 13, "column_bits": 9}
_32M = {"data_bits": 16, "row_bits": 13, "column_bits": 10}
_8K_IN_64_MS = 64e6 / 8192      # ns

# DE2-115 (two), DE1-SoC, DE0-CV, DE10-Lite.
IS42S16320D_7 = SdramChip(
    "IS42S16320D-7", **_32M, rcd=15, rp=15, ras=37, rc=60, rfc=60, wr=14, rrd=14, mrd=14,
    ras_max=100_000, refresh=_8K_IN_64_MS, cas=((2, 10), (3, 7)),
    source="ISSI, IS42S16320D, revision B, 05/2015, AC electrical characteristics, as two public "
           "controllers for the chip have them")
IS42S16320D_6 = replace(
    IS42S16320D_7, name="IS42S16320D-6", rcd=18, rp=18, ras=42, wr=12, rrd=12, mrd=12,
    cas=((2, 10), (3, 6)))
# ULX3S, DE0-Nano of later years.
IS42S16160G_7 = SdramChip(
    "IS42S16160G-7", **_16M, rcd=15, rp=15, ras=37, rc=60, rfc=60, wr=14, rrd=14, mrd=14,
    ras_max=100_000, refresh=_8K_IN_64_MS, cas=((2, 10), (3, 7)),
    source="ISSI, IS42S16160G, AC electrical characteristics, as in public controllers; "
           "tRRD, tWR and tRFC as of the IS42S16320D of the same grade")
# DE0-Nano.
IS42S16160B_7 = SdramChip(
    "IS42S16160B-7", **_16M, rcd=20, rp=20, ras=45, rc=67.5, rfc=70, wr=20, rrd=15, mrd=15,
    ras_max=100_000, refresh=_8K_IN_64_MS, cas=((2, 10), (3, 7)),
    source="ISSI, IS42S16160B, revision D, 07/2008, for sizes and CAS latencies; its times are "
           "those of LiteDRAM's IS42S16160, and of the slowest grade of this family where it has "
           "none")
AS4C16M16SA_7 = SdramChip(
    "AS4C16M16SA-7", **_16M, rcd=21, rp=21, ras=42, rc=63, rfc=63, wr=14, rrd=14, mrd=14,
    ras_max=120_000, refresh=7_800, cas=((2, 10), (3, 7)),
    source="Alliance Memory, AS4C16M16SA-C&I, revision 3.0, 03/2015, table 16")
AS4C16M16SA_6 = replace(
    AS4C16M16SA_7, name="AS4C16M16SA-6", rcd=18, rp=18, rc=60, rfc=60, wr=12, rrd=12, mrd=12,
    cas=((2, 10), (3, 6)))
MT48LC16M16A2_75 = SdramChip(
    "MT48LC16M16A2-75", **_16M, rcd=20, rp=20, ras=44, rc=66, rfc=66, wr=15, rrd=15, mrd=15,
    ras_max=120_000, refresh=_8K_IN_64_MS, cas=((2, 10), (3, 7.5)),
    source="Micron, 256 Mb SDRAM, AC operating conditions, as LiteDRAM and public controllers for "
           "the family have them")
MT48LC16M16A2_7E = replace(
    MT48LC16M16A2_75, name="MT48LC16M16A2-7E", rcd=15, rp=15, ras=37, rc=60, wr=14, rrd=14,
    mrd=14, cas=((2, 7.5), (3, 7)))
W9825G6KH_6 = SdramChip(
    "W9825G6KH-6", **_16M, rcd=18, rp=18, ras=42, rc=60, rfc=72, wr=12, rrd=12, mrd=12,
    ras_max=100_000, refresh=_8K_IN_64_MS, cas=((2, 10), (3, 6)),
    source="Winbond, W9825G6KH; times rounded up to those of the other chips of grade 6, tRFC to "
           "its tXSR")
# Colorlight i9.
M12L64322A_7 = SdramChip(
    "M12L64322A-7", data_bits=32, row_bits=11, column_bits=8, rcd=21, rp=21, ras=42, rc=63, rfc=63,
    wr=14, rrd=14, mrd=14, ras_max=100_000, refresh=64e6 / 4096, refresh_cycles=4096,
    cas=((2, 10), (3, 7)),
    source="ESMT, M12L64322A (2S), revision 1.0, 12/2015, AC characteristics; the slowest grade")
# The ULX3S is made with one or another of these.
ULX3S_32MB = slowest("any 32 MB chip of the ULX3S", IS42S16160G_7, AS4C16M16SA_7, W9825G6KH_6,
                     MT48LC16M16A2_7E)

CHIPS = {chip.name: chip for chip in (
    IS42S16320D_6, IS42S16320D_7, IS42S16160B_7, IS42S16160G_7, AS4C16M16SA_6, AS4C16M16SA_7,
    MT48LC16M16A2_75, MT48LC16M16A2_7E, W9825G6KH_6, M12L64322A_7)}

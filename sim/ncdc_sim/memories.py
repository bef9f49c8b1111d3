"""Timing of the simulated memory: presets by name."""

from dataclasses import dataclass

from ncdc_model.errors import InputError

__all__ = ["MEMORIES", "MemoryTiming", "memory_timing"]


@dataclass(frozen=True)
class MemoryTiming:
    """What the memory model ``avalon_memory`` is set to.

    Parameters
    ----------
    latency : (int, int)
        Clocks from an accepted read command to its first data at the earliest, drawn anew for
        each command from this range, both ends included.
    bytes_per_clock : float or None
        Bytes that all ports together move per clock; None: every port moves a word per clock.
    granule : int
        Bytes that a read costs at least.
    wait_chance : int
        How often, of 256 clocks, a port refuses commands for no reason.
    max_pending : int
        Read commands that one port holds before it refuses more, 1..64.
    """
    latency: tuple = (1, 1)
    bytes_per_clock: float | None = None
    granule: int = 1
    wait_chance: int = 0
    max_pending: int = 64

    def plusargs(self, data_width, ports):
        """Settings of the bench for words of ``data_width`` bits and ``ports`` read ports."""
        word = data_width // 8
        rate = 256 * (ports + 1) if self.bytes_per_clock is None else max(
            1, round(256 * self.bytes_per_clock / word))
        return {"latency_min": self.latency[0], "latency_max": self.latency[1], "rate": rate,
                "granule": -(-self.granule // word), "wait_chance": self.wait_chance,
                "max_pending": self.max_pending}


# The two real memories are averages, without rows, banks and refresh. Anchors: a 32-bit
# single-data-rate SDRAM and a 16-bit DDR3-800, both behind a controller at 100 MHz, deliver their
# first word after about 10 and 20 clocks and 70-95 % of 4 and 16 bytes per clock.
MEMORIES = {
    "ideal": MemoryTiming(),
    "sdram": MemoryTiming(latency=(10, 14), bytes_per_clock=0.8 * 4, granule=4, max_pending=8),
    "ddr3": MemoryTiming(latency=(20, 30), bytes_per_clock=0.8 * 16, granule=16, max_pending=16),
    "hostile": MemoryTiming(latency=(1, 60), bytes_per_clock=6, granule=4, wait_chance=128,
                            max_pending=4),
}


def memory_timing(memory):
    """The preset of that name; a :class:`MemoryTiming` is returned as it is.

    Raises
    ------
    InputError
        If there is no preset of that name, or a value is out of its range.
    """
    if isinstance(memory, str):
        if memory not in MEMORIES:
            raise InputError(f"memory is {memory!r}, one of {', '.join(MEMORIES)} is needed")
        memory = MEMORIES[memory]
    low, high = memory.latency
    if not 1 <= low <= high <= 10000:
        raise InputError(f"the memory's latency is {low}..{high} clocks, "
                         "the limits are 1 and 10000")
    if not 1 <= memory.max_pending <= 64:
        raise InputError(f"max_pending is {memory.max_pending}, the limits are 1 and 64")
    if not 0 <= memory.wait_chance <= 255:
        raise InputError(f"wait_chance is {memory.wait_chance}, the limits are 0 and 255")
    return memory

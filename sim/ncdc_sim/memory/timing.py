"""The memories that a frame is simulated with."""

from ncdc_model.planner.memory_timing import DramMemory, memory_timing
from ncdc_sim.memory.litedram import LITEDRAM

__all__ = ["memory_settings", "simulated_memory"]

_SAME = ("word_clocks", "cas_latency", "rcd", "rp", "ras", "rc", "rrd", "faw", "read_to_write",
         "write_to_read", "write_to_precharge", "refresh", "refresh_interval", "look_ahead",
         "controller_clocks", "write_batch", "max_pending")


def simulated_memory(memory):
    """The memory of a name: a controller of :data:`ncdc_sim.memory.litedram.LITEDRAM`, or whatever
    :func:`ncdc_model.planner.memory_timing.memory_timing` knows; a memory is returned as it is.

    Raises
    ------
    InputError
        If there is none of that name, or a value is out of its range.
    """
    if isinstance(memory, str) and memory in LITEDRAM:
        return LITEDRAM[memory]
    return memory_timing(memory, others=LITEDRAM)


def memory_settings(memory, data_width, ports):
    """Plusargs of ``avalon_memory`` that make it the ``memory`` for words of ``data_width`` bits.

    Parameters
    ----------
    memory : LatencyMemory or DramMemory
    data_width, ports : int
        Bits of a word; read ports.
    """
    if isinstance(memory, DramMemory):
        return {"dram": 1, "ratio_mul": memory.ratio.numerator,
                "ratio_div": memory.ratio.denominator, "bank_bits": _log2(memory.banks),
                "column_bits": _log2(memory.row_bytes), "access_bits": _log2(memory.access_bytes),
                "word_bits": _log2(memory.word_bytes),
                **{name: getattr(memory, name) for name in _SAME}}
    word = data_width // 8
    rate = 256 * (ports + 1) if memory.bytes_per_clock is None else max(
        1, round(256 * memory.bytes_per_clock / word))
    return {"dram": 0, "latency_min": memory.latency[0], "latency_max": memory.latency[1],
            "rate": rate, "granule": -(-memory.granule // word),
            "wait_probability": memory.wait_probability, "max_pending": memory.max_pending}


def _log2(value):
    return value.bit_length() - 1

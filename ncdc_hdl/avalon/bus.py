"""Avalon-MM interfaces (Intel, "Avalon Interface Specifications"), as the gateware uses them."""

from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from ncdc_spec.frames import ADDRESS_BITS

__all__ = ["Agent", "ADDRESS_BITS", "PENDING", "ReadHost", "WriteHost"]

PENDING = 16
"""Most write bursts that wait for their answers at a time, if the memory answers."""


class ReadHost(wiring.Signature):
    """Pipelined burst reads: byte address, variable latency, data never stalled.

    Parameters: ``data_width`` in bits, ``max_burst`` in words.
    """

    def __init__(self, data_width, max_burst):
        self.max_burst = max_burst
        super().__init__({
            "address": Out(ADDRESS_BITS), "read": Out(1), "burstcount": Out(range(max_burst + 1)),
            "waitrequest": In(1), "readdata": In(data_width), "readdatavalid": In(1),
        })


class WriteHost(wiring.Signature):
    """Burst writes: byte address, one word per accepted clock.

    Parameters: ``data_width`` in bits, ``max_burst`` in words. With ``pending``, bursts that may
    wait for an answer at a time, the agent answers each burst in order once its words are in
    memory. It gives ``writeresponsevalid`` for a clock, and ``response`` is not 0 if it has failed.
    """

    def __init__(self, data_width, max_burst, pending=0):
        self.max_burst, self.pending = max_burst, pending
        super().__init__({
            "address": Out(ADDRESS_BITS), "write": Out(1), "burstcount": Out(range(max_burst + 1)),
            "writedata": Out(data_width), "byteenable": Out(data_width // 8),
            "waitrequest": In(1),
        } | ({"writeresponsevalid": In(1), "response": In(2)} if pending else {}))


class Agent(wiring.Signature):
    """32-bit register access by word address; reads answer with ``readdatavalid``."""

    def __init__(self, address_bits):
        super().__init__({
            "address": Out(address_bits), "read": Out(1), "write": Out(1), "writedata": Out(32),
            "readdata": In(32), "readdatavalid": In(1), "waitrequest": In(1),
        })

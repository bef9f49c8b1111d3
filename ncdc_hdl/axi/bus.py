"""AXI interfaces (Arm, "AMBA AXI and ACE Protocol Specification" and "AXI4-Stream Protocol
Specification"), as the gateware uses them."""

from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from ncdc_hdl.avalon.bus import ADDRESS_BITS

__all__ = ["Lite", "PAGE_BITS", "ReadPort", "VideoStream", "WritePort", "burst_values"]

PAGE_BITS = 12
"""log2 of the bytes of a page, whose end no burst crosses (A3.4.1 of the specification)."""

_ID_BITS = 1                # all bursts have the ID 0, so that answers come in order

# The parameters of a burst, of AW and AR alike.
_BURST = {"id": _ID_BITS, "addr": ADDRESS_BITS, "len": 8, "size": 3, "burst": 2, "lock": 1,
          "cache": 4, "prot": 3, "qos": 4, "valid": 1}


def burst_values(data_width):
    """Constant parameters of every burst of words of ``data_width`` bits, by name.

    Addresses that rise by a word. Normal memory without caching or buffering, so that the answer
    to a write comes from the memory itself; unprivileged, secure data.
    """
    return {"id": 0, "size": (data_width // 8).bit_length() - 1, "burst": 0b01, "lock": 0,
            "cache": 0b0010, "prot": 0, "qos": 0}


class ReadPort(wiring.Signature):
    """AXI4 manager that only reads; ``data_width`` in bits."""

    def __init__(self, data_width):
        super().__init__(
            {f"ar{name}": Out(width) for name, width in _BURST.items()}
            | {"arready": In(1), "rid": In(_ID_BITS), "rdata": In(data_width), "rresp": In(2),
               "rlast": In(1), "rvalid": In(1), "rready": Out(1)})


class WritePort(wiring.Signature):
    """AXI4 manager that only writes; ``data_width`` in bits."""

    def __init__(self, data_width):
        super().__init__(
            {f"aw{name}": Out(width) for name, width in _BURST.items()}
            | {"awready": In(1), "wdata": Out(data_width), "wstrb": Out(data_width // 8),
               "wlast": Out(1), "wvalid": Out(1), "wready": In(1), "bid": In(_ID_BITS),
               "bresp": In(2), "bvalid": In(1), "bready": Out(1)})


class Lite(wiring.Signature):
    """AXI4-Lite manager of 32-bit registers; ``address_bits`` of its byte addresses."""

    def __init__(self, address_bits):
        super().__init__({
            "awaddr": Out(address_bits), "awprot": Out(3), "awvalid": Out(1), "awready": In(1),
            "wdata": Out(32), "wstrb": Out(4), "wvalid": Out(1), "wready": In(1),
            "bresp": In(2), "bvalid": In(1), "bready": Out(1),
            "araddr": Out(address_bits), "arprot": Out(3), "arvalid": Out(1), "arready": In(1),
            "rdata": In(32), "rresp": In(2), "rvalid": In(1), "rready": Out(1),
        })


class VideoStream(wiring.Signature):
    """AXI4-Stream of pixels of 24 bits, ``lanes`` at a time, as in AMD's video blocks:
    ``tuser`` with a frame's first pixel, ``tlast`` with a row's last."""

    def __init__(self, lanes):
        super().__init__({"tdata": Out(24 * lanes), "tuser": Out(1), "tlast": Out(1),
                          "tvalid": Out(1), "tready": In(1)})

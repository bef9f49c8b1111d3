"""Registers through the JTAG chain that configures the device."""

from amaranth import *
from amaranth.lib import data, wiring
from amaranth.lib.cdc import FFSynchronizer
from amaranth.lib.wiring import In, Out

from ncdc_hdl.registers.access import Access
from ncdc_spec.protocols.jtag_link import BITS, READ, WRITE

__all__ = ["DOMAIN", "JtagBridge", "Scan"]

DOMAIN = "jtag"
"""The JTAG chain's clock, which stops between scans."""


class Scan(wiring.Signature):
    """A data register of the chain, with a virtual TAP's states, in :data:`DOMAIN`.

    ``tdi``, ``tdo``: into the register's top bit, out of its lowest one. ``capture``, ``shift``,
    ``update``: the TAP is in this state.
    """

    def __init__(self):
        super().__init__({"tdi": Out(1), "tdo": In(1), "capture": Out(1), "shift": Out(1),
                          "update": Out(1)})


class JtagBridge(wiring.Component):
    """Answers scans of :mod:`ncdc_spec.protocols.jtag_link`, one request at a time.

    A request is stable in :data:`DOMAIN` until it is answered, an answer in ``sync`` until the
    next request: only their two flags cross, through synchronisers. As the chain's
    clock stops between scans, an answer may be seen only by the second scan after it. A
    request while another is under way is dropped, without an answer.

    Parameters
    ----------
    address_bits : int
        Bits of a word address, at most 16.

    Members
    -------
    scan : ``In(Scan())``
    access : ``Out(Access(address_bits))``
    """

    def __init__(self, address_bits):
        super().__init__({"scan": In(Scan()), "access": Out(Access(address_bits))})

    def elaborate(self, platform):
        m = Module()
        message = data.StructLayout({"word": 32, "address": 16, "tag": 8, "kind": 8})
        assert message.size == BITS
        scan, access = self.scan, self.access
        bits = Signal(BITS, reset_less=True)        # the data register
        request = Signal(message, reset_less=True)  # the last request
        asked = Signal(reset_less=True)             # changes with each request
        answered = Signal(reset_less=True)          # is `asked` once the request is answered
        answer = Signal(32, reset_less=True)        # the word that was read
        seen = Signal(reset_less=True)              # is `asked` once the answer was scanned out

        answered_here, kind = Signal(), message(bits).kind
        m.submodules.answered_cdc = FFSynchronizer(
            answered, answered_here, o_domain=DOMAIN, reset_less=True)
        m.d.comb += scan.tdo.eq(bits[0])
        with m.If(scan.capture):
            m.d[DOMAIN] += bits.eq(0)
            with m.If((answered_here == asked) & (seen != asked)):
                m.d[DOMAIN] += [bits.eq(request), seen.eq(asked)]
                with m.If(request.kind == READ):
                    m.d[DOMAIN] += message(bits).word.eq(answer)
        with m.Elif(scan.shift):
            m.d[DOMAIN] += bits.eq(Cat(bits[1:], scan.tdi))
        with m.Elif(scan.update & ((kind == READ) | (kind == WRITE)) & (answered_here == asked)):
            # The answer of an earlier one, if not yet read, is dropped.
            m.d[DOMAIN] += [request.eq(bits), asked.eq(~asked), seen.eq(asked)]

        asked_here = Signal()
        m.submodules.asked_cdc = FFSynchronizer(asked, asked_here, reset_less=True)
        m.d.comb += [
            access.valid.eq(asked_here != answered), access.write.eq(request.kind == WRITE),
            access.address.eq(request.address), access.word.eq(request.word),
        ]
        with m.If(access.done):
            m.d.sync += [answered.eq(asked_here), answer.eq(access.answer)]
        return m

"""Readers of both frame stores, controlled by registers."""

from amaranth import *
from amaranth.lib import data, wiring
from amaranth.lib.wiring import In, Out

__all__ = ["READER_STATE", "StoreReader"]

READER_STATE = data.StructLayout({"held": 1, "lost": 1, "corrected": 1, "buffer": 4})
"""State of a reader: whether it holds ``buffer``, or lost it, and the buffer's store."""


class StoreReader(wiring.Component):
    """One reader of raw and of corrected frames, which has at most one buffer of both.

    Members
    -------
    claim_raw, claim_corrected, release : ``In(1)``
        High for one clock; the first of several wins.
    stores : array of store
        Claim and release at the raw store and that of corrected frames, and their answers.
    state : ``Out(READER_STATE)``
    """
    def __init__(self, index_bits):
        store = wiring.Signature({"claim": Out(1), "release": Out(1), "held": In(1),
                                  "lost": In(1), "buffer": In(index_bits)})
        super().__init__({"claim_raw": In(1), "claim_corrected": In(1), "release": In(1),
                          "stores": Out(store).array(2), "state": Out(READER_STATE)})

    def elaborate(self, platform):
        m = Module()
        raw, corrected = self.stores
        which = Signal()            # the store of the last claim
        claim = Signal(2)
        m.d.comb += claim.eq(Cat(self.claim_raw, self.claim_corrected & ~self.claim_raw))
        with m.If(claim.any()):
            m.d.sync += which.eq(claim[1])
        any_request = claim.any() | self.release
        for k, store in enumerate(self.stores):
            m.d.comb += [store.claim.eq(claim[k]), store.release.eq(any_request & ~claim[k])]
        m.d.comb += [
            self.state.corrected.eq(which),
            self.state.held.eq(Mux(which, corrected.held, raw.held)),
            self.state.lost.eq(Mux(which, corrected.lost, raw.lost)),
            self.state.buffer.eq(Mux(which, corrected.buffer, raw.buffer)),
        ]
        return m

"""D-PHY of a CSI-2 receiver from the cells of an ECP5's pins."""

from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.cdc import FFSynchronizer
from amaranth.lib.wiring import In, Out

from ncdc_hdl.camera.csi2.burst_start import SETTLE_BITS, BurstCheck, Settling
from ncdc_hdl.camera.csi2.eye_search import EYE, EyeSearch
from ncdc_hdl.camera.csi2.layouts import LANE

__all__ = ["Ecp5Csi2Phy"]

_BITS = 4               # of an IDDRX2F


class Ecp5Csi2Phy(wiring.Component):
    """Deserialises the lanes, and finds the delay of each.

    The clock pair, half as fast as the bits, drives an edge clock (ECLKSYNCB) and a quarter of the
    bits' rate (CLKDIVF), with which an IDDRX2F gives four bits of a lane. A flip-flop halves that
    clock once more: ``clock`` has a rising edge for each byte. Bytes change with its falling edge:
    there are a whole period of the faster clock for their setup, and what is left of the other one
    by the way of ``clock`` to its network for their hold.

    That crossing needs no constraint, and nextpnr, for which the clocks are unrelated, takes none.
    Both clocks have one source. The paths lead from flip-flop to flip-flop, without logic: nextpnr
    reports 1.6 ns at most, of 8.8 ns at 456 Mb/s. A hold time could be violated only if ``clock``
    took longer than those 8.8 ns from its flip-flop to its network.

    Until the delays are chosen no lane is active at ``o``.

    Parameters
    ----------
    lanes : int
    search :
        Of :class:`EyeSearch`.

    Members
    -------
    pair, pairs : ``In(1)``, ``In(lanes)``
        Clock and lanes, from differential inputs.
    low_power : ``In(lanes)``
        Dn of each lane, from single-ended inputs.
    settle : ``In(SETTLE_BITS)``
        As of :class:`Settling`.
    clock : ``Out(1)``
    o : ``Out(LANE).array(lanes)``
        In the domain of ``clock``.
    ready, eyes, failures : ``Out(1)``, ``Out(EYE).array(lanes)``, ``Out(8)``
        As of :class:`EyeSearch`, in ``sync``.
    """

    def __init__(self, lanes, **search):
        self.lanes, self.search = lanes, search
        super().__init__({
            "pair": In(1), "pairs": In(lanes), "low_power": In(lanes),
            "settle": In(SETTLE_BITS), "clock": Out(1), "o": Out(LANE).array(lanes),
            "ready": Out(1), "eyes": Out(EYE).array(lanes), "failures": Out(8)})

    def elaborate(self, platform):
        m = Module()
        # Without a reset, as the clocks stop during one.
        m.domains.csi_word = ClockDomain(local=True, reset_less=True)
        m.domains.csi_byte = ClockDomain(local=True, reset_less=True)
        m.submodules.search = search = EyeSearch(self.lanes, domain="csi_byte", **self.search)
        edge, half, ready = Signal(), Signal(), Signal()
        m.submodules.edge_clock = Instance(
            "ECLKSYNCB", i_ECLKI=self.pair, i_STOP=search.stop, o_ECLKO=edge)
        m.submodules.word_clock = Instance(
            "CLKDIVF", p_DIV="2.0", i_CLKI=edge, i_RST=search.reset, i_ALIGNWD=Const(0),
            o_CDIVX=ClockSignal("csi_word"))
        m.d.csi_word += half.eq(~half)
        m.submodules.byte_clock = Instance(
            "DCCA", i_CLKI=half, i_CE=Const(1), o_CLKO=ClockSignal("csi_byte"))
        m.d.comb += [self.clock.eq(ClockSignal("csi_byte")), self.ready.eq(search.ready),
                     self.failures.eq(search.failures)]
        m.submodules.ready = FFSynchronizer(search.ready, ready, o_domain="csi_byte")
        for k in range(self.lanes):
            m.d.comb += self.eyes[k].eq(search.eyes[k])
            byte = self._byte(m, k, edge, half, search)
            m.submodules[f"settling{k}"] = settling = DomainRenamer("csi_byte")(Settling())
            m.submodules[f"check{k}"] = check = DomainRenamer("csi_byte")(BurstCheck())
            m.d.comb += [
                settling.low_power.eq(self.low_power[k]), settling.settle.eq(self.settle),
                check.i.data.eq(byte), check.i.active.eq(settling.active),
                search.ended[k].eq(check.ended), search.good[k].eq(check.good),
                self.o[k].data.eq(byte), self.o[k].active.eq(settling.active & ready)]
        return m

    def _byte(self, m, number, edge, half, search):
        """Eight bits of a lane, in the domain of the bytes."""
        late, bits = Signal(name=f"late{number}"), Signal(_BITS, name=f"bits{number}")
        before = Signal(_BITS, name=f"bits{number}_before")
        pair, byte = Signal(2 * _BITS, name=f"pair{number}"), Signal(8, name=f"byte{number}")
        m.submodules[f"delay{number}"] = Instance(
            "DELAYF", p_DEL_MODE="USER_DEFINED", p_DEL_VALUE=0, i_A=self.pairs[number],
            i_LOADN=search.load_n, i_MOVE=search.move[number], i_DIRECTION=Const(0), o_Z=late)
        m.submodules[f"deserialiser{number}"] = Instance(
            "IDDRX2F", i_D=late, i_ECLK=edge, i_SCLK=ClockSignal("csi_word"),
            i_RST=search.reset, i_ALIGNWD=Const(0),
            **{f"o_Q{k}": bits[k] for k in range(_BITS)})
        m.d.csi_word += before.eq(bits)
        with m.If(half):
            m.d.csi_word += pair.eq(Cat(before, bits))
        m.d.csi_byte += byte.eq(pair)
        return byte

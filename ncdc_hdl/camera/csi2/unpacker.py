"""Samples of the payload of a row."""

from amaranth import *
from amaranth.lib import data, wiring
from amaranth.lib.wiring import In, Out

from ncdc_hdl.camera.csi2.layouts import SETTINGS, payload, rest_shape
from ncdc_hdl.camera.csi2.packing import Packing
from ncdc_hdl.lib.pipeline import register
from ncdc_spec.sensors.csi2 import SAMPLE_BITS_OF, DataType
from ncdc_spec.sensors.level import SAMPLE_BITS

__all__ = ["Unpacker"]

_PACKED = (DataType.RAW10, DataType.RAW12)      # each byte of other types is a sample


class Unpacker(wiring.Component):
    """Unpacks RAW10 and RAW12; each byte of another data type is a sample.

    All formats leave after the same number of words, so that the upper bits of a sample come from
    one or two bytes of the history, whatever the format is. After the last word of a row its other
    samples leave by themselves, whatever comes.

    Timing: free-running. The first samples of a row leave ``latency`` clocks after its first word,
    and the last ones at most ``latency`` clocks after its last word.

    Parameters
    ----------
    lanes : int

    Members
    -------
    settings : ``In(SETTINGS)``
    i : ``In(payload(lanes))``
    valid, sample, last : ``Out(lanes)``, ``Out(ArrayLayout(12, lanes))``, ``Out(1)``
        As in :func:`ncdc_hdl.camera.samples.samples`. A row whose length is wrong lacks ``last``.
    length : ``Out(1)``
        High for a clock: the bytes of a row are no whole groups.
    """

    def __init__(self, lanes):
        self.lanes = lanes
        packings = {kind: Packing(bits, lanes) for kind, bits in SAMPLE_BITS_OF.items()}
        self.depth = max(packing.times[0] for packing in packings.values())
        self.packings = {kind: Packing(packing.bits, lanes, self.depth - packing.times[0])
                         for kind, packing in packings.items()}
        super().__init__({
            "settings": In(SETTINGS), "i": In(payload(lanes)), "valid": Out(lanes),
            "sample": Out(data.ArrayLayout(SAMPLE_BITS, lanes)), "last": Out(1),
            "length": Out(1)})

    @property
    def latency(self):
        """The words of the history, and the register of the output."""
        return self.depth + 1

    def elaborate(self, platform):
        m = Module()
        # Number of the word in its period.
        word = Signal(range(max(packing.group_bytes for packing in self.packings.values())))
        filled = Signal(self.depth)             # words that the history has, a bit for each
        drain = Signal(range(self.depth + 1))   # words that are made up after the last one
        count = Signal(rest_shape(self.lanes))  # samples of the last output, modulo the lanes
        now = Signal(data.StructLayout({        # of this word:
            "following": word.shape(),          # number of the next one
            "leaves": 1,                        # an output leaves with it
            "whole": 1,                         # the row may end with it
            "drain": drain.shape(),             # then these are the values of `drain`
            "count": count.shape()}))           # and of `count`
        draining, ends, step, final = Signal(), Signal(), Signal(), Signal()
        m.d.comb += [
            draining.eq(drain.any()), ends.eq(self.i.valid & self.i.last),
            step.eq(self.i.valid | draining),
            final.eq(Mux(draining, drain == 1, ends & now.whole & (now.drain == 0)))]
        with m.If(self.i.start):
            m.d.sync += [word.eq(0), filled.eq(0), drain.eq(0)]
        with m.Elif(step):
            m.d.sync += [word.eq(now.following), filled.eq(Cat(Const(1, 1), filled)),
                         drain.eq(Mux(draining, drain - 1, Mux(ends & now.whole, now.drain, 0)))]
        with m.If(ends):
            m.d.sync += count.eq(now.count)
        sample = self._samples(m, word, now, self._history(m, step))
        number = Mux(draining, count, now.count)
        leaving = Mux(step & filled[-1] & now.leaves,
                      Mux(final & number.any(), number, self.lanes), 0)
        m.d.comb += [
            self.sample.eq(register(m, "sample_", sample)),
            self.valid.eq(register(m, "valid_", Cat(leaving > k for k in range(self.lanes)),
                                   reset_less=False)),
            self.last.eq(register(m, "last_", final, reset_less=False)),
            self.length.eq(register(m, "length_", ends & ~now.whole, reset_less=False))]
        return m

    def _history(self, m, step):
        """This word and those before it, the newest first."""
        history = [self.i.data]
        for k in range(self.depth):
            before = Signal(8 * self.lanes, name=f"word_d{k}", reset_less=True)
            with m.If(step):
                m.d.sync += before.eq(history[-1])
            history.append(before)
        return history

    def _samples(self, m, word, now, history):
        """The samples that leave with a word; sets ``now``."""
        samples = Signal(data.ArrayLayout(SAMPLE_BITS, self.lanes))
        kind = register(m, "kind", Cat(self.settings.type == each for each in _PACKED))
        with m.Switch(kind):
            for each, packing in self.packings.items():
                number = 1 << _PACKED.index(each) if each in _PACKED else 0
                with m.Case(number), m.Switch(word):
                    for position in range(packing.group_bytes):
                        with m.Case(position):
                            self._set(m, packing, position, now)
                            m.d.comb += samples.eq(Cat(
                                _sample(packing, position, k, history)
                                for k in range(self.lanes)))
        return samples

    def _set(self, m, packing, position, now):
        """Set ``now`` for the word at a position of the period of ``packing``."""
        m.d.comb += [now.following.eq((position + 1) % packing.group_bytes),
                     now.leaves.eq(packing.output_at(position) is not None)]
        with m.Switch(self.i.rest):
            for rest in range(self.lanes):
                end = packing.end(position, rest)
                if end is not None:
                    with m.Case(rest):
                        m.d.comb += [now.whole.eq(1), now.drain.eq(end[0]), now.count.eq(end[1])]


def _sample(packing, position, lane, history):
    """Sample ``lane`` of the output that leaves with the word at a position of the period."""
    output = packing.output_at(position) or 0       # any one if none leaves
    sample = output * packing.lanes + lane

    def byte(number):
        back, lane = divmod(number, packing.lanes)
        return history[packing.times[output] - back].word_select(lane, 8)

    low_byte, first = packing.lower(sample)
    low = byte(low_byte)[first:first + packing.low_bits]
    return Cat(Const(0, SAMPLE_BITS - packing.bits), low, byte(packing.upper(sample)))

"""A CSI-2 receiver: from the bytes of the lanes to a stream of samples."""

from functools import reduce
from operator import or_

from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out, connect, flipped

from ncdc_hdl.camera.csi2.frames import Frames
from ncdc_hdl.camera.csi2.lane_aligner import LaneAligner
from ncdc_hdl.camera.csi2.layouts import BYTES, FAULTS, LANE, LANES, SETTINGS
from ncdc_hdl.camera.csi2.packets import Packets
from ncdc_hdl.camera.csi2.unpacker import Unpacker
from ncdc_hdl.camera.csi2.word_aligner import WordAligner
from ncdc_hdl.camera.samples import samples
from ncdc_hdl.lib.pipeline import delay
from ncdc_spec.errors import InputError

__all__ = ["Receiver"]


class Receiver(wiring.Component):
    """Receives the frames of one virtual channel, in the clock of the lanes' bytes.

    Packets of other channels and types are skipped. A fault makes the frame under way bad; the
    next frame is right. See ``docs/reference/csi2.md``.

    Timing: free-running. A frame's ``end`` leaves ``latency`` clocks after the last byte of its
    packet. The clock may stop in between.

    Parameters
    ----------
    lanes : int
        One of :data:`LANES`; also the number of samples per clock.
    aligned : bool
        The lanes come from a PHY that aligns words.

    Members
    -------
    i : ``In(LANE).array(lanes)``, with ``aligned`` ``In(BYTES).array(lanes)``
    settings : ``In(SETTINGS)``
        Constant while a frame is under way.
    o : ``Out(samples(lanes))``
    faults : ``Out(FAULTS)``

    Raises
    ------
    InputError
        If the number of lanes is not supported.
    """

    def __init__(self, lanes, aligned=False):
        if lanes not in LANES:
            raise InputError(f"a CSI-2 receiver has 1, 2 or 4 lanes, not {lanes}")
        self.lanes, self.aligned = lanes, aligned
        super().__init__({"i": In(BYTES if aligned else LANE).array(lanes),
                          "settings": In(SETTINGS), "o": Out(samples(lanes)),
                          "faults": Out(FAULTS)})

    @property
    def latency(self):
        """Alignment of words and of lanes, the header, the register of the frame's end."""
        return ((0 if self.aligned else WordAligner.latency) + LaneAligner.latency
                + Packets.latency + 1)

    def elaborate(self, platform):
        m = Module()
        m.submodules.aligner = aligner = LaneAligner(self.lanes)
        m.submodules.packets = packets = Packets(self.lanes)
        m.submodules.unpacker = unpacker = Unpacker(self.lanes)
        m.submodules.frames = frames = Frames()
        for k, lane in enumerate(self.i):
            if self.aligned:
                connect(m, flipped(lane), aligner.i[k])
            else:
                m.submodules[f"lane{k}"] = word = WordAligner()
                connect(m, flipped(lane), word.i)
                connect(m, word.o, aligner.i[k])
        connect(m, aligner.o, packets.i)
        connect(m, packets.o, unpacker.i)
        # All faults in the order of their packets.
        unaligned = delay(m, aligner.unaligned, Packets.latency, "unaligned", reset_less=False)
        m.d.comb += [
            packets.settings.eq(self.settings), unpacker.settings.eq(self.settings),
            packets.open.eq(frames.open), frames.begins.eq(packets.begins),
            frames.ends.eq(packets.ends), frames.samples.eq(unpacker.valid[0]),
            self.faults.eq(packets.faults),
            self.faults.unaligned.eq(unaligned),
            self.faults.length.eq(packets.faults.length | unpacker.length),
            self.faults.order.eq(packets.faults.order | frames.order),
            frames.fault.eq(reduce(or_, (self.faults[name] for name, _ in FAULTS
                                         if name not in ("corrected", "order")))),
            self.o.valid.eq(unpacker.valid), self.o.sample.eq(unpacker.sample),
            self.o.first.eq(frames.first & unpacker.valid[0]), self.o.last.eq(unpacker.last),
            self.o.end.eq(frames.end), self.o.bad.eq(frames.bad & frames.end),
        ]
        return m

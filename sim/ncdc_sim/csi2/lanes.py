"""Lanes of a CSI-2 transmitter: bursts of bits, as a receiver's deserialisers see them."""

import numpy as np

from ncdc_spec.sensors.csi2 import SYNC_BYTE

__all__ = ["Lanes", "MIN_GAP"]

MIN_GAP = 2             # byte clocks between two bursts, at least: the clock may stop


class Lanes:
    """Gathers what each lane's deserialiser gives in each byte clock.

    A clock that stops between bursts is one that has few clocks there. Bits of a lane in
    low-power mode are random.

    Parameters
    ----------
    lanes : int
    rng : numpy.random.Generator
    """

    def __init__(self, lanes, rng):
        self.lanes, self.rng = lanes, rng
        self._parts = []            # arrays of (clocks, lanes, data and active)

    def burst(self, packet, *, skew=None, zeros=16, gap=MIN_GAP, change=lambda lane, bits: bits,
              cut=False):
        """Send a packet as one burst, and then ``gap`` clocks of low-power mode.

        Parameters
        ----------
        packet : bytes
        skew : sequence of int, optional
            Bits by which each lane is late; 0 to 7 at random without it.
        zeros : int
            Bits of the lanes' zeros after they have settled.
        gap : int
        change : callable
            Gives other bits of a lane, from its sync byte on, for its number and bits.
        cut : bool
            Whether the lanes stop after the last bit, without a trail.
        """
        skew = self.rng.integers(0, 8, self.lanes) if skew is None else skew
        sent = []
        for lane in range(self.lanes):
            content = np.frombuffer(bytes([SYNC_BYTE]) + packet[lane::self.lanes], np.uint8)
            bits = change(lane, np.unpackbits(content, bitorder="little"))
            bits = np.concatenate([np.zeros(zeros + int(skew[lane]), np.uint8), bits])
            # The trail repeats the inverted last bit.
            trail = 0 if cut else self.rng.integers(8, 24)
            sent.append(np.append(bits, np.full(trail, 1 - bits[-1], np.uint8)))
        self._send(sent, gap, cut)

    def rest(self, clocks):
        """Low-power mode on all lanes for some byte clocks."""
        part = np.zeros((clocks, self.lanes, 2), np.uint8)
        part[..., 0] = self.rng.integers(0, 256, part.shape[:2])
        self._parts.append(part)

    def _send(self, sent, gap, cut):
        """Add the bits of the lanes, the first ones in the same clock, and low-power mode."""
        longest = max(-(-len(bits) // 8) for bits in sent)
        # Low-power mode is seen on one lane sooner than on another.
        more = [0 if cut else int(self.rng.integers(0, 3)) for _ in sent]
        self.rest(longest + max(more) + gap)
        for lane, bits in enumerate(sent):
            clocks = longest + more[lane]
            padded = np.full(8 * clocks, bits[-1], np.uint8)
            padded[:len(bits)] = bits
            self._parts[-1][:clocks, lane, 0] = np.packbits(padded, bitorder="little")
            self._parts[-1][:clocks, lane, 1] = 1

    @property
    def clocks(self):
        """(data, active) of each byte clock and lane, as two arrays of uint8."""
        everything = np.concatenate(self._parts)
        return everything[..., 0], everything[..., 1]

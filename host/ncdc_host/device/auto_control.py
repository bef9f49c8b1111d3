"""Automatic exposure, gain and white balance of the emulated device, frame by frame."""

from dataclasses import replace

import numpy as np

from ncdc_spec.protocols.auto_control import (
    LEVEL_SHIFT,
    OFF,
    ONCE,
    balanced,
    exposed,
    sample_positions,
)

__all__ = ["AutoControl", "level_of"]


def level_of(raw):
    """Mean of some samples of a ``raw`` uint8 (height, width) frame, in 16ths of a grey level."""
    rows, columns = (np.add.outer(sample_positions(size), (0, 1)).ravel() for size in raw.shape)
    return int(raw[np.ix_(rows, columns)].sum(dtype=np.int64)) >> LEVEL_SHIFT


class AutoControl:
    """Applies the rule of :mod:`ncdc_spec.protocols.auto_control` to the frames of a stream.

    Parameters
    ----------
    registers : Registers
        Its ``auto`` says which features are automatic; what the rule finds is written there.
    """
    def __init__(self, registers):
        self._registers = registers

    def observe(self, frame):
        """Set what the next frames are made with, by a :class:`Frame` that was sent.

        A frame of other settings than the present ones says nothing of them, and is not used.
        """
        with self._registers.lock:
            if frame.settings != self._registers.settings:
                return
            self._expose(frame)
            if frame.sums is not None and self._registers.auto["BalanceWhiteAuto"] != OFF:
                self._balance(frame)

    def _expose(self, frame):
        auto = self._registers.auto
        limits = self._registers.limits(auto["ExposureAuto"] != OFF, auto["GainAuto"] != OFF)
        present = self._registers.lines, frame.settings.gain_eighths
        lines, gain = exposed(frame.level, *present, limits)
        if (lines, self._registers.possible_gain(gain)) != present:
            self._registers.set_exposure(lines, gain)
        else:
            self._settled("ExposureAuto", "GainAuto")

    def _balance(self, frame):
        colour = frame.settings.colour
        gains = balanced(frame.sums.colours, frame.sums.pixels, colour.raw_gains)
        if gains != colour.raw_gains:
            self._registers.set_colour(replace(colour, raw_gains=gains))
        else:
            self._settled("BalanceWhiteAuto")

    def _settled(self, *names):
        for name in names:
            if self._registers.auto[name] == ONCE:
                self._registers.auto[name] = OFF

"""Runs the sensor's side of capture, clock by clock, and gathers its entries."""

import numpy as np
from amaranth import *
from amaranth.sim import Simulator

from ncdc_hdl.camera.camera_side import CameraSide
from ncdc_hdl.camera.grid import Grid
from ncdc_hdl.camera.layouts import REPORT, Kind
from ncdc_hdl.camera.samples import FRAME_GAP
from ncdc_hdl.camera.sensor_port import SensorPort
from ncdc_hdl.lib.gains import NO_BALANCE

__all__ = ["CLEAN", "Port", "SamplesPort", "pins_of", "random_frames", "samples_of"]

CLEAN = {"rows": 0, "overflow": 0, "bad": 0, "lines": 0, "missed": 0}


def random_frames(sent, count, seed=1):
    return np.random.default_rng(seed).integers(0, 4096, (count, sent[1], sent[0]))


def pins_of(samples, pauses, change=lambda y, row: row):
    """(FRAME_VALID, LINE_VALID, sample) of each clock of a frame.

    ``pauses``: clocks before the first row, after a row, after the last one, in which FRAME_VALID
    is high; 0 after the last one: it falls with the last sample's LINE_VALID.
    ``change(y, row)`` gives a row's samples otherwise, None for a clock without one.
    """
    before, between, after = pauses
    clocks = [(1, 0, 1234)] * before
    for y, row in enumerate(samples):
        clocks += [(1, 0, 4095) if value is None else (1, 1, int(value))
                   for value in change(y, list(row))]
        clocks += [(1, 0, 777)] * (between if y < len(samples) - 1 else after)
    return clocks + [(0, 0, 99)] * 4


def samples_of(frame, count, rng, change=lambda y, row: row, end=(1, 0)):
    """(samples, ``first``, ``last``, ``end``, ``bad``) of each clock of a frame, with random gaps.

    ``change(y, row)`` gives a row's samples otherwise; None as the last one: without ``last``.
    ``end``: that the frame has one, and what ``bad`` is then.
    """
    clocks, gap = [], ([], 0, 0, 0, 0)
    for y, row in enumerate(frame):
        row = change(y, [int(sample) for sample in row])
        last = row[-1] is not None
        row = row if last else row[:-1]
        for x in range(0, len(row), count):
            clocks += [gap] * (rng.integers(3) if rng.integers(2) else 0)
            clocks.append((row[x:x + count], y == x == 0, last and x + count >= len(row), 0, 0))
    late = rng.integers(3)
    clocks += [gap] * late
    *others, _, _ = clocks.pop()
    return [*clocks, (*others, *end), *[gap] * (FRAME_GAP + rng.integers(3))]


class Port:
    """Runs the ``SensorPort`` of a parallel sensor, and gathers its entries.

    Parameters
    ----------
    sent, window : (int, int)
        Width and height.
    corner : (int, int)
    mode : (int, int) or None
        Weight and binning of the grid stage; None without one.
    row : int, optional
        Of the stage; by default the sent width.
    balance : dict
        Gains and phase, of the layout ``BALANCE``.
    """
    def __init__(self, sent, window, corner, mode, row=None, balance=NO_BALANCE):
        self.dut = self._component(None if mode is None else row or sent[0])
        self.sent, self.window, self.corner, self.mode = sent, window, corner, mode
        self.balance = balance
        self.frames, self.entries = [], None

    REST = 0, 0, 0          # a clock between two frames

    def _component(self, row):
        return CameraSide(grid=row)

    def _put(self, ctx, clock):
        """Drive the inputs for a clock."""
        pins = self.dut.camera.pins
        for signal, value in zip((pins.frame_valid, pins.line_valid, pins.data), clock):
            ctx.set(signal, value)

    def run(self, clocks, events=(), enable=1):
        """Give the inputs what ``clocks`` say; ``events``: (clock, signal, value)."""
        dut, reset = self.dut, Signal()
        simulator = Simulator(ResetInserter(reset)(dut))
        simulator.add_clock(1e-8)

        async def bench(ctx):
            (width, height), (left, top) = self.window, self.corner
            ctx.set(dut.settings, {"sent_width": self.sent[0], "sent_height": self.sent[1],
                                   "left": left, "top": top, "width": width, "height": height})
            ctx.set(dut.settings.level.curve, [16 * k for k in range(17)])
            ctx.set(dut.balance, self.balance)
            if self.mode is not None:
                ctx.set(dut.grid, dict(zip(("weight", "binning"), self.mode)))
            ctx.set(dut.enable, enable)
            ctx.set(dut.space, 1)
            await ctx.tick().repeat(Grid.latency + 8)
            for number, clock in enumerate([*clocks, *[self.REST] * 60]):
                for at, name, value in events:
                    if at == number:
                        ctx.set(reset if name == "reset" else getattr(dut, name), value)
                self._put(ctx, clock)
                self._look(ctx)
                await ctx.tick()

        simulator.add_testbench(bench)
        simulator.run()
        return self.frames

    def _look(self, ctx):
        """Take the entry of this clock."""
        dut = self.dut
        if not ctx.get(dut.push) or not ctx.get(dut.space):
            return
        kind, word = ctx.get(dut.entry.kind), ctx.get(dut.entry.data)
        if kind == Kind.BEGIN:
            self.entries = [[]]
        elif kind == Kind.END:
            report = REPORT.from_bits(word)
            rows = [row[:self.window[0]] for row in self.entries[:-1]]
            self.frames.append((rows, {name: getattr(report, name) for name, _ in REPORT}))
        elif kind in (Kind.WORD, Kind.ROW_END):
            self.entries[-1] += list(word.to_bytes(4, "little"))
            if kind == Kind.ROW_END:
                self.entries.append([])


class SamplesPort(Port):
    """The same for a ``SensorPort`` with ``count`` samples per clock."""

    REST = [], 0, 0, 0, 0

    def __init__(self, count, sent, window, corner, mode=None, **options):
        self.count = count
        super().__init__(sent, window, corner, mode, **options)

    def _component(self, row):
        return SensorPort(self.count, row)

    def _put(self, ctx, clock):
        i, (samples, first, last, end, bad) = self.dut.i, clock
        ctx.set(i.valid, (1 << len(samples)) - 1)
        for signal, value in zip(i.sample, samples):
            ctx.set(signal, value)
        for signal, value in ((i.first, first), (i.last, last), (i.end, end), (i.bad, bad)):
            ctx.set(signal, int(value))

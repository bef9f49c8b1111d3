"""A CSI-2 receiver's Verilog, run on the lanes of a transmitter."""

from dataclasses import dataclass
from functools import cache

import numpy as np
from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from ncdc_hdl.camera.csi2.layouts import FAULTS, SETTINGS
from ncdc_hdl.camera.csi2.receiver import Receiver
from ncdc_hdl.export.verilog import module_verilog
from ncdc_sim.runner import HDL, build, command_of
from ncdc_sim.transcript import transcribed
from ncdc_spec.sensors.level import SAMPLE_BITS

__all__ = ["RECEIVER", "FlatReceiver", "Frame", "Received", "receive"]

RECEIVER = "csi2"
"""Name of the module that is run."""

_MORE_CLOCKS = 8
_FLAGS = [*(name for name, _ in FAULTS), "first", "last", "end", "bad"]


@dataclass(frozen=True)
class Frame:
    """A frame that ended: its rows of samples, whether it was bad, the clock of its end."""
    rows: list
    bad: bool
    clock: int


@dataclass(frozen=True)
class Received:
    """What a receiver gave: frames, and the number of times that each fault was reported."""
    frames: list
    faults: dict


class FlatReceiver(wiring.Component):
    """A receiver whose ports are numbers: lanes as (data, active) each, outputs as ``_FLAGS``, the
    valid bits and the samples."""

    def __init__(self, receiver):
        self.receiver = receiver
        lanes = receiver.lanes
        super().__init__({"settings": In(SETTINGS.size), "i": In(9 * lanes),
                          "o": Out(len(_FLAGS) + (1 + SAMPLE_BITS) * lanes)})

    def elaborate(self, platform):
        m = Module()
        m.submodules.receiver = receiver = self.receiver
        o = receiver.o
        for k, lane in enumerate(receiver.i):
            m.d.comb += Cat(lane.data, lane.active).eq(self.i.word_select(k, 9))
        m.d.comb += [receiver.settings.as_value().eq(self.settings),
                     self.o.eq(Cat(receiver.faults, o.first, o.last, o.end, o.bad, o.valid,
                                   o.sample))]
        return m


@cache
def _verilog(lanes):
    """Text of a receiver."""
    return module_verilog(FlatReceiver(Receiver(lanes)), RECEIVER)


def _program(verilog):
    """The compiled receiver."""
    return build(RECEIVER, RECEIVER, [(f"{RECEIVER}.v", verilog)], main=HDL / "csi2_main.cpp")


def receive(lanes, data, active, *, channel, kind, reset=None, verilog=None, transcripts=None):
    """What a receiver's Verilog makes of the lanes, in a Verilator model.

    Some clocks of low-power mode follow, in which the end of the last frame leaves.

    Parameters
    ----------
    lanes : int
    data, active : array_like of int
        Of each byte clock and lane, as :class:`ncdc_sim.csi2.lanes.Lanes` gives them.
    channel, kind : int
        Settings of the receiver.
    reset : array_like of bool, optional
        Whether each clock is one of a reset.
    verilog : str, optional
        Text of a :class:`FlatReceiver`, made if absent.
    transcripts : list, optional
        The run's transcript is added to it.

    Returns
    -------
    Received

    Raises
    ------
    InputError
        If Verilator is not installed.
    SimulationError
        If the Verilog does not compile or the run fails.
    AssertionError
        If the stream breaks a rule of :func:`ncdc_hdl.camera.samples.samples`.
    """
    data, active = np.asarray(data, np.uint64), np.asarray(active, np.uint64)
    words = np.zeros(len(data), "<u8")
    for lane in range(lanes):
        words |= (data[:, lane] | active[:, lane] << np.uint64(8)) << np.uint64(9 * lane)
    if reset is not None:
        words |= np.asarray(reset, np.uint64) << np.uint64(63)
    words = np.append(words, np.zeros(_MORE_CLOCKS, "<u8"))
    settings = SETTINGS.const({"channel": channel, "type": kind}).as_value().value
    program = _program(verilog or _verilog(lanes))
    written = transcribed([*command_of(program), "inputs", "outputs", str(settings),
                           *map(str, (len(_FLAGS), lanes, SAMPLE_BITS))],
                          lambda line: None, transcripts, files={"inputs": words.tobytes()},
                          writes=["outputs"])
    every = np.frombuffer(written["outputs"], "<u8")
    clocks = np.flatnonzero(every)
    outputs = every[clocks]
    return _received(lanes, clocks, outputs, reset is not None)


def _received(lanes, clocks, outputs, reset):
    """Frames and faults of the clocks in which a receiver gave something."""
    def bits(first, count=1):
        return outputs >> np.uint64(first) & np.uint64((1 << count) - 1)
    flags = {name: bits(k).astype(bool) for k, name in enumerate(_FLAGS)}
    at = len(_FLAGS)
    valid = np.stack([bits(at + k) for k in range(lanes)], 1).astype(bool)
    values = np.stack([bits(at + lanes + SAMPLE_BITS * k, SAMPLE_BITS) for k in range(lanes)], 1)
    _check(valid, flags, reset)
    frames, begins = [], np.flatnonzero(flags["first"])
    for end in np.flatnonzero(flags["end"]):
        part = slice(begins[np.searchsorted(begins, end) - 1], end)
        taken = valid[part]
        ends = np.cumsum(taken.sum(1))[flags["last"][part]]
        rows = np.split(values[part][taken].astype(int), ends)
        frames.append(Frame(rows[:-1] if len(rows[-1]) == 0 else rows, bool(flags["bad"][end]),
                            int(clocks[end])))
    return Received(frames, {name: int(flags[name].sum()) for name, _ in FAULTS})


def _check(valid, flags, reset):
    """The rules of the stream; after a reset a frame may lack its end."""
    some = valid[:, 0]
    assert not (valid[:, 1:] & ~valid[:, :-1]).any(), "a lower sample is not valid"
    assert not (~valid.all(1) & some & ~flags["last"]).any(), "fewer samples within a row"
    assert not ((flags["first"] | flags["last"]) & ~some).any(), "a flag without a sample"
    assert not (flags["end"] & some).any(), "a frame ends with a sample"
    assert not (flags["bad"] & ~flags["end"]).any(), "bad without an end"
    events = flags["first"][flags["first"] | flags["end"]]
    assert reset or (events == (np.arange(len(events)) % 2 == 0)).all(), "a first or an end missing"
    under_way = False
    for first, sample, end in zip(flags["first"], some, flags["end"]):
        under_way |= first
        assert under_way or not (sample or end), "a sample or an end outside of a frame"
        under_way &= ~end

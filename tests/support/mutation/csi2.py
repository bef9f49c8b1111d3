"""A CSI-2 receiver of two lanes, on the lanes of a transmitter that is written apart from it."""

from functools import cache

from csi2_frames import (
    FAULTS,
    check_corrupted,
    check_faulty,
    check_reset,
    check_whole,
    corrupted_frames,
    faulty_frames,
    received,
    reset_frames,
    whole_frames,
)
from ncdc_bench.mutation.designs import Bench, Design
from ncdc_hdl.camera.csi2.receiver import Receiver
from ncdc_sim.csi2.run import RECEIVER, FlatReceiver
from ncdc_spec.sensors.csi2 import SAMPLE_BITS_OF, DataType

__all__ = ["DESIGN"]

_LANES = 2
# What is sent is made once for all mutants.
whole_frames, faulty_frames = cache(whole_frames), cache(faulty_frames)
corrupted_frames, reset_frames = cache(corrupted_frames), cache(reset_frames)


def make():
    """The receiver, anew."""
    return FlatReceiver(Receiver(_LANES))


def frames(verilog, more):
    """Frames of each format and of rows of each length."""
    for kind in SAMPLE_BITS_OF:
        wire, sent = whole_frames(_LANES, kind, 20)
        check_whole(received(wire, kind, verilog=verilog, more=more), sent, kind)


def faults(verilog, more):
    """Each fault that can be planted in a frame."""
    for fault in FAULTS:
        wire, sent = faulty_frames(_LANES, fault)
        result = received(wire, DataType.RAW10, verilog=verilog, more=more)
        check_faulty(result, fault, sent)


def corrupted(verilog, more):
    """Packets with random faults."""
    wire, sent, untouched = corrupted_frames(_LANES, 600)
    check_corrupted(received(wire, DataType.RAW10, verilog=verilog, more=more), sent, untouched)


def resets(verilog, more):
    """Resets at any clock."""
    wire, sent, reset, whole = reset_frames(_LANES)
    result = received(wire, DataType.RAW10, reset=reset, verilog=verilog, more=more)
    check_reset(result, sent, whole)


_RUNS = {"frames": frames, "faults": faults, "corrupted packets": corrupted, "resets": resets}

DESIGN = Design("csi2", RECEIVER, make, tuple(Bench(*item) for item in _RUNS.items()))

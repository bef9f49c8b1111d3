"""A CSI-2 receiver of two lanes, on the lanes of a transmitter that is written apart from it."""

from functools import cache

from csi2_frames import (
    FAULTS,
    check_corrupted,
    check_faulty,
    check_reset,
    check_statuses,
    check_whole,
    corrupted_frames,
    faulty_frames,
    header_frames,
    long_frames,
    odd_frames,
    received,
    reset_frames,
    residue_frames,
    whole_frames,
)
from ncdc_bench.mutation.designs import Design, PlayedBench
from ncdc_hdl.camera.csi2.receiver import Receiver
from ncdc_sim.csi2.run import RECEIVER, FlatReceiver
from ncdc_spec.sensors.csi2 import SAMPLE_BITS_OF, DataType

__all__ = ["DESIGN"]

_LANES = 2
# What is sent is made once for all mutants.
whole_frames, faulty_frames = cache(whole_frames), cache(faulty_frames)
corrupted_frames, reset_frames = cache(corrupted_frames), cache(reset_frames)
header_frames, odd_frames, long_frames = map(cache, (header_frames, odd_frames, long_frames))
residue_frames = cache(residue_frames)


def make():
    """The receiver, anew."""
    return FlatReceiver(Receiver(_LANES))


def frames(verilog, transcripts):
    """Frames of each format and of rows of each length."""
    for kind in SAMPLE_BITS_OF:
        wire, sent = whole_frames(_LANES, kind, 20)
        check_whole(received(wire, kind, verilog=verilog, transcripts=transcripts), sent, kind)


def faults(verilog, transcripts):
    """Each fault that can be planted in a frame."""
    for fault in FAULTS:
        wire, sent = faulty_frames(_LANES, fault)
        result = received(wire, DataType.RAW10, verilog=verilog, transcripts=transcripts)
        check_faulty(result, fault, sent)


def corrupted(verilog, transcripts):
    """Packets with random faults."""
    wire, sent, untouched = corrupted_frames(_LANES, 600)
    result = received(wire, DataType.RAW10, verilog=verilog, transcripts=transcripts)
    check_corrupted(result, sent, untouched)


def headers(verilog, transcripts):
    """Headers with each wrong bit, and with each pair of them."""
    wire, bad, faults = header_frames(_LANES)
    check_statuses(received(wire, DataType.RAW10, verilog=verilog, transcripts=transcripts), bad,
                   faults)


def lengths(verilog, transcripts):
    """Rows of any number of bytes of each format, and of up to 65,535."""
    for kind in SAMPLE_BITS_OF:
        wire, bad, faults = odd_frames(_LANES, kind)
        check_statuses(received(wire, kind, verilog=verilog, transcripts=transcripts), bad, faults)
    wire, sent = long_frames(_LANES)
    check_whole(received(wire, DataType.RAW8, verilog=verilog, transcripts=transcripts), sent,
                DataType.RAW8)


def residues(verilog, transcripts):
    """Checksums that leave a single bit, each one."""
    wire, bad, faults = residue_frames(_LANES)
    check_statuses(received(wire, DataType.RAW8, verilog=verilog, transcripts=transcripts), bad,
                   faults)


def resets(verilog, transcripts):
    """Resets at any clock."""
    wire, sent, reset, whole = reset_frames(_LANES)
    result = received(wire, DataType.RAW10, reset=reset, verilog=verilog, transcripts=transcripts)
    check_reset(result, sent, whole)


_RUNS = {"frames": frames, "faults": faults, "corrupted packets": corrupted, "resets": resets,
         "headers": headers, "lengths": lengths, "wrong checksums": residues}

DESIGN = Design("csi2", RECEIVER, make, tuple(PlayedBench(*item) for item in _RUNS.items()))

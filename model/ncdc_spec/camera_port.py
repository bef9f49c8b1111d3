"""How a system takes its camera's samples."""

from dataclasses import dataclass

from ncdc_spec.errors import InputError

__all__ = ["AVALON_ST", "AXIS", "CSI2", "CameraPort", "FAULTS", "KINDS", "LANES", "PARALLEL",
           "SAMPLE_BITS", "SAMPLES_PER_CLOCK", "VIP", "camera_port", "fault_registers"]

KINDS = PARALLEL, AXIS, AVALON_ST, VIP, CSI2 = (
    "parallel", "axis", "avalon-st", "avalon-st:vip", "csi2")
SAMPLES_PER_CLOCK = LANES = 1, 2, 4
SAMPLE_BITS = 8, 10, 12, 16

_VIDEO = {"short": "Frames that began before the last row of the one before had ended.",
          "stray": "Rows, or packets, outside of a frame, which were dropped."}
FAULTS = {
    PARALLEL: {},
    AXIS: _VIDEO,
    AVALON_ST: _VIDEO,
    VIP: _VIDEO | {"size": "Frames with another size than `SENT_WIDTH` and `SENT_HEIGHT`, by "
                           "their control packet."},
    CSI2: {
        "unaligned": "Bursts without a sync byte on some lane, or with too much skew.",
        "corrected": "Headers with one wrong bit, which was corrected.",
        "header": "Headers with more wrong bits, whose packets were dropped.",
        "checksum": "Rows with a wrong checksum.",
        "cut": "Bursts that ended before their header, or the row in them, was complete.",
        "length": "Rows whose bytes are no whole groups of samples.",
        "order": "Frames in a frame, ends without a start, rows out of a frame, frames without "
                 "a row."}}
"""Faults that a camera of each kind counts, with what is counted."""


@dataclass(frozen=True)
class CameraPort:
    """A camera's way into a system.

    Parameters
    ----------
    kind : str
        One of :data:`KINDS`: a parallel sensor's pins, AXI4-Stream video, Avalon-ST video, the
        same with types of packets, or the bytes of CSI-2 lanes.
    samples : int
        Samples per clock, one of :data:`SAMPLES_PER_CLOCK`. A parallel sensor has 1, and
        CSI-2 as many as lanes.
    bits : int
        Bits of a sample of AXI4-Stream and Avalon-ST video, one of :data:`SAMPLE_BITS`. The others
        have 12: shorter ones are in the upper bits.
    aligned : bool
        The lanes of CSI-2 come from a PHY elsewhere, which aligns words.
    serial : bool
        Samples of CSI-2 lanes go on one per clock, as a grid stage needs them. The clock of the
        bytes has to run between rows.

    Raises
    ------
    InputError
        If the kind is unknown, or does not have such samples.
    """
    kind: str = PARALLEL
    samples: int = 1
    bits: int = 12
    aligned: bool = True
    serial: bool = False

    def __post_init__(self):
        for what, value, known in (("kind of a camera", self.kind, KINDS),
                                   ("number of samples per clock", self.samples,
                                    SAMPLES_PER_CLOCK),
                                   ("number of bits per sample", self.bits, SAMPLE_BITS)):
            if value not in known:
                raise InputError(f"the {what} is {value}, it must be one of "
                                 f"{', '.join(map(str, known))}")
        if self.kind == PARALLEL and self.samples != 1:
            raise InputError(f"a parallel camera has 1 sample per clock, not {self.samples}")
        if self.kind in (PARALLEL, CSI2) and self.bits != 12:
            raise InputError(f"a camera of the kind {self.kind} has samples of 12 bits, not "
                             f"{self.bits}: shorter ones are in the upper bits")

    @property
    def phy(self):
        """Whether its PHY is part of the design, which then has registers for it."""
        return self.kind == CSI2 and not self.aligned

    @property
    def faults(self):
        """Names of the faults that it counts."""
        return tuple(FAULTS[self.kind])

    @property
    def fault_registers(self):
        """Names of the registers that count them, by fault."""
        return fault_registers(self.kind)

    @property
    def options(self):
        """Options of ``ncdc generate`` for it."""
        if self.kind in (PARALLEL, CSI2):
            return [] if self.kind == PARALLEL else [f"--camera {CSI2}:{self.samples}"]
        return [f"--camera {self.kind}", f"--samples-per-clock {self.samples}",
                f"--sample-bits {self.bits}"]


def fault_registers(kind):
    """Names of the registers that count a camera's faults, by fault."""
    prefix = "CSI" if kind == CSI2 else "VIDEO"
    return {name: f"{prefix}_{name.upper()}" for name in FAULTS[kind]}


def camera_port(text, samples=None, bits=None):
    """:class:`CameraPort` of the options ``--camera``, ``--samples-per-clock``, ``--sample-bits``.

    Raises
    ------
    InputError
        If the text is none of them, or the samples do not fit.
    """
    kind, _, lanes = text.partition(":")
    if kind == CSI2 and lanes in map(str, LANES):
        if samples not in (None, int(lanes)):
            raise InputError(f"--camera {text} has {lanes} samples per clock, not {samples}")
        return CameraPort(CSI2, int(lanes), bits or 12)
    if text == CSI2 or text not in KINDS:
        raise InputError(f"--camera is {text}, it must be parallel, axis, avalon-st, "
                         "avalon-st:vip, csi2:1, csi2:2 or csi2:4")
    return CameraPort(text, samples or 1, bits or 12)

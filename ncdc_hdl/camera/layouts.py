"""What the parts of the camera hand each other."""

from amaranth.lib import data, enum, wiring
from amaranth.lib.wiring import Out

from ncdc_hdl.camera.level import LEVEL
from ncdc_model.geometry import MAX_SIZE
from ncdc_model.sensors.level import SAMPLE_BITS

__all__ = ["ENTRY", "Kind", "PINS", "REPORT", "SAMPLES", "SETTINGS", "SIZE_BITS"]

SIZE_BITS = MAX_SIZE.bit_length()
SAMPLES = 4                             # of an entry

PINS = wiring.Signature({"frame_valid": Out(1), "line_valid": Out(1), "data": Out(SAMPLE_BITS)})
"""A parallel sensor's signals, high when valid; fewer bits of a sample lie at the top."""

SETTINGS = data.StructLayout({
    "sent_width": SIZE_BITS, "sent_height": SIZE_BITS,      # what the sensor sends, exactly
    "left": SIZE_BITS, "top": SIZE_BITS,                    # the window of it that is captured
    "width": SIZE_BITS, "height": SIZE_BITS,
    "level": LEVEL,
})


class Kind(enum.Enum, shape=2):
    """What an :data:`ENTRY` is."""
    WORD = 0        # samples
    ROW_END = 1     # the last samples of a row
    BEGIN = 2       # a frame begins
    END = 3         # it ends; the data are a REPORT


ENTRY = data.StructLayout({"data": 8 * SAMPLES, "kind": Kind})

REPORT = data.StructLayout({
    "rows": 1,                  # more or fewer rows than the sensor is to send
    "overflow": 1,              # the queue was full
    "lines": 14,                # rows of a wrong length; this many or more
    "missed": 16,               # frames before that were not captured at all, modulo 65536
})

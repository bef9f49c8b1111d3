"""Layouts between the parts of the camera."""

from amaranth.lib import data, enum, wiring
from amaranth.lib.wiring import In, Out

from ncdc_hdl.avalon.bus import ADDRESS_BITS
from ncdc_hdl.camera.level import LEVEL
from ncdc_spec.geometry import MAX_SIZE
from ncdc_spec.sensors.level import SAMPLE_BITS

__all__ = ["ENTRY", "GRID", "Kind", "PINS", "REPORT", "ROWS", "RUN", "RUN_BUFFERS", "SAMPLES",
           "SETTINGS", "SIZE_BITS", "VIDEO_FAULTS", "VIP_FAULTS"]

SIZE_BITS = MAX_SIZE.bit_length()
SAMPLES = 4                             # samples of an entry

PINS = wiring.Signature({"frame_valid": Out(1), "line_valid": Out(1), "data": Out(SAMPLE_BITS)})
"""A parallel sensor's signals, high when valid; shorter samples are in the upper bits."""

ROWS = wiring.Signature({"frame": Out(1), "valid": Out(1), "row_end": Out(1),
                         "sample": Out(SAMPLE_BITS)})
"""A stream of frames. ``frame`` is high during one, and low between two. ``row_end`` is high in the
clock of the last sample of a row, which may be left out. The next row may begin a clock later."""

GRID = data.StructLayout({"weight": 2, "binning": 1})
"""Settings for an even grid of samples: see ``ncdc_spec.sensors.grid``."""

SETTINGS = data.StructLayout({
    "sent_width": SIZE_BITS, "sent_height": SIZE_BITS,      # what the sensor sends, exactly
    "left": SIZE_BITS, "top": SIZE_BITS,                    # the window of it that is captured
    "width": SIZE_BITS, "height": SIZE_BITS,
    "level": LEVEL,
})


VIDEO_FAULTS = data.StructLayout({
    "short": 1,                 # a frame began before the last row of the one before had ended
    "stray": 1,                 # a row, or a packet, outside of a frame
})
"""What may be wrong with a stream of video; each is high for a clock."""

VIP_FAULTS = data.StructLayout({**dict(VIDEO_FAULTS.members), "size": 1})
"""The same of packets with types: also a frame whose control packet has another size."""


class Kind(enum.Enum, shape=3):
    """Kind of an :data:`ENTRY`."""
    WORD = 0        # samples
    ROW_END = 1     # the last samples of a row
    BEGIN = 2       # a frame begins
    END = 3         # it ends; the data are a REPORT
    ALIVE = 4       # a row outside of the window has ended: the sensor's clock runs


ENTRY = data.StructLayout({"data": 8 * SAMPLES, "kind": Kind})

REPORT = data.StructLayout({
    "rows": 1,                  # more or fewer rows than the sensor should send
    "overflow": 1,              # the queue was full
    "bad": 1,                   # the source found a fault, or gave no end
    "lines": 13,                # rows of a wrong length; this many or more
    "missed": 16,               # earlier frames that were not captured at all, modulo 65536
})

RUN_BUFFERS = data.StructLayout({
    "source": ADDRESS_BITS, "source_limit": ADDRESS_BITS, "pitch": SIZE_BITS,
    "width": SIZE_BITS, "height": SIZE_BITS,
    "target": ADDRESS_BITS, "target_limit": ADDRESS_BITS, "follow": 1,
})
"""Byte addresses of a raw and a corrected frame and of the ends of their areas. For the raw
frame bytes from row to row, samples of a row, rows, and whether it is still being written."""

RUN = wiring.Signature({
    "active": Out(1),           # the corrector runs by itself: the host does not start it
    "start": Out(1),            # for one clock: begin a frame
    "assigned": Out(1),         # that frame uses `buffers`; constant from `start` to `over`
    "buffers": Out(RUN_BUFFERS),
    "idle": In(1),              # the corrector has no frame, and none waits
    "over": In(1),              # for one clock: its frame is over
    "cut": In(1),               # it lacks pixels, when it is over
    "fault": In(1),             # it has a fault
})
"""From the :class:`RunControl` to the corrector."""

"""The files of a ULX3S design, for synthesis and simulation."""

from dataclasses import dataclass

from ncdc_boards.ulx3s.clocks import DOMAINS
from ncdc_boards.ulx3s.platform import Ulx3sPlatform
from ncdc_boards.ulx3s.top import Ulx3sTop

__all__ = ["NAME", "Files", "clock_cells", "prepared"]

NAME = "ncdc_ulx3s"


@dataclass(frozen=True)
class Files:
    """Text of the top and of all below it in Yosys's own language and as Verilog, of its
    constraints (Lattice's preferences)."""
    rtlil: str
    verilog: str
    preferences: str


def prepared(design):
    """The :class:`Files` of a :class:`~ncdc_boards.camera_board.core.Design`."""
    plan = Ulx3sPlatform().prepare(Ulx3sTop(design), NAME, debug_verilog=True)
    texts = {name: text.decode() if isinstance(text, bytes) else text
             for name, text in plan.files.items()}
    return Files(*(texts[f"{NAME}.{kind}"] for kind in ("il", "debug.v", "lpf")))


def clock_cells():
    """Cell and output of the device that drives each clock, by the clock's name."""
    gates = {domain: (f"clocks.{domain}_gate", "CLKO") for domain in DOMAINS}
    return gates | {"sensor": ("camera_0__pixclk__io_buffer.buf.buf0", "O")}

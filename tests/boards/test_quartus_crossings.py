"""Every way from one clock of a board to another is one that the constraints name."""

import re
from fnmatch import fnmatchcase

import pytest
from amaranth.back import rtlil

from cameras import barrel_descriptor
from crossings import Clocks
from ncdc_boards.camera_board.core import BUTTONS, BoardCore
from ncdc_boards.camera_board.design import design_of, sensor_for
from ncdc_boards.catalogue import board
from ncdc_boards.quartus.sdc import constraints
from ncdc_hdl.video.modes import mode_named

pytestmark = pytest.mark.regress

DOMAINS = {"pixel_clk": "pixel_clk", "pixel_rst": "pixel_clk",
           **dict.fromkeys(("sensor_clock", "sensor__frame_valid", "sensor__line_valid",
                            "sensor__data"), "sensor_clock"),
           "jtag_clk": "jtag_clk", **dict.fromkeys(
               (f"scan__{name}" for name in ("tdi", "capture", "shift", "update")), "jtag_clk"),
           **dict.fromkeys(("scl", "sda", "receive", "again", *BUTTONS), "")}


@pytest.fixture(scope="module")
def design():
    lens = barrel_descriptor((64, 24), (64, 24), hidden_neurons=2, strength=.4)
    return design_of(board("de1-soc"), [("a", lens)], sensor_for("mt9p031", lens.geometry),
                     mode_named("640x480"))


def unnamed(crossings, sdc):
    """Crossings that no constraint names: not into a synchroniser or the reset of one, nor from
    what a false path begins at."""
    cut = re.findall(r"set_false_path -from \[get_registers {\*:([\w|]+)\*}\] -to .get_clocks", sdc)
    skewed = re.findall(r"set_net_delay .*-from \[get_registers {\*\|(\w+)\*}\]", sdc)
    found = []
    for crossing in crossings:
        source = crossing.source.replace(".", "|")
        first = crossing.sink.endswith(".stage0") and "consume_buffered" not in crossing.sink
        if first and (len(crossing.bits) == 1 or
                      any(fnmatchcase(source, f"*|{name}") for name in skewed)):
            continue
        if any(source.endswith(f"{name}") for name in cut):
            continue
        found.append(crossing)
    return found


def test_every_crossing_is_named(design):
    core = BoardCore(design)
    text = rtlil.convert(core, name="core", emit_src=False)
    crossings = Clocks(text, DOMAINS).crossings()
    assert len(crossings) > 30
    sdc = constraints(design, 25, ["led_0__io"])
    left = {(c.source, c.sink) for c in unnamed(crossings, sdc)}
    # Resets end in synchronisers; a queue's memory is read when its counter has crossed; outputs
    # of the core that belong to the screen; and a level for the writer, that nothing reads, with a
    # synchroniser of its own, which synthesis removes.
    left = {(source, sink) for source, sink in left if not (
        source == "rst" and sink.endswith(("stage0", "stage1"))
        or source.endswith(".storage") and sink.endswith(".r_data")
        or sink in ("picture", "scan__tdo") or "consume_buffered_cdc" in sink)}
    assert left == set()
    # Without the constraints on settings and counters they are found.
    less = re.sub(r"set_(net_delay|false_path -from).*\n", "", sdc)
    assert {c.source.split(".")[-1] for c in unnamed(crossings, less)} >= {
        "values", "produce_w_gry", "consume_r_gry", "request", "answer"}

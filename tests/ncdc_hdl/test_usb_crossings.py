"""No signal goes between the clocks of the core and of an FTDI chip but by ways named here."""

import pytest
from amaranth import *
from amaranth.back import rtlil
from amaranth.lib import fifo as amaranth_fifo

from crossings import Clocks, Wire
from ncdc_hdl.usb.fifo import UsbFifo
from ncdc_hdl.usb.layouts import FT232H, FT601

INPUTS = "clock", "rxf_n", "txe_n", "data_i", "be_i"
OUTPUTS = {f"pins__{name}" for name in ("data_o", "be_o", "data_oe", "oe_n", "rd_n", "wr_n")}
QUEUES = "from_host", "to_host.unbuffered"
# Gray counters, without logic before the first flop.
COUNTERS = {(f"{queue}.{counter}_gry", f"{queue}.{name}_cdc.stage0") for queue in QUEUES
            for counter, name in (("consume_r", "consume"), ("produce_w", "produce"))}
# A word is read when the counter that has passed it has crossed.
MEMORIES = {(f"{queue}.storage", f"{queue}.r_data") for queue in QUEUES}
# At once, not with an edge; their ends go through both flops.
RESETS = {(source, f"{register}.stage{k}") for k in (0, 1) for source, register in (
    ("rst", "reset"), ("reset.stage1", "from_host.rst_cdc"),
    ("rst", "to_host.unbuffered.rst_cdc"))}
# Amaranth's queue has a level for its writer, with logic before a synchroniser. We do not use it.
UNUSED = "to_host.consume_buffered_cdc"


def clocks_of(fifo):
    return Clocks(rtlil.convert(fifo, name="usb", emit_src=False),
                  dict.fromkeys((f"pins__{name}" for name in INPUTS), "pins__clock"))


def unknown(clocks):
    """(source, sink) of the crossings that no table has."""
    known = COUNTERS | MEMORIES | RESETS
    return {(c.source, c.sink) for c in clocks.crossings()
            if (c.source, c.sink) not in known and c.sink not in OUTPUTS
            and c.sink != f"{UNUSED}.stage0"}


@pytest.mark.parametrize("chip", [FT232H, FT601], ids=lambda chip: chip.name)
def test_every_crossing_is_a_known_one(chip):
    clocks = clocks_of(UsbFifo(chip))
    assert unknown(clocks) == set()
    found = {(c.source, c.sink): c for c in clocks.crossings()}
    assert COUNTERS | MEMORIES | RESETS <= found.keys()
    assert all(found[pair].direct for pair in COUNTERS)
    for _, first in COUNTERS:
        assert clocks.readers(first) == {first.replace("stage0", "stage1"): True}
    # Pins come from registers of the chip's clock.
    assert all(c.direct for c in clocks.crossings() if c.sink in OUTPUTS)


def test_nothing_reads_what_has_logic_before_its_synchroniser():
    clocks = clocks_of(UsbFifo(FT232H))
    assert clocks.readers(f"{UNUSED}.stage0") == {f"{UNUSED}.stage1": True}
    assert clocks.readers(f"{UNUSED}.stage3") == {}


def test_a_crossing_without_a_synchroniser_is_found(monkeypatch):
    monkeypatch.setattr(amaranth_fifo, "FFSynchronizer", Wire)
    found = {source.rpartition(".")[0] for source, _ in unknown(clocks_of(UsbFifo(FT232H)))}
    assert found >= set(QUEUES)

"""Formal proof of the bus to an FTDI chip (docs/evidence/proofs.md): covers and planted errors."""

import pytest
from amaranth import Signal

from formal.sby import FAIL, PASS, run
from formal.usb_bus import UsbBus
from ncdc_hdl.usb.fifo_bus import FifoBus


class Believes(FifoBus):
    """Takes a word for taken without a look at TXE#."""

    @staticmethod
    def _accepted(pins):
        return ~pins.wr_n


class Fills(FifoBus):
    """Reads on without space."""

    def elaborate(self, platform):
        m = super().elaborate(platform)
        m.d.sync += self.pins.rd_n.eq(self.pins.oe_n)
        return m


class Drives(FifoBus):
    """Drives the bus a clock for too long."""

    def elaborate(self, platform):
        m = super().elaborate(platform)
        wrote = Signal()
        m.d.sync += [self.pins.data_oe.eq(wrote), wrote.eq(~self.pins.wr_n)]
        return m


PLANTED = {
    "a word that the chip did not take": (Believes, "as_many"),
    "words without space": (Fills, "space"),
    "a bus that is driven for too long": (Drives, "rest"),
}


@pytest.mark.longer
def test_holds(tmp_path):
    assert run(UsbBus(), tmp_path, mode="prove", depth=4) == (PASS, set())


def test_is_reached(tmp_path):
    assert run(UsbBus(), tmp_path, mode="cover", depth=20) == (
        PASS, {"paused", "read_after_writes", "write_after"})


@pytest.mark.parametrize("bus,rule", PLANTED.values(), ids=PLANTED)
def test_planted_error_is_found(bus, rule, tmp_path):
    status, names = run(UsbBus(bus), tmp_path, mode="bmc", depth=14, only=rule)
    assert status == FAIL and {name.rpartition(".")[2] for name in names} == {rule}

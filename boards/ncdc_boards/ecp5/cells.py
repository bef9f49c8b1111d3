"""Cells at the pins of an ECP5."""

from amaranth import *

from ncdc_boards.camera_board.pins import buffer

__all__ = ["clock_out", "delayed"]


def clock_out(m, domain, port):
    """Drive a pin with a clock through a DDR register, as late as the pins' registers."""
    pin = buffer(m, port)
    m.submodules[f"{domain}_clock"] = Instance(
        "ODDRX1F", i_SCLK=ClockSignal(domain), i_RST=Const(0), i_D0=Const(1), i_D1=Const(0),
        o_Q=pin.o)


def delayed(m, name, pins):
    """Delay inputs, which change in the middle between clock edges, before their registers.

    The clock takes longer to the registers than the data would. The delay cells compensate for
    it: setup and hold times at the pins are 0.52 ns each (Lattice, FPGA-DS-02012,
    GDDRX1_RX.SCLK.Centered).
    """
    late = Signal.like(pins, name=f"{name}_delayed")
    for k, pin in enumerate(pins):
        m.submodules[f"{name}_delay{k}"] = Instance(
            "DELAYG", p_DEL_MODE="SCLK_CENTERED", i_A=pin, o_Z=late[k])
    return late

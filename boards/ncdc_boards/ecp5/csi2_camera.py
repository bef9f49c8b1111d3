"""A camera with CSI-2 at the pins of a board with an ECP5."""

from amaranth import *
from amaranth.build import Attrs, Clock, DiffPairs, Pins, Resource, Subsignal
from amaranth.lib.wiring import connect

from ncdc_boards.camera_board.pins import buffer, join_sensor_control, request
from ncdc_boards.ecp5.csi2_phy import Ecp5Csi2Phy

__all__ = ["LANE_HZ_MAX", "csi_camera", "join_csi_camera", "lane_targets"]

LANE_HZ_MAX = 456_000_000
"""Most bits per second of a lane: half of the IMX219's usual ones. Of GDDRX2 speed grade
8 takes 800 Mb/s (FPGA-DS-02012), grade 6, which the boards have, less."""

_QUICK = {"steps": 16, "stride": 8, "bursts": 2}


def lane_targets(lane_mhz):
    """MHz of the clocks that lanes of so many Mb/s give, by their names."""
    return {"sensor": lane_mhz / 8, "csi_word": lane_mhz / 4}


def csi_camera(wires, conn):
    """The resource ``csi_camera``, whose pairs end in resistors of 100 ohms in the device.

    Parameters
    ----------
    wires : dict
        ``clock`` and ``lanes``: (P, N) of each pair; ``low_power``, ``scl``, ``sda`` and
        ``reset_n``: names of wires of the connector.
    conn : (str, int)
        The connector.
    """
    def pairs(name, *more):
        sides = (" ".join(side) for side in zip(*wires[name]))
        return Subsignal(name, DiffPairs(*sides, dir="i", conn=conn),
                         Attrs(IO_TYPE="LVDS", DIFFRESISTOR="100"), *more)

    def single(name, direction, **attrs):
        return Subsignal(name, Pins(" ".join(wires[name]), dir=direction, conn=conn),
                         Attrs(**attrs))

    slow = {"IO_TYPE": "LVCMOS33", "DRIVE": "4", "SLEWRATE": "SLOW"}
    return Resource(
        "csi_camera", 0, pairs("clock", Clock(LANE_HZ_MAX / 2)), pairs("lanes"),
        single("low_power", "i", IO_TYPE="LVCMOS12", PULLMODE="NONE"),
        *(single(name, "io", PULLMODE="UP", **slow) for name in ("scl", "sda")),
        single("reset_n", "o", PULLMODE="NONE", **slow))


def join_csi_camera(m, platform, core, design):
    """Join a sensor with CSI-2, whose module has its own clock, to the core of a board.

    Parameters
    ----------
    m : Module
        Of the top.
    platform : amaranth.build.Platform
        With the resource of :func:`csi_camera`.
    core : BoardCore
    design : Design
    """
    wires = request(platform, "csi_camera",
                    ("clock", "lanes", "low_power", "scl", "sda", "reset_n"))
    # A simulation that takes no time for the sensor's reset does not for the search either.
    search = _QUICK if design.time_scale > 1 else {}
    m.submodules.csi2_phy = phy = Ecp5Csi2Phy(design.link.lanes, **search)
    m.d.comb += [
        phy.pair.eq(buffer(m, wires.clock).i), phy.pairs.eq(buffer(m, wires.lanes).i),
        phy.low_power.eq(buffer(m, wires.low_power).i),
        phy.settle.eq(core.csi_settle), core.sensor_clock.eq(phy.clock),
        core.csi_phy.eq(Cat(phy.ready, phy.failures)), core.csi_eyes.eq(Cat(phy.eyes))]
    for ours, theirs in zip(core.lanes, phy.o):
        connect(m, theirs, ours)
    join_sensor_control(m, core, wires)

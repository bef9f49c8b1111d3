"""The clocks of the Colorlight i9: one phase-locked loop of the ECP5."""

from dataclasses import dataclass
from math import isclose

from amaranth import *

from ncdc_boards.ecp5.csi2_camera import lane_targets
from ncdc_boards.ecp5.pll import Pll, gate, loop
from ncdc_spec.errors import InputError

__all__ = ["CORE_MHZ", "DOMAINS", "ClockPlan", "ColorlightI9Clocks", "clock_plan"]

REFERENCE_MHZ = 25                  # the module's oscillator, also the sensor's clock
ETHERNET_MHZ = 125                  # clock of RGMII at any speed of the line
DOMAINS = ("sync", "memory", "sensor_reference", "ethernet")
_OSCILLATOR_MHZ = 500               # divided by integers for each of these clocks
CORE_MHZ = _OSCILLATOR_MHZ / 14     # the processor, the slowest part, reached 45 MHz after routing
_EARLY = 2      # periods of the oscillator from the SDRAM's clock at its pin to the core's next one
_RESET_CLOCKS = 64                  # length of the processor's reset


@dataclass(frozen=True)
class ClockPlan:
    """The loop; ``ethernet`` is always there. ``lane_mhz``: Mb/s of the lanes of a sensor with
    CSI-2, else 0."""
    loop: Pll
    ethernet: bool = True
    lane_mhz: float = 0

    @property
    def core_mhz(self):
        return self.loop.outputs_mhz[0]

    def targets(self):
        """MHz of each domain, by its name."""
        found = dict(zip(DOMAINS, self.loop.outputs_mhz))
        if self.lane_mhz:       # a module with CSI-2 has its own reference
            del found["sensor_reference"]
            found |= lane_targets(self.lane_mhz)
        return found


def clock_plan(mode, core_mhz=CORE_MHZ):
    """The :class:`ClockPlan`; ``mode`` is None, as there is no screen.

    The clock at the SDRAM's pin is 4 ns before the core's next one, see
    docs/reference/colorlight_i9.md. The sensor's clock is fed back: it is the loop's input again.

    Raises
    ------
    InputError
        If the loop makes no such clock.
    """
    divider = round(_OSCILLATOR_MHZ / core_mhz)
    if not divider or not isclose(_OSCILLATOR_MHZ / divider, core_mhz):
        raise InputError(f"the core's clock is {core_mhz} MHz, a whole part of "
                         f"{_OSCILLATOR_MHZ} MHz is needed")
    dividers = (divider, divider, _OSCILLATOR_MHZ // REFERENCE_MHZ, _OSCILLATOR_MHZ // ETHERNET_MHZ)
    return ClockPlan(Pll(REFERENCE_MHZ, 1, 1, DOMAINS.index("sensor_reference"), dividers,
                         (0, divider - _EARLY, 0, 0)))


class ColorlightI9Clocks(Elaboratable):
    """Drives the clocks of the :data:`DOMAINS`, which its parent defines.

    The domains have no resets; their clocks start when the loop is locked. The processor has a
    reset, which its registers need.

    Parameters
    ----------
    plan : ClockPlan
    reference : Value
        The module's oscillator.

    Attributes
    ----------
    reset : Signal
        High for the first clocks of the core.
    """

    def __init__(self, plan, reference):
        self.plan, self.reference = plan, reference
        self.reset = Signal(init=1)

    def elaborate(self, platform):
        m = Module()
        outputs, locked = loop(m, "core", self.plan.loop, self.reference)
        for domain, output in zip(DOMAINS, outputs):
            gate(m, domain, output, locked)
        clock = Signal(range(_RESET_CLOCKS + 1))
        m.d.sync += self.reset.eq(clock != _RESET_CLOCKS)
        with m.If(clock != _RESET_CLOCKS):
            m.d.sync += clock.eq(clock + 1)
        return m

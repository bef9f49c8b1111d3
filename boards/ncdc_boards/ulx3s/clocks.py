"""The clocks of the ULX3S: two phase-locked loops of the ECP5."""

from dataclasses import dataclass, replace
from fractions import Fraction

from amaranth import *

from ncdc_boards.ecp5.csi2_camera import lane_targets
from ncdc_boards.ecp5.pll import OSCILLATOR_MHZ, Pll, gate, loop
from ncdc_spec.errors import InputError

__all__ = ["CORE_MHZ", "DOMAINS", "Ulx3sClocks", "ClockPlan", "clock_plan"]

REFERENCE_MHZ = 25                  # the board's oscillator
CORE_MHZ = 62.5     # the whole design reached 73.6 MHz after routing for speed grade 6
# Lattice, ECP5 and ECP5-5G Family Data Sheet (FPGA-DS-02012), sysCLOCK PLL timing.
_COMPARED = 10                      # lowest MHz at the phase detector
_OUTPUT_MHZ = 400
_LARGEST_DIVIDER, _LARGEST_FEEDBACK, _LARGEST_REFERENCE = 128, 80, 128
# The same, maximum I/O buffer speed and ODDRX1 of speed grade 6: 250 MHz, two bits a clock.
_SHIFT_MHZ = 250
DOMAINS = ("sync", "memory", "sensor_reference", "shift", "pixel")
_PIXEL_TOLERANCE = .005             # VESA, Display Monitor Timing: 0.5 % of the pixel clock


@dataclass(frozen=True)
class ClockPlan:
    """Both loops. ``core`` gives the clocks of core, SDRAM and sensor, and the input of
    ``video``. That gives five times the pixel clock, the pixel clock, and its feedback.
    ``lane_mhz``: Mb/s of the lanes of a sensor with CSI-2, else 0."""
    core: Pll
    video: Pll
    lane_mhz: float = 0

    @property
    def core_mhz(self):
        return self.core.outputs_mhz[0]

    @property
    def pixel_mhz(self):
        return self.video.outputs_mhz[1]

    def targets(self):
        """MHz of each domain, by its name."""
        core, video = self.core.outputs_mhz, self.video.outputs_mhz
        # A module with CSI-2 has its own reference.
        sensor = lane_targets(self.lane_mhz) if self.lane_mhz else {"sensor_reference": core[2]}
        return {"sync": core[0], "memory": core[1], **sensor, "shift": video[0],
                "pixel": video[1]}


def clock_plan(mode, core_mhz=CORE_MHZ):
    """The :class:`ClockPlan` for a video mode.

    The clock at the SDRAM's pin is three quarters of a period late. Commands are stable around
    its edges, and read data come in the middle between two edges of the core's clock. See
    docs/reference/ulx3s.md.

    Raises
    ------
    InputError
        If no loop makes the mode's pixel clock, or the pins are too slow for it.
    """
    divider = 4 * int(OSCILLATOR_MHZ[1] / core_mhz / 4)    # so that a quarter period is a phase
    ratio = Fraction(core_mhz) / REFERENCE_MHZ
    core = Pll(REFERENCE_MHZ, ratio.denominator, ratio.numerator, 0,
               (divider, divider, int(divider * ratio)), (0, 3 * divider // 4, 0))
    if core.outputs_mhz[2] != REFERENCE_MHZ or REFERENCE_MHZ / ratio.denominator < _COMPARED:
        raise InputError(f"the core's clock is {core_mhz} MHz, multiples of 12.5 MHz can be made")
    wanted = mode.pixel_mhz
    if 5 * wanted > _SHIFT_MHZ:
        raise InputError(f"the mode {mode.name} has a pixel clock of {wanted:.2f} MHz, the "
                         f"ULX3S's output takes {_SHIFT_MHZ / 5:.0f} MHz at most: a smaller --mode "
                         "fits, or one of fewer frames per second")
    # The second loop's input is an output of the first one, with a suitable divider.
    loops = [(abs(pll.outputs_mhz[1] - wanted), pll.reference, fed, pll.dividers, pll)
             for fed in range(4, 17) for pll in _loops(core.oscillator_mhz / fed, wanted)]
    *_, fed, _, video = min(loops, default=(None, None, None))
    if video is None or abs(video.outputs_mhz[1] / wanted - 1) > _PIXEL_TOLERANCE:
        raise InputError(f"no phase-locked loop makes {wanted:.3f} MHz of {core_mhz} MHz")
    core = replace(core, dividers=(*core.dividers, fed), phases=(*core.phases, 0))
    return ClockPlan(core, video)


def _loops(input_mhz, pixel_mhz):
    """Loops whose second output is near ``pixel_mhz`` and whose first is five times as fast."""
    for first in range(1, _LARGEST_DIVIDER // 5 + 1):
        if not OSCILLATOR_MHZ[0] <= 5 * first * pixel_mhz <= OSCILLATOR_MHZ[1]:
            continue
        for reference in range(1, min(_LARGEST_REFERENCE, int(input_mhz / _COMPARED)) + 1):
            total = round(5 * first * pixel_mhz * reference / input_mhz)
            for fed in range(1, _LARGEST_DIVIDER + 1):
                feedback, rest = divmod(total, fed)
                if rest or not 1 <= feedback <= _LARGEST_FEEDBACK:
                    continue
                pll = Pll(input_mhz, reference, feedback, 2, (first, 5 * first, fed), (0, 0, 0))
                if (OSCILLATOR_MHZ[0] <= pll.oscillator_mhz <= OSCILLATOR_MHZ[1]
                        and max(pll.outputs_mhz) <= _OUTPUT_MHZ):
                    yield pll
                    break


class Ulx3sClocks(Elaboratable):
    """Drives the clocks of the :data:`DOMAINS`, which its parent defines.

    There is no reset; the clocks start when both loops are locked.

    Parameters
    ----------
    plan : ClockPlan
    reference : Value
        The board's oscillator.
    """

    def __init__(self, plan, reference):
        self.plan, self.reference = plan, reference

    def elaborate(self, platform):
        m = Module()
        core, core_locked = loop(m, "core", self.plan.core, self.reference)
        video, video_locked = loop(m, "video", self.plan.video, core[3], ~core_locked)
        locked = Signal()
        m.d.comb += locked.eq(core_locked & video_locked)
        for domain, output in zip(DOMAINS, (*core[:3], *video)):
            gate(m, domain, output, locked)
        return m

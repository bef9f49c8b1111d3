"""The clocks of the Quartus boards: phase-locked loops of the device."""

from dataclasses import dataclass

from amaranth import *
from amaranth.lib.cdc import ResetSynchronizer

from ncdc_boards.quartus.names import CYCLONE_IV, LOOPS
from ncdc_spec.errors import InputError

__all__ = ["CORE_MHZ", "DOMAINS", "ClockPlan", "QuartusClocks", "clock_plan"]

REFERENCE_MHZ = 50                  # the boards' oscillator
CORE_MHZ = 75
SENSOR_MHZ = 25
ETHERNET_MHZ = 125                  # clock of RGMII at any speed of the line
_ETHERNET_LATE_PS = 2000            # delay of the clock at RGMII's pin: a quarter of its period
DOMAINS = ("sync", "memory", "sensor_reference", "pixel", "ethernet", "ethernet_late")
_LOOP_OF = {"pixel": LOOPS[1], "ethernet": LOOPS[2], "ethernet_late": LOOPS[2]}
# Intel, Cyclone IV Device Handbook, volume 3 (CYIV-53001), and Cyclone V Device Datasheet
# (CV-51002), PLL specifications: MHz of the oscillator in the slowest device.
_OSCILLATOR = (600, 1300)
_STEPS = 8                          # phases of the oscillator's period
_EARLY_NS = 3                       # from the clock at the SDRAM's pin to the core's next edge


@dataclass(frozen=True)
class ClockPlan:
    """Clocks of a board.

    Parameters
    ----------
    family : str
    core_mhz : number
    phase_ps : int
        Delay of the SDRAM's clock relative to the core's.
    ratio : (int, int)
        Ratio of the pixel clock to the oscillator's.
    sdram, ethernet : bool
        Whether there is a clock for an SDRAM at the device's pins, and one for Ethernet.
    """
    family: str
    core_mhz: float
    phase_ps: int
    ratio: tuple
    sdram: bool = True
    ethernet: bool = False

    @property
    def pixel_mhz(self):
        """Pixel clock in MHz."""
        return REFERENCE_MHZ * self.ratio[0] / self.ratio[1]

    def targets(self):
        """MHz of each domain, by its name."""
        mhz = {"sync": self.core_mhz, "memory": self.core_mhz, "sensor_reference": SENSOR_MHZ,
               "pixel": self.pixel_mhz, "ethernet": ETHERNET_MHZ, "ethernet_late": ETHERNET_MHZ}
        absent = ["memory"] * (not self.sdram) + list(DOMAINS[-2:]) * (not self.ethernet)
        return {name: mhz[name] for name in DOMAINS if name not in absent}

    def loops(self):
        """Names of the domains that each loop drives, in the order of its outputs."""
        found = {}
        for name in self.targets():
            found.setdefault(_LOOP_OF.get(name, LOOPS[0]), []).append(name)
        return found

    def output(self, domain):
        """(MHz or a ratio to the oscillator's, ps after the loop's first output)."""
        late = {"memory": self.phase_ps, "ethernet_late": _ETHERNET_LATE_PS}
        return (self.ratio if domain == "pixel" else self.targets()[domain]), late.get(domain, 0)


def clock_plan(mode, core_mhz=CORE_MHZ, *, family, max_mhz, sdram=True):
    """The :class:`ClockPlan` for a video mode.

    The SDRAM's clock comes 3 ns before the core's next edge, at the nearest phase that the loop
    has. Its inputs are stable for the rest of a period before, and for those 3 ns after.

    Parameters
    ----------
    mode : VideoMode
    core_mhz : number
    family : str
    max_mhz : number
        Highest pixel clock of the board's converter.
    sdram : bool
        As in :class:`ClockPlan`.

    Raises
    ------
    InputError
        If the converter is too slow for the mode, or the core's clock cannot be made.
    """
    if mode.pixel_mhz > max_mhz:
        raise InputError(f"the mode {mode.name} has a pixel clock of {mode.pixel_mhz:.1f} MHz, the "
                         f"board's converter takes {max_mhz:g} MHz at most: a smaller --mode fits")
    oscillator = next((SENSOR_MHZ * k for k in range(1, _OSCILLATOR[1] // SENSOR_MHZ + 1)
                       if SENSOR_MHZ * k >= _OSCILLATOR[0] and not SENSOR_MHZ * k % core_mhz), None)
    if oscillator is None:
        raise InputError(f"no phase-locked loop makes {core_mhz} and {SENSOR_MHZ} MHz together")
    step, period = 1e6 / oscillator / _STEPS, 1e6 / core_mhz
    steps = round((period - 1000 * _EARLY_NS) / step)
    return ClockPlan(family, core_mhz, round(steps * step), mode.ratio, sdram)


class QuartusClocks(Elaboratable):
    """Drives the clocks of the plan's domains, which its parent defines, and their resets.

    The core and the pixel domain are in reset until all loops are locked.

    Parameters
    ----------
    plan : ClockPlan
    reference, restart : Value
        The board's oscillator; high restarts the loops.
    """

    def __init__(self, plan, reference, restart):
        self.plan, self.reference, self.restart = plan, reference, restart

    def elaborate(self, platform):
        m = Module()
        loop = self._cyclone_iv if self.plan.family == CYCLONE_IV else self._cyclone_v
        locks = []
        for name, domains in self.plan.loops().items():
            outputs, locked = loop(m, name, [self.plan.output(domain) for domain in domains])
            locks.append(locked)
            m.d.comb += [ClockSignal(domain).eq(output)
                         for domain, output in zip(domains, outputs)]
        unlocked = Signal()
        m.d.comb += unlocked.eq(~Cat(locks).all())
        for domain in self.plan.targets():
            if domain in ("sync", "pixel"):
                m.submodules[f"{domain}_reset"] = ResetSynchronizer(unlocked, domain=domain)
            else:
                m.d.comb += ResetSignal(domain).eq(0)
        return m

    def _cyclone_iv(self, m, name, outputs):
        """Outputs of an ALTPLL, and a signal that is high when it is locked."""
        clocks, locked = Signal(5, name=f"{name}_outputs"), Signal(name=f"{name}_locked")
        parameters = {}
        for k, (mhz, late_ps) in enumerate(outputs):
            up, down = mhz if isinstance(mhz, tuple) else _ratio(mhz)
            parameters |= {f"p_CLK{k}_MULTIPLY_BY": up, f"p_CLK{k}_DIVIDE_BY": down,
                           f"p_CLK{k}_PHASE_SHIFT": str(late_ps), f"p_CLK{k}_DUTY_CYCLE": 50,
                           f"p_PORT_CLK{k}": "PORT_USED"}
        m.submodules[name] = Instance(
            "altpll", p_OPERATION_MODE="NORMAL", p_COMPENSATE_CLOCK="CLK0",
            p_BANDWIDTH_TYPE="AUTO", p_WIDTH_CLOCK=5, p_PORT_LOCKED="PORT_USED",
            p_PORT_ARESET="PORT_USED", p_INCLK0_INPUT_FREQUENCY=round(1e6 / REFERENCE_MHZ),
            i_inclk=Cat(self.reference, Const(0, 1)), i_areset=self.restart, o_clk=clocks,
            o_locked=locked, **parameters)
        return list(clocks)[:len(outputs)], locked

    def _cyclone_v(self, m, name, outputs):
        """Outputs of an ALTERA_PLL, and a signal that is high when it is locked."""
        clocks, locked = (Signal(len(outputs), name=f"{name}_outputs"),
                          Signal(name=f"{name}_locked"))
        parameters = {}
        for k, (mhz, late_ps) in enumerate(outputs):
            mhz = REFERENCE_MHZ * mhz[0] / mhz[1] if isinstance(mhz, tuple) else mhz
            parameters |= {f"p_output_clock_frequency{k}": f"{mhz:.6f} MHz",
                           f"p_phase_shift{k}": f"{late_ps} ps", f"p_duty_cycle{k}": 50}
        m.submodules[name] = Instance(
            "altera_pll", p_fractional_vco_multiplier="false",
            p_reference_clock_frequency=f"{REFERENCE_MHZ:.1f} MHz", p_operation_mode="normal",
            p_number_of_clocks=len(outputs), p_pll_type="General", p_pll_subtype="General",
            i_rst=self.restart, i_refclk=self.reference, i_fbclk=Const(0), o_outclk=clocks,
            o_locked=locked, **parameters)
        return list(clocks), locked


def _ratio(mhz):
    """Ratio of a clock to the reference, as two numbers."""
    up, down = (float(mhz) / REFERENCE_MHZ).as_integer_ratio()
    return up, down

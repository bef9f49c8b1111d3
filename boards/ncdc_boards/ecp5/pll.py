"""Phase-locked loops of the ECP5, and gates of clocks."""

from dataclasses import dataclass

from amaranth import *

__all__ = ["OSCILLATOR_MHZ", "Pll", "gate", "loop"]

# Lattice, ECP5 and ECP5-5G Family Data Sheet (FPGA-DS-02012), sysCLOCK PLL timing.
OSCILLATOR_MHZ = (400, 800)


@dataclass(frozen=True)
class Pll:
    """Dividers of an EHXPLLL.

    Parameters
    ----------
    input_mhz : number
    reference, feedback : int
        Dividers before the phase detector, of the input and of the feedback.
    source : int
        Which output is fed back.
    dividers : tuple of int
        Dividers of the oscillator for each output.
    phases : tuple of int
        Delay of each output in periods of the oscillator.
    """
    input_mhz: float
    reference: int
    feedback: int
    source: int
    dividers: tuple
    phases: tuple

    @property
    def oscillator_mhz(self):
        """Frequency of the voltage-controlled oscillator in MHz."""
        return (self.input_mhz * self.feedback * self.dividers[self.source] / self.reference)

    @property
    def outputs_mhz(self):
        """Frequency of each output in MHz."""
        return tuple(self.oscillator_mhz / divider for divider in self.dividers)

    def parameters(self):
        """Parameters of the cell, by name."""
        names = ("OP", "OS", "OS2", "OS3")
        values = {"CLKI_DIV": self.reference, "CLKFB_DIV": self.feedback,
                  "FEEDBK_PATH": f"INT_{names[self.source]}", "OUTDIVIDER_MUXA": "DIVA",
                  "OUTDIVIDER_MUXB": "DIVB", "OUTDIVIDER_MUXC": "DIVC", "OUTDIVIDER_MUXD": "DIVD",
                  "PLLRST_ENA": "ENABLED", "INTFB_WAKE": "DISABLED", "STDBY_ENABLE": "DISABLED",
                  "DPHASE_SOURCE": "DISABLED", "PLL_LOCK_MODE": 0}
        for name, divider, phase in zip(names, self.dividers, self.phases):
            values |= {f"CLK{name}_ENABLE": "ENABLED", f"CLK{name}_DIV": divider,
                       f"CLK{name}_CPHASE": divider - 1 + phase, f"CLK{name}_FPHASE": 0}
        return values


def loop(m, name, pll, clock, reset=Const(0)):
    """Outputs of a :class:`Pll`, and a signal that is high when it is locked."""
    outputs = [Signal(name=f"{name}_output{k}") for k in range(len(pll.dividers))]
    locked, fed_back = Signal(name=f"{name}_locked"), Signal(name=f"{name}_fed_back")
    m.submodules[f"{name}_loop"] = Instance(
        "EHXPLLL", **{f"p_{key}": value for key, value in pll.parameters().items()},
        i_CLKI=clock, i_CLKFB=fed_back, o_CLKINTFB=fed_back, i_RST=reset, i_STDBY=Const(0),
        i_PHASESEL0=Const(0), i_PHASESEL1=Const(0), i_PHASEDIR=Const(0), i_PHASESTEP=Const(0),
        i_PHASELOADREG=Const(0), i_PLLWAKESYNC=Const(0), i_ENCLKOP=Const(0),
        i_ENCLKOS=Const(0), i_ENCLKOS2=Const(0), i_ENCLKOS3=Const(0), o_LOCK=locked,
        **{f"o_CLK{port}": signal for port, signal in zip(("OP", "OS", "OS2", "OS3"), outputs)})
    return outputs, locked


def gate(m, domain, output, open_):
    """Drive a domain's clock from a loop's output while ``open_``; it has no reset.

    The bitstream initialises the registers. A reset would be a net to every register of
    the device, and the slowest net.
    """
    clock = Signal(name=f"{domain}_gated")
    m.submodules[f"{domain}_gate"] = Instance("DCCA", i_CLKI=output, i_CE=open_, o_CLKO=clock)
    m.d.comb += [ClockSignal(domain).eq(clock), ResetSignal(domain).eq(0)]

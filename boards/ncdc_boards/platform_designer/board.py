"""What a board tells of itself."""

from dataclasses import dataclass, field

__all__ = ["Board", "Pll", "Sdram"]


@dataclass(frozen=True)
class Pll:
    """Clocks made from the board's oscillator by the device's phase-locked loop.

    Parameters
    ----------
    reference_mhz, core_mhz : float
        The oscillator; the clock of corrector and memory controller.
    sdram_phase_ps : int
        By how much the clock at the SDRAM's pin leads (negative) or trails the core's.
    """
    reference_mhz: float
    core_mhz: float
    sdram_phase_ps: int = 0


@dataclass(frozen=True)
class Sdram:
    """Single data rate SDRAM, as Platform Designer's SDRAM controller wants it described.

    Parameters: data width and number of row, column and bank address bits of all chips
    together, and the chip's timing in ns (``refresh_us``: between two refreshes, in us) with
    the clocks of CAS latency.
    """
    data_width: int
    rows: int
    columns: int
    banks: int
    cas_latency: int
    t_ac: float
    t_rcd: float
    t_rfc: float
    t_rp: float
    t_wr: float
    refresh_us: float

    @property
    def bytes(self):
        """Size of the memory."""
        return (self.banks << (self.rows + self.columns)) * self.data_width // 8


@dataclass(frozen=True)
class Board:
    """A board that ``ncdc generate --board`` writes a Quartus project for.

    Parameters
    ----------
    name, title : str
        As given on the command line; for people.
    family, device : str
        As Quartus names them.
    platform : type or None
        Subclass of ``amaranth.vendor.AlteraPlatform`` with the resources clk50, rst, sdram and
        vga; None where the pin-out is not known.
    pll : Pll
    data_width : int
        Bits of the corrector's memory ports.
    memory : str
        The memory model that stands for this board's memory in plan and simulation.
    sdram : Sdram or None
        None where the user brings the memory controller.
    multipliers : int
        Multiplier blocks of the device.
    multiplier_bits : int
        18 or 27: what one of them multiplies.
    sources : tuple of str
        Where the pins are published.
    left_to_user : dict
        What the project does not hold: {what: why}.
    """
    name: str
    title: str
    family: str
    device: str
    platform: type | None
    pll: Pll
    data_width: int
    memory: str
    sdram: Sdram | None
    multipliers: int
    multiplier_bits: int
    sources: tuple
    left_to_user: dict = field(default_factory=dict)

"""Description of a board without a memory controller of this project."""

from dataclasses import dataclass, field

from ncdc_boards.platform_designer.project import project_files

__all__ = ["DesignerBoard"]


@dataclass(frozen=True)
class DesignerBoard:
    """A board for which ``ncdc generate --board`` writes a project for Platform Designer.

    Parameters
    ----------
    name, title : str
        As given on the command line; the name for people.
    family, device : str
        As Quartus names them.
    core_mhz : float
        Clock of the corrector.
    data_width : int
        Bits of the corrector's memory ports.
    multiplier_bits : int
        18 or 27: what a multiplier block of the device multiplies.
    sources : tuple of str
        Where the board is described.
    left_to_user : dict
        Parts that the project lacks: {what: why}.
    """
    name: str
    title: str
    family: str
    device: str
    core_mhz: float
    data_width: int
    multiplier_bits: int
    sources: tuple
    left_to_user: dict = field(default_factory=dict)

    commands = "generate",

    @property
    def elsewhere(self):
        return ("has no design of ours, its project for Platform Designer is made by ncdc generate "
                f"--board {self.name}")

    def files(self, design, sources=()):
        """:func:`~ncdc_boards.platform_designer.project.project_files` of a corrector;
        ``sources``: none."""
        return project_files(self, design)

"""A board for Quartus, beyond that of every board."""

from dataclasses import dataclass

from ncdc_boards.camera_board.board import CameraBoard
from ncdc_boards.quartus.project import USER_FILE, project_files
from ncdc_boards.quartus.sdc import check_sensor

__all__ = ["QuartusBoard"]


@dataclass(frozen=True)
class QuartusBoard(CameraBoard):
    """A board for which ``ncdc build`` writes a project for Quartus.

    Parameters
    ----------
    family : str
        As Quartus names it.
    dac : bool
        VGA goes through a converter ADV7123, with a clock; else through resistors.
    """
    family: str = ""
    dac: bool = False
    jtag: bool = True

    tools = "quartus"
    user_files = USER_FILE,

    def design(self, named, request, plan):
        check_sensor(request.settings)
        return super().design(named, request, plan)

    def files(self, design, sources=()):
        """:func:`~ncdc_boards.quartus.project.project_files`."""
        return project_files(design, sources)

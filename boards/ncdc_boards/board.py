"""What the commands need of a board: see docs/howto/new_board.md."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Protocol

__all__ = ["Board", "CorrectorBoard", "PlannedBoard", "Request", "WholeBoard", "project_name"]


@dataclass(frozen=True)
class Request:
    """What is asked of a board's design.

    Parameters
    ----------
    sensor : str
        Its name; the default is that of the Terasic D5M.
    mode : str or None
        Name of a video mode; None: the smallest that holds the picture.
    settings : dict
        Settings of the sensor that are not the default: ``exposure_us``, ``pixel_clock_hz``,
        ``field``.
    lanes : int
        Pixels per clock.
    colour : bool
        With gains and a tone curve.
    processor : bool
        With a processor and Ethernet.
    """
    sensor: str = "mt9p031"
    mode: str | None = None
    settings: Mapping = field(default_factory=dict)
    lanes: int = 1
    colour: bool = False
    processor: bool = False


class Board(Protocol):
    """A board that a command takes with ``--board``.

    Parameters
    ----------
    name, title : str
        As given on the command line; the name for people.
    commands : tuple of str
        Commands of ``ncdc`` that take it.
    elsewhere : str
        End of the sentence with which the others reject it: what to type instead.
    """
    name: str
    title: str
    commands: tuple
    elsewhere: str

    def files(self, design: Any, sources: Sequence = ()) -> dict:
        """Text of each file of the project, by name.

        ``sources``: names of more Verilog files, of a processor.
        """


class CorrectorBoard(Board, Protocol):
    """A board whose project is around a corrector of ``ncdc generate``, the design of ``files``.

    Parameters
    ----------
    data_width : int
        Bits of the corrector's memory ports.
    multiplier_bits : int
        18 or 27: what a multiplier block of the device multiplies.
    left_to_user : dict
        Parts that the project lacks: {what: why}.
    """
    data_width: int
    multiplier_bits: int
    left_to_user: dict


class WholeBoard(Board, Protocol):
    """A board whose whole design ``ncdc build`` makes, from the sensor's pins to the picture.

    Parameters
    ----------
    tools : str
        "open": ``ncdc build`` makes the bitstream of the files, for an ECP5; "quartus": the files
        are a project of Quartus.
    user_files : tuple of str
        Files that are the user's once they exist.
    """
    tools: str
    user_files: tuple

    def design(self, named: Sequence, request: Request, plan: Callable) -> Any:
        """The design that shows the first lens.

        It has the attributes ``board``, ``system``, ``mode``, ``clocks`` (with ``core_mhz`` and
        ``targets()``), ``processor`` and ``sensor``, a :class:`~ncdc_spec.sensors.sensor.Setup`
        and a :class:`~ncdc_spec.sensors.framing.Crop`.

        Parameters
        ----------
        named : sequence of (path, Descriptor)
        request : Request
        plan : callable
            From :class:`~ncdc_spec.hardware.Hardware` and a descriptor to the Hardware with its
            tile cache.

        Raises
        ------
        InputError
            If the board lacks what is requested, or cannot carry the picture.
        """

    def rates(self, design: Any) -> dict:
        """Rates of memory and sensor per second, by the names of every report."""


class PlannedBoard(WholeBoard, Protocol):
    """A board whose memory ``ncdc plan`` judges.

    Parameters
    ----------
    memory_bytes : int
        Size of the memory.
    """
    memory_bytes: int

    def budget(self, design: Any) -> Any:
        """The :class:`~ncdc_boards.camera_board.budget.Budget` of a design."""


def project_name(board):
    """Name of a board's project, of its files and of its top."""
    return "ncdc_" + board.name.replace("-", "_")

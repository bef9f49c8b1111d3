"""A board of your own: a DE0-CV with the camera on its other header, and a Quartus project for it.

    python examples/own_board.py net.toml [folder]

``ncdc build --board my-board`` finds a board of another package through that package's entry point:

    [project.entry-points."ncdc.boards"]
    my-board = "my_package.own_board:BOARD"
"""

import sys
import warnings
from dataclasses import replace
from pathlib import Path

from amaranth.hdl import UnusedElaboratable
from amaranth_boards.de0_cv import DE0CVPlatform

from ncdc.cli.board_design import planner
from ncdc_boards.board import Request
from ncdc_boards.quartus.de0_cv import BOARD as DE0_CV
from ncdc_boards.quartus.de0_cv import De0CvPlatform
from ncdc_boards.quartus.resources import camera, serial
from ncdc_spec.descriptor import Descriptor
from ncdc_spec.errors import InputError

CAMERA, SERIAL = ("j", 2), ("j", 1)     # GPIO 1 and GPIO 0, as amaranth-boards numbers them


class MyPlatform(De0CvPlatform):
    """The DE0-CV with the camera on GPIO 1 and the serial port on GPIO 0."""
    resources = [
        *(one for one in De0CvPlatform.resources if one.name not in ("camera", "uart")),
        camera(CAMERA), serial(SERIAL),
    ]


# Everything else is the DE0-CV's: device, SDRAM chip, clocks. A board with another chip or
# oscillator states them here as boards/ncdc_boards/quartus/de0_cv.py does.
BOARD = replace(DE0_CV, name="my-board", title="DE0-CV, camera on GPIO 1", platform=MyPlatform,
                sources=(DE0CVPlatform.__module__, "the camera's cable"))


def main(network, output="my_board"):
    """Write the project of the network's descriptor; return its files, texts by name.

    Raises
    ------
    InputError
        If the descriptor cannot be read, or the board cannot carry it.
    """
    # The planner asks modules for their clocks and does not elaborate them.
    warnings.simplefilter("ignore", UnusedElaboratable)
    design = BOARD.design([(network, Descriptor.load(network))], Request(), planner())
    files = BOARD.files(design)
    folder = Path(output)
    folder.mkdir(parents=True, exist_ok=True)
    for name, text in files.items():
        (folder / name).write_text(text)
    rates = BOARD.rates(design)
    print(f"{folder}: {len(files)} files, {rates['corrected_frames_per_second']:.0f} corrected "
          f"frames a second; sh {folder}/build.sh makes the bitstream, with Quartus Prime Lite")
    return files


if __name__ == "__main__":
    try:
        main(*sys.argv[1:3])
    except InputError as error:
        sys.exit(f"own_board: {error}")

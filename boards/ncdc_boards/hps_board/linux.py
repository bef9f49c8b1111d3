"""What Linux on the board's processor needs: device tree, settings, and the program that starts."""

import json
from importlib.resources import files

from ncdc_boards.camera_board.set_up import camera_values
from ncdc_boards.hps_board.adv7513 import I2C_ADDRESS, WRITES
from ncdc_boards.quartus.project import project_name
from ncdc_hdl.export.axi.device_tree import Place, device_tree
from ncdc_model.interface.system_map import SYSTEM_WORDS_BITS

__all__ = ["REGISTERS", "host_files"]

REGISTERS = 0xFF20_0000         # where the ARM has the lightweight bridge (HPS manual, address map)
_INTERRUPT = 40                 # of f2h_irq0, among the shared ones (number 72 of all)


def host_files(design, setup, corner):
    """``ncdc_<board>.dtsi``, ``ncdc_board.json``, ``ncdc_board.py``, by name.

    Parameters: as of :func:`ncdc_boards.hps_board.project.project_files`.
    """
    board = design.board
    base, size = board.frames
    name = project_name(board)
    settings = {
        "board": board.name, "frames": base, "frame_bytes": size,
        "registers": camera_values(setup, corner, round(board.core_mhz * 1e6)),
        "sensor": setup.report(),
        "transmitter": {
            "i2c_address": I2C_ADDRESS, "pointer_bits": 8, "value_bits": 8,
            "writes": [{"register": register, "value": value, "meaning": meaning}
                       for register, value, meaning in WRITES]}}
    return {
        f"{name}.dtsi": device_tree(name, Place(
            REGISTERS, 4 << SYSTEM_WORDS_BITS, base, size, _INTERRUPT, fixed=True)),
        "ncdc_board.json": json.dumps(settings, indent=1) + "\n",
        "ncdc_board.py": (files("ncdc_boards.hps_board") / "host/ncdc_board.py").read_text()}

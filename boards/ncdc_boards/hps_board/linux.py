"""What Linux on the board's processor needs: device tree, settings, and the program that starts."""

import json
from dataclasses import asdict
from importlib.resources import files

from ncdc_boards.board import project_name
from ncdc_boards.camera_board.programs import camera_values
from ncdc_boards.hps_board.adv7513 import I2C_ADDRESS, WRITES
from ncdc_boards.hps_board.ports import PORT_RESETS, PORT_RESETS_ALL, port_resets
from ncdc_hdl.export.ip.axi.device_tree import ModuleResources, device_tree
from ncdc_spec.frames import output_format
from ncdc_spec.pixel_formats import raw_format
from ncdc_spec.protocols.table_one import SYSTEM_PAGE, SYSTEM_WORDS, TCP_PORT, server_settings
from ncdc_spec.registers.system_map import SYSTEM_WORDS_BITS
from ncdc_spec.sensors.framing import Crop, field_values

__all__ = ["REGISTERS", "host_files"]

REGISTERS = 0xFF20_0000         # where the ARM has the lightweight bridge (HPS manual, address map)
_INTERRUPT = 40                 # f2h_irq0 among the shared interrupts (number 72 of all)
_SILENT = 0xFFFF                # value read if the sensor does not answer, as over USB
_HOST = ("ncdc_board.py", "ncdc_server.py")


def host_files(design):
    """``ncdc_<board>.dtsi``, ``ncdc_board.json``, and the programs, by name, for a
    :class:`~ncdc_boards.hps_board.core.HpsDesign`."""
    board, (setup, corner) = design.board, design.sensor
    base, size = board.frames
    name = project_name(board)
    clock_hz = round(board.core_mhz * 1e6)
    settings = {
        "board": board.name, "frames": base, "frame_bytes": size, "clock_hz": clock_hz,
        "port_resets": {"address": PORT_RESETS, "all": PORT_RESETS_ALL, "used": port_resets()},
        "registers": camera_values(setup, corner, clock_hz),
        "sensor": setup.report() | {"user_registers": [
            asdict(one) for one in setup.sensor.user_registers]},
        **_pictures(design.system), "table": _table(),
        "field": field_values(setup, Crop(*corner), design.system.descriptor.geometry),
        "transmitter": {
            "i2c_address": I2C_ADDRESS, "pointer_bits": 8, "value_bits": 8,
            "writes": [{"register": register, "value": value, "meaning": meaning}
                       for register, value, meaning in WRITES]}}
    return {
        f"{name}.dtsi": device_tree(name, ModuleResources(
            REGISTERS, 4 << SYSTEM_WORDS_BITS, base, size, _INTERRUPT, fixed=True)),
        "ncdc_board.json": json.dumps(settings, indent=1) + "\n",
        "ncdc_table_users.py": (files("ncdc_spec.protocols") / "table_users.py").read_text(),
        **{file: (files("ncdc_boards.hps_board") / "host" / file).read_text() for file in _HOST}}


def _pictures(system):
    """Description of the pictures for the server."""
    form = output_format(system.hardware.format)
    raw = raw_format(system.descriptor.geometry)
    return {"pixel_bytes": form.pixel_bytes, "formats": {"raw": raw.mraw,
                                                         "corrected": form.sent.mraw}}


def _table():
    """Table I, for a program that cannot import it."""
    return server_settings() | {
        "port": TCP_PORT, "page": SYSTEM_PAGE, "silent": _SILENT,
        "words": {word.name: word.address for word in SYSTEM_WORDS}}

"""What commands need of a board: each board of the catalogue has it, in its documented form."""

import pytest

from cameras import barrel_descriptor
from ncdc.cli.board_design import planner
from ncdc_boards.board import Request
from ncdc_boards.catalogue import board, board_for, board_names
from ncdc_hdl.corrector import Corrector
from ncdc_spec.errors import InputError
from ncdc_spec.hardware import Hardware
from ncdc_spec.sensors.framing import Crop
from ncdc_spec.sensors.sensor import Setup

COMMANDS = "build", "plan", "generate"


@pytest.mark.parametrize("name", board_names())
def test_a_board_is_taken_by_its_commands_and_by_no_other(name):
    found = board(name)
    assert found.name == name and found.title and set(found.commands) <= set(COMMANDS)
    for command in COMMANDS:
        if command in found.commands:
            assert board_for(command, name) is found
            continue
        with pytest.raises(InputError, match=f"^the board {name} .*ncdc "):
            board_for(command, name)


@pytest.mark.parametrize("name", [name for name in board_names()
                                  if "build" in board(name).commands])
def test_a_design_has_what_commands_read(name):
    found = board(name)
    lens = barrel_descriptor((64, 48), (64, 48), hidden_neurons=2)
    design = found.design([("a", lens)], Request(), planner())
    setup, crop = design.sensor
    assert isinstance(setup, Setup) and isinstance(crop, Crop)
    assert design.board is found and design.system.descriptor is lens
    assert design.clocks.targets()["sync"] == design.clocks.core_mhz
    assert isinstance(design.processor, bool) and (design.mode is None) != bool(
        getattr(found, "screen", True))
    assert found.rates(design)["sensor_frames_per_second"] == setup.timing.frames_per_second
    assert found.tools in ("open", "quartus")
    if "plan" in found.commands:
        assert found.memory_bytes > 1e6 and found.budget(design).carried > 1e7


@pytest.mark.longer
@pytest.mark.parametrize("name", [      # one of each class
    "ulx3s", *(pytest.param(name, marks=pytest.mark.regress)
               for name in ("de0-cv", "de10-nano", "faka2"))])
def test_files_carry_the_board_s_name(name):
    found = board(name)
    lens = barrel_descriptor((64, 48), (64, 48), hidden_neurons=2)
    if "build" in found.commands:
        design = found.design([("a", lens)], Request(), planner())
    else:
        design = Corrector(lens, Hardware(output="stream", data_width=found.data_width))
    files = found.files(design)
    assert any(file.startswith("ncdc_" + name.replace("-", "_") + ".") for file in files)
    assert all(isinstance(text, str) and text for text in files.values())
    assert set(getattr(found, "user_files", ())) <= set(files)

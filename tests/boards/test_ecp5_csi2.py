"""A camera with CSI-2 on boards with an ECP5: wires, rates, programs; other boards reject it."""

import pytest

from cameras import barrel_descriptor
from ncdc.cli import main
from ncdc_boards.board import Request
from ncdc_boards.camera_board.design import design_of, requested_sensor
from ncdc_boards.camera_board.programs import register_addresses
from ncdc_boards.catalogue import board
from ncdc_boards.colorlight_i9.platform import ColorlightI9Platform
from ncdc_boards.ecp5.build import clock_cells, prepared
from ncdc_boards.ecp5.csi2_camera import LANE_HZ_MAX
from ncdc_boards.ulx3s.platform import CSI_WIRES, Ulx3sPlatform
from ncdc_hdl.camera.csi2.burst_start import settle_clocks
from ncdc_hdl.registers.program import Op
from ncdc_hdl.video.modes import MODES
from ncdc_spec.interpolation import INTERPOLATIONS
from ncdc_spec.sensors.csi2 import DataType

ULX3S, I9 = board("ulx3s"), board("colorlight-i9")


def designed(name, on=ULX3S):
    """The design of a board, the Colorlight i9's with its processor."""
    descriptor = barrel_descriptor((64, 24), (64, 24), hidden_neurons=2, strength=.4,
                                   interpolation=INTERPOLATIONS[on.interpolations[0]])
    sensor = requested_sensor(Request(sensor=name), descriptor.geometry, on)
    mode, processor = (MODES[0], False) if on.screen else (None, True)
    return design_of(on, [("net", descriptor)], sensor, mode, processor=processor)


def wires_of(platform):
    """Pins of the device at each wire of the camera."""
    found = {}
    for part in platform.lookup("csi_camera").ios:
        pins = part.ios[0]
        for side in ("p", "n") if hasattr(pins, "p") else ("",):
            names = getattr(pins, side) if side else pins
            found[part.name + side] = list(names.map_names(platform._conn_pins, part))
    return found


def test_wires_are_pairs_of_the_header():
    """Of nextpnr's device: F4 and E3, G3 and F3, H4 and G5 are PIOA and PIOB of one cell each."""
    platform = Ulx3sPlatform()
    assert wires_of(platform) == {"clockp": ["G3"], "clockn": ["F3"], "lanesp": ["F4", "H4"],
                     "lanesn": ["E3", "G5"], "low_power": ["C4", "B4"], "scl": ["A6"],
                     "sda": ["B6"], "reset_n": ["A5"]}
    assert set(CSI_WIRES) == {part.name for part in platform.lookup("csi_camera").ios}


def test_wires_are_pairs_of_the_i9s_header():
    """Of nextpnr's device J20 and K20, L18 and M18 are PIOC and PIOD, U18 and U17 PIOA and PIOB of
    a cell of the right side each. J20 is PCLKT2_0 of Project Trellis, a clock's pin there."""
    assert wires_of(ColorlightI9Platform()) == {
        "clockp": ["J20"], "clockn": ["K20"], "lanesp": ["L18", "U18"], "lanesn": ["M18", "U17"],
        "low_power": ["L20", "P18"], "scl": ["R17"], "sda": ["R18"], "reset_n": ["K18"]}


@pytest.mark.parametrize("on", [ULX3S, I9], ids=lambda on: on.name)
@pytest.mark.parametrize("name,lane_hz", [("imx219", 456_000_000), ("ov5647", 437_500_000)])
def test_lanes_are_as_fast_as_the_device_takes(name, lane_hz, on):
    design = designed(name, on)
    assert design.link.lane_hz == lane_hz <= LANE_HZ_MAX
    assert abs(design.sensor[0].timing.frames_per_second - 24) < .02
    targets = design.clocks.targets()
    assert (targets["sensor"], targets["csi_word"]) == (lane_hz / 8e6, lane_hz / 4e6)
    assert set(targets) == set(clock_cells(design)) - {"ethernet_received"}
    at = register_addresses(design.system)
    assert (Op.WRITE, at["CSI_TYPE"], DataType.RAW10) in design.programs[0]
    assert (Op.WRITE, at["CSI_SETTLE"], settle_clocks(lane_hz)) in design.programs[0]
    # T_HS-SETTLE of D-PHY, with the three clocks of the registers.
    settled = (settle_clocks(lane_hz) + 3) * 8e9 / lane_hz
    assert 85 + 6e9 / lane_hz <= settled <= 145 + 10e9 / lane_hz


def test_a_long_exposure_is_slower():
    geometry = barrel_descriptor((64, 24), (64, 24), hidden_neurons=2).geometry
    request = Request(sensor="imx219", settings={"exposure_us": 100_000.0})
    setup, _ = requested_sensor(request, geometry, ULX3S)
    assert 9.9 < setup.timing.frames_per_second < 10


@pytest.mark.longer
@pytest.mark.parametrize("on,sites,other", [
    (ULX3S, ("G3", "F4", "H4"), "E3"),
    pytest.param(I9, ("J20", "L18", "U18"), "M18", marks=pytest.mark.regress)],
    ids=["ulx3s", "colorlight-i9"])
def test_preferences_of_the_pins(on, sites, other):
    text = next(text for name, text in prepared(designed("imx219", on)).items()
                if name.endswith(".lpf"))
    for site in sites:
        port = next(line.split('"')[1] for line in text.splitlines() if f'SITE "{site}"' in line)
        line = next(line for line in text.splitlines() if f'IOBUF PORT "{port}"' in line)
        assert "IO_TYPE=LVDS" in line and "DIFFRESISTOR=100" in line
    assert "228000000" in text and f'SITE "{other}"' not in text


@pytest.mark.parametrize("name", ["de1-soc", "de10-nano"])
def test_boards_without_lanes_reject_it(name, tmp_path, capsys):
    net = tmp_path / "net.toml"
    barrel_descriptor((64, 24), (64, 24), hidden_neurons=2, strength=.4).save(net)
    output = tmp_path / "out"
    arguments = ["build", str(net), "--board", name, "--sensor", "imx219", "-o", str(output)]
    assert main(arguments) == 2 and not output.exists()
    said = capsys.readouterr().err
    assert f"the sensor imx219 has CSI-2 lanes, the {name} takes parallel sensors" in said

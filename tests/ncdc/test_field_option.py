"""``--field``: what build and plan say of the part of the sensor, and what they reject."""

import json

import pytest

from cameras import barrel_descriptor
from ncdc.cli import main


@pytest.fixture(scope="module")
def net(tmp_path_factory):
    path = tmp_path_factory.mktemp("field") / "net.toml"
    barrel_descriptor((640, 480), (640, 480), hidden_neurons=2, bayer="GRBG").save(path)
    return str(path)


@pytest.mark.parametrize("options,shown,photos", [
    ([], "2560x1920+14+4 of the mt9p031's 2592x1944 pixels, 99 % of each side; reduced by 4: the "
     "sensor skips by 4 and bins 2", "2560x1920 pixels, reduced to 640x480"),
    (["--sensor", "ov5640"], "2560x1920+16+12 of the ov5640's 2592x1944 pixels, 99 % of each side; "
     "reduced by 4: the sensor skips by 2 and bins 2, the FPGA bins 2", "reduced to 640x480"),
    (["--sensor", "mt9d111"], "1280x960+159+119 of the mt9d111's 1600x1200 pixels, 80 % of each "
     "side; reduced by 2: the sensor skips by 2", "1280x960 pixels, reduced to 640x480"),
    (["--field", "640x480"], "640x480+976+732 of the mt9p031's 2592x1944 pixels, 25 % of each "
     "side; every pixel is read", "these 640x480 pixels")])
def test_plan_says_what_is_seen(net, options, shown, photos, capsys):
    assert main(["plan", net, "--board", "ulx3s", *options]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert f"raw frames show {shown}" in lines
    assert photos in next(line for line in lines if line.startswith("photos for ncdc calibrate"))


@pytest.mark.parametrize("board", [
    pytest.param("de1-soc", marks=pytest.mark.longer), "de10-nano"])
def test_build_says_what_is_seen_and_writes_it(net, board, tmp_path, capsys):
    assert main(["build", net, "--board", board, "-o", str(tmp_path), "--field", "1280x960+0+0",
                 "--json", "-"]) == 0
    field = json.loads(capsys.readouterr().out)["field"]
    assert field == {"left": 0, "top": 2, "width": 1280, "height": 960, "sensor_width": 2592,
                     "sensor_height": 1944, "reduction": 2, "sensor_skip": 2, "sensor_bins": 2,
                     "fpga_binning": 1}
    if board == "de10-nano":
        registers = json.loads((tmp_path / "ncdc_board.json").read_text())["registers"]
        assert registers["GRID_WEIGHT"] == 2 and registers["GRID_BIN"] == 0


@pytest.mark.parametrize("command", [
    ["build", "--board", "de1-soc"], ["build", "--board", "de10-nano"],
    ["plan", "--board", "ulx3s"], ["plan", "--sensor", "mt9p031"],
    ["simulate", "PHOTO", "--sensor", "mt9p031", "-o", "OUT"]])
def test_a_bad_field_is_one_sentence(net, command, tmp_path, capsys):
    photo = tmp_path / "photo.png"
    name, *options = [str(photo) if one == "PHOTO" else one for one in command]
    output = tmp_path / "out.webp"
    options = [str(output) if one == "OUT" else one for one in options]
    if name == "build":
        options += ["-o", str(tmp_path / "project")]
    assert main([name, net, *options, "--field", "1000x1000"]) == 2
    printed = capsys.readouterr()
    assert printed.err == (f"ncdc {name}: the field is 1000x1000, raw frames of 640x480 show "
                           f"640x480, 1280x960, 1920x1440, 2560x1920 "
                           f"of the mt9p031's 2592x1944 pixels\n")
    assert not printed.out and not (tmp_path / "project").exists() and not output.exists()


def test_a_field_without_a_sensor(net, capsys):
    assert main(["plan", net, "--field", "full"]) == 2
    assert "--field full is of a sensor: --sensor NAME or --board NAME is needed" in \
        capsys.readouterr().err

"""``ncdc client`` and ``ncdc device``: good runs over TCP, one sentence on bad input."""

import json
import socket

import numpy as np
import pytest

from cameras import barrel_descriptor
from devices import SIZE, device, loopback_address, small_lens
from eeprom_images import BUILT_IN, GOOD, OTHER
from ncdc import cli
from ncdc_bench.client import command as bench
from ncdc_model.example import noise_picture
from ncdc_model.golden.corrector import correct
from ncdc_model.images import read_image, write_image
from ncdc_spec.eeprom import STATES
from ncdc_spec.protocols.features import feature
from ncdc_spec.protocols.gvcp import CORRECTOR_BASE, READREG, command_packet


@pytest.fixture
def one():
    with device([small_lens(), small_lens(seed=5)]) as served:
        yield served


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    small_lens().save("net.toml")
    barrel_descriptor((64, 50), SIZE).save("other.toml")
    barrel_descriptor((63, 48), SIZE).save("odd.toml")
    write_image("small.png", np.zeros((40, 47), np.uint8))
    return tmp_path


def run(command):
    """Exit status of ``ncdc command``, however it ends."""
    try:
        return cli.main(command.split())
    except SystemExit as end:
        return end.code


def url(one):
    return f"tcp://{one.options.address}:{one.table.port}"


def test_show_and_set(one, capsys):
    assert run(f"client set Gain=2.5 ReverseX=on PixelFormat=Mono8 --device {url(one)}") == 0
    assert capsys.readouterr().out == "Gain = 2.5\nReverseX = True\nPixelFormat = Mono8\n"
    assert run(f"client show --device {url(one)}") == 0
    lines = capsys.readouterr().out.splitlines()
    assert "  Gain                   2.5                          1 to 7.875, step 0.125" in lines
    assert run(f"client show --device {url(one)} --json -") == 0
    features = json.loads(capsys.readouterr().out)["features"]
    assert features["PixelFormat"]["value"] == "Mono8" and features["Width"]["maximum"] == 64
    assert one.registers.read(0x20) == 0x4000


def test_grabbed_pictures_are_the_golden_models(one, capsys):
    assert run(f"client grab 3 -o frames --device {url(one)} --json -") == 0
    report = json.loads(capsys.readouterr().out)
    golden = correct(small_lens(), noise_picture(*SIZE)).picture
    assert len(report["files"]) == report["frames"] == 3 and report["lost"] == 0
    for file in report["files"]:
        assert np.array_equal(read_image(file), golden)
    with open("frames/frames.csv") as table:
        rows = table.read().splitlines()
    assert rows[0] == "file,number,time_ns,format" and len(rows) == 4
    # A raw frame is written as ncdc correct takes it.
    assert run(f"client set CorrectionEnable=0 --device {url(one)}") == 0
    assert run(f"client grab 1 -o raw --device {url(one)} --json report.json") == 0
    with open("report.json") as file:
        raw = read_image(json.load(file)["files"][0])
    assert np.array_equal(raw, noise_picture(*SIZE))


def test_the_folder_of_pictures_may_be_there(one, folder):
    """The documented line works a second time, and whatever else is in the folder stays."""
    (folder / "frames").mkdir()
    (folder / "frames/notes.txt").write_text("of the user")
    for _ in range(2):
        assert run(f"client grab 1 -o frames --device {url(one)}") == 0
    assert (folder / "frames/notes.txt").read_text() == "of the user"
    [_, row] = (folder / "frames/frames.csv").read_text().splitlines()
    assert (folder / "frames" / row.partition(",")[0]).is_file()


@pytest.mark.parametrize("command,status,message", [
    ("set Width=9999", 2, "Width is 9999, the limits are 8 and 64"),
    ("set Width", 2, "'Width' is no NAME=VALUE"),
    ("set =3", 2, "'' is no NAME=VALUE"),
    ("set Nonsense=1", 1, "has no feature 'Nonsense'"),
    ("set WidthMax=8", 1, "WidthMax is read-only"),
    ("grab 0 -o frames", 2, "0 pictures are asked for, 1 is the limit"),
    ("grab 1 -o frames --timeout 0", 2, "the timeout is 0 seconds, it must be more than 0"),
    ("grab 1 -o net.toml", 2, "cannot write net.toml/frames.csv"),
    ("grab 1 -o frames --device tcp://127.0.0.1:1", 1, "no device answers at tcp://127.0.0.1:1"),
    ("show --device http://1", 2, "'http://1' is no URL of a device: gige, aravis, tcp, usb with"),
    ("show --device usb://232h", 1, "no FT232H answers at ftdi://ftdi:232h/1"),
    ("show --device tcp://127.0.0.1:x", 2, "no URL of a device"),
    ("show --device gige://127.0.0.1:5", 2, "has a port, which gige:// has not"),
])
def test_one_sentence(one, command, status, message, capsys):
    command = command if "--device" in command else f"{command} --device {url(one)}"
    assert run(f"client {command}") == status
    out, err = capsys.readouterr()
    assert message in err and err.count("\n") == 1 and not out, err


@pytest.mark.parametrize("options,message", [
    ("none.toml", "cannot read none.toml"),
    ("odd.toml", "a side of the picture has 63 pixels, an emulated device needs even sides"),
    ("net.toml other.toml", "lens 2 has other sizes"),
    ("net.toml --photo small.png", "the picture has 47x40 pixels, the descriptor is for 64x48"),
    ("net.toml --photo net.toml", "net.toml is a descriptor of ncdc train, a picture is"),
    ("net.toml --photo small.png --raw 64x48:RGGB:8", "small.png has "),
    ("net.toml --photo small.png --bits 12", "small.png declares samples of 8 bits"),
    ("net.toml --eeprom none.bin", "cannot read none.bin"),
    ("net.toml --count 0", "0 devices are asked for, the limits are 1 and 16"),
    ("net.toml --packet-loss 0.6", "loss is 0.6, the limits are 0 and 0.5"),
    ("net.toml --noise -1", "noise is -1, the limits are 0 and 50"),
    ("net.toml --address here", "the address 'here' is no IPv4 address"),
    ("net.toml --address 255.255.255.255 --count 2", "is no IPv4 address"),
    ("net.toml --address 192.0.2.1", "cannot answer at 192.0.2.1"),
    ("net.toml --tcp-port 70000", "the TCP port is 70000, the limits are 0 and 65535"),
])
def test_a_device_that_cannot_be(options, message, capsys):
    assert run(f"device serve {options}") == 2
    err = capsys.readouterr().err.removeprefix("preparing the correction\n")
    assert message in err and err.count("\n") == 1, err


@pytest.mark.parametrize("content,state,lens,text", [
    (GOOD, "Loaded", OTHER, "a.bin: the lens of A0017"),
    (GOOD[:-1], "Length", BUILT_IN, f"a.bin: the image is rejected: it is shorter or longer than "
     f"it says ({len(GOOD) - 1} bytes, it says {len(GOOD)}); the built-in lens stays")])
def test_a_device_with_an_eeprom(folder, monkeypatch, capsys, content, state, lens, text):
    def look(devices):
        agent = devices[0].agent
        for address in (feature("EepromStatus").address, CORRECTOR_BASE + 4):
            packet = command_packet(READREG, 1, address.to_bytes(4, "big"))
            seen.append(int.from_bytes(agent.handle(packet, ("127.1.1.1", 5000))[8:], "big"))
        raise KeyboardInterrupt

    seen = []
    monkeypatch.setattr("ncdc.cli.device.Announcer", look)
    (folder / "a.bin").write_bytes(content)
    assert run(f"device serve net.toml --eeprom a.bin --address {loopback_address()}") == 0
    assert seen == [STATES.index(state), int(lens.digest[:8], 16)]
    assert text in capsys.readouterr().err.splitlines()


@pytest.mark.parametrize("options,message", [
    ("--sensor nope", "the sensor is 'nope', a device on a network has one of mt9p031, imx219"),
    ("--fps 0", "fps is 0, the limits are")])
def test_options_are_checked_before_lenses_are_prepared(options, message, capsys):
    assert run(f"device serve net.toml {options}") == 2
    err = capsys.readouterr().err
    assert message in err and err.count("\n") == 1


def test_an_address_in_use(capsys):
    address = loopback_address()
    with socket.create_server((address, 4000)):
        assert run(f"device serve net.toml --address {address}") == 2
    assert f"cannot answer at {address}" in capsys.readouterr().err


ROW = {"peer": "Aravis", "transport": "GVSP", "devices": 3, "frames": 3, "incomplete": 0,
       "wrong_pixels": 0, "features": 4, "features_read_back": 4, "frames_per_second": 9.0,
       "loss": 0.0}


@pytest.mark.parametrize("change,message", [
    ({"incomplete": 1}, "1 frames incomplete"), ({"wrong_pixels": 7}, "7 pixels are wrong"),
    ({"features_read_back": 3}, "3 of 4 features"), ({"found": 2}, "2 of 3 devices found"),
    ({"monitors": 2, "writes_rejected": 1}, "a monitor could write")])
def test_the_bench_complains(change, message):
    assert bench.complaints([ROW]) == []
    found = bench.complaints([ROW, {**ROW, **change}])
    assert len(found) == 1 and message in found[0]
    assert "Aravis" in bench.table([ROW])


def test_the_bench_complains_of_control_that_stays_taken():
    assert bench.late([ROW, {**ROW, "seconds_until_free": 3.4}]) == []
    assert bench.late([{**ROW, "seconds_until_free": 3.6}]) == [
        "Aravis, GVSP: control is free after 3.6 s, 3.5 is the limit"]

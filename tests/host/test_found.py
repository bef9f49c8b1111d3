"""Devices that are found: by their address alone, distinguished, and with harmless names."""

import pytest

from devices import device
from ncdc.cli import parser
from ncdc.cli.client import run
from ncdc_host.client.devices import open_device
from ncdc_host.client.errors import DeviceError, NoFrame
from ncdc_host.client.found import Found
from ncdc_spec.protocols import gvcp
from peers import need

EVIL = "\x1b]0;owned\x07\u202eNCDC\n"
HARMLESS = "\\x1b]0;owned\\x07\\u202eNCDC\\n"


@pytest.mark.parametrize("scheme", ["gige", "aravis"])
def test_a_device_without_an_announcer_is_opened_by_its_address(scheme):
    if scheme == "aravis":
        need("aravis")
    with device() as one, open_device(f"{scheme}://{one.options.address}") as client:
        assert client.set("Gain", 2) == 2
        with client.stream() as frames:
            assert frames.next().pixels.shape[:2] == (48, 64)


def test_no_two_devices_have_one_serial_number():
    with device() as one, device() as two:
        assert one.options.serial != two.options.serial
        found = []
        for each in (one, two):
            with open_device(f"gige://{each.options.address}", monitor=True) as client:
                found.append(client.get("DeviceSerialNumber"))
        assert found == [one.options.serial, two.options.serial]


def test_a_device_s_texts_do_not_change_the_terminal(capsys):
    found = Found("gige://127.0.0.2", "127.0.0.2", EVIL, EVIL, EVIL, EVIL)
    assert (found.mac, found.vendor, found.model, found.serial) == (HARMLESS,) * 4
    assert str(DeviceError(EVIL)) == HARMLESS
    with device() as one:
        model = gvcp.register("DeviceModelName")
        one.agent._texts[model.address] = b"\x1b[31mred\x07".ljust(model.length, b"\0")
        arguments = parser("client").parse_args(
            ["client", "show", "--device", f"gige://{one.options.address}"])
        assert not run(arguments)
    shown = capsys.readouterr().out
    assert "\\x1b[31mred\\x07" in shown and "\x1b" not in shown and "\x07" not in shown


@pytest.mark.parametrize("scheme", ["gige", "aravis"])
def test_each_trigger_sends_one_picture(scheme):
    """Its exposure begins after the trigger: it has what was written before."""
    if scheme == "aravis":
        need("aravis")
    with device() as one, open_device(f"{scheme}://{one.options.address}") as client:
        client.set("TriggerMode", "On")
        assert client.info("TriggerSource").choices == ("Software",)
        with client.stream() as frames:
            with pytest.raises(NoFrame):
                frames.next(.3)
            for gain in (2, 4):
                client.set("Gain", gain)
                before = one.camera.now_ns()
                client.execute("TriggerSoftware")
                frame = frames.next()
                assert frame.time_ns >= before
                with pytest.raises(NoFrame):
                    frames.next(.3)
        assert client.set("TriggerMode", "Off") == "Off"

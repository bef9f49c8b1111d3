"""A device with a view: its features over GVCP, its pictures, and a device without one."""

import struct
from dataclasses import replace

import numpy as np
import pytest

from devices import SIZE, device, small_lens, view_lens
from ncdc_host.client import open_device
from ncdc_host.client.errors import DeviceError
from ncdc_model.example import noise_picture
from ncdc_model.golden.corrector import correct
from ncdc_spec.protocols import gvcp
from ncdc_spec.protocols.features import VIEW_FEATURES, feature, register_number
from ncdc_spec.protocols.genicam import genicam_xml
from ncdc_spec.view_matrix import LIMITS, Angles, PlaneCamera

USER = "127.1.1.1", 5000


def command(one, code, payload):
    status, _, _, rest = gvcp.parse_acknowledge(
        one.agent.handle(gvcp.command_packet(code, 7, payload), USER))
    return status, rest


def read(one, name):
    status, rest = command(one, gvcp.READREG, struct.pack(">I", feature(name).address))
    return (status, None) if status else (status, register_number(
        feature(name), int.from_bytes(rest, "big")))


def write(one, address, value):
    return command(one, gvcp.WRITEREG, struct.pack(">II", address, value & 0xFFFFFFFF))[0]


def controlled(one):
    assert write(one, gvcp.register("ControlPrivilege").address, 2) == gvcp.SUCCESS


def test_registers_of_a_view():
    with device([view_lens(), view_lens(2, 50)]) as one:
        assert [read(one, name) for name in ("Pan", "Zoom", "ViewFocal")] == [
            (0, 0), (0, 1000), (0, 4126)]
        assert write(one, feature("Pan").address, 5) == gvcp.ACCESS_DENIED
        controlled(one)
        for name, (low, high) in LIMITS.items():
            known = feature(name.capitalize())
            steps = known.scale[1]
            for value in (low * steps, high * steps):
                assert write(one, known.address, int(value)) == gvcp.SUCCESS
                assert read(one, known.name) == (0, value)
            for value in (low * steps - 1, high * steps + 1, 0x7FFFFFFF, 0x80000000):
                assert write(one, known.address, int(value)) == gvcp.INVALID_PARAMETER
                assert read(one, known.name) == (0, high * steps)
        assert write(one, feature("ViewFocal").address, 5) == gvcp.WRITE_PROTECT
        one.registers.write(feature("LensSelector").table[0], 1)
        assert read(one, "ViewFocal") == (0, 5000)


@pytest.mark.parametrize("lens", [small_lens(), replace(small_lens(), nodes=8),
                                  replace(view_lens(), nodes=1)])
def test_a_device_without_a_view(lens):
    with device([view_lens(), lens] if lens.nodes > 1 else [lens]) as one:
        assert one.agent._xml.rstrip(b"\0") == genicam_xml()
        for known in VIEW_FEATURES:
            assert read(one, known.name) == (gvcp.INVALID_ADDRESS, None)


def test_a_view_that_does_not_fit_the_registers_is_rejected():
    with device([view_lens(), view_lens(2, 9000)]) as one:
        controlled(one)
        pan = feature("Pan").address
        assert write(one, pan, 9000) == gvcp.INVALID_PARAMETER
        assert read(one, "Pan") == (0, 0) and write(one, pan, 4500) == gvcp.SUCCESS


def picture(one):
    frame = one.camera.newest()
    return np.frombuffer(frame.data, np.uint8).reshape(*SIZE[::-1], 3)[..., ::-1]


def test_pictures_of_a_view_are_the_golden_model_s():
    lens, raw = view_lens(), noise_picture(*SIZE)
    with device([lens], raw) as one:
        controlled(one)
        np.testing.assert_array_equal(picture(one), correct(lens, raw).picture)
        for angles in (Angles(pan=-12.25), Angles(pan=20, tilt=7, roll=-30, zoom=1.5)):
            for known in VIEW_FEATURES[:-1]:
                value = round(getattr(angles, known.name.lower()) * known.scale[1])
                assert write(one, known.address, value) == gvcp.SUCCESS
            wanted = correct(lens, raw, view=PlaneCamera.of(lens).looking(angles)).picture
            np.testing.assert_array_equal(picture(one), wanted)
        one.registers.write(feature("CorrectionEnable").table[0], 0)
        np.testing.assert_array_equal(
            np.frombuffer(one.camera.newest().data, np.uint8).reshape(SIZE[::-1]), raw)


def test_a_lens_that_is_loaded_brings_its_camera():
    lens, other, raw = view_lens(), view_lens(9, 52.5), noise_picture(*SIZE)
    with device([lens], raw) as one:
        controlled(one)
        write(one, feature("Pan").address, 800)
        one.registers.controlled = False
        write(one, gvcp.register("ControlPrivilege").address, 0)
        with open_device(f"gige://{one.options.address}") as client:
            client.load_lens(other)
        wanted = correct(other, raw, view=PlaneCamera.of(other).looking(Angles(pan=8))).picture
        np.testing.assert_array_equal(picture(one), wanted)
        assert read(one, "ViewFocal") == (0, 5250)


def test_a_lens_without_a_camera_is_shown_as_trained():
    blind, raw = replace(view_lens(9), provenance={}), noise_picture(*SIZE)
    with device([view_lens()], raw) as one:
        controlled(one)
        write(one, feature("Pan").address, 800)
        write(one, gvcp.register("ControlPrivilege").address, 0)
        with open_device(f"gige://{one.options.address}") as client:
            client.load_lens(blind)
            assert read(one, "ViewFocal") == (0, 0) and read(one, "Pan") == (0, 800)
            np.testing.assert_array_equal(picture(one), correct(blind, raw).picture)
            client.load_lens(view_lens())
        assert read(one, "ViewFocal") == (0, 4126)


def test_a_lens_that_cannot_look_so_far_is_rejected():
    with device([view_lens()]) as one:
        controlled(one)
        write(one, feature("Pan").address, 9000)
        write(one, gvcp.register("ControlPrivilege").address, 0)
        with open_device(f"gige://{one.options.address}") as client, \
                pytest.raises(DeviceError, match="rejects the lens"):
            client.load_lens(view_lens(2, 9000))
        assert read(one, "ViewFocal") == (0, 4126)


@pytest.mark.parametrize("scheme", [
    "gige", "tcp", pytest.param("aravis", marks=pytest.mark.longer)])
def test_clients_set_a_view(scheme):
    with device([view_lens()]) as one:
        try:
            port = f":{one.table.port}" if scheme == "tcp" else ""
            opened = open_device(f"{scheme}://{one.options.address}{port}")
        except DeviceError as error:
            if scheme != "aravis":      # only Aravis may be absent
                raise
            pytest.skip(str(error))
        with opened as client:
            assert client.info("ViewFocal").value == pytest.approx(41.26)
            for name, value, number in (("Pan", "-10", -1000), ("Pan", -10.996, -1100),
                                        ("Pan", 10.996, 1100), ("Tilt", -.01, -1),
                                        ("Roll", 179.99, 17999), ("Zoom", 2.5, 2500)):
                assert client.set(name, value) == pytest.approx(number / feature(name).scale[1])
                assert read(one, name) == (0, number)
            for name, value in (("Pan", 91), ("Tilt", -90.5), ("Zoom", .2)):
                with pytest.raises(DeviceError, match=f"{name} is .*, the limits are"):
                    client.set(name, value)

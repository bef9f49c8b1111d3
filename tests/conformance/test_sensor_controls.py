"""Settings of a user of a network, in the registers of each sensor: one list for every device."""

import io
import struct
import zipfile
from dataclasses import replace
from xml.etree import ElementTree

import pytest

from cameras import barrel_descriptor
from devices import SIZE, device, small_lens
from firmware_wire import TcpUser, Wire, wire_program
from gvcp_client import PEER, Client
from ncdc_host.client.table import Connection
from ncdc_host.device import registers
from ncdc_spec.protocols import gvcp
from ncdc_spec.protocols.features import features_of
from ncdc_spec.protocols.genicam import genicam_xml
from ncdc_spec.protocols.table_one import WRITE
from ncdc_spec.sensors.catalogue import SENSORS, controlled_sensor, setup
from ncdc_spec.sensors.controls import number_in
from ncdc_spec.sensors.sensor import Settings

# Feature, value, and what its registers then hold: by the sensors' own documents, not our table.
CASES = {
    "mt9p031": [
        ("ExposureTime", 0x12345, {0x08: 1, 0x09: 0x2345}),
        ("Gain", 20, {0x35: 20}),                   # 2.5 in eighths
        ("TestPattern", "ColorBar", {0xA0: 8 << 3 | 1}),
        ("TestPattern", "Off", {0xA0: 0})],
    "imx219": [
        ("ExposureTime", 0x145, {0x015A: 1, 0x015B: 0x45}),
        ("Gain", 16, {0x0157: 128}),                # 256 / (256 - 128)
        ("Gain", 85, {0x0157: 232}),                # 10.67, the largest
        ("TestPattern", "ColorBar", {0x0600: 0, 0x0601: 2}),
        ("TestPattern", "ColorField", {0x0600: 0, 0x0601: 1}),
        ("TestPattern", "Off", {0x0600: 0, 0x0601: 0})],
    "ov5647": [
        ("ExposureTime", 0x123, {0x3500: 0, 0x3501: 0x12, 0x3502: 0x30}),   # sixteenths
        ("Gain", 20, {0x350A: 0, 0x350B: 40}),      # sixteenths
        ("Gain", 300, {0x350A: 2, 0x350B: 0x58}),
        ("TestPattern", "ColorBar", {0x503D: 0x80}),
        ("TestPattern", "Off", {0x503D: 0})]}
# Mirrors and window, which the firmware does not have: value, registers and their bits.
MIRRORS = {
    "mt9p031": [("ReverseX", {0x20: (0x4000, 0x4000)}), ("ReverseY", {0x20: (0x8000, 0x8000)})],
    "imx219": [("ReverseX", {0x0172: (1, 1)}), ("ReverseY", {0x0172: (2, 2)})],
    "ov5647": [("ReverseX", {0x3821: (2, 0)}), ("ReverseY", {0x3820: (2, 2)})]}
WINDOWS = {                 # of 32x16 at column 8, row 4 of the raw frame, whose corner is (x, y)
    "mt9p031": lambda x, y: {0x02: 16 + x + 8, 0x01: 54 + y + 4, 0x04: 31, 0x03: 15},
    "imx219": lambda x, y: {0x0165: x + 8 & 255, 0x0169: y + 4 & 255, 0x016D: 32, 0x016F: 16},
    "ov5647": lambda x, y: {0x3801: x + 8 & 255, 0x3803: y + 4 & 255, 0x3809: 32, 0x380B: 16}}
NAMES = [pytest.param(name, marks=[pytest.mark.longer] * (name == "ov5647")) for name in CASES]


class Emulated:
    """An emulated device and its sensor's registers."""

    def __init__(self, name):
        lens = small_lens(bayer=controlled_sensor(name).bayer)
        self.device = device([lens], sensor=name)
        self.client = Client(lambda data: self.device.agent.answers(data, PEER))

    def register(self, address):
        return self.device.registers.read(address)

    def table_write(self, address, value):
        with Connection(self.device.options.address, self.device.table.port) as user:
            return user.write(address, value)

    def close(self):
        self.device.close()


class Firmware:
    """The firmware on this machine, and its sensor's registers."""

    def __init__(self, program):
        self.wire, self._user = Wire(program).__enter__(), None
        self.client = Client(lambda data: self.wire.datagram(data, PEER[1], PEER[0]))

    def register(self, address):
        return self.wire.sensor_register(address)

    def table_write(self, address, value):
        if self._user is None:
            self._user = TcpUser(self.wire, 40_000)
            assert self._user.connect()
        return self._user.ask(WRITE, address, value)

    def close(self):
        self.wire.__exit__()


@pytest.fixture(scope="module", params=NAMES)
def name(request):
    return request.param


@pytest.fixture(scope="module", params=["emulated", "firmware"])
def one(request, name, wire_firmware, tmp_path_factory):
    if request.param == "emulated":
        found = Emulated(name)
    elif name == "mt9p031":
        found = Firmware(wire_firmware)
    else:
        found = Firmware(wire_program(tmp_path_factory.mktemp("wire"),
                                      barrel_descriptor(SIZE, SIZE), sensor=name))
    found.client.control()
    yield found
    found.close()


def xml_of(client):
    """The XML of a device, as clients read it."""
    def memory(address, count):
        status, answer = client.command(gvcp.READMEM, struct.pack(">IHH", address, 0, count))
        assert status == gvcp.SUCCESS
        return answer[4:]

    url = gvcp.register("FirstUrl")
    name, *where = memory(url.address, url.length).rstrip(b"\0").split(b";")
    base, size = (int(number, 16) for number in where)
    content = b"".join(memory(base + at, min(512, (size - at + 3) // 4 * 4))
                       for at in range(0, size, 512))[:size]
    if not name.endswith(b".zip"):
        return content
    with zipfile.ZipFile(io.BytesIO(content)) as archive:
        return archive.read(*archive.namelist())


def code(name, feature, value):
    """The GVCP register of a feature's value."""
    choices = {one.name: {choice.name: choice.value for choice in one.choices}
               for one in features_of(controlled_sensor(name))}[feature]
    return choices[value] if isinstance(value, str) else value


def test_a_setting_is_in_the_sensors_registers(name, one):
    for feature, value, words in CASES[name]:
        number = code(name, feature, value)
        assert one.client.set(**{feature: number}) == [gvcp.SUCCESS], (feature, value)
        assert {at: one.register(at) for at in words} == words, (feature, value)
        assert one.client.get(feature) == number


def test_a_device_lists_what_it_has(one):
    """The firmware has no mirrors and one size; what is there may be written again."""
    access = {node.get("Name").removesuffix("Register"): node.findtext("{*}AccessMode")
              for node in ElementTree.fromstring(xml_of(one.client)).findall("{*}IntReg")}
    emulated = isinstance(one, Emulated)
    assert access["Gain"] == "RW"
    assert access.get("ReverseX") == access.get("ReverseY") == ("RW" if emulated else None)
    for feature in ("Width", "Height", "OffsetX", "OffsetY"):
        there = one.client.get(feature)
        assert access[feature] == ("RW" if emulated else "RO")
        assert one.client.set(**{feature: there}) == [gvcp.SUCCESS]
        assert one.client.set(**{feature: there + 2}) == [gvcp.INVALID_PARAMETER]


def test_values_that_the_sensor_lacks_are_rejected(name, one):
    sensor = controlled_sensor(name)
    at = {one.name: one for one in features_of(sensor)}
    before = one.client.get("Gain"), one.client.get("ExposureTime"), one.client.get("TestPattern")
    for feature in ("Gain", "ExposureTime"):
        assert one.client.set(**{feature: at[feature].low - 1}) == [gvcp.INVALID_PARAMETER]
        assert one.client.set(**{feature: at[feature].high + 1}) == [gvcp.INVALID_PARAMETER]
    assert one.client.set(TestPattern=0x55) == [gvcp.INVALID_PARAMETER]
    # Of the firmware, what would not fit into a frame that does not become longer by itself.
    if isinstance(one, Firmware) and not sensor.controls.stretches:
        assert one.client.set(ExposureTime=at["ExposureTime"].high) == [gvcp.INVALID_PARAMETER]
    assert before == (one.client.get("Gain"), one.client.get("ExposureTime"),
                      one.client.get("TestPattern"))


def test_a_register_takes_no_more_than_its_bits(name, one):
    sensor = controlled_sensor(name)
    register = sensor.user_registers[-1].address
    assert one.table_write(register, 0) == 0
    assert one.table_write(register, 0x100) == (0x100 if sensor.value_bits == 16 else 0)


def test_mirrors_and_window(name):
    """Of the emulated device: the mirrors keep other bits, and the window moves on the sensor."""
    one = Emulated(name)
    one.client.control()
    try:
        for feature, bits in MIRRORS[name]:
            for value in (1, 0):
                assert one.client.set(**{feature: value}) == [gvcp.SUCCESS]
                assert one.client.get(feature) == value
                for address, (mask, mirrored) in bits.items():
                    assert (one.register(address) & mask == mirrored) == bool(value), feature
        x, y = one.client.get("FieldLeft"), one.client.get("FieldTop")
        assert one.client.set(CorrectionEnable=0, Width=32, Height=16, OffsetX=8, OffsetY=4) == [
            gvcp.SUCCESS] * 5
        words = WINDOWS[name](x, y)
        assert {at: one.register(at) for at in words} == words
    finally:
        one.close()


@pytest.mark.parametrize("sensor", [one for one in SENSORS if one.controls],
                         ids=lambda one: one.name)
def test_the_table_is_what_the_configuration_writes(sensor):
    """Where exposure, gain, pattern and mirrors are, by the setup of the sensor itself."""
    controls = sensor.controls
    for exposure_us, gain_db, mirrors, pattern in (
            (1000.0, 0.0, (False, False), "Off"), (20_000.0, 6.0, (True, False), "Off"),
            (7777.0, 12.0, (False, True), next(iter(controls.patterns)))):
        plan = setup(sensor, Settings(
            width=640, height=480, exposure_us=exposure_us, gain_db=gain_db,
            mirror_columns=mirrors[0], mirror_rows=mirrors[1], test_pattern=pattern))
        read = dict(plan.pairs).get
        lines = round(exposure_us * 1000 / (plan.timing.line_us * 1000))
        assert abs(number_in(controls.exposure, read) - lines) <= 1
        gain = controls.gain.eighths(number_in(controls.gain.parts, read)) / 8
        assert abs(gain - min(10 ** (gain_db / 20), controls.gain.high / 8)) <= 1 / 8
        for mirror, on in zip((controls.mirror_columns, controls.mirror_rows), mirrors):
            number = number_in(mirror.parts, read)
            assert number == (mirror.mirrored if on else mirror.plain)
        found = number_in(controls.pattern, lambda address: read(address, 0))
        assert controls.pattern_named(found) == pattern


@pytest.mark.parametrize("sensor", [one for one in SENSORS if one.controls],
                         ids=lambda one: one.name)
def test_a_gain_that_the_sensor_has_stays(sensor):
    """What is read back and written again is the same: automatic gain settles."""
    gain = sensor.controls.gain
    for eighths in range(8, gain.high + 1):
        number = gain.word(eighths)
        there = gain.eighths(number)
        assert 0 <= number <= gain.largest and abs(there - eighths) <= 0.04 * eighths
        assert gain.eighths(gain.word(there)) == there
    assert gain.eighths(gain.largest) in (gain.high, gain.high + 1)


def test_the_xml_has_what_the_sensor_has():
    found = {one.name: genicam_xml(features=features_of(one)) for one in SENSORS if one.controls}
    assert b"GreyHorizontalRamp" in found["mt9p031"]
    for name in ("imx219", "ov5647"):
        assert b"GreyHorizontalRamp" not in found[name] and b'"ColorBar"' in found[name]
    assert b"ColorField" in found["imx219"] and b"ColorField" not in found["ov5647"]
    assert b"<Max>10.625</Max>" in found["imx219"]


def test_what_a_sensor_lacks_is_absent(monkeypatch):
    """It is no feature of the XML, reads as 0, and cannot be written."""
    whole = controlled_sensor("imx219")
    less = replace(whole, controls=replace(
        whole.controls, mirror_columns=None, pattern=(), patterns={}))
    xml = genicam_xml(features=features_of(less))
    assert b"ReverseX" not in xml and b"TestPattern" not in xml and b"ReverseY" in xml
    monkeypatch.setattr(registers, "controlled_sensor", lambda name: less)
    one = Emulated("imx219")
    one.client.control()
    try:
        assert one.client.set(ReverseX=1, TestPattern=2, ReverseY=1) == [
            gvcp.WRITE_PROTECT, gvcp.WRITE_PROTECT, gvcp.SUCCESS]
        assert [one.client.get(name) for name in ("ReverseX", "TestPattern", "ReverseY")] == [
            0, 0, 1]
    finally:
        one.close()

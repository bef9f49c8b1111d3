"""The GVCP agent, fed with datagrams: access, heartbeat, memory, and anything at random."""

import random
import resource
import struct
import time
from ipaddress import IPv4Address

import pytest

from devices import device, small_lens
from ncdc_spec.protocols import gvcp
from ncdc_spec.protocols.features import FEATURES, feature
from ncdc_spec.protocols.genicam import genicam_xml

USER, OTHER = ("127.1.1.1", 5000), ("127.1.1.1", 5001)
CCP = gvcp.register("ControlPrivilege").address


class Asker:
    """Commands of ``peer`` to the agent of a device, at the time ``now``."""

    def __init__(self, one, peer=USER):
        self._agent, self._peer, self.now = one.agent, peer, time.monotonic()

    def command(self, code, payload):
        answer = self._agent.handle(gvcp.command_packet(code, 77, payload), self._peer, self.now)
        status, acknowledged, request, rest = gvcp.parse_acknowledge(answer)
        assert (acknowledged, request) == (code + 1, 77)
        return status, rest

    def read(self, address):
        status, rest = self.command(gvcp.READREG, struct.pack(">I", address))
        return int.from_bytes(rest, "big") if status == gvcp.SUCCESS else hex(status)

    def write(self, address, value):
        return self.command(gvcp.WRITEREG, struct.pack(">II", address, value))[0]

    def set(self, name, value):
        return self.write(feature(name).address, value)

    def get(self, name):
        return self.read(feature(name).address)

    def control(self):
        return self.write(CCP, gvcp.CCP_CONTROL)


@pytest.fixture
def one():
    with device([small_lens(), small_lens(seed=5)]) as served:
        yield served


def test_discovery(one):
    status, rest = Asker(one).command(gvcp.DISCOVERY, b"")
    assert status == gvcp.SUCCESS and len(rest) == gvcp.DISCOVERY_BYTES
    assert rest[0x48:0x68].rstrip(b"\0") == b"NCDC" and rest[0xD8:0xE8].rstrip(
        b"\0").decode() == f"EMU-{int(IPv4Address(one.options.address)):08X}"
    assert ".".join(map(str, rest[0x24:0x28])) == one.options.address


def test_writes_need_control_and_reads_do_not(one):
    user, other = Asker(one), Asker(one, OTHER)
    assert user.set("Gain", 16) == gvcp.ACCESS_DENIED and user.get("Gain") == 8
    assert user.control() == gvcp.SUCCESS
    assert user.set("Gain", 16) == gvcp.SUCCESS
    assert other.set("Gain", 24) == other.write(CCP, 2) == gvcp.ACCESS_DENIED
    assert other.get("Gain") == 16 and other.read(CCP) == gvcp.CCP_CONTROL
    assert user.write(CCP, 0) == gvcp.SUCCESS
    assert other.control() == gvcp.SUCCESS and other.set("Gain", 24) == gvcp.SUCCESS
    assert one.registers.read(0x35) == 24


def test_control_is_free_after_the_heartbeat(one):
    user, other = Asker(one), Asker(one, OTHER)
    user.control()
    for _ in range(5):                              # any command keeps it
        user.now += 2.9
        user.read(0)
        other.now = user.now
        assert other.write(CCP, 2) == gvcp.ACCESS_DENIED
    other.now = user.now + 3.1
    assert other.write(CCP, 2) == gvcp.SUCCESS
    other.write(gvcp.register("HeartbeatTimeout").address, 1)
    assert other.read(gvcp.register("HeartbeatTimeout").address) == gvcp.HEARTBEAT_MIN_MS


def test_no_heartbeat_locks_the_device_for_long(one):
    user, other = Asker(one), Asker(one, OTHER)
    address = gvcp.register("HeartbeatTimeout").address
    user.command(gvcp.WRITEREG, struct.pack(">IIII", CCP, 2, address, 0xFFFFFFFF))
    user.read(0)
    assert other.read(address) == gvcp.HEARTBEAT_MAX_MS <= 60_000
    other.now = user.now + gvcp.HEARTBEAT_MAX_MS / 1000 + .1
    assert other.write(CCP, 2) == gvcp.SUCCESS


def test_one_datagram_holds_control_for_the_default_time(one):
    """Its sender may be forged; who sends a second one is there."""
    address = gvcp.register("HeartbeatTimeout").address
    for count, seconds in ((0, 3.1), (1, 30.1)):
        user, other = Asker(one), Asker(one, OTHER)
        user.command(gvcp.WRITEREG, struct.pack(">IIII", CCP, 2, address, 0xFFFFFFFF))
        for _ in range(count):
            user.read(0)
        other.now = user.now + seconds - .2
        assert other.control() == gvcp.ACCESS_DENIED
        other.now = user.now + seconds
        assert other.control() == gvcp.SUCCESS
        assert other.read(address) == gvcp.HEARTBEAT_MS and other.write(CCP, 0) == gvcp.SUCCESS


def test_pictures_go_to_the_controller_s_machine_or_a_group(one, monkeypatch):
    user, sent = Asker(one), []
    for name in ("send", "send_all"):
        monkeypatch.setattr(one.stream._sender, name, lambda parts, address: sent.append(address))
    user.control()
    size, port, address = (gvcp.register(f"Stream{name}").address
                           for name in ("PacketSize", "Port", "Address"))
    assert user.write(port, 6000) == gvcp.SUCCESS
    for third in ("127.9.9.9", "8.8.8.8", "255.255.255.255", "127.255.255.255"):
        assert user.write(address, int(IPv4Address(third))) == gvcp.SUCCESS
        user.write(size, gvcp.SCPS_FIRE | 1000)
        assert user.set("AcquisitionStart", 1) == gvcp.ACCESS_DENIED
    assert sent == []
    for own in (USER[0], "239.192.1.1"):
        assert user.write(address, int(IPv4Address(own))) == gvcp.SUCCESS
        user.write(size, gvcp.SCPS_FIRE | 1000)
        assert sent.pop() == (own, 6000) and sent == []


def test_only_the_controller_learns_where_the_pictures_come_from(one):
    """Who knows the port can send pictures in the device's name."""
    user, other = Asker(one), Asker(one, OTHER)
    port = gvcp.register("StreamSourcePort").address
    assert user.read(port) == other.read(port) == 0
    user.control()
    assert user.read(port) == one.stream.port > 0 == other.read(port)
    request = struct.pack(">IHH", port, 0, 4)
    assert [int.from_bytes(each.command(gvcp.READMEM, request)[1][4:], "big")
            for each in (user, other)] == [one.stream.port, 0]


def test_the_request_number_0_is_answered(one):
    answer = one.agent.handle(gvcp.command_packet(gvcp.DISCOVERY, 0), USER)
    status, code, number, rest = gvcp.parse_acknowledge(answer)
    assert (status, code, number, len(rest)) == (0, 3, 0, gvcp.DISCOVERY_BYTES)


def test_rejections_have_their_status(one):
    user = Asker(one)
    user.control()
    for name, value, status in (
            ("Width", 66, gvcp.INVALID_PARAMETER), ("Width", 9, gvcp.INVALID_PARAMETER),
            ("PixelFormat", 0x01080008, gvcp.INVALID_PARAMETER),
            ("PixelFormat", 1, gvcp.INVALID_PARAMETER), ("Gain", 64, gvcp.INVALID_PARAMETER),
            ("WidthMax", 8, gvcp.WRITE_PROTECT), ("LensSelector", 2, gvcp.INVALID_PARAMETER),
            ("AcquisitionStart", 1, gvcp.ACCESS_DENIED)):       # no destination
        before = user.get(name)
        assert user.set(name, value) == status, name
        assert user.get(name) == before
    assert user.write(0x9000, 1) == user.write(gvcp.XML_BASE + 0xFFFC, 1) == gvcp.INVALID_ADDRESS
    assert user.write(gvcp.XML_BASE, 1) == user.write(0x48, 1) == gvcp.WRITE_PROTECT
    assert user.write(2, 1) == gvcp.BAD_ALIGNMENT and user.read(6) == hex(gvcp.BAD_ALIGNMENT)
    assert user.command(0x00C0, b"")[0] == gvcp.NOT_IMPLEMENTED


def test_parameters_are_locked(one):
    user = Asker(one)
    user.control()
    assert user.set("TLParamsLocked", 1) == gvcp.SUCCESS
    locked = [f for f in FEATURES if f.locked and f.table]
    assert len(locked) >= 8
    for one_feature in locked:
        value = user.get(one_feature.name)
        other = 0x01080001 if one_feature.name == "PixelFormat" else value ^ (
            1 if one_feature.high == 1 else 2)
        assert user.set(one_feature.name, other) == gvcp.ACCESS_DENIED, one_feature.name
        assert user.get(one_feature.name) == value
    assert user.set("Gain", 9) == user.set("LensSelector", 1) == gvcp.SUCCESS
    user.write(CCP, 0)
    assert not one.registers.streaming


def test_the_xml_is_read_as_it_is(one):
    user = Asker(one)
    xml, url = b"", b""
    for at in range(0, 512, 512):
        url += user.command(gvcp.READMEM, struct.pack(">IHH", 0x200 + at, 0, 512))[1][4:]
    name, address, length = url.rstrip(b"\0").decode().removeprefix("Local:").split(";")
    assert name == gvcp.XML_NAME and int(address, 16) == gvcp.XML_BASE
    while len(xml) < int(length, 16):
        xml += user.command(gvcp.READMEM, struct.pack(">IHH", gvcp.XML_BASE + len(xml), 0,
                                                      536))[1][4:]
    assert xml[:int(length, 16)] == genicam_xml()


def test_both_protocols_see_one_state(one):
    user = Asker(one)
    user.control()
    assert user.set("ExposureTime", 0x12345) == gvcp.SUCCESS
    assert (one.registers.read(0x08), one.registers.read(0x09)) == (1, 0x2345)
    one.registers.write(0x20, 0x4000)
    assert (user.get("ReverseX"), user.get("ReverseY")) == (1, 0)
    assert user.set("ReverseY", 1) == gvcp.SUCCESS and one.registers.read(0x20) == 0xC000
    assert user.set("SensorRegisterAddress", 0xF004) == gvcp.SUCCESS
    assert user.set("SensorRegisterValue", 77) == gvcp.SUCCESS
    assert user.get("AcquisitionFrameRate") == one.registers.read(0xF004) == 77


def test_a_command_that_needs_the_sensor_s_bus_is_put_off(one):
    """For who says that they understand it; what the device keeps is answered at once."""
    user = Asker(one)
    user.control()
    address, value = (feature(f"SensorRegister{name}").address for name in ("Address", "Value"))
    read = gvcp.command_packet(gvcp.READREG, 9, struct.pack(">I", value))
    write = gvcp.command_packet(gvcp.WRITEREG, 9, struct.pack(">II", value, 77))

    def codes(packet, peer=USER):
        answers = one.agent.answers(packet, peer, user.now)
        return [gvcp.parse_acknowledge(data)[1] for data in answers]

    assert user.write(address, 0x2C) == gvcp.SUCCESS
    assert codes(read) == [0x81] and codes(write) == [0x83]
    configuration = gvcp.register("Configuration").address
    assert user.write(configuration, 1) == gvcp.INVALID_PARAMETER
    assert user.write(configuration, gvcp.CONFIGURATION_PENDING_ACK) == gvcp.SUCCESS
    assert codes(read) == [0x89, 0x81] and codes(write) == [0x89, 0x83]
    status, _, number, rest = gvcp.parse_acknowledge(one.agent.answers(read, USER, user.now)[0])
    assert (status, number, rest) == (0, 9, struct.pack(">I", gvcp.PENDING_MS))
    assert codes(read, OTHER) == [0x81]
    assert user.set("Gain", 16) == gvcp.SUCCESS
    assert user.write(address, 0x35) == gvcp.SUCCESS and codes(read) == [0x81]
    assert user.write(gvcp.register("ControlPrivilege").address, 0) == gvcp.SUCCESS
    assert user.read(configuration) == 0


def test_an_address_is_forced_on_whom_it_names(one):
    user, mac = Asker(one), one.agent._identity.mac
    own = int.from_bytes(map(int, one.options.address.split(".")), "big")

    def force(mac, address):
        packet = gvcp.command_packet(gvcp.FORCEIP, 9, gvcp.FORCE_IP.pack(
            mac >> 32, mac & 0xFFFFFFFF, address, 0xFFFFFF00, 0))
        return [gvcp.parse_acknowledge(data)[:2] for data in one.agent.answers(
            packet, USER, user.now)]

    assert force(mac, own) == force(mac, 0) == [(gvcp.SUCCESS, 5)]
    assert force(mac, own + 1) == [(gvcp.INVALID_PARAMETER, 5)] and force(mac ^ 1, own) == []
    user.control()
    assert force(mac, own) == [(gvcp.ACCESS_DENIED, 5)]
    assert user.command(gvcp.FORCEIP, bytes(20))[0] == gvcp.INVALID_HEADER


WRITABLE = {f.address for f in FEATURES if f.access != "ro"} | {
    p.address for p in gvcp.BOOTSTRAP if p.access == "rw"}


def everything(one):
    """All that the network can read, but for what changes by itself, and the corrector's own."""
    user = Asker(one, OTHER)
    own = [p for p in gvcp.BOOTSTRAP if p.length == 4]
    return {address: user.read(address) for address in
            {f.address for f in FEATURES if f.kind != "text"} | {p.address for p in own}}


def datagrams(count):
    """Random bytes, mutated commands, and whole commands at random addresses, well formed."""
    rng = random.Random(5)
    addresses = [f.address for f in FEATURES] + [p.address for p in gvcp.BOOTSTRAP] + [
        gvcp.XML_BASE, gvcp.CORRECTOR_BASE, gvcp.CORRECTOR_BASE + 0x400, 0xFFFFFFFC]
    codes = [0x0002, 0x0004, 0x0040, 0x0080, 0x0082, 0x0084, 0x0086, 0x00C0, 0x0100]
    for _ in range(count):
        kind = rng.randrange(4)
        if kind == 0:
            yield rng.randbytes(rng.choice([0, 1, 7, 8, 9, 20, 600, 2048]))
            continue
        code = rng.choice(codes)
        words = [rng.choice(addresses) if rng.random() < .7 else rng.randrange(1 << 32)
                 for _ in range(rng.choice([0, 1, 2, 3, 4, 20, 140]))]
        if kind == 1:
            words[1::2] = [rng.choice([0, 1, 8, 1 << 31, rng.randrange(1 << 32)])
                           for _ in words[1::2]]
        packet = bytearray(gvcp.command_packet(code, rng.randrange(1, 1 << 16),
                                               struct.pack(f">{len(words)}I", *words)))
        if kind == 3:
            for _ in range(rng.randrange(1, 4)):
                packet[rng.randrange(len(packet))] = rng.randrange(256)
        yield bytes(packet)


def hostile_user(one, count, controls):
    """Feed it all to the agent; nothing but writable registers may change, and nothing may break.

    ``controls``: it comes from the user in control; else from another one.
    """
    user, before = Asker(one), everything(one)
    # A stream that is begun at random goes to an address at random: not one packet may leave.
    one.stream._sender.send = one.stream._sender.send_all = lambda *_: None
    digest = one.camera.corrections[0].descriptor.digest
    words = [one.registers.read(address) for address in range(256)]
    for k, data in enumerate(datagrams(count)):
        if k % 50 == 0:
            user.control()
        answer = one.agent.handle(data, USER if controls else OTHER, user.now)
        assert answer is None or 8 <= len(answer) <= 8 + 4 + gvcp.MEMORY_BYTES_MAX
    one.agent.tick(user.now + (1 << 32) / 1000)     # the longest heartbeat's time
    after = everything(one)
    changed = {address for address in before if before[address] != after[address]}
    assert one.agent.controller is None and not one.registers.streaming
    if not controls:
        assert changed == set()
        assert words == [one.registers.read(address) for address in range(256)]
        assert one.camera.corrections[0].descriptor.digest == digest
    # What a user with control has written, other features of the same picture follow.
    followers = {feature(name).address for name in (
        "WidthMax", "HeightMax", "LineTime", "PayloadSize")} | {0x948, 0x94C}
    assert changed <= WRITABLE | followers, [hex(a) for a in changed - WRITABLE]
    assert Asker(one).command(gvcp.DISCOVERY, b"")[0] == gvcp.SUCCESS
    assert len(one.camera.newest().data) == one.registers.settings.view.size
    return changed


@pytest.mark.parametrize("controls", [False, True])
def test_a_hostile_user(one, controls):
    assert bool(hostile_user(one, 1500, controls)) == controls


@pytest.mark.regress
@pytest.mark.parametrize("controls", [False, True])
def test_a_hostile_user_at_length(one, controls):
    hostile_user(one, 20_000, controls)
    first = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    hostile_user(one, 80_000, controls)
    # What the first 20,000 did not need, 80,000 more must not: 20 MB are those of threads' stacks.
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - first < 20_000

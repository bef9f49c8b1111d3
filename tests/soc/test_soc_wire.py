"""The firmware on this machine, one frame at a time: who may what, for how long, and when."""

import struct
from ipaddress import IPv4Address

import pytest

from cameras import barrel_descriptor
from devices import device, small_lens
from firmware_host import host_program
from firmware_wire import CLIENT_IP, TcpUser, Wire, wire_config
from ncdc_spec.protocols import gvcp
from ncdc_spec.protocols.features import FEATURES, feature
from ncdc_spec.protocols.genicam import genicam_xml
from ncdc_spec.protocols.table_one import IDLE_SECONDS, MRAW, READ, WRITE
from ncdc_spec.protocols.table_two import HEADER_BYTES
from ncdc_spec.registers.link_map import STATUS_RESENDING
from ncdc_spec.sensors import mt9p031
from ncdc_spec.white_balance import UNITY

SIZE = (64, 48)
PACKAGE = HEADER_BYTES + 3 * SIZE[0] * SIZE[1]
USERS = 8
OTHER_IP = "10.77.0.2"
CCP, HEARTBEAT = (gvcp.register(name).address for name in ("ControlPrivilege", "HeartbeatTimeout"))


@pytest.fixture(scope="module")
def text():
    """``text(clock_hz)``: config.h of a system at that clock; None: its own."""
    return wire_config(barrel_descriptor(SIZE, SIZE))


@pytest.fixture(scope="module")
def program(text, tmp_path_factory):
    return host_program(text(), tmp_path_factory.mktemp("wire"), "wire")


@pytest.fixture
def wire(program):
    with Wire(program) as one:
        yield one


def users(wire, count, first=40_000, **options):
    found = [TcpUser(wire, first + k, **options) for k in range(count)]
    assert all(user.connect() for user in found)
    return found


def width(user):
    return user.ask(READ, 0xF001)


# Table I.

def test_users_write_the_registers_of_the_list(wire):
    user, = users(wire, 1)
    free = {one.address for one in mt9p031.SENSOR.user_registers}
    # What is read back is what the bus says, here always zeros: GVCP's status shows it instead.
    asker = Asker(wire)
    assert asker.write(CCP, 2) == gvcp.SUCCESS
    for address in [*range(0x100), 0x100, 0xEFFF]:
        assert asker.set("SensorRegisterAddress", address) == gvcp.SUCCESS
        status = asker.set("SensorRegisterValue", 9)
        assert status == (gvcp.SUCCESS if address in free else gvcp.WRITE_PROTECT), hex(address)
    assert user.ask(WRITE, mt9p031.GLOBAL_GAIN, 16) == 16


def test_half_open_connections_keep_no_user_out(wire):
    for k in range(12):
        TcpUser(wire, 50_000 + k, source="10.77.0.77").begin()
    user, = users(wire, 1)
    assert width(user) == SIZE[0]


def test_silent_users_give_their_position_to_a_new_one(wire):
    first = users(wire, USERS)
    assert [width(user) for user in first] == [SIZE[0]] * USERS
    assert not TcpUser(wire, 41_000).connect()
    first[0].send(bytes([READ]))                 # half a request: silent as well
    wire.wait(1000 * IDLE_SECONDS + 100)
    assert [width(user) for user in first[1:]] == [SIZE[0]] * (USERS - 1)
    late, = users(wire, 1, 42_000)
    assert width(late) == SIZE[0] and width(first[0]) is None
    assert [width(user) for user in first[1:]] == [SIZE[0]] * (USERS - 1)


@pytest.mark.parametrize("drips", [False, True], ids=["nothing", "drops"])
def test_a_user_who_takes_little_holds_up_no_other(wire, drips):
    slow, quick = users(wire, 2)
    slow.takes = False
    slow.send(bytes([MRAW]))
    wire.wait(20)
    quick.send(bytes([MRAW]))
    for _ in range(20):
        quick.wait(100)
        if len(quick.data) >= PACKAGE:
            break
        if drips:
            slow.drip(100)
    assert len(quick.data) == PACKAGE


def test_users_who_take_no_answers_are_disconnected(wire):
    polite, *rude = users(wire, USERS)
    for one in rude:
        one.takes = False
    for _ in range(60):
        for one in rude:
            one.send(bytes([READ, 0xF0, 1, 0, 0]) * 8)
        assert width(polite) == SIZE[0]
    wire.wait(100)
    assert [one.ended for one in rude] == [True] * (USERS - 1) and width(polite) == SIZE[0]


# GVCP.

class Asker:
    """Commands of a client."""

    def __init__(self, wire, port=5000, source=CLIENT_IP):
        self._wire, self._port, self._source = wire, port, source

    def command(self, code, payload, request=77):
        answers = self._wire.datagram(gvcp.command_packet(code, request, payload), self._port,
                                      self._source)
        assert len(answers) == 1
        status, acknowledged, number, rest = gvcp.parse_acknowledge(answers[0])
        assert (acknowledged, number) == (code + 1, request)
        return status, rest

    def read(self, address):
        return int.from_bytes(self.command(gvcp.READREG, struct.pack(">I", address))[1], "big")

    def write(self, address, value):
        return self.command(gvcp.WRITEREG, struct.pack(">II", address, value))[0]

    def set(self, name, value):
        return self.write(feature(name).address, value)

    def choose_receiver(self):
        """Take control, and have pictures come here."""
        for name, value in (("ControlPrivilege", 2), ("StreamPort", 6000),
                            ("StreamAddress", int(IPv4Address(CLIENT_IP)))):
            assert self.write(gvcp.register(name).address, value) == gvcp.SUCCESS


def test_a_corrector_without_gains_has_no_balance(wire):
    asker = Asker(wire)
    asker.choose_receiver()
    for name, value in (("BalanceWhiteAuto", 0), ("BalanceRatioSelector", 0),
                        ("BalanceRatio", UNITY)):
        assert asker.set(name, 1) == gvcp.WRITE_PROTECT
        assert asker.read(feature(name).address) == value
        assert name.encode() not in genicam_xml(colour=False)
    assert asker.set("ExposureAuto", 1) == gvcp.SUCCESS


def test_each_trigger_sends_one_picture(wire):
    asker = Asker(wire)
    asker.choose_receiver()
    assert asker.set("TriggerMode", 2) == gvcp.INVALID_PARAMETER
    assert asker.set("TriggerMode", 1) == asker.set("TriggerSource", 0) == gvcp.SUCCESS
    assert asker.set("AcquisitionStart", 1) == gvcp.SUCCESS
    assert asker.set("TriggerMode", 0) == gvcp.ACCESS_DENIED        # while pictures stream
    wire.wait(200)
    assert wire.streamed == 0
    for count in (1, 2):
        assert asker.set("TriggerSoftware", 1) == gvcp.SUCCESS
        wire.wait(200)
        assert wire.streamed == count
    assert asker.set("AcquisitionStop", 1) == asker.set("TriggerMode", 0) == gvcp.SUCCESS
    assert asker.set("AcquisitionStart", 1) == gvcp.SUCCESS
    wire.wait(200)
    assert wire.streamed > 5


def test_number_zero_is_answered(wire):
    status, rest = Asker(wire).command(gvcp.DISCOVERY, b"", 0)
    assert status == gvcp.SUCCESS and len(rest) == gvcp.DISCOVERY_BYTES


def test_no_heartbeat_locks_the_device_for_long(wire):
    one, other = Asker(wire), Asker(wire, 5001, OTHER_IP)
    one.command(gvcp.WRITEREG, struct.pack(">IIII", CCP, 2, HEARTBEAT, 0xFFFFFFFF))
    assert other.read(HEARTBEAT) == gvcp.HEARTBEAT_MAX_MS
    assert other.write(CCP, 2) == gvcp.ACCESS_DENIED
    wire.wait(gvcp.HEARTBEAT_MAX_MS + 100)
    assert other.write(CCP, 2) == gvcp.SUCCESS
    assert other.write(HEARTBEAT, 1) == gvcp.SUCCESS
    assert other.read(HEARTBEAT) == gvcp.HEARTBEAT_MIN_MS


def test_many_lost_packets_are_sent_again(wire):
    """A client asks for each one by itself, while the packetiser sends the first ones again."""
    asker = Asker(wire)
    asker.choose_receiver()
    assert asker.set("AcquisitionMode", 1) == gvcp.SUCCESS         # the block stays number 1
    assert asker.set("AcquisitionStart", 1) == gvcp.SUCCESS
    wire.wait(100)
    wire.set_link(STATUS_RESENDING)
    for packet in range(1, 41):
        wire.datagram(gvcp.command_packet(gvcp.PACKETRESEND, 1, struct.pack(
            ">HHII", 0, 1, packet, packet), answered=False))
    assert wire.resent == []
    wire.set_link(0)
    wire.wait(50)
    assert [last & 0xFFFFFF for last in wire.resent] == list(range(1, 41))


@pytest.mark.parametrize("clock_hz", [
    75_000_000, pytest.param(66_666_667, marks=pytest.mark.longer)])
def test_time_stamps_are_nanoseconds_at_any_clock(text, tmp_path, clock_hz):
    one_second = 10**9
    with Wire(host_program(text(clock_hz), tmp_path, "wire")) as wire:
        asker = Asker(wire)
        asker.write(CCP, 2)
        for seconds in (1, 4_000):
            wire.set_clock(seconds * clock_hz)
            asker.write(CCP, 2)         # it has not been heard of for long
            assert asker.write(gvcp.register("TimestampControl").address, 2) == gvcp.SUCCESS
            stamp = asker.read(gvcp.register("TimestampHigh").address) << 32 | asker.read(
                gvcp.register("TimestampLow").address)
            # The loop has turned a few thousand times meanwhile.
            assert 0 <= stamp - seconds * one_second < 10**6


def commands():
    """Datagrams of a client without control, each of one kind."""
    spots = [p.address for p in gvcp.BOOTSTRAP] + [f.address for f in FEATURES] + [
        gvcp.XML_BASE, gvcp.XML_BASE + 0xFFFC, gvcp.CORRECTOR_BASE + 0x10,
        gvcp.CORRECTOR_BASE + gvcp.CORRECTOR_BYTES, 0x0100, 0x0F00, 0x9000, 2, 0x10002, 0xFFFFFFFC]
    for address in spots:
        yield gvcp.READREG, struct.pack(">I", address)
        if address != CCP:
            yield gvcp.WRITEREG, struct.pack(">II", address, 1)
            yield gvcp.WRITEMEM, struct.pack(">II", address, 1)
        yield gvcp.READMEM, struct.pack(">IHH", address, 0, 4)
    for count in (0, 3, 5, 536, 540, 0xFFFF):
        yield gvcp.READMEM, struct.pack(">IHH", 0, 0, count)
    for code in (gvcp.READREG, gvcp.WRITEREG, gvcp.READMEM, gvcp.WRITEMEM, gvcp.FORCEIP,
                 gvcp.PACKETRESEND, 0x00C0, 0x0100, 0x0003):
        for size in (0, 3, 8, 12, 20, 56, 544):
            yield code, bytes(size)
    yield gvcp.READREG, struct.pack(">II", CCP, 0x9000)
    yield gvcp.WRITEREG, struct.pack(">IIII", HEARTBEAT, 5000, 0x9000, 1)


@pytest.mark.parametrize("controlled", [
    False, pytest.param(True, marks=pytest.mark.longer)], ids=["free", "controlled"])
def test_firmware_and_emulated_device_answer_a_client_without_control_alike(wire, controlled):
    """Each answer's status, code, number and length; the values are each device's own."""
    different, count = [], 0
    with device([small_lens()]) as emulated:
        if controlled:
            assert Asker(wire, 5009, OTHER_IP).write(CCP, 2) == gvcp.SUCCESS
            emulated.agent.handle(gvcp.command_packet(gvcp.WRITEREG, 1, struct.pack(">II", CCP, 2)),
                                  (OTHER_IP, 5009))
        for code, payload in commands():
            for request, answered in ((77, True), (0, True), (77, False)):
                if request == 0 and len(payload) not in (0, 8):
                    continue
                packet = gvcp.command_packet(code, request, payload, answered)
                mine = [answer[:8] for answer in wire.datagram(packet)]
                its = [answer[:8] for answer in emulated.agent.answers(packet, (CLIENT_IP, 5000))]
                count += 1
                if mine != its:
                    different.append((hex(code), payload[:12].hex(), len(payload),
                                      [a.hex() for a in mine], [a.hex() for a in its]))
    assert count > 500 and different == []

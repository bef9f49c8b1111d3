"""The whole system's commands in simulation: users at once, answers put off, addresses, a flood."""

import re
import subprocess

import pytest

from ncdc_sim.link.namespaces import TAP
from ncdc_sim.system.soc import ADDRESS, SocRun
from ncdc_soc.firmware import Identity
from ncdc_spec.protocols.table_one import TCP_PORT
from peers import need
from soc_clients import OPEN, SIZE, matches, peer

# Compiling the model takes more than a minute.
pytestmark = [pytest.mark.regress, pytest.mark.many_clocks]


_USERS = """
import json, socket, struct
users = [socket.create_connection(("{address}", {port}), 60) for _ in range(8)]
def ask(user, *request):
    user.settimeout(60)
    user.sendall(struct.pack(">BHH", *request))
    answer = b""
    while len(answer) < 5:
        answer += user.recv(5 - len(answer)) or b"?????"
    return list(struct.unpack(">BHH", answer))
widths = [ask(user, 0x80, 0xF001, 0) for user in users]
written = ask(users[3], 0x81, 9, 7)
seen = ask(users[5], 0x80, 9, 0)
rejected = ask(users[2], 0x81, 3, 1)
users[0].sendall(bytes([0x82, 0x55]))
unknown = users[0].recv(2) + users[0].recv(2)
print(json.dumps([widths, written, seen, rejected, list(unknown)]))
"""


def test_eight_users_of_table_one(model, tmp_path):
    script = _USERS.replace("{address}", ADDRESS).replace("{port}", str(TCP_PORT))
    with SocRun(model) as run:
        widths, written, seen, rejected, unknown = peer(run, script, tmp_path)
    assert widths == [[0x80, 0xF001, SIZE[0]]] * 8
    assert written == [0x81, 9, 7] and seen == [0x80, 9, 7]
    # The rows of the sensor's frame are the firmware's: what is read back is what was there.
    assert rejected == [0x81, 3, model.setup.settings.height - 1]
    assert unknown == [0xFF, 0x55]


_FLOOD = """
import json, random, socket, struct, sys, time
from ncdc_spec.protocols import gvcp
count, mac = map(json.loads, sys.argv[3:])
random.seed(1)
wire = socket.socket(socket.AF_PACKET, socket.SOCK_RAW)
wire.bind(("{tap}", 0))
wire.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, 1 << 16)
to = bytes(int(part, 16) for part in mac.split(":"))
def checked(header, at):
    total = sum(struct.unpack(f">{len(header) // 2}H", header))
    while total >> 16:
        total = (total & 0xFFFF) + (total >> 16)
    return header[:at] + struct.pack(">H", 0xFFFF ^ total) + header[at + 2:]
def ip(protocol, payload, source):
    length = 20 + len(payload) if random.random() < .95 else random.getrandbits(16)
    header = struct.pack(">BBHHHBBH4s4s", 0x45, 0, length, 0, 0, 64, protocol, 0, source,
                         bytes([10, 77, 0, 11]))
    return b"\\x08\\x00" + checked(header, 10) + payload
def udp(port, payload):
    return struct.pack(">HHHH", random.getrandbits(16), port, 8 + len(payload), 0) + payload
def frame():
    source = bytes([10, 77, 0, random.choice([1, 2, 77])])
    kind = random.randrange(8)
    junk = random.randbytes(random.choice([4, 8, 20, 60, 200, random.randrange(1400)]))
    if kind < 3:
        code = random.choice([2, 0x40, 0x80, 0x82, 0x84, 0x86, 0x88, random.getrandbits(16)])
        body = ip(17, udp(gvcp.PORT, gvcp.command_packet(code, 1 + random.getrandbits(8), junk)),
                  source)
    elif kind == 3:
        body = ip(17, udp(random.getrandbits(16), junk), source)
    elif kind == 4:
        flags = random.choice([2, 2, 16, 24, 17, 4, random.getrandbits(8)])
        body = ip(6, struct.pack(">HHIIBBHHH", random.randrange(1024, 65536), {port},
                                 random.getrandbits(32), random.getrandbits(32), 0x50, flags,
                                 random.getrandbits(16), random.getrandbits(16), 0) + junk, source)
    elif kind == 5:
        body = ip(1, junk, source)
    elif kind == 6:
        body = b"\\x08\\x06" + b"\\0\\1\\x08\\0\\6\\4\\0" + random.randbytes(21)
    else:
        body = random.randbytes(2) + junk
    whom = random.choice([to, to, to, b"\\xff" * 6])
    return whom + b"\\2\\0\\0\\0\\0" + random.randbytes(1) + body
def gone():                             # that the simulation has fetched
    line = next(line for line in open("/proc/net/dev") if line.strip().startswith("{tap}:"))
    return int(line.split(":")[1].split()[9])
sent, before = 0, gone()
while gone() - before < count:
    if sent - (gone() - before) > 300:      # more would be dropped by the kernel
        time.sleep(.002)
        continue
    for _ in range(50):
        wire.send(frame())
    sent += 50
""" + OPEN + """
with device.stream() as stream:         # it still does what it is there for
    for _ in range(2):
        take(stream)
print(json.dumps([sent, len(taken)]))
"""


def test_a_flood_of_frames_of_any_kind(model, tmp_path):
    """100,000 frames as fast as the wire takes them: none stops it or wakes the watchdog."""
    script = _FLOOD.replace("{tap}", TAP).replace("{port}", str(TCP_PORT))
    with SocRun(model) as run:
        sent, taken = peer(run, script, tmp_path, 100_000, Identity().mac)
        screen, said = run.screen, run.end()
    received = int(re.search(r"(\d+) in,", said)[1])
    assert sent >= 100_000 and received >= 100_000 and taken == 2
    assert screen.count("NCDC ") == 1 and "exception" not in screen and " 0 broken" in said
    assert matches(tmp_path, taken, [model.golden().picture]) == [0] * taken


_PUT_OFF = """
import json, socket, struct
from ncdc_spec.protocols import gvcp
from ncdc_spec.protocols.features import feature
asking = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
asking.settimeout(300)
other = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
other.settimeout(300)
number = 0
def send(code, *words, by=asking):
    global number
    number += 1
    by.sendto(gvcp.command_packet(code, number, struct.pack(f">{len(words)}I", *words)),
              ("{address}", gvcp.PORT))
def take(by=asking):
    status, code, request, rest = gvcp.parse_acknowledge(by.recv(2000))
    return [status, code, request == number, int.from_bytes(rest[-4:], "big")]
def ask(code, *words):
    send(code, *words)
    return take()
address, value = (feature(f"SensorRegister{name}").address for name in ("Address", "Value"))
answers = {}
ask(gvcp.WRITEREG, gvcp.register("ControlPrivilege").address, 2)
ask(gvcp.WRITEREG, address, 0x2c)
answers["at once"] = ask(gvcp.WRITEREG, value, 7)
ask(gvcp.WRITEREG, gvcp.register("Configuration").address, 2)
answers["write"] = [ask(gvcp.WRITEREG, value, 9), take()]
answers["read"] = [ask(gvcp.READREG, value), take()]
answers["two reads"] = [ask(gvcp.READREG, value, value), take()]
answers["feature"] = ask(gvcp.WRITEREG, feature("Gain").address, 8)
# Another user's command is answered between.
send(gvcp.WRITEREG, value, 11)
other.sendto(gvcp.command_packet(gvcp.READREG, 99, struct.pack(
    ">I", gvcp.register("HeartbeatTimeout").address)), ("{address}", gvcp.PORT))
other.sendto(gvcp.command_packet(gvcp.READREG, 98, struct.pack(">I", value)),
             ("{address}", gvcp.PORT))
answers["third"] = [take(), take()]
answers["others"] = [list(gvcp.parse_acknowledge(other.recv(2000))[:3]) for _ in range(2)]
print(json.dumps(answers))
"""


def _put_off_times(capture, whole=True):
    """Times in ms of all answers put off in a file of packets; not ``whole``: it is growing yet."""
    fields = subprocess.run(
        ["tshark", "-r", str(capture), "-Y", "gvcp.ack.pendingack.timetocompletion", "-T", "fields",
         "-e", "gvcp.ack.pendingack.timetocompletion", "-e", "_ws.malformed"],
        capture_output=True, text=True, check=whole).stdout.split()
    return [int(field, 16) for field in fields]


def test_an_answer_that_waits_for_the_sensor_is_put_off(model, tmp_path):
    need("tshark")
    file = tmp_path / "capture.pcapng"
    with SocRun(model) as run:
        capture = run.network.start(["tshark", "-q", "-i", TAP, "-w", str(file)],
                                    stderr=subprocess.PIPE)
        while "Capture" not in (line := capture.stderr.readline()):
            assert line
        answers = peer(run, _PUT_OFF.replace("{address}", ADDRESS), tmp_path)
        # What the kernel has not handed over yet would be lost with the one who captures.
        run.wait_for(lambda: len(_put_off_times(file, whole=False)) >= 4)
        capture.terminate()
        capture.wait(20)
        assert "exception" not in run.screen
    off, written, read = [0, 0x89, True, 1000], [0, 0x83, True, 1], [0, 0x81, True, 9]
    assert answers["at once"] == written and answers["write"] == [off, written]
    assert answers["read"] == answers["two reads"] == [off, read]
    assert answers["feature"] == written and answers["third"] == [off, written]
    # The one that needs no bus is answered, and the one that does if the bus is free by then.
    assert answers["others"][0] == [0, 0x81, 99] and answers["others"][1][1:] == [0x81, 98]
    assert answers["others"][1][0] in (0, 0x8007)
    assert _put_off_times(file) == [1000] * 4


_ARAVIS_PUT_OFF = OPEN + """
from ncdc_spec.protocols import gvcp
device._bridge.call("write_memory", gvcp.register("Configuration").address,
                    [gvcp.CONFIGURATION_PENDING_ACK])
device.set("ExposureTime", 200)
device.set("SensorRegisterAddress", 0x2c)
device.set("SensorRegisterValue", 77)
print(json.dumps([device.get("ExposureTime"), device.get("SensorRegisterValue")]))
"""


def test_aravis_waits_for_an_answer_that_is_put_off(model, tmp_path):
    with SocRun(model) as run:
        exposure, word = peer(run, _ARAVIS_PUT_OFF, tmp_path)
    assert word == 77 and exposure == pytest.approx(200, rel=0.05)


_FORCE = """
import json, sys
import viva_genicam
from ncdc_host.client.devices import open_device
viva_genicam.force_ip({mac!r}, "10.77.0.99", "255.255.255.0", "0.0.0.0", {tap!r})
with open_device("aravis://10.77.0.99") as device:
    print(json.dumps(device.get("DeviceModelName")))
"""


def test_viva_genicam_forces_another_address_on_it(model, tmp_path):
    script = _FORCE.format(mac=Identity().mac, tap=TAP)
    with SocRun(model) as run:
        name = peer(run, script, tmp_path)
        assert "address: 0a4d0063" in run.screen.lower() or "address: a4d0063" in run.screen
    assert name == "NCDC camera"



"""The whole system in simulation, seen by Debian's Aravis: every pixel is the golden model's."""

import json
import re
import subprocess
import sys
from pathlib import Path

import cv2
import numpy as np
import pytest

from cameras import barrel_descriptor
from ncdc.report.soc_window import window_on
from ncdc_model.corrector import correct
from ncdc_model.interface.frames import output_format
from ncdc_model.interface.pixel_formats import raw_format
from ncdc_model.interface.table_one import TCP_PORT
from ncdc_model.interface.table_two import HEADER_BYTES
from ncdc_sim.link.namespaces import TAP
from ncdc_sim.system.soc import ADDRESS, SocModel, SocRun
from ncdc_soc.firmware import Identity
from peers import need

pytestmark = pytest.mark.regress        # compiling the model takes more than a minute

_SIZE = (64, 48)
_EXPOSURES_US = (100.0, 60.0, 200.0)


@pytest.fixture(scope="module")
def model():
    need("riscv64-unknown-elf-gcc", "unshare", "ip", "aravis")
    noise = np.random.default_rng(1).integers(0, 256, _SIZE[::-1], dtype=np.uint8)
    descriptor = barrel_descriptor(corrected=_SIZE, distorted=_SIZE)
    return SocModel(descriptor, cv2.GaussianBlur(noise, (0, 0), 1.0), _EXPOSURES_US[0])


def peer(run, script, folder, *arguments):
    """Run a ``script`` on the clients' side: what it prints as its last line, in JSON."""
    done = run.network.run([sys.executable, "-c", script, f"aravis://{ADDRESS}", str(folder),
                            *map(json.dumps, arguments)], timeout=900)
    assert not done.returncode, done.stderr + run.screen
    return json.loads(done.stdout.splitlines()[-1])


_OPEN = """
import json, sys
import numpy as np
from ncdc_host.client.devices import open_device
url, folder, *arguments = sys.argv[1:]
arguments = [json.loads(text) for text in arguments]
device = open_device(url)
taken = []
def take(stream):
    frame = stream.next(300)
    np.save(f"{folder}/{len(taken)}.npy", frame.pixels)
    taken.append(frame.number)
"""

_EXPOSE = _OPEN + """
with device.stream() as stream:
    take(stream)
    for exposure in arguments[0]:
        device.set("ExposureTime", exposure)
        for _ in range(16):             # those under way, or waiting here, have the one before
            take(stream)
print(json.dumps(taken))
"""


def matches(folder, count, goldens):
    """For each frame the number of the golden picture that it equals; None: of none."""
    return [next((k for k, golden in enumerate(goldens)
                  if np.array_equal(np.load(f"{folder}/{number}.npy"), golden)), None)
            for number in range(count)]


def test_the_exposure_changes_between_frames(model, tmp_path):
    goldens = [model.golden(exposure).picture for exposure in _EXPOSURES_US]
    assert not any(np.array_equal(goldens[k], goldens[k - 1]) for k in range(3))
    with SocRun(model) as run:
        taken = peer(run, _EXPOSE, tmp_path, _EXPOSURES_US[1:])
        said = run.end()
    found = matches(tmp_path, len(taken), goldens)
    # Whole frames of one exposure each, in the order in which they were asked for.
    assert None not in found and found == sorted(found) and set(found) == {0, 1, 2}
    assert taken == sorted(set(taken)) and " 0 broken" in said


_ANOTHER_LENS = _OPEN + """
from ncdc_model.descriptor import Descriptor
with device.stream() as stream:
    take(stream)
    device.load_lens(Descriptor.load(arguments[0]))
    for _ in range(16):                 # those under way, or waiting here, have the one before
        take(stream)
print(json.dumps(taken))
"""


def test_another_lens_over_the_network(model, tmp_path):
    lens = barrel_descriptor(corrected=_SIZE, distorted=_SIZE, strength=0.1, seed=2)
    lens.save(tmp_path / "lens.toml")
    goldens = [model.golden().picture, correct(lens, model.raw(model.setup)).picture]
    assert not np.array_equal(*goldens)
    with SocRun(model) as run:
        taken = peer(run, _ANOTHER_LENS, tmp_path, str(tmp_path / "lens.toml"))
    found = matches(tmp_path, len(taken), goldens)
    # None is torn: each frame has the one lens or the other.
    assert None not in found and found == sorted(found) and set(found) == {0, 1}


_GRAB = _OPEN + """
device.set("CorrectionEnable", arguments[0])
with device.stream() as stream:
    for _ in range(arguments[1]):
        take(stream)
    again = stream.statistics.resent
print(json.dumps([taken, again]))
"""


@pytest.mark.parametrize("loss,frames", ((50, 8), (10, 20)))
def test_packets_that_are_lost_are_sent_again(model, tmp_path, loss, frames):
    with SocRun(model, loss=loss) as run:
        taken, again = peer(run, _GRAB, tmp_path, True, frames)
        said = run.end()
    assert matches(tmp_path, len(taken), [model.golden().picture]) == [0] * frames
    assert again > 0 and " 0 lost" not in said


def test_raw_frames(model, tmp_path):
    with SocRun(model) as run:
        taken, _ = peer(run, _GRAB, tmp_path, False, 2)
    assert matches(tmp_path, len(taken), [model.raw(model.setup)]) == [0, 0]


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
refused = ask(users[2], 0x81, 3, 1)
users[0].sendall(bytes([0x82, 0x55]))
unknown = users[0].recv(2) + users[0].recv(2)
print(json.dumps([widths, written, seen, refused, list(unknown)]))
"""


def test_eight_users_of_table_one(model, tmp_path):
    script = _USERS.replace("{address}", ADDRESS).replace("{port}", str(TCP_PORT))
    with SocRun(model) as run:
        widths, written, seen, refused, unknown = peer(run, script, tmp_path)
    assert widths == [[0x80, 0xF001, _SIZE[0]]] * 8
    assert written == [0x81, 9, 7] and seen == [0x80, 9, 7]
    # The rows of the sensor's frame are the firmware's: what is read back is what was there.
    assert refused == [0x81, 3, model.setup.settings.height - 1]
    assert unknown == [0xFF, 0x55]


def test_the_window_and_the_command_on_one_simulation(model, tmp_path):
    golden = model.golden().picture
    with SocRun(model) as run:
        assert window_on(run, tmp_path) == ""
        done = run.network.run([str(Path(sys.executable).with_name("ncdc")), "client", "grab",
                                "2", "-o", str(tmp_path / "grabbed"), "--device",
                                f"aravis://{ADDRESS}"], timeout=600)
    assert not done.returncode, done.stderr
    assert np.array_equal(np.load(tmp_path / "shown.npy"), golden)
    window = cv2.imread(str(tmp_path / "window.png"))
    assert window.shape[0] == 760 and len(np.unique(window)) > 50
    grabbed = sorted((tmp_path / "grabbed").glob("*.png"))
    assert len(grabbed) == 2
    for path in grabbed:
        assert np.array_equal(cv2.imread(str(path))[..., ::-1], golden)


_SINGLE = _OPEN + """
device.set("AcquisitionMode", "SingleFrame")
for _ in range(2):
    with device.stream() as stream:
        take(stream)
        try:
            stream.next(2)
            taken.append("one too many")
        except NoFrame:
            pass
print(json.dumps(taken))
"""


def test_single_pictures(model, tmp_path):
    script = "from ncdc_host.client.errors import NoFrame\n" + _SINGLE
    with SocRun(model) as run:
        taken = peer(run, script, tmp_path)
    assert matches(tmp_path, len(taken), [model.golden().picture]) == [0, 0]


_PACKAGES = """
import json, sys
import numpy as np
from concurrent.futures import ThreadPoolExecutor
from ncdc_host.client.table import Connection
from ncdc_model.interface.features import system_word
folder, formats = sys.argv[2], json.loads(sys.argv[3])
address, port = "{address}", {port}
users = [Connection(address, port, 300) for _ in range(3)]
told = []
def take(user):
    package = user.picture(300)
    number = user.read(system_word("NUMBER_UPPER")) << 16 | user.read(system_word("NUMBER_LOWER"))
    return package, number
for form in formats:
    users[0].write(system_word("FORMAT"), form)
    with ThreadPoolExecutor(3) as pool:
        for package, number in pool.map(take, users):
            header = package.header
            np.save(f"{folder}/{len(told)}.npy", np.frombuffer(package.data, np.uint8))
            told.append([header.width, header.height, header.pixel_format.mraw, header.address,
                         header.port, header.time_us, number])
# Requests behind a package are answered behind it, also when no more will come.
users[1]._socket.sendall(bytes([0x83, 0x80, 0xF0, 0x01, 0, 0]))
users[1]._socket.shutdown(1)
rest = b""
while part := users[1]._socket.recv(65536):
    rest += part
print(json.dumps([told, len(rest), list(rest[-5:])]))
"""


def test_packages_over_tcp(model, tmp_path):
    """Raw and corrected, to three users at once; what is asked behind one waits for its end."""
    script = _PACKAGES.replace("{address}", ADDRESS).replace("{port}", str(TCP_PORT))
    raw, corrected = raw_format(model.descriptor.geometry), output_format("BGR8").sent
    with SocRun(model) as run:
        told, length, last = peer(run, script, tmp_path, [raw.mraw, corrected.mraw])
        assert "exception" not in run.screen
    goldens = [model.raw(model.setup), model.golden().picture[..., ::-1]]      # BGR
    for k, (width, height, form, address, port, time_us, number) in enumerate(told):
        assert (width, height) == _SIZE and (address, port) == (ADDRESS, TCP_PORT)
        assert form == (raw, corrected)[k // 3].mraw and time_us > 0 and number > 0
        assert np.array_equal(np.load(tmp_path / f"{k}.npy"), goldens[k // 3].ravel())
    assert length == HEADER_BYTES + goldens[1].size + 5
    assert last == [0x80, 0xF0, 0x01, 0, _SIZE[0]]


_FLOOD = """
import json, random, socket, struct, sys, time
from ncdc_model.interface import gvcp
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
""" + _OPEN + """
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
from ncdc_model.interface import gvcp
from ncdc_model.interface.features import feature
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
told = {}
ask(gvcp.WRITEREG, gvcp.place("ControlPrivilege").address, 2)
ask(gvcp.WRITEREG, address, 0x2c)
told["at once"] = ask(gvcp.WRITEREG, value, 7)
ask(gvcp.WRITEREG, gvcp.place("Configuration").address, 2)
told["write"] = [ask(gvcp.WRITEREG, value, 9), take()]
told["read"] = [ask(gvcp.READREG, value), take()]
told["two reads"] = [ask(gvcp.READREG, value, value), take()]
told["kept"] = ask(gvcp.WRITEREG, feature("Gain").address, 8)
# Somebody else's command is answered between.
send(gvcp.WRITEREG, value, 11)
other.sendto(gvcp.command_packet(gvcp.READREG, 99, struct.pack(
    ">I", gvcp.place("HeartbeatTimeout").address)), ("{address}", gvcp.PORT))
other.sendto(gvcp.command_packet(gvcp.READREG, 98, struct.pack(">I", value)),
             ("{address}", gvcp.PORT))
told["third"] = [take(), take()]
told["others"] = [list(gvcp.parse_acknowledge(other.recv(2000))[:3]) for _ in range(2)]
print(json.dumps(told))
"""


def test_an_answer_that_waits_for_the_sensor_is_put_off(model, tmp_path):
    need("tshark")
    file = tmp_path / "capture.pcapng"
    with SocRun(model) as run:
        capture = run.network.start(["tshark", "-q", "-i", TAP, "-w", str(file)],
                                    stderr=subprocess.PIPE)
        while "Capture" not in (line := capture.stderr.readline()):
            assert line
        told = peer(run, _PUT_OFF.replace("{address}", ADDRESS), tmp_path)
        capture.terminate()
        capture.wait(20)
        assert "exception" not in run.screen
    off, written, read = [0, 0x89, True, 1000], [0, 0x83, True, 1], [0, 0x81, True, 9]
    assert told["at once"] == written and told["write"] == [off, written]
    assert told["read"] == told["two reads"] == [off, read]
    assert told["kept"] == written and told["third"] == [off, written]
    # The one that needs no bus is answered, and the one that does if the bus is free by then.
    assert told["others"][0] == [0, 0x81, 99] and told["others"][1][1:] == [0x81, 98]
    assert told["others"][1][0] in (0, 0x8007)
    fields = subprocess.run(
        ["tshark", "-r", str(file), "-Y", "gvcp.ack.pendingack.timetocompletion", "-T", "fields",
         "-e", "gvcp.ack.pendingack.timetocompletion", "-e", "_ws.malformed"],
        capture_output=True, text=True, check=True).stdout.split()
    assert [int(field, 16) for field in fields] == [1000] * 4


_ARAVIS_PUT_OFF = _OPEN + """
from ncdc_model.interface import gvcp
device._bridge.call("write_memory", gvcp.place("Configuration").address,
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


_JUMBO = """
import json, sys
import numpy as np
from ncdc_host.client.devices import open_device
from ncdc_model.interface.gvcp import place
_, folder, url = sys.argv[1:]
with open_device(json.loads(url)) as device:
    with device.stream(9000) as stream:
        for k in range(3):
            np.save(f"{folder}/{k}.npy", stream.next(300).pixels)
        print(json.dumps(device.get("GevSCPSPacketSize")))
"""


@pytest.mark.parametrize("scheme", ("aravis", "gige"))
def test_jumbo_packets(model, tmp_path, scheme):
    """A client asks for packets of 9,000 bytes; a test packet of that size comes through.

    viva-genicam looks for the largest size by its own clock: how far it gets before it loses
    patience depends on the simulation's speed.
    """
    with SocRun(model, mtu=9000) as run:
        size = peer(run, _JUMBO, tmp_path, f"{scheme}://{ADDRESS}")
    assert size == 36 + (9000 - 36) // 16 * 16 if scheme == "aravis" else 1500 < size <= 9000
    assert matches(tmp_path, 3, [model.golden().picture]) == [0] * 3


_COUNT = """
import json, time
from ncdc_host.client.table import Connection
from ncdc_model.interface.features import system_word
user = Connection("{address}", {port}, 300)
counts = []
while len(set(counts)) < 5:
    counts.append(user.read(system_word("FRAMES")))
print(json.dumps(counts))
"""


def test_each_frame_interrupts_the_processor_once(model, tmp_path):
    with SocRun(model) as run:
        counts = peer(run, _COUNT.format(address=ADDRESS, port=TCP_PORT), tmp_path)
    # No frame twice: it grows, and by few between two answers.
    steps = np.diff(counts)
    assert min(steps) >= 0 and counts[0] > 0 and counts[-1] - counts[0] >= 4

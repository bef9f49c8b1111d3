"""The whole system in simulation, seen by Debian's Aravis: every pixel is the golden model's."""

import sys
from pathlib import Path

import cv2
import numpy as np
import pytest

from cameras import barrel_descriptor
from ncdc_bench.figures.soc_window import window_on
from ncdc_model.correction import correct
from ncdc_sim.system.soc import ADDRESS, SocRun
from ncdc_spec.frames import output_format
from ncdc_spec.pixel_formats import raw_format
from ncdc_spec.protocols.table_one import TCP_PORT
from ncdc_spec.protocols.table_two import HEADER_BYTES
from soc_clients import OPEN, SIZE, matches, peer

# Compiling the model takes more than a minute.
pytestmark = [pytest.mark.regress, pytest.mark.many_clocks]

_EXPOSURES_US = (100.0, 60.0, 200.0)

_EXPOSE = OPEN + """
with device.stream() as stream:
    take(stream)
    for exposure in arguments[0]:
        device.set("ExposureTime", exposure)
        for _ in range(16):             # those under way, or waiting here, have the one before
            take(stream)
print(json.dumps(taken))
"""


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


_ANOTHER_LENS = OPEN + """
from ncdc_spec.descriptor import Descriptor
with device.stream() as stream:
    take(stream)
    device.load_lens(Descriptor.load(arguments[0]))
    for _ in range(16):                 # those under way, or waiting here, have the one before
        take(stream)
print(json.dumps(taken))
"""


def test_another_lens_over_the_network(model, tmp_path):
    lens = barrel_descriptor(corrected=SIZE, distorted=SIZE, strength=0.1, seed=2)
    lens.save(tmp_path / "lens.toml")
    goldens = [model.golden().picture, correct(lens, model.raw(model.setup)).picture]
    assert not np.array_equal(*goldens)
    with SocRun(model) as run:
        taken = peer(run, _ANOTHER_LENS, tmp_path, str(tmp_path / "lens.toml"))
    found = matches(tmp_path, len(taken), goldens)
    # None is torn: each frame has the one lens or the other.
    assert None not in found and found == sorted(found) and set(found) == {0, 1}


_GRAB = OPEN + """
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


_SINGLE = OPEN + """
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
from ncdc_spec.protocols.features import system_word
folder, formats = sys.argv[2], json.loads(sys.argv[3])
address, port = "{address}", {port}
users = [Connection(address, port, 300) for _ in range(3)]
packages = []
def take(user):
    package = user.picture(300)
    number = user.read(system_word("NUMBER_UPPER")) << 16 | user.read(system_word("NUMBER_LOWER"))
    return package, number
for form in formats:
    users[0].write(system_word("FORMAT"), form)
    with ThreadPoolExecutor(3) as pool:
        for package, number in pool.map(take, users):
            header = package.header
            np.save(f"{folder}/{len(packages)}.npy", np.frombuffer(package.data, np.uint8))
            packages.append([header.width, header.height, header.pixel_format.mraw, header.address,
                             header.port, header.time_us, number])
# Requests after a package are answered after it, also when no more will come.
users[1]._socket.sendall(bytes([0x83, 0x80, 0xF0, 0x01, 0, 0]))
users[1]._socket.shutdown(1)
rest = b""
while part := users[1]._socket.recv(65536):
    rest += part
print(json.dumps([packages, len(rest), list(rest[-5:])]))
"""


def test_packages_over_tcp(model, tmp_path):
    """Raw and corrected, to three users at once; what is asked after one waits for its end."""
    script = _PACKAGES.replace("{address}", ADDRESS).replace("{port}", str(TCP_PORT))
    raw, corrected = raw_format(model.descriptor.geometry), output_format("BGR8").sent
    with SocRun(model) as run:
        packages, length, last = peer(run, script, tmp_path, [raw.mraw, corrected.mraw])
        assert "exception" not in run.screen
    goldens = [model.raw(model.setup), model.golden().picture[..., ::-1]]      # BGR
    for k, (width, height, form, address, port, time_us, number) in enumerate(packages):
        assert (width, height) == SIZE and (address, port) == (ADDRESS, TCP_PORT)
        assert form == (raw, corrected)[k // 3].mraw and time_us > 0 and number > 0
        assert np.array_equal(np.load(tmp_path / f"{k}.npy"), goldens[k // 3].ravel())
    assert length == HEADER_BYTES + goldens[1].size + 5
    assert last == [0x80, 0xF0, 0x01, 0, SIZE[0]]


_JUMBO = """
import json, sys
import numpy as np
from ncdc_host.client.devices import open_device
from ncdc_spec.protocols.gvcp import place
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

    viva-genicam looks for the largest size by its own clock: how far it gets before it gives up
    depends on the simulation's speed.
    """
    with SocRun(model, mtu=9000) as run:
        size = peer(run, _JUMBO, tmp_path, f"{scheme}://{ADDRESS}")
    assert size == 36 + (9000 - 36) // 16 * 16 if scheme == "aravis" else 1500 < size <= 9000
    assert matches(tmp_path, 3, [model.golden().picture]) == [0] * 3


_COUNT = """
import json, time
from ncdc_host.client.table import Connection
from ncdc_spec.protocols.features import system_word
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

"""Where the system's address comes from: Debian's DHCP server, or the system itself."""

import re
import shutil
import socket
import struct
import sys
import time

import numpy as np
import pytest

from cameras import barrel_descriptor
from ncdc_sim.link.namespaces import CLIENT, TAP
from ncdc_sim.system.soc import SocModel, SocRun
from ncdc_soc.firmware import Identity
from peers import need

# Compiling the model takes more than a minute.
pytestmark = [pytest.mark.regress, pytest.mark.many_clocks]

_SIZE = (64, 48)
_TIME_SCALE = 500            # a second of lwIP's takes 200,000 clocks
_FIRST, _LAST = "10.77.0.50", "10.77.0.60"
_LINK_LOCAL = "169.254.1.1"


@pytest.fixture(scope="module")
def model():
    """A system that is given no address."""
    need("riscv64-unknown-elf-gcc", "unshare", "ip")
    return SocModel(barrel_descriptor(corrected=_SIZE, distorted=_SIZE),
                    np.zeros(_SIZE[::-1], np.uint8),
                    identity=Identity(ip="0.0.0.0", mask="0.0.0.0", time_scale=_TIME_SCALE))


def number(text):
    """An address as a number."""
    return struct.unpack(">I", socket.inet_aton(text))[0]


def reported(run, low, high):
    """The first address between these two that the firmware says it has; waits for it."""
    def found():
        texts = re.findall(r"^address: ([0-9a-f]{8})$", run.screen, re.MULTILINE)
        return [value for value in (int(text, 16) for text in texts)
                if number(low) <= value <= number(high)]
    run.wait_for(found)
    return socket.inet_ntoa(struct.pack(">I", found()[0]))


_READ = """
import socket, struct, sys
asking = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
asking.settimeout(30)
asking.sendto(struct.pack(">BBHHHI", 0x42, 1, 0x80, 4, 1, 0x24), (sys.argv[1], 3956))
print(struct.unpack(">HHHHI", asking.recv(100)))
"""


def own_address(run, at):
    """What a read of the register of its own address gives, by GVCP from that address."""
    done = run.network.run([sys.executable, "-c", _READ, at], timeout=60)
    assert not done.returncode, done.stderr
    status, _, _, _, value = map(int, done.stdout.strip("()\n").split(","))
    assert not status
    return socket.inet_ntoa(struct.pack(">I", value))


def test_an_address_of_dnsmasq(model, tmp_path):
    program = shutil.which("dnsmasq", path="/usr/sbin:/usr/bin")
    need("dnsmasq" if program is None else program)
    with SocRun(model) as run:
        run.network.start(
            [program, "--no-daemon", "--conf-file=/dev/null", "--port=0", f"--interface={TAP}",
             "--bind-interfaces", "--user=root", "--group=root", "--no-ping",
             "--dhcp-authoritative", f"--dhcp-range={_FIRST},{_LAST},1h",
             f"--dhcp-leasefile={tmp_path / 'leases'}", f"--pid-file={tmp_path / 'pid'}"])
        address = reported(run, _FIRST, _LAST)
        assert own_address(run, address) == address
        # The server has given exactly this address to exactly this machine.
        end = time.monotonic() + 10
        while not (lease := (tmp_path / "leases").read_text()) and time.monotonic() < end:
            time.sleep(0.1)
    assert lease.split()[1:3] == [model.identity.mac, address]


def test_a_link_local_address_if_no_server_answers(model):
    with SocRun(model) as run:
        address = reported(run, "169.254.1.0", "169.254.254.255")
        done = run.network.run(["ip", "addr", "add", f"{_LINK_LOCAL}/16", "dev", TAP], timeout=10)
        assert not done.returncode, done.stderr
        assert own_address(run, address) == address != CLIENT
        # Seconds of lwIP's later the watchdog has not begun anything anew.
        assert run.screen.count("NCDC ") == 1

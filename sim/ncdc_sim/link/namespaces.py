"""A network of its own: a client's and a device's namespace, joined by a pair of interfaces.

Nothing that runs in it reaches any other address. It needs no root: the kernel gives an
unprivileged user namespaces in which it may make interfaces, where that is allowed.
"""

import os
import signal
import subprocess

from ncdc_sim.tools import SimulationError
from ncdc_spec.needs import check_programs

__all__ = ["CLIENT", "DEVICES", "Network", "TAP", "TapNetwork"]

CLIENT = "10.77.0.1"
DEVICES = ("10.77.0.11", "10.77.0.12", "10.77.0.13")
_CLIENT_LINK, _DEVICE_LINK = "client0", "device0"
TAP = "ncdc0"           # the interface whose other end is a simulation


class Network:
    """The two namespaces, from ``with`` to its end, when all that runs in them is killed.

    Parameters
    ----------
    mtu : int
        Bytes of an IP packet; 1500 of Ethernet, 9000 of jumbo packets.

    Raises
    ------
    SimulationError
        If the kernel allows no namespaces.
    InputError
        If a program is not installed.
    """
    def __init__(self, mtu=1500):
        self._mtu = mtu
        self._running = []

    def __enter__(self):
        check_programs("a network of its own needs", "unshare", "nsenter", "ip")
        try:
            self._client = self._holder(["unshare", "-Urn"])
            self._make()
        except (OSError, subprocess.SubprocessError) as error:
            self.__exit__()
            raise SimulationError(f"no network namespaces here: {error}") from error
        return self

    def __exit__(self, *_):
        for process in reversed(self._running):
            if process.poll() is None:
                process.send_signal(signal.SIGKILL)
            process.wait()

    def _holder(self, prefix):
        """A process that keeps a new namespace, and says when it is there.

        It ends with the process that made it, whose end of the pipe is closed then.
        """
        process = subprocess.Popen([*prefix, "sh", "-c", "echo here; exec cat"],
                                   stdin=subprocess.PIPE, stdout=subprocess.PIPE,
                                   stderr=subprocess.PIPE, text=True)
        self._running.append(process)
        if process.stdout.readline() != "here\n":
            raise OSError(process.stderr.read().strip())
        return process

    @staticmethod
    def _enter(process):
        return ["nsenter", "--preserve-credentials", "-U", "-n", "-t", str(process.pid)]

    def _make(self):
        """The device's namespace, and what joins it to the client's."""
        self._device = self._holder([*self._enter(self._client), "unshare", "-n"])
        client, device = self._enter(self._client), self._enter(self._device)
        group = "224.0.0.0/4"
        commands = [
            [*client, "ip", "link", "add", _CLIENT_LINK, "type", "veth", "peer", "name",
             _DEVICE_LINK, "netns", str(self._device.pid)],
            [*client, "ip", "addr", "add", f"{CLIENT}/24", "brd", "+", "dev", _CLIENT_LINK],
            *([*device, "ip", "addr", "add", f"{address}/24", "brd", "+", "dev", _DEVICE_LINK]
              for address in DEVICES)]
        for side, link in ((client, _CLIENT_LINK), (device, _DEVICE_LINK)):
            commands += [[*side, "ip", "link", "set", "lo", "up"],
                         [*side, "ip", "link", "set", link, "mtu", str(self._mtu), "up"],
                         [*side, "ip", "route", "add", group, "dev", link]]
        self._carry_out(commands)

    @staticmethod
    def _carry_out(commands):
        for command in commands:
            done = subprocess.run(command, capture_output=True, text=True, timeout=20)
            if done.returncode:
                raise OSError(f"{' '.join(command[6:])}: {done.stderr.strip()}")

    def run(self, command, timeout, **options):
        """Run ``command`` on the client's side to its end: a CompletedProcess with texts."""
        return subprocess.run([*self._enter(self._client), *command], capture_output=True,
                              text=True, timeout=timeout, **options)

    def start(self, command, device=False, **options):
        """Start ``command`` on either side; killed at the end of the network."""
        side = self._enter(self._device if device else self._client)
        process = subprocess.Popen([*side, *command], text=True,
                                   env={**os.environ, "PYTHONUNBUFFERED": "1"}, **options)
        self._running.append(process)
        return process

    @property
    def client_link(self):
        """Name of the client's network interface."""
        return _CLIENT_LINK


class TapNetwork(Network):
    """One namespace with a network interface, ``TAP``, whose frames a program reads and writes.

    ``holder`` is the process that keeps it, for who wants to join by ``nsenter``.
    """
    client_link = TAP

    def _make(self):
        client = self._enter(self._client)
        self._carry_out([
            [*client, "ip", "link", "set", "lo", "up"],
            [*client, "ip", "tuntap", "add", "dev", TAP, "mode", "tap"],
            [*client, "ip", "addr", "add", f"{CLIENT}/24", "brd", "+", "dev", TAP],
            [*client, "ip", "link", "set", TAP, "mtu", str(self._mtu), "up"],
            [*client, "ip", "route", "add", "224.0.0.0/4", "dev", TAP]])

    @property
    def holder(self):
        """Its process."""
        return self._client.pid

"""One list of requests of Table I, and the same answers from every device that speaks it."""

import numpy as np
import pytest

from devices import device
from firmware_wire import TcpUser, Wire, wire_program
from hps_server import HEIGHT, WIDTH, hps_descriptor, hps_project, serving
from ncdc_host.client.table import Connection
from ncdc_spec.protocols.table_one import READ
from ncdc_spec.sensors import mt9p031
from table_requests import table_requests

REQUESTS = table_requests()


@pytest.fixture(scope="module")
def program(tmp_path_factory):
    """The firmware, built for this machine."""
    return wire_program(tmp_path_factory.mktemp("wire"), hps_descriptor(), field="full")


@pytest.fixture(scope="module")
def project(tmp_path_factory):
    return hps_project(tmp_path_factory.mktemp("server"))


def asked(connection):
    """Values that a connection answers."""
    with connection:
        return [connection.read(address) if code == READ else connection.write(address, value)
                for code, address, value in REQUESTS]


def emulated():
    image = np.zeros((HEIGHT, WIDTH), np.uint8)
    with device([hps_descriptor()], image, field="full") as one:
        return asked(Connection(one.options.address, one.table.port))


def firmware(program):
    with Wire(program) as wire:
        user = TcpUser(wire, 40_000)
        assert user.connect()
        return [user.ask(*request) for request in REQUESTS]


def hps(project):
    with serving(project) as running:
        return asked(running.connection())


def differences(one, other):
    """(code, address, value, answers) of requests that two devices answer differently."""
    return [(hex(code), hex(address), hex(value), *pair) for (code, address, value), *pair in
            zip(REQUESTS, one, other) if pair[0] != pair[1]]


def test_all_devices_answer_alike(program, project):
    ours = emulated()
    assert differences(ours, firmware(program)) == []
    assert differences(ours, hps(project)) == []


def test_a_planted_difference_is_seen(project, monkeypatch):
    ours = hps(project)
    monkeypatch.setattr(mt9p031.SENSOR.user_registers[0].__class__, "takes", lambda *_: True)
    assert differences(ours, emulated())

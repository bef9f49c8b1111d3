"""The firmware that the devices are compared with, built for this machine once."""

import pytest

from cameras import barrel_descriptor
from devices import SIZE
from firmware_wire import wire_program
from ncdc_spec.protocols import gvsp

# Of a packet: what the largest size that a client may ask for holds.
CAPACITY = gvsp.packet_size(gvsp.MAX_PACKET) - gvsp.HEADERS_BYTES


@pytest.fixture(scope="session")
def wire_firmware(tmp_path_factory):
    """Program for :class:`~firmware_wire.Wire`, of a corrector with gains."""
    return wire_program(tmp_path_factory.mktemp("wire"), barrel_descriptor(SIZE, SIZE),
                        capacity=CAPACITY, colour=True)

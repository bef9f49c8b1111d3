"""The firmware that the devices are compared with, built for this machine once."""

import pytest

from devices import NARROW, view_lens
from eeprom_images import BUILT_IN
from firmware_wire import wire_program
from ncdc_spec.protocols import gvsp

# Of a packet: what the largest size that a client may ask for holds.
CAPACITY = gvsp.packet_size(gvsp.MAX_PACKET) - gvsp.HEADERS_BYTES


@pytest.fixture(scope="session")
def wire_firmware(tmp_path_factory):
    """Program for :class:`~firmware_wire.Wire`, of a corrector with gains and a view."""
    return wire_program(tmp_path_factory.mktemp("wire"), view_lens(focal=NARROW),
                        capacity=CAPACITY, colour=True, view=True)


@pytest.fixture(scope="session")
def plain_firmware(tmp_path_factory):
    """The same without a view, with the built-in lens of the EEPROM's images."""
    return wire_program(tmp_path_factory.mktemp("wire"), BUILT_IN, capacity=CAPACITY, colour=True)

"""pyftdi at the simulated FT232H of a whole camera system: Table I, pictures, registers."""

import textwrap
from pathlib import Path

import numpy as np
import pytest
import usb.core

from cameras import barrel_descriptor
from ncdc_hdl.export.drivers.host.ncdc_backends import Serial
from ncdc_hdl.export.verilog.system_cover import system_verilog
from ncdc_hdl.system import System
from ncdc_hdl.usb.layouts import FT232H
from ncdc_hdl.usb.system import UsbSystem
from ncdc_host.client.errors import DeviceGone
from ncdc_host.client.usb import UsbConnection, UsbDevice, UsbPort
from ncdc_model.correction import correct
from ncdc_sim.sensor.verilog import Light
from ncdc_sim.system.running import running
from ncdc_spec.hardware import Hardware
from ncdc_spec.protocols.features import system_word
from ncdc_spec.sensors.catalogue import sensor_named, setup
from ncdc_spec.sensors.sensor import Settings
from simulations.usb_backend import SimulatedUsb

# The model of a system takes a minute to compile.
pytestmark = [pytest.mark.regress, pytest.mark.many_clocks]

SENSOR = sensor_named("mt9p031")
SECONDS = 300.0         # that a machine may take for an answer, not that the device may
PAUSES = "+usb_rx_stall=60", "+usb_tx_stall=60"


def simulated(size, more=()):
    """A camera of ``size`` with USB, as a context, and its system."""
    descriptor = barrel_descriptor(size, size, hidden_neurons=2, strength=.4)
    system = UsbSystem(System(descriptor, Hardware(data_width=64)), FT232H, SENSOR)
    width, height = size
    noise = np.random.default_rng(1).integers(0, 4096, (6, height, width), dtype=np.uint16)
    asked = setup(SENSOR, Settings(width=width, height=height, exposure_us=100,
                                   clock_hz=SENSOR.pixel_clock_hz))
    return system, running(system, asked, Light(noise), verilog=system_verilog(system),
                           registers={"RUN": 1}, more=more)


def connected(live, step=20_000):
    device = usb.core.find(backend=SimulatedUsb(live, step))
    return UsbPort(device=device, timeout=SECONDS)


def picture(connection, after=0):
    """A picture and the number of its frame, which is beyond ``after``."""
    number = after
    while number <= after:
        package = connection.picture(SECONDS)
        number = (connection.read(system_word("NUMBER_UPPER")) << 16
                  | connection.read(system_word("NUMBER_LOWER")))
    header = package.header
    shape = header.height, header.width, *([header.pixel_format.pixel_bytes]
                                           if header.pixel_format.pixel_bytes > 1 else [])
    return np.frombuffer(package.data, np.uint8).reshape(shape), number


def test_table_one_pictures_and_registers():
    system, context = simulated((64, 24), PAUSES)
    with context as camera:
        port = connected(camera.host.live)
        connection = UsbConnection(port, SECONDS)
        assert connection.read(0) == 0x1801             # the sensor's chip version
        assert connection.write(0x35, 0x0123) == 0x0123 and connection.read(0x35) == 0x0123
        assert connection.read(system_word("WIDTH_MAX")) == 64
        raw, number = picture(connection)
        np.testing.assert_array_equal(raw, camera.sent(number))
        assert connection.write(system_word("SOURCE"), 1) == 1
        corrected, number = picture(connection, number)
        np.testing.assert_array_equal(corrected[..., 2::-1], correct(
            system.descriptor, camera.sent(number), strip=system.hardware.strip).picture)
        # Registers of the corrector and the camera, by the driver that users get.
        read, write = Serial(port)
        width = next(r.address for r in system.table if r.name == "WINDOW_WIDTH")
        assert read(4 * width) == 64
        limit = next(r.address for r in system.table if r.name == "READER_LIMIT")
        write(4 * limit, 123_456_789)
        assert read(4 * limit) == camera.host.get("READER_LIMIT") == 123_456_789
        bench = camera.host.live.end()
    assert not any(value for name, value in bench.items() if name.endswith("_errors"))


def test_the_client_s_device_and_the_page_s_example():
    _, context = simulated((64, 24))
    with context as camera:
        port = connected(camera.host.live)
        device = UsbDevice(port)
        assert (device.get("WidthMax"), device.get("HeightMax")) == (64, 24)
        with device.stream() as stream:
            frames = [stream.next(SECONDS) for _ in range(3)]
        numbers = [frame.number for frame in frames]
        assert numbers == sorted(set(numbers))
        for frame in frames:
            np.testing.assert_array_equal(frame.pixels, camera.sent(frame.number))
        # Of the documentation.
        page = (Path(__file__).resolve().parents[2] / "docs" / "reference" / "usb.md").read_text()
        block = page.partition("## On the PC")[2].split("\n\n`pip")[0]
        names = {}
        exec(textwrap.dedent(block), names)
        header, data = names["fetch"](device=port._ftdi._usb_dev)
        assert (header.width, header.height, len(data)) == (64, 24, 64 * 24)


def test_a_chip_in_its_other_mode_moves_nothing():
    _, context = simulated((64, 24), PAUSES)
    with context as camera:
        port = connected(camera.host.live)
        port._ftdi.set_bitmode(0xFF, port._ftdi.BitMode.RESET)
        with pytest.raises(DeviceGone, match="synchronous mode"):
            port.write(b"\x83")


def test_five_pictures_of_640_by_480():
    system, context = simulated((640, 480), PAUSES)
    with context as camera:
        connection, number = UsbConnection(connected(camera.host.live, 200_000), SECONDS), 0
        for _ in range(5):
            raw, number = picture(connection, number)
            np.testing.assert_array_equal(raw, camera.sent(number))
        connection.write(system_word("SOURCE"), 1)
        corrected, number = picture(connection, number)
        np.testing.assert_array_equal(corrected[..., 2::-1], correct(
            system.descriptor, camera.sent(number), strip=system.hardware.strip).picture)
        bench = camera.host.live.end()
    assert not any(value for name, value in bench.items() if name.endswith("_errors"))

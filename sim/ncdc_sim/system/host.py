"""A host of a simulated system: registers by name, I2C, frames claimed and read."""

from contextlib import suppress
from dataclasses import dataclass

import numpy as np

from ncdc_model.errors import InputError
from ncdc_model.interface.frames import output_format, stored_picture
from ncdc_model.interface.register_map import registers
from ncdc_model.interface.system_map import EVENTS, I2C_COMMAND_FLAGS, system_registers

__all__ = ["Frame", "I2cError", "SystemHost"]

_FLAGS = {name: mask for name, mask, _ in I2C_COMMAND_FLAGS}


class I2cError(InputError):
    """A target did not acknowledge, or the bus is not free."""


@dataclass(frozen=True)
class Frame:
    """A frame that was claimed: number and time of its raw frame, and its bytes."""
    number: int
    time: int
    data: bytes


class SystemHost:
    """What a driver does, on a :class:`LiveSystem`.

    Parameters
    ----------
    live : LiveSystem
    system : ncdc_hdl.system.System

    Attributes
    ----------
    i2c_errors : list of str
        Flags of `I2C_RESULT` that ended commands.
    """

    def __init__(self, live, system):
        self.live, self.system, self.geometry = live, system, system.descriptor.geometry
        table = (*registers(system.descriptor.hidden_neurons, system.descriptor.formats,
                            system.descriptor.nodes), *system_registers(system.stores))
        self.rows = {r.name: r for r in table}
        self.i2c_errors = []

    def put(self, **values):
        """Write registers by name, in this order."""
        for name, value in values.items():
            self.live.write(self.rows[name].address, value)

    def get(self, name):
        """Value of a register."""
        return self.live.read(self.rows[name].address)

    def flag(self, register, name):
        """Value of some bits of a register."""
        [flag] = [flag for flag in self.rows[register].flags if flag.name == name]
        return (self.get(register) & flag.mask) >> flag.low

    def events(self):
        """Names of the events since they were asked for last, which are forgotten."""
        status = self.get("CAMERA_STATUS")
        self.put(CAMERA_STATUS=status)
        return {name for k, (name, _) in enumerate(EVENTS) if status >> 8 + k & 1}

    def listen(self, *names):
        """Let the interrupt follow these events."""
        order = [name for name, _ in EVENTS]
        self.put(CAMERA_IRQ_ENABLE=sum(1 << order.index(name) for name in names))

    def i2c(self, data=0, *flags):
        """One command; the byte received.

        Raises
        ------
        I2cError
            If it is not acknowledged, or the bus is lost or held.
        """
        self.put(I2C_COMMAND=data | sum(_FLAGS[name] for name in flags))
        quarter = self.get("I2C_QUARTER")
        self.live.wait(36 * quarter)        # of a byte
        for _ in range(1000):
            result = self.get("I2C_RESULT")
            if not result & 0x100:
                break
            self.live.wait(4 * quarter)
        for mask, name, what in (
                (0x200, "NACK", "nobody acknowledges"), (0x400, "LOST", "the bus is not free"),
                (0x800, "TIMEOUT", "SCL is held"), (0x100, "BUSY", "the command does not end")):
            if result & mask:
                self.i2c_errors.append(name)
                raise I2cError(f"I2C: {what}")
        return result & 0xFF

    def persistent(self, transfer, *arguments):
        """A transfer, a second and a third time if it fails; before each the bus is freed.

        A target that a reset, or noise, left in mid-byte sends the rest of it then.
        """
        for _ in range(2):
            try:
                return transfer(*arguments)
            except I2cError:
                with suppress(I2cError):
                    self.i2c(0, "READ", "NACK", "STOP")
        return transfer(*arguments)

    def write_sensor(self, sensor, register, value):
        """Write a register of a :class:`ncdc_model.sensors.sensor.Sensor`."""
        words = [*value_bytes(register, sensor.pointer_bits),
                 *value_bytes(value, sensor.value_bits)]
        self.i2c(sensor.i2c_address << 1, "START", "WRITE")
        for word in words[:-1]:
            self.i2c(word, "WRITE")
        self.i2c(words[-1], "WRITE", "STOP")

    def read_sensor(self, sensor, register):
        """Value of a register of a sensor."""
        self.i2c(sensor.i2c_address << 1, "START", "WRITE")
        for word in value_bytes(register, sensor.pointer_bits):
            self.i2c(word, "WRITE")
        self.i2c(sensor.i2c_address << 1 | 1, "START", "WRITE")
        value = self.i2c(0, "READ") if sensor.value_bits == 16 else 0
        return value << 8 | self.i2c(0, "READ", "NACK", "STOP")

    def set_up(self, setup, before_start=lambda: None):
        """Write a sensor's set-up; its last write, which lets it send, behind ``before_start``.

        Raises
        ------
        I2cError
            If the sensor does not answer, or is another one.
        """
        sensor = setup.sensor
        for register, value in sensor.chip_id:
            if (found := self.persistent(self.read_sensor, sensor, register)) != value:
                raise I2cError(f"register {register:#x} of the {sensor.name} reads {found:#x}, "
                               f"{value:#x} is needed")
        for write in setup.writes[:-1]:
            self.persistent(self.write_sensor, sensor, write.register, write.value)
        before_start()
        last = setup.writes[-1]
        self.persistent(self.write_sensor, sensor, last.register, last.value)

    def claim(self, corrected=True, reader=0):
        """Claim the newest frame; its :class:`Frame`, or None if there is none."""
        name = f"READER{reader}"
        self.put(**{name: 2 if corrected else 1})
        if not self.flag(name, "HELD"):
            return None
        buffer = f"{'CORRECTED' if corrected else 'RAW'}{self.flag(name, 'BUFFER')}"
        size = self.get("CORRECTED_BYTES" if corrected else "RAW_BYTES")
        return Frame(self.get(f"{buffer}_NUMBER"),
                     self.get(f"{buffer}_TIME_LOW") | self.get(f"{buffer}_TIME_HIGH") << 32,
                     self.live.memory(self.get(f"{buffer}_BASE"), size))

    def reread(self, corrected, reader, size):
        """Bytes of the buffer that a reader claimed, as they are now."""
        buffer = self.flag(f"READER{reader}", "BUFFER")
        base = self.get(f"{'CORRECTED' if corrected else 'RAW'}{buffer}_BASE")
        return self.live.memory(base, size)

    def release(self, reader=0):
        """Release what a reader holds."""
        self.put(**{f"READER{reader}": 4})

    def streamed(self):
        """The last :class:`Frame` that left as a stream, three bytes a pixel, of no known time."""
        width, height = self.geometry.corrected
        return Frame(self.get("CORRECTED_NUMBER"), 0,
                     self.live.streamed()[-3 * width * height:])

    def picture(self, frame):
        """Pixels of a corrected frame, uint8 (height, width, 3)."""
        width, height = self.geometry.corrected
        form = output_format(self.system.hardware.format)
        size = 3 if self.live.stream else form.pixel_bytes
        pixels = np.frombuffer(frame.data, np.uint8)[:size * width * height]
        pixels = pixels.reshape(height, width, size)
        return pixels if self.live.stream else stored_picture(pixels, form)

    def raw(self, frame):
        """Samples of a raw frame, uint8 (height, width)."""
        width, height = self.geometry.distorted
        pitch = self.get("RAW_PITCH")
        rows = np.frombuffer(frame.data, np.uint8)[:pitch * height].reshape(height, pitch)
        return rows[:, :width]


def value_bytes(value, bits):
    """Bytes of a number of 8 or 16 bits, the upper one first."""
    return value.to_bytes(bits // 8, "big")

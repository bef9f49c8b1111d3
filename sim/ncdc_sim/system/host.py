"""A host of a simulated system: registers by name, I2C, frames claimed and read."""

from dataclasses import dataclass

import numpy as np

from ncdc_model.errors import InputError
from ncdc_model.interface.frames import stored_picture
from ncdc_model.interface.register_map import registers
from ncdc_model.interface.system_map import EVENTS, I2C_COMMAND_FLAGS, system_registers

__all__ = ["Frame", "I2cError", "SystemHost"]

_FLAGS = {name: mask for name, mask, _ in I2C_COMMAND_FLAGS}
_I2C_CLOCKS = 10_000_000        # for a byte, at most


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
    """

    def __init__(self, live, system):
        self.live, self.system, self.geometry = live, system, system.descriptor.geometry
        table = (*registers(system.descriptor.hidden_neurons, system.descriptor.formats,
                            system.descriptor.nodes), *system_registers(system.stores))
        self.rows = {r.name: r for r in table}

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
        for _ in range(1000):
            result = self.get("I2C_RESULT")
            if not result & 0x100:
                break
            self.live.wait(max(1, self.get("I2C_QUARTER")))
        for mask, what in ((0x200, "nobody acknowledges"), (0x400, "the bus is not free"),
                           (0x800, "SCL is held"), (0x100, "the command does not end")):
            if result & mask:
                raise I2cError(f"I2C: {what}")
        return result & 0xFF

    def write_sensor(self, address, writes, wide_address=False, wide_value=True):
        """Write registers of the target at the 7-bit ``address``: (register, value) each."""
        for register, value in writes:
            words = [register >> 8] * wide_address + [register & 0xFF]
            words += [value >> 8] * wide_value + [value & 0xFF]
            self.i2c(address << 1, "START", "WRITE")
            for word in words[:-1]:
                self.i2c(word, "WRITE")
            self.i2c(words[-1], "WRITE", "STOP")

    def read_sensor(self, address, register, wide_address=False, wide_value=True):
        """A register of the target at the 7-bit ``address``."""
        self.i2c(address << 1, "START", "WRITE")
        for word in [register >> 8] * wide_address + [register & 0xFF]:
            self.i2c(word, "WRITE")
        self.i2c(address << 1 | 1, "START", "WRITE")
        value = self.i2c(0, "READ") if wide_value else 0
        return value << 8 | self.i2c(0, "READ", "NACK", "STOP")

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

    def release(self, reader=0):
        """Release what a reader holds."""
        self.put(**{f"READER{reader}": 4})

    def picture(self, frame):
        """Pixels of a corrected frame, uint8 (height, width, 3)."""
        width, height = self.geometry.corrected
        stored = np.frombuffer(frame.data, np.uint8)[:4 * width * height]
        return stored_picture(stored.reshape(height, width, 4))

    def raw(self, frame):
        """Samples of a raw frame, uint8 (height, width)."""
        width, height = self.geometry.distorted
        pitch = self.get("RAW_PITCH")
        rows = np.frombuffer(frame.data, np.uint8)[:pitch * height].reshape(height, pitch)
        return rows[:, :width]

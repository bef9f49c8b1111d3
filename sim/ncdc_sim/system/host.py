"""A host of a simulated system: the driver that users get, on its registers and its memory."""

import sys
from dataclasses import dataclass
from importlib.resources import files
from types import ModuleType
from unittest import mock

import numpy as np

from ncdc_hdl.export.drivers.python_registers import python_registers
from ncdc_spec.frames import output_format, stored_picture
from ncdc_spec.registers.register_map import registers

__all__ = ["Content", "SystemHost"]


@dataclass(frozen=True)
class Content:
    """A frame and its bytes: number of its raw frame, clocks from the reset to its beginning."""
    number: int
    time: int
    data: bytes


class SystemHost:
    """The Python driver of a system, on a :class:`LiveSystem`.

    Parameters
    ----------
    live : LiveSystem
    system : ncdc_hdl.system.System

    Attributes
    ----------
    camera : Camera
        Instance of ``ncdc_camera.py``'s class.
    errors : type
        What it raises if the sensor does not answer, or a write is rejected.
    """

    def __init__(self, live, system):
        self.live, self.system, self.geometry = live, system, system.descriptor.geometry
        descriptor = system.descriptor
        table = (*registers(descriptor.hidden_neurons, descriptor.formats, descriptor.nodes,
                            system.hardware.colour, system.hardware.raw_balance,
                            system.hardware.view, system.hardware.views,
                            system.hardware.view_rows),
                 *system.table)
        driver = _driver(python_registers(table))
        self.camera = driver.CameraSystem(lambda offset: live.read(offset >> 2),
                                    lambda offset, value: live.write(offset >> 2, value),
                                    lambda: live.wait(8 * self.quarter))
        self.errors, self._offsets = driver.CameraError, {r.name: 4 * r.address for r in table}
        self.quarter = 8        # clocks of a quarter of a bit on the I2C bus

    def get(self, name):
        """Value of a register."""
        return self.camera.get(name)

    def write(self, name, value):
        """Write a register; nothing is raised if the system rejects it."""
        self.camera.write(self._offsets[name], value)

    def claim(self, corrected=True, reader=0):
        """Claim the newest frame; its :class:`Content`, or None if there is none."""
        frame = self.camera.claim(reader, corrected)
        return frame and Content(frame.number, frame.time,
                                 self.live.memory(frame.base, frame.size))

    def streamed(self):
        """The last frame that left as a stream, three bytes a pixel, of no known time."""
        width, height = self.geometry.corrected
        return Content(self.get("CORRECTED_NUMBER"), 0, self.live.streamed()[-3 * width * height:])

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


def _driver(registers_text):
    """The module ``ncdc_camera``, with a module ``ncdc_registers`` of this text."""
    text = (files("ncdc_hdl.export.drivers") / "host" / "ncdc_camera.py").read_text()
    modules = {name: ModuleType(name) for name in ("ncdc_registers", "ncdc_camera")}
    exec(registers_text, vars(modules["ncdc_registers"]))
    with mock.patch.dict(sys.modules, modules):
        exec(compile(text, "ncdc_camera.py", "exec"), vars(modules["ncdc_camera"]))
    return modules["ncdc_camera"]

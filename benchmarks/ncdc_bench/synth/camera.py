"""The blocks of a camera side by side, as one component."""

from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.wiring import Out

from ncdc_hdl.camera.capture import Capture
from ncdc_hdl.camera.frame_store import FrameStore
from ncdc_hdl.camera.i2c import I2cController
from ncdc_hdl.lib.ports import forward

__all__ = ["CameraBlocks"]


class CameraBlocks(wiring.Component):
    """Capture, a frame store and an I2C controller, not connected with each other.

    Parameters
    ----------
    data_width, burst : int
        Bits of a word of the memory; words of a burst.
    readers : int
        Readers of the store.
    depth : int
        Depth of the queue between the clocks.
    """

    def __init__(self, data_width, burst, readers, depth):
        self.parts = {"capture": Capture(data_width, burst=burst, depth=depth),
                      "store": FrameStore(readers), "i2c": I2cController()}
        super().__init__({name: Out(part.signature) for name, part in self.parts.items()})

    def elaborate(self, platform):
        m = Module()
        for name, part in self.parts.items():
            m.submodules[name] = part
            forward(m, part.signature, getattr(self, name), part)
        return m

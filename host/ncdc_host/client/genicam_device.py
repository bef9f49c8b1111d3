"""What all devices over GVCP share, whichever library talks to them."""

from abc import abstractmethod

from ncdc_host.client.device import Device
from ncdc_host.client.errors import DeviceError
from ncdc_host.client.lens import LensLoader

__all__ = ["GenicamDevice"]


class GenicamDevice(Device):
    """A :class:`Device` with the features of an XML file, whose memory reaches the corrector.

    Its classes set ``_kinds``: the kind of each feature, by name.
    """
    _kinds: dict

    def names(self):
        return list(self._kinds)

    def _kind(self, name):
        if name not in self._kinds:
            raise DeviceError(f"{self.url} has no feature {name!r}")
        return self._kinds[name]

    @abstractmethod
    def read_memory(self, address, count):
        """``count`` bytes of the device's memory, a multiple of 4."""

    @abstractmethod
    def write_memory(self, address, data):
        """Write ``data``, whole words, to the device's memory."""

    def load_lens(self, descriptor):
        LensLoader(self).load(descriptor)

    def lens_limits(self):
        return LensLoader(self).limits()

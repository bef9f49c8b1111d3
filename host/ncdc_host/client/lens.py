"""A lens into a device: the corrector's registers over the network."""

import struct
import time
from dataclasses import dataclass

from ncdc_host.client.errors import DeviceError, Rejected
from ncdc_spec.errors import InputError
from ncdc_spec.formats import MAX_NEURONS, Formats
from ncdc_spec.geometry import BAYER_PHASE, MONO
from ncdc_spec.hardware import Hardware
from ncdc_spec.protocols.gvcp import CORRECTOR_BASE
from ncdc_spec.registers.host_values import host_values, table_words
from ncdc_spec.registers.register_map import (
    BAYER_MONO,
    CAPABILITIES,
    CTRL_COMMIT,
    ID,
    INTERPOLATION_BITS,
    NODES,
    STATUS_BANK,
    STATUS_COMMITTED,
    STATUS_REFUSED,
    VIEW_BIT,
    network_registers,
    registers,
)
from ncdc_spec.view import CAMERA_FORMATS

__all__ = ["LensLimits", "LensLoader"]

_CHUNK = 64             # words of a write
_SECONDS = 60           # that a device may take until a lens is active

# What has to be the same already: the device's memory is laid out for it.
_FIXED = ("CORRECTED_WIDTH", "CORRECTED_HEIGHT", "DISTORTED_WIDTH", "DISTORTED_HEIGHT",
          "BAYER_PHASE", "FILL")


@dataclass(frozen=True)
class LensLimits:
    """Requirements of a device on the lenses that it can load.

    Parameters
    ----------
    neurons : int
        Maximum number of hidden neurons.
    corrected, distorted : (int, int)
        Width and height.
    bayer : str
        Colour filter of the sensor, first two rows.
    fill : (int, int, int)
        Colour of pixels without a source.
    nodes : int
        Pixels from one evaluation of the network to the next.
    interpolation : str
    """
    neurons: int
    corrected: tuple
    distorted: tuple
    bayer: str
    fill: tuple
    nodes: int
    interpolation: str


class LensLoader:
    """Writes descriptors to the corrector of ``device``, which has read_memory and write_memory."""

    def __init__(self, device):
        self._device = device

    def limits(self):
        """See :meth:`ncdc_host.client.device.Device.lens_limits`."""
        table = {r.name: r for r in registers(1, Formats())}
        if self._read(table["ID"].address) != ID:
            raise DeviceError(f"{self._device.url} has no corrector")
        values = {name: self._read(table[name].address) for name in ("NEURONS", *_FIXED)}
        names = {phase[0] | phase[1] << 1: name for name, phase in BAYER_PHASE.items()}
        word = values["BAYER_PHASE"]
        bayer = MONO if word & BAYER_MONO else names[word & 3]
        corrected, distorted = (
            tuple(values[f"{side}_{part}"] for part in ("WIDTH", "HEIGHT"))
            for side in ("CORRECTED", "DISTORTED"))
        return LensLimits(values["NEURONS"], corrected, distorted, bayer,
                          tuple(values["FILL"].to_bytes(4, "big")[1:]), self._nodes(),
                          self._interpolation())

    def load(self, descriptor):
        """See :meth:`ncdc_host.client.device.Device.load_lens`."""
        view = bool(self._read(CAPABILITIES) & VIEW_BIT)
        table = {r.name: r for r in registers(MAX_NEURONS, descriptor.formats, view=view)}
        if self._read(table["ID"].address) != ID:
            raise DeviceError(f"{self._device.url} has no corrector")
        neurons = self._read(table["NEURONS"].address)
        if descriptor.nodes != self._nodes():
            raise Rejected(f"the lens has nodes {descriptor.nodes} pixels apart, the device "
                          f"{self._nodes()}")
        own, interpolation = self._interpolation(), descriptor.geometry.interpolation.name
        if interpolation != own:
            raise Rejected(f"the lens is for the interpolation {interpolation}, the device has "
                          f"{own}")
        try:
            values = host_values(descriptor, Hardware(view=view), neurons=neurons)
        except InputError as error:
            raise Rejected(str(error)) from error
        for name in _FIXED:
            present = self._read(table[name].address)
            if present != values[name]:
                raise Rejected(f"the lens has {name} {values[name]}, the device has {present}")
        words = {r.address: values[r.name] & 0xFFFFFFFF
                 for r in network_registers(neurons, descriptor.formats)}
        words |= dict(table_words(descriptor.valid))
        if view:
            # The device makes its matrix anew from the camera.
            words |= {table[name].address: values[name] & 0xFFFFFFFF for name in CAMERA_FORMATS}
        # A running frame holds the bank of valid rows that it uses: the other one is written.
        bank = int(not self._read(table["STATUS"].address) & STATUS_BANK)
        self._write({table["STATUS"].address: STATUS_REFUSED,
                     table["VALID_WINDOW"].address: bank})
        self._write(words | {table["VALID_BANK"].address: bank})
        self._write({table["CTRL"].address: CTRL_COMMIT})
        until = time.monotonic() + _SECONDS
        while (status := self._read(table["STATUS"].address)) & STATUS_COMMITTED:
            if time.monotonic() > until:
                raise DeviceError(f"the lens is not active after {_SECONDS} s")
            time.sleep(0.05)
        if status & STATUS_REFUSED:
            raise Rejected(f"{self._device.url} rejects the lens")

    def _nodes(self):
        """Distance of the device's nodes; without nodes it has no register of them."""
        return self._read(NODES) or 1

    def _interpolation(self):
        """Name of the interpolation that the device has."""
        word = self._read(CAPABILITIES)
        for name, bit in INTERPOLATION_BITS.items():
            if word & bit:
                return name
        raise DeviceError(f"{self._device.url} does not report its interpolation: "
                          f"CAPABILITIES reads {word:#010x}")

    def _read(self, address):
        data = self._device.read_memory(CORRECTOR_BASE + 4 * address, 4)
        return int.from_bytes(data, "big")

    def _write(self, words):
        """Write ``words`` by word address, as few packets as their gaps allow."""
        run = []
        for address in sorted(words):
            if run and (address != run[-1] + 1 or len(run) == _CHUNK):
                self._send(words, run)
                run = []
            run.append(address)
        self._send(words, run)

    def _send(self, words, run):
        data = struct.pack(f">{len(run)}I", *(words[address] for address in run))
        self._device.write_memory(CORRECTOR_BASE + 4 * run[0], data)

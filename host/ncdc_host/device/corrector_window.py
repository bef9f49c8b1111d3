"""The corrector's own registers over the network: how a host gives a device another lens."""

import threading
from dataclasses import replace

import numpy as np

from ncdc_host.device.registers import Rejected
from ncdc_model.correction import Correction
from ncdc_spec.colour import COLOURS, Colour
from ncdc_spec.descriptor import Descriptor
from ncdc_spec.errors import InputError
from ncdc_spec.float_network import FloatNetwork
from ncdc_spec.geometry import ValidRows
from ncdc_spec.hardware import Hardware
from ncdc_spec.interpolation import CRESTS, DIRECTIONAL
from ncdc_spec.raw_gains import NO_RAW_GAINS
from ncdc_spec.registers.host_values import colour_values, host_values, table_words
from ncdc_spec.registers.register_map import (
    COLOUR_SETTINGS,
    CTRL_COMMIT,
    ID,
    OUTSIDE_DIGEST,
    STATUS_COMMITTED,
    STATUS_REFUSED,
    TABLE,
    capabilities,
    network_registers,
    registers,
)
from ncdc_spec.view import CAMERA_FORMATS
from ncdc_spec.view_matrix import frame_of_values

__all__ = ["CorrectorWindow", "descriptor_of_words"]


class CorrectorWindow:
    """A window on registers as ``docs/reference/registers.md`` has them.

    A write changes a shadow; CTRL.COMMIT makes the network and the valid rows of the shadow those
    of the selected lens, and gains and tone those of corrected pictures. Geometry, fill and format
    of the device stay: a commit with others is rejected. The matrix of a view has no effect, the
    device writes its own by Pan, Tilt, Roll and Zoom.
    """
    def __init__(self, state, camera):
        self._state, self._camera = state, camera
        self._lock = threading.Lock()
        self._words, self._lens, self._base, self._colour = {}, None, None, None
        self._status = 0
        descriptor = camera.corrections[0].descriptor
        self._hardware = Hardware(colour=True, view=state.has_view)
        self._map = {r.name: r for r in registers(
            descriptor.hidden_neurons, descriptor.formats, descriptor.nodes, colour=True,
            view=state.has_view)}
        self._by_address = {r.address: r for r in self._map.values()}

    def _load(self):
        """Fill the shadow with the registers of the lens that is selected."""
        settings = self._state.settings
        lens = settings.lens
        descriptor = self._camera.corrections[lens].descriptor
        if lens != self._lens or descriptor is not self._base:
            self._lens, self._base = lens, descriptor
            self._words = {self._map[name].address: value & 0xFFFFFFFF
                           for name, value in self._values(descriptor).items()}
            self._words |= dict(table_words(descriptor.valid))
            self._words |= {self._map["ID"].address: ID,
                            self._map["DIGEST"].address: int(descriptor.digest[:8], 16),
                            self._map["NEURONS"].address: descriptor.hidden_neurons}
            width, height = descriptor.geometry.corrected
            self._words |= {self._map[name].address: value for name, value in capabilities(
                self._hardware.made_for(descriptor), width, height, capture=True).items()}
            if descriptor.nodes > 1:
                self._words[self._map["NODES"].address] = descriptor.nodes
            self._colour = None
        colour = replace(settings.colour, raw_gains=NO_RAW_GAINS)     # of its registers
        if colour != self._colour:
            self._colour = colour
            self._words |= {self._map[name].address: value
                            for name, value in colour_values(self._colour).items()}
            self._words[self._map["CREST"].address] = self._colour.crest

    def _values(self, descriptor):
        return host_values(descriptor, Hardware(view=self._state.has_view))

    def read(self, address):
        """The word at a word address; 0 where there is none."""
        with self._lock:
            self._load()
            if address == self._map["STATUS"].address:
                return self._status
            for name, value in self._camera.sums.registers.items():
                self._words[self._map[name].address] = value
            return self._words.get(address, 0)

    def write(self, address, value):
        """Write a word; raises :class:`Rejected`."""
        with self._lock:
            self._load()
            if address == self._map["STATUS"].address:
                self._status &= ~(value & STATUS_REFUSED)
                return
            if self._status & STATUS_COMMITTED:
                # The set is about to become active: it is not changed any more.
                self._status |= STATUS_REFUSED
                return
            if address == self._map["CTRL"].address:
                if value & CTRL_COMMIT:
                    self._status |= STATUS_COMMITTED
                    threading.Thread(target=self._commit, daemon=True).start()
                return
            register = self._by_address.get(address)
            if register is not None and register.access not in ("shadow", "rw"):
                raise Rejected("read only")
            if register is None and address < TABLE:
                raise Rejected("read only")
            if register is not None and register.name in (*COLOUR_SETTINGS, "CREST"):
                value &= (1 << register.shape.width) - 1
            self._words[address] = value

    def _commit(self):
        """Make the lens of the shadow; takes seconds, while which STATUS.COMMITTED is high."""
        try:
            colour = self._committed_colour()
            correction = Correction(self._checked())
            self._state.replace_lens(self._lens, correction.descriptor)
        except InputError:
            correction = None
        with self._lock:
            if correction is None:
                self._status |= STATUS_REFUSED
            else:
                self._camera.replace_lens(self._lens, correction)
                with self._state.lock:
                    present = self._state.settings.colour.raw_gains
                    self._state.set_colour(replace(colour, raw_gains=present))
            self._status &= ~STATUS_COMMITTED

    def _committed_colour(self):
        """The :class:`Colour` of the shadow; raises :class:`InputError` if its tone is no curve.

        Gains at capture are none of the corrector's registers.
        """
        tone = [name for name in COLOUR_SETTINGS if name.startswith("TONE")]
        values = {name: self._words[self._map[name].address] for name in COLOUR_SETTINGS}
        # As in hardware: 3 counts as 2, and another interpolation has no crest.
        crest = min(self._words[self._map["CREST"].address], max(CRESTS.values()))
        return Colour(tuple(values[f"GAIN_{name.upper()}"] for name in COLOURS),
                      tuple(values[name] for name in tone),
                      crest * (self._base.geometry.interpolation == DIRECTIONAL))

    def _checked(self):
        """The descriptor of the shadow."""
        network = {r.name for r in network_registers(self._base.hidden_neurons,
                                                     self._base.formats)}
        for name, value in self._values(self._base).items():
            if name not in network and name not in OUTSIDE_DIGEST:
                if self._words[self._map[name].address] != value & 0xFFFFFFFF:
                    raise InputError(f"{name} cannot be changed")
        values = {name: _signed(self._words[self._map[name].address]) for name in CAMERA_FORMATS
                  } if self._state.has_view else {}
        return descriptor_of_words(self._base, self._words, values)


def _signed(word):
    return word - ((word & 1 << 31) << 1)


def descriptor_of_words(base, words, camera):
    """``base`` with the network and valid rows of register ``words`` by word address.

    ``camera``: values of the registers of the picture's camera by name, empty where there are
    none.

    Raises
    ------
    InputError
        If they are no descriptor.
    """
    arrays = {"hidden": [base.hidden_weights.copy(), base.hidden_biases.copy()],
              "output": [base.output_weights.copy(), base.output_biases.copy()]}
    skip = None if base.skip_weights is None else base.skip_weights.copy()
    for register in network_registers(base.hidden_neurons, base.formats):
        value = _signed(words[register.address])
        layer, neuron, part, *weight = register.parameter
        if part == "skip":
            skip[(neuron, *weight)] = value
        else:
            arrays[layer][part == "bias"][(neuron, *weight)] = value
    height = base.geometry.corrected_height
    rows = [words.get(TABLE + k, 0) for k in range(2 * height)]
    spans = np.array([[row & 0xFFFF, row >> 16] for row in rows]).reshape(height, 4)
    q = base.formats
    real = FloatNetwork(
        q.hidden_weight.real(arrays["hidden"][0]), q.hidden_bias.real(arrays["hidden"][1]),
        q.output_weight.real(arrays["output"][0]), q.output_bias.real(arrays["output"][1]),
        gamma=1.0, skip_weights=None if skip is None else q.skip_weight.real(skip))
    frame = frame_of_values(camera) if camera else None
    (hidden_weights, hidden_biases), (output_weights, output_biases) = (
        arrays["hidden"], arrays["output"])
    return Descriptor(base.geometry, real, hidden_weights, hidden_biases, output_weights,
                      output_biases, ValidRows(spans), q, base.variant, skip, nodes=base.nodes,
                      provenance={"frame": frame} if frame else {})

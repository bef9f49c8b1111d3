"""The descriptor: one human-readable file per trained camera, from which everything is made."""

import hashlib
import json
import tomllib
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from ncdc_spec.errors import InputError, reading
from ncdc_spec.files import parse_text, write_text
from ncdc_spec.fixed import Q
from ncdc_spec.float_network import FloatNetwork, check_gamma
from ncdc_spec.formats import MAX_NEURONS, Formats
from ncdc_spec.geometry import Geometry, ValidRows
from ncdc_spec.interpolation import FAST, interpolation_of
from ncdc_spec.nodes import check_nodes

__all__ = ["Descriptor", "FloatNetwork", "Formats", "MAX_NEURONS", "VERSION"]

VERSION = 1

# Weights and biases in the order of the file, and their formats.
_LAYERS = {"hidden_weights": "hidden_weight", "hidden_biases": "hidden_bias",
           "output_weights": "output_weight", "output_biases": "output_bias",
           "skip_weights": "skip_weight"}


@dataclass(frozen=True)
class Descriptor:
    """A trained camera as integers, with the formats, the geometry and where they came from.

    Parameters
    ----------
    geometry : Geometry
    network : FloatNetwork
        Before quantisation; the reference of the fixed-point errors.
    hidden_weights, hidden_biases, output_weights, output_biases : ndarray of int
        Raw integers in ``formats``; shapes (HN, 2), (HN,), (2, HN), (2,). The hidden layer's are
        multiplied by gamma, since f(n) with gamma is f(gamma n) without: the tan-sigmoid itself
        has no gamma. For a power of two that is exact; for another gamma the products are
        rounded, once, like every weight.
    skip_weights : ndarray of int or None
        Weights of the skip path, shape (2, 2): [x', y'] rows of the weights of x and y.
    valid : ValidRows
        Which corrected pixels have a source.
    formats : Formats
    variant : str
        Variant of the tan-sigmoid, see ``ncdc_spec.tansig.VARIANTS``.
    nodes : int
        Distance in pixels of the columns at which the network is evaluated, one of
        ``ncdc_spec.nodes.NODES``; 1: at every pixel.
    errors : dict
        Errors measured at training, as in every report.
    provenance : dict
        Trainer, seed, source of the points and their hash; ``homography``: nine numbers, row by
        row, that take the target's plane to corrected pixels (points only).

    Raises
    ------
    InputError
        If a shape is wrong, an integer does not fit its format, a span leaves the image, gamma is
        not positive, there is no such tan-sigmoid, or network, integers and formats do not agree
        whether there is a skip path; if there are no such nodes, or the picture is too narrow for
        them.
    """
    geometry: Geometry
    network: FloatNetwork
    hidden_weights: np.ndarray
    hidden_biases: np.ndarray
    output_weights: np.ndarray
    output_biases: np.ndarray
    valid: ValidRows
    formats: Formats = Formats()
    variant: str = "mmhbc"
    skip_weights: np.ndarray | None = None
    nodes: int = 1
    errors: dict = field(default_factory=dict)
    provenance: dict = field(default_factory=dict)

    def __post_init__(self):
        hn = self.hidden_neurons
        if not 1 <= hn <= MAX_NEURONS:
            raise InputError(f"the network has {hn} hidden neurons, the limits are 1 and "
                             f"{MAX_NEURONS}")
        skips = [part is not None for part in (self.skip_weights, self.network.skip_weights,
                                               self.formats.skip_weight)]
        if any(skips) != all(skips):
            raise InputError("skip_weights are needed in integers, in real numbers and in the "
                             "formats, or in none of the three")
        for name, shape, q in self._layers():
            raw, real = getattr(self, name), getattr(self.network, name)
            if raw.shape != shape or real.shape != shape:
                raise InputError(f"{name} has shape {raw.shape}, {hn} hidden neurons need {shape}")
            if not np.isfinite(real).all():
                raise InputError(f"{name} before quantisation holds a value that is not finite")
            if not q.holds(raw):
                worst = raw.flat[np.abs(raw).argmax()]
                raise InputError(f"{name} holds {worst} ({q.real(worst):g}), "
                                 f"the limits of {q} are {q.lo} and {q.hi}")
        size, q = max(self.geometry.distorted), self.formats.coordinate
        if not q.holds((size + 1) << q.f_bits):
            raise InputError(f"coordinates {q} end at {q.real(q.hi):g}, the distorted image "
                             f"has {size} pixels on a side")
        interpolation = self.geometry.interpolation
        if q.f_bits < interpolation.min_f_bits:
            raise InputError(f"coordinates have {q.f_bits} fraction bits, the interpolation "
                             f"{interpolation.name} needs {interpolation.min_f_bits}")
        if self.formats.input.i_bits != 1:
            raise InputError(f"the format input {self.formats.input} does not suit the scan, one "
                             f"integer bit is needed")
        check_nodes(self.nodes, self.geometry.corrected_width)
        self.valid.check(*self.geometry.corrected)
        check_gamma(self.network.gamma)
        if self.formats.net != Formats.net:
            # Other inputs are within the error bound as well, but not known to be monotonic.
            raise InputError(f"the format net is {self.formats.net}, the tan-sigmoids are proven "
                             f"for {Formats.net}")
        self.tansig       # raises if there is no such design or it is not faithful

    @cached_property
    def tansig(self):
        """The :class:`~ncdc_spec.tansig.Design` of the hidden neurons' tan-sigmoid."""
        return self.formats.tansig_design(self.variant)

    @property
    def network_formats(self):
        """The formats in which the network computes: ``formats``, or those at nodes."""
        return self.formats if self.nodes == 1 else self.formats.at_nodes()

    @property
    def exact_network(self):
        """The :class:`FloatNetwork` whose numbers are exactly the integers."""
        reals = {name: q.real(getattr(self, name)) for name, _, q in self._layers()}
        return FloatNetwork(**reals)

    def _layers(self):
        hn, q = self.hidden_neurons, self.formats
        shapes = {"hidden_weights": (hn, 2), "hidden_biases": (hn,), "output_weights": (2, hn),
                  "output_biases": (2,), "skip_weights": (2, 2)}
        return [(name, shapes[name], getattr(q, key)) for name, key in _LAYERS.items()
                if getattr(q, key) is not None]

    @property
    def hidden_neurons(self):
        """HN."""
        return len(self.hidden_biases)

    @property
    def digest(self):
        """Twelve hex digits of the hash of all that the hardware depends on."""
        nodes = () if self.nodes == 1 else (self.nodes,)
        state = hashlib.sha256(repr((self.geometry, self.formats, self.variant, *nodes)).encode())
        for name, _, _ in self._layers():
            state.update(getattr(self, name).astype("<i8").tobytes())
        state.update(self.valid.spans.astype("<i8").tobytes())
        if self.geometry.interpolation != FAST:
            state.update(self.geometry.interpolation.name.encode())
        return state.hexdigest()[:12]

    @classmethod
    def quantise(cls, network, geometry, valid, formats=Formats(), **about):
        """Descriptor of ``network``, its numbers rounded to nearest in ``formats``.

        ``about``: further parameters of the class.

        Raises
        ------
        InputError
            If a weight or bias leaves the range of its format.
        """
        plain = network.with_gamma(1)
        if network.skip_weights is not None and formats.skip_weight is None:
            formats = formats.with_skip()
        raw = {name: getattr(formats, key).quantise(getattr(plain, name))
               for name, key in _LAYERS.items() if getattr(plain, name) is not None}
        return cls(geometry=geometry, network=network, valid=valid, formats=formats, **raw, **about)

    def save(self, path):
        """Write the descriptor as TOML; the file is replaced whole or not at all."""
        write_text(path, _to_toml(self))

    @classmethod
    def load(cls, path):
        """Read and check a descriptor.

        Raises
        ------
        InputError
            If the file cannot be read, is truncated, is of another version, lacks a value, or
            holds one that does not fit.
        """
        table = parse_text(path, "descriptor", tomllib.loads)
        if table.get("version") != VERSION:
            raise InputError(f"{path} has descriptor version {table.get('version')}, "
                             f"version {VERSION} is needed")
        with reading(path):
            return _of_table(table)


def _of_table(table):
    geometry = dict(table["geometry"])
    geometry["fill"] = tuple(geometry["fill"])
    if "interpolation" in geometry:
        geometry["interpolation"] = interpolation_of(geometry["interpolation"])
    scan = {name: geometry.pop(name) for name in _SCAN}
    geometry = Geometry(**geometry)
    if tuple(scan.values()) != geometry.scan():
        raise InputError(f"the scan {list(scan.values())} is not that of the image size, "
                         f"{list(geometry.scan())}")
    formats = Formats(**{name: Q(*bits) for name, bits in table["formats"].items()})
    tansig = table["tansig"]
    if formats.tansig.f_bits != tansig["fraction_bits"] + 1:
        raise InputError(f"the tan-sigmoid has {tansig['fraction_bits']} fraction bits, its format "
                         f"{formats.tansig} has one more than {formats.tansig.f_bits - 1}")
    layers = [name for name in _LAYERS if name != "skip_weights" or name in table["network"]]
    network = FloatNetwork(**{name: np.array(table["network"]["real"][name], np.float64)
                              for name in layers}, gamma=check_gamma(tansig["gamma"]))
    raw = {name: _integers(table["network"][name], name) for name in layers}
    spans = _integers(table["valid"]["rows"], "valid rows").reshape(-1, 4)
    return Descriptor(geometry=geometry, network=network, **raw, valid=ValidRows(spans),
                      nodes=table["network"].get("nodes", 1), formats=formats,
                      variant=tansig["variant"], errors=table["errors"],
                      provenance=table["provenance"])


_SCAN = ("scan_origin_x", "scan_step_x", "scan_origin_y", "scan_step_y")


def _integers(values, name):
    array = np.array(values)
    if array.dtype.kind != "i":
        raise InputError(f"{name} holds values that are no integers")
    return array.astype(np.int64)


def _to_toml(d):
    lines = ["# NCDC descriptor: a trained camera distortion corrector.",
             f"version = {VERSION}", "", "[geometry]  # pixels"]
    geometry = dict(vars(d.geometry))
    interpolation = geometry.pop("interpolation")
    lines += [f"{name} = {_toml(value)}" for name, value in geometry.items()]
    if interpolation != FAST:
        lines.append(f"interpolation = {_toml(interpolation.name)}")
    lines += [f"{name} = {value}" for name, value in zip(_SCAN, d.geometry.scan())]
    lines += ["", "[formats]  # integer bits with sign, fraction bits"]
    lines += [f"{name} = [{q.i_bits}, {q.f_bits}]" for name, q in d.formats.items()]
    lines += ["", "[tansig]  # gamma is that of network.real; the integers below contain it"]
    lines += [f"variant = {_toml(d.variant)}", f"gamma = {_toml(d.network.gamma)}",
              f"fraction_bits = {d.tansig.fraction_bits}"]
    lines += ["", "[network]  # raw integers in the formats above; one line per neuron"]
    if d.nodes > 1:
        lines += [f"nodes = {d.nodes}  # evaluated at every {d.nodes}th column"]
    layers = [name for name, _, _ in d._layers()]
    lines += [f"{name} = {_toml(getattr(d, name))}" for name in layers]
    lines += ["", "[network.real]  # the same before quantisation; output layer in pixels"]
    lines += [f"{name} = {_toml(getattr(d.network, name))}" for name in layers]
    for title in ("errors", "provenance"):
        lines += ["", f"[{title}]"]
        lines += [f"{name} = {_toml(value)}" for name, value in getattr(d, title).items()]
    lines += ["", "[valid]  # corrected pixels with a source: start, stop, start, stop of each row",
              f"rows = {_toml(d.valid.spans)}", ""]
    return "\n".join(lines)


def _toml(value):
    """TOML text of a number, string, list, table, or array (two-dimensional: a line per row)."""
    if isinstance(value, np.ndarray):
        if value.ndim == 2:
            return "[\n" + "".join(f"    {_toml(row)},\n" for row in value) + "]"
        value = value.tolist()
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{key} = {_toml(item)}" for key, item in value.items()) + " }"
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(_toml(item) for item in value) + "]"
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, (int, float, np.integer, np.floating)):
        return repr(value.item() if isinstance(value, np.generic) else value)
    # JSON's escapes are TOML's as well, but it leaves DEL as it is. Half a pair of surrogates
    # stands for a byte of a file name; it has no UTF-8.
    text = str(value).encode("utf-8", "backslashreplace").decode()
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")

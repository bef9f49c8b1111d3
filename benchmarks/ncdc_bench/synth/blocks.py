"""Designs that ``ncdc bench synth`` synthesises: the corrector's blocks, and the whole."""

from dataclasses import replace
from functools import cache

import numpy as np

from ncdc_bench.synth.board import board_core
from ncdc_bench.synth.camera import CameraBlocks
from ncdc_boards.sdram.chips import IS42S16320D_7, ULX3S_32MB, in_parallel
from ncdc_boards.sdram.controller import SdramController
from ncdc_hdl.backend.cache.cache import Cache
from ncdc_hdl.backend.colour import Colour
from ncdc_hdl.backend.interpolator import Interpolator
from ncdc_hdl.camera.axis_source import AxisSource
from ncdc_hdl.camera.camera_side import CameraSide
from ncdc_hdl.camera.csi2.layouts import FAULTS
from ncdc_hdl.camera.csi2.receiver import Receiver
from ncdc_hdl.camera.fault_counters import FaultCounters
from ncdc_hdl.camera.frame_store import FrameStore
from ncdc_hdl.camera.i2c import I2cController
from ncdc_hdl.corrector import Corrector
from ncdc_hdl.frontend.backmap import BackMap
from ncdc_hdl.frontend.between import NodesToCoordinates
from ncdc_hdl.frontend.node_network import node_axes
from ncdc_hdl.neural.neuron import HiddenNeuron, OutputNeuron
from ncdc_hdl.neural.tansig import Tansig
from ncdc_spec.cache_options import CacheOptions
from ncdc_spec.descriptor import Descriptor, FloatNetwork
from ncdc_spec.formats import Formats
from ncdc_spec.geometry import Geometry, ValidRows
from ncdc_spec.hardware import Hardware
from ncdc_spec.interpolation import DIRECTIONAL, FAST, GRADIENT
from ncdc_spec.tansig import design_for
from ncdc_spec.view_rows import MAX_MATRICES

__all__ = ["BLOCKS", "ONLY", "PLACED", "SPEEDS", "component", "traits"]

_GEOMETRY = Geometry(1280, 1024, 1280, 1024)
_SCREEN = Geometry(640, 480, 640, 480)     # what boards show
_UHD = Geometry(3840, 2160, 3840, 2160)
_CACHE = CacheOptions.of_bytes(32 << 10)
_GRADIENT_CACHE = CacheOptions.of_bytes(32 << 10, GRADIENT)
_DIRECTIONAL_CACHE = CacheOptions.of_bytes(32 << 10, DIRECTIONAL)
_DATA_WIDTH = 32
_BEND = 40              # columns without a source in the first and last row, at either side
_NODES = 16             # pixels from node to node, as on most of the reference lenses


def component(block, variant, multiplier_bits):
    """The Amaranth component of a block of :data:`BLOCKS`, for multipliers of so many bits."""
    return BLOCKS[block][variant](multiplier_bits)


def traits(part):
    """``hidden_neurons``, ``nodes`` and ``lanes`` of a block, None where it has no such thing."""
    d = getattr(part, "descriptor", None)
    hardware = getattr(part, "hardware", part)
    return {"hidden_neurons": getattr(d or part, "hidden_neurons", None),
            "nodes": getattr(d or part, "nodes", None), "lanes": getattr(hardware, "lanes", None)}


@cache
def _descriptor(hidden_neurons, variant, nodes=1, interpolation=FAST, geometry=_GEOMETRY):
    """A descriptor of arbitrary weights: they are reset values of registers, the size is theirs
    whatever they are. All pixels have a source but those between bent edges left and right: a
    table of rows that are all the same would be none in a core with a fixed lens."""
    rng = np.random.default_rng(hidden_neurons)
    network = FloatNetwork(rng.uniform(-2, 2, (hidden_neurons, 2)),
                           rng.uniform(-1, 1, hidden_neurons),
                           rng.uniform(-500, 500, (2, hidden_neurons)), np.array([640.0, 512.0]))
    geometry = replace(geometry, interpolation=interpolation)
    width, height = geometry.corrected
    bend = (_BEND * np.linspace(-1, 1, height) ** 2).astype(int)[:, None]
    column = np.arange(width)
    valid = ValidRows.of_mask((column >= bend) & (column < width - bend))
    return Descriptor.quantise(network, geometry, valid, variant=variant, nodes=nodes)


def _tansig(variant):
    return lambda bits: Tansig(design_for(variant, Formats().tansig.f_bits - 1))


def _front_end(hidden_neurons, variant="mmhbc", **options):
    return lambda bits: BackMap(hidden_neurons, Formats(), variant=variant,
                                hardware=Hardware(multiplier_bits=bits, **options))


def _between(lanes=1):
    return lambda bits: NodesToCoordinates(node_axes(Formats().at_nodes()),
                                           dict.fromkeys("xy", Formats().coordinate), _NODES,
                                           lanes)


def _core(hidden_neurons, variant="mmhbc", nodes=1, cache_bytes=_CACHE.bytes, interpolation=FAST,
          **options):
    """1280 x 1024 pixels, cache of 32 KB, memory of 32 bits, video stream out."""
    options = {"data_width": _DATA_WIDTH, "output": "stream",
               "cache": CacheOptions.of_bytes(cache_bytes, interpolation)} | options
    return lambda bits: Corrector(_descriptor(hidden_neurons, variant, nodes, interpolation),
                                  Hardware(multiplier_bits=bits, **options))


def _smallest(variant, **options):
    """The smallest useful core: HN 8 at nodes, strips to memory from a cache of 8 KB."""
    return _core(8, variant, _NODES, 8 << 10, output="memory", strip=128, **options)


def _four_lanes(variant, interpolation=FAST, cache_bytes=_CACHE.bytes):
    """Four pixels per clock, for which the memory's port must be wide."""
    return _core(16, variant, _NODES, cache_bytes, interpolation, lanes=4, data_width=128)


def _uhd(bits):
    """The core of ``ncdc bench system --uhd``: 3840 x 2160 pixels, 60 times a second at 125 MHz."""
    cache = replace(CacheOptions.of_bytes(128 << 10, GRADIENT), pending=256, outstanding=64)
    return Corrector(_descriptor(16, "table", 32, GRADIENT, _UHD),
                     Hardware(multiplier_bits=bits, data_width=128, output="stream", lanes=4,
                              cache=cache))


def _board(name):
    return lambda bits: board_core(name, _descriptor(8, "table", _NODES, GRADIENT, _SCREEN))


def _sdram(chip, data_width):
    """At 133 MHz, with two readers and the video's, and bursts of 16."""
    return lambda bits: SdramController(chip, 133e6, data_width, 3, 16)


# Of each block its variants, the first one first in the tables. Multipliers shared by four
# neurons and the tabulated tan-sigmoid make the smallest core.
BLOCKS = {
    "tansig": {"mmhbc": _tansig("mmhbc"), "table": _tansig("table"),
               "classic": _tansig("classic")},
    "neuron": {"hidden": lambda bits: HiddenNeuron(Formats(), bits),
               "output HN 8": lambda bits: OutputNeuron(8, Formats(), multiplier_bits=bits)},
    "front-end": {"HN 4": _front_end(4), "HN 4 raster": _front_end(4, hidden="raster"),
                  "HN 4 table": _front_end(4, "table"), "HN 8": _front_end(8),
                  "HN 4, 2 lanes": _front_end(4, lanes=2)},
    "nodes to coordinates": {"1 lane": _between(), "4 lanes": _between(4)},
    "fetcher": {"cache 32 KB":
                lambda bits: Cache(Formats().coordinate.f_bits, _DATA_WIDTH, _CACHE),
                "cache 32 KB gradient":
                lambda bits: Cache(Formats().coordinate.f_bits, _DATA_WIDTH, _GRADIENT_CACHE),
                "cache 32 KB directional":
                lambda bits: Cache(Formats().coordinate.f_bits, _DATA_WIDTH, _DIRECTIONAL_CACHE)},
    "interpolator": {"bayer bilinear":
                     lambda bits: Interpolator(Formats().coordinate.f_bits),
                     "gradient bilinear":
                     lambda bits: Interpolator(Formats().coordinate.f_bits,
                                               interpolation=GRADIENT),
                     "directional bilinear":
                     lambda bits: Interpolator(Formats().coordinate.f_bits,
                                               interpolation=DIRECTIONAL)},
    "camera": {"capture, store, I2C": lambda bits: CameraBlocks(_DATA_WIDTH, 16, 3, 512),
               "with a queue of 32": lambda bits: CameraBlocks(_DATA_WIDTH, 16, 3, 32),
               "frame store": lambda bits: FrameStore(3), "I2C": lambda bits: I2cController(),
               "sensor port": lambda bits: CameraSide(),
               "AXI4-Stream, 1 sample": lambda bits: CameraSide(AxisSource(1, 12)),
               "AXI4-Stream, 2 samples": lambda bits: CameraSide(AxisSource(2, 12)),
               "AXI4-Stream, 4 samples": lambda bits: CameraSide(AxisSource(4, 12)),
               "sensor port, grid of 648": lambda bits: CameraSide(grid=648),
               "sensor port, grid of 1296": lambda bits: CameraSide(grid=1296)},
    "CSI-2": {"receiver, 1 lane": lambda bits: Receiver(1),
              "receiver, 2 lanes": lambda bits: Receiver(2),
              "receiver, 4 lanes": lambda bits: Receiver(4),
              "fault counters": lambda bits: FaultCounters(FAULTS, "sync")},
    "colour": {"gains and tone": lambda bits: Colour()},
    "SDRAM controller": {"16 bits": _sdram(ULX3S_32MB, 32),
                         "32 bits": _sdram(in_parallel(IS42S16320D_7, 2), 32),
                         "16 bits, words of 64": _sdram(IS42S16320D_7, 64)},
    "core": {"HN 4": _core(4), "HN 4 table": _core(4, "table"),
             "HN 4 smallest": _core(4, "table", share=4), "HN 8": _core(8),
             "HN 8, nodes, 8 KB": _smallest("mmhbc"),
             "HN 8, nodes, 8 KB, table": _smallest("table"),
             "HN 8, nodes, 8 KB, table, fixed lens": _smallest("table", fixed_lens=True),
             "HN 8, nodes, 8 KB, table, no counters": _smallest("table", counters=False),
             "HN 8, nodes, 8 KB, table, no follow": _smallest("table", follow=False),
             "HN 8, smallest": _smallest("table", fixed_lens=True, counters=False, follow=False),
             "HN 16, nodes": _core(16, nodes=_NODES),
             "HN 16, nodes, table": _core(16, "table", _NODES),
             "HN 16, nodes, table, view": _core(16, "table", _NODES, view=True),
             "HN 16, nodes, table, view, rows": _core(16, "table", _NODES, view=True,
                                                      view_rows=MAX_MATRICES),
             "HN 16, nodes, gradient": _core(16, nodes=_NODES, interpolation=GRADIENT),
             "HN 16, nodes, table, gradient": _core(16, "table", _NODES, interpolation=GRADIENT),
             "HN 16, nodes, table, directional": _core(16, "table", _NODES,
                                                       interpolation=DIRECTIONAL),
             "HN 16, 3840x2160 at 60": _uhd,
             "HN 16, nodes, 4 lanes": _four_lanes("mmhbc"),
             "HN 16, nodes, 4 lanes, table": _four_lanes("table"),
             "HN 16, nodes, 4 lanes, table, gradient": _four_lanes("table", GRADIENT, 64 << 10)},
    "board": {"DE0-CV, HN 8": _board("de0-cv"), "DE2-115, HN 8": _board("de2-115")},
}
ONLY = {"DE0-CV, HN 8": "cyclonev", "DE2-115, HN 8": "cycloneiv"}
"""The one target of variants that are made for it."""

PLACED = {"HN 16, 3840x2160 at 60": ("--placer", "static", "--router", "router2", "--tmg-ripup",
                                     "--freq", "140")}
"""Options of nextpnr for variants that need others. That placer uses the whole device. That router
also takes up routes that are too slow, not only those that collide."""

SPEEDS = {"CSI-2": 6}
"""Speed grade of the ECP5 for blocks whose goal is that of the slowest one."""

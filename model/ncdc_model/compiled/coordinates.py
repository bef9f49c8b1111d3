"""Coordinates of a whole frame by the compiled network."""

import ctypes

import numpy as np

from ncdc_model.compiled.library import library, pointer, structure
from ncdc_model.golden.network import normalised_scan
from ncdc_spec.nodes import AFTER, BEFORE

__all__ = ["between_nodes", "frame_coordinates", "node_columns", "tables_at"]

_ROWS = 64              # at a time: bounds the memory
_VARIANTS = ("mmhbc", "classic", "table")       # as numbered in coordinates.c


class _Tansig(ctypes.Structure):
    """``struct tansig`` of coordinates.c."""
    _fields_ = [(name, ctypes.c_int32) for name in
                ("variant", "input_bits", "largest", "width", "digits", "steps")]
    _fields_ += [("shifts", ctypes.c_void_p), ("angles", ctypes.c_void_p),
                 ("start", ctypes.c_int32), ("fine_bits", ctypes.c_int32)]
    _fields_ += [(name, ctypes.c_void_p) for name in ("table", "ranges", "segments")]
    _fields_ += [(name, ctypes.c_int32) for name in
                 ("position_bits", "slope_bits", "offset_bits", "fraction_bits")]


class _Layers(ctypes.Structure):
    """``struct layers`` of coordinates.c."""
    _fields_ = [(name, ctypes.c_int32) for name in
                ("neurons", "net_shift", "net_low", "net_high", "shift", "low", "high")]
    _fields_ += [("hidden", ctypes.c_void_p), ("output", ctypes.c_void_p)]


def frame_coordinates(descriptor):
    """Raw (x', y') of the whole corrected frame, int32 of shape (2, height, width).

    The same integers as of :func:`ncdc_model.golden.network.frame_coordinates`.

    Raises
    ------
    InputError
        If there is no compiled library, see :func:`ncdc_model.compiled.library.library`.
    """
    d, formats = descriptor, descriptor.network_formats
    width, height = d.geometry.corrected
    columns, layers, tansig = node_columns(width, d.nodes), _layers(d), _tansig(d.tansig)
    tables = np.empty((2, height, len(columns)), np.int32)
    for top in range(0, height, _ROWS):
        u, v = np.meshgrid(columns, np.arange(top, min(top + _ROWS, height)))
        x, y = normalised_scan(u, v, d.geometry, formats)
        tables[:, top:top + _ROWS] = _tables(layers, tansig, x, y)
    if d.nodes == 1:
        return tables
    return np.stack([between_nodes(table, d.nodes, width, formats.coordinate, d.formats.coordinate)
                     for table in tables])


def node_columns(width, nodes):
    """Columns of the nodes of a row of ``width`` pixels."""
    if nodes == 1:
        return np.arange(width)
    return np.arange(-BEFORE, (width - 1) // nodes + AFTER + 1) * nodes


def tables_at(descriptor, x, y):
    """Raw coordinates (x', y'), int32 of shape (2, ...), of raw normalised ``x`` and ``y``.

    The same integers as of :func:`ncdc_model.golden.network.network`.
    """
    return _tables(_layers(descriptor), _tansig(descriptor.tansig), x, y)


def _tables(layers, tansig, x, y):
    x, y = (np.ascontiguousarray(part, np.int64) for part in (x, y))
    tables = np.empty((2, *x.shape), np.int32)
    library().network(layers, tansig, pointer(x), pointer(y), ctypes.c_long(x.size),
                      pointer(tables[0]), pointer(tables[1]))
    return tables


def between_nodes(table, nodes, width, fine, coarse):
    """Values in ``coarse``, int32 (rows, ``width``), between those of each row's ``nodes``.

    ``table``: int32 in ``fine``, at :func:`node_columns`.
    """
    shift = 2 + 2 * (nodes.bit_length() - 1) + fine.f_bits - coarse.f_bits
    out = np.empty((len(table), width), np.int32)
    library().between_nodes(pointer(np.ascontiguousarray(table)), table.shape[1], nodes,
                            len(table), width, shift, coarse.lo, coarse.hi, pointer(out))
    return out


def _layers(descriptor):
    """Address of the :class:`_Layers` of a descriptor."""
    d, q = descriptor, descriptor.network_formats
    products = q.input.f_bits + q.hidden_weight.f_bits
    hidden = np.column_stack([d.hidden_weights,
                              d.hidden_biases << products - q.hidden_bias.f_bits])
    finest = weighted = q.tansig.f_bits + q.output_weight.f_bits
    skip = np.zeros((2, 2), np.int64)
    if d.skip_weights is not None:
        skipped = q.input.f_bits + q.skip_weight.f_bits
        finest = max(weighted, skipped)
        skip = d.skip_weights << finest - skipped
    output = np.column_stack([d.output_biases << finest - q.output_bias.f_bits, skip,
                              d.output_weights << finest - weighted])
    return structure(_Layers, neurons=d.hidden_neurons, net_shift=products - q.net.f_bits,
                      net_low=q.net.lo, net_high=q.net.hi, shift=finest - q.coordinate.f_bits,
                      low=q.coordinate.lo, high=q.coordinate.hi,
                      hidden=hidden.astype(np.int64), output=output.astype(np.int64))


def _tansig(design):
    """Address of the :class:`_Tansig` of a design."""
    values = {"variant": _VARIANTS.index(design.variant), "input_bits": design.input.f_bits,
              "largest": design.input.hi}
    if design.variant == "table":
        values |= {"steps": len(design.ranges), "ranges": np.array(design.ranges, np.int32),
                   "segments": np.array(design.coefficients, np.int64)}
        values |= {name: getattr(design, name) for name in
                   ("position_bits", "slope_bits", "offset_bits", "fraction_bits")}
        return structure(_Tansig, **values)
    values |= {"width": design.width, "digits": design.digits, "steps": len(design.shifts),
               "shifts": np.array(design.shifts, np.int32),
               "table": np.array(design.table, np.int32)}
    if design.variant == "mmhbc":
        return structure(_Tansig, fine_bits=design.fine_bits, **values)
    return structure(_Tansig, start=design.start, angles=np.array(design.angles, np.int32),
                      **values)

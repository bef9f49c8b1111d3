"""The search of :mod:`ncdc_model.training.varpro` by the compiled library, with the same bits."""

import ctypes

import numpy as np

from ncdc_model.compiled.library import library, pointer, structure
from ncdc_model.correction import COMPILED, default_model
from ncdc_model.exact import TANH_STEPS, tanh_table
from ncdc_model.training.varpro import Batch

__all__ = ["CompiledBatch", "batch_kind"]

_LANES = 8             # numbers: a row is padded to a multiple of the longest vector


class _Points(ctypes.Structure):
    """``struct points`` of search.c."""
    _fields_ = [(name, ctypes.c_int32) for name in
                ("neurons", "linear", "slices", "count", "stride", "half")]
    _fields_ += [(name, ctypes.c_double) for name in ("ridge", "reach", "per_entry")]
    _fields_ += [(name, ctypes.c_void_p) for name in
                 ("fan", "constant", "targets", "target_slices", "limit", "table")]


class CompiledBatch(Batch):
    """:class:`Batch` whose steps are computed in C, one network after the other.

    Raises
    ------
    InputError
        If there is no compiled library, see :func:`ncdc_model.compiled.library.library`.
    """
    _STATE = ("theta", "output", "cost", "damping", "growth")

    def _start(self):
        table = tanh_table()
        self._points = structure(
            _Points, neurons=self.neurons, linear=self.linear[0].shape[0], slices=self.count,
            count=self.inputs.shape[1], stride=-(-self.inputs.shape[1] // _LANES) * _LANES,
            half=len(table) // 2, ridge=self.ridge, reach=self.reach.item(), per_entry=TANH_STEPS,
            fan=_padded(self.fan), constant=_padded(self.linear), targets=_padded(self.targets),
            target_slices=_padded(self.target_slices), limit=self.limit, table=table)
        self.cost = self.run(0)[0]

    def run(self, count):
        starts, terms = len(self.theta), self.neurons + self.linear[0].shape[0]
        costs = np.empty((count + 1, starts))
        self.output = np.empty((starts, terms, 2))
        for name in ("theta", "damping", "growth"):
            setattr(self, name, np.ascontiguousarray(getattr(self, name)))
        if not library().search_steps(self._points, starts, count, *map(pointer, (
                self.theta, self.output, self.damping, self.growth, costs))):
            raise MemoryError
        self.cost = costs[-1]
        return costs


def batch_kind():
    """The :class:`Batch` to search with, compiled wherever that is possible.

    Both give the same networks, bit by bit.
    """
    return CompiledBatch if default_model() == COMPILED else Batch


def _padded(rows):
    """``rows`` (..., n), an array or a list of them, with zeros up to a multiple of the lanes."""
    rows = np.asarray(rows)
    wide = np.zeros((*rows.shape[:-1], rows.shape[-1] + -rows.shape[-1] % _LANES))
    wide[..., :rows.shape[-1]] = rows
    return wide

"""The points of a plane nearest to others, found through a grid of cells.

SciPy's tree does the same, and takes 0.3 s of processor time to import.
"""

from functools import cached_property

import numpy as np

__all__ = ["Nearest"]

_IN_CELL = 2           # points, in the mean
_BLOCK = 4096          # positions at a time: bounds the memory
_FEW = 1 << 15         # pairs of a position and a point: all distances take less time


class Nearest:
    """Points (n, 2), at least one, that can be searched for those nearest to a position."""

    def __init__(self, points):
        self._points = np.asarray(points, np.float64)
        count, self._low = len(self._points), self._points.min(axis=0)
        span = np.ptp(self._points, axis=0)
        # The second term bounds the number of cells of points on a line.
        self._size = max(np.sqrt(span.prod() * _IN_CELL / count), span.max() * _IN_CELL / count,
                         1e-12)
        self._shape = (span / self._size).astype(np.intp) + 1
        column, row = self._cells(self._points).T
        key = column * self._shape[1] + row
        self._order = np.argsort(key, kind="stable")
        self._first = np.searchsorted(key[self._order], np.arange(self._shape.prod() + 1))

    def query(self, positions, count=1):
        """Distances to the nearest points, ascending, and their numbers.

        Parameters
        ----------
        positions : ndarray, shape (m, 2)
        count : int
            Points for each position, at most n.

        Returns
        -------
        distance, number : ndarray, shape (m, count)
        """
        positions = np.asarray(positions, np.float64).reshape(-1, 2)
        if len(positions) * len(self._points) < _FEW:
            return _smallest(((self._points - positions[:, None])**2).sum(axis=2), count)
        distance, number = np.empty((len(positions), count)), np.empty((len(positions), count), int)
        for start in range(0, len(positions), _BLOCK):
            left = np.arange(start, min(start + _BLOCK, len(positions)))
            reach = 1 + int(np.sqrt(count / _IN_CELL) / 2)
            while len(left):
                distance[left], number[left], sure = self._within(positions[left], count, reach)
                left, reach = left[~sure], 2 * reach
        return distance, number

    def nearest(self, position):
        """Distance and number of the point nearest to one ``position`` (2,)."""
        (x, y), (left, top), size, (columns, rows) = map(float, position), *self._plain
        column = min(max(int((x - left) / size), 0), columns - 1)
        row, reach = min(max(int((y - top) / size), 0), rows - 1), 1
        while True:
            near = [((x - px)**2 + (y - py)**2, number)
                    for i in range(column - reach, column + reach + 1)
                    for j in range(row - reach, row + reach + 1)
                    for px, py, number in self._lists.get((i, j), ())]
            if near and min(near)[0] <= (reach * size)**2 or reach >= max(columns, rows):
                square, number = min(near)
                return square**.5, number
            reach *= 2

    @cached_property
    def _plain(self):
        """Lowest position, side of a cell, and number of cells as plain numbers."""
        return self._low.tolist(), float(self._size), self._shape.tolist()

    @cached_property
    def _lists(self):
        """x, y and number of the points in each cell that has any."""
        lists = {}
        cells = map(tuple, self._cells(self._points).tolist())
        for number, (cell, (x, y)) in enumerate(zip(cells, self._points.tolist())):
            lists.setdefault(cell, []).append((x, y, number))
        return lists

    def _within(self, positions, count, reach):
        """:meth:`query` among the cells at most ``reach`` away, and which positions are sure."""
        column, row = self._cells(positions).T
        columns = column[:, None] + np.arange(-reach, reach + 1)
        there = (columns >= 0) & (columns < self._shape[0])
        base = np.where(there, columns, 0) * self._shape[1]
        # The points of neighbouring cells of a column follow each other.
        start = self._first[base + np.maximum(row - reach, 0)[:, None]]
        end = self._first[base + np.minimum(row + reach, self._shape[1] - 1)[:, None] + 1]
        length = np.where(there, end - start, 0).ravel()
        flat = np.arange(length.sum()) - np.repeat(np.cumsum(length) - length - start.ravel(),
                                                   length)
        many = length.reshape(there.shape).sum(axis=1)
        owner = np.repeat(np.arange(len(positions)), many)
        slot = np.arange(len(owner)) - np.repeat(np.cumsum(many) - many, many)
        square = np.full((len(positions), max(count, many.max())), np.inf)
        number = np.zeros(square.shape, np.intp)
        number[owner, slot] = self._order[flat]
        square[owner, slot] = ((self._points[self._order[flat]] - positions[owner])**2).sum(axis=1)
        distance, best = _smallest(square, count)
        sure = (distance[:, -1] <= reach * self._size) | (reach >= self._shape.max())
        return distance, np.take_along_axis(number, best, 1), sure

    def _cells(self, positions):
        """Columns and rows (m, 2) of the cells nearest to ``positions`` (m, 2)."""
        return np.clip((positions - self._low) / self._size, 0, self._shape - 1).astype(np.intp)


def _smallest(square, count):
    """Roots of the smallest numbers, ascending, of each row, and their columns."""
    best = np.argpartition(square, count - 1, axis=1)[:, :count]
    best = np.take_along_axis(best, np.take_along_axis(square, best, 1).argsort(axis=1), 1)
    return np.sqrt(np.take_along_axis(square, best, 1)), best

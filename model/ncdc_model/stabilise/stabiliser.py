"""Matrices that hold a shaking camera's picture still, one for each row of its raw frame."""

from dataclasses import dataclass

import numpy as np

from ncdc_model.stabilise.orientation import Gyroscope
from ncdc_model.stabilise.quaternions import matrices
from ncdc_spec.errors import InputError
from ncdc_spec.view import View
from ncdc_spec.view_matrix import PlaneCamera, view_matrix
from ncdc_spec.view_rows import MAX_MATRICES, row_view

__all__ = ["MAX_READOUT", "MAX_SMOOTHING", "Stabiliser"]

MAX_READOUT = 0.2       # s; a slower sensor sends five frames per second
MAX_SMOOTHING = 1000.0  # s: the view stands still, whatever the film


@dataclass(frozen=True)
class Stabiliser:
    """A view that follows the mean orientation of its camera.

    Parameters
    ----------
    gyroscope : Gyroscope
    trained, view : PlaneCamera
        Of the descriptor's picture, and of the view.
    rotation : ndarray, shape (3, 3)
        Of the view in the mean camera, see :class:`ncdc_spec.view_matrix.Angles`.
    rows : int
        Of the raw frame.
    readout : float
        Seconds from the reading of the first row of a frame to that of the row after the last.
    offset : float
        Time of the gyroscope when the film begins.
    smoothing : float
        Standard deviation in seconds of the Gaussian that the orientation is averaged by; 0: the
        view follows every movement, and only the rolling shutter is corrected.

    Raises
    ------
    InputError
        If readout or smoothing is outside its limits.
    """
    gyroscope: Gyroscope
    trained: PlaneCamera
    view: PlaneCamera
    rotation: np.ndarray
    rows: int
    readout: float = 0.0
    offset: float = 0.0
    smoothing: float = 0.5

    def __post_init__(self):
        for name, value, high in (("readout", self.readout, MAX_READOUT),
                                  ("smoothing", self.smoothing, MAX_SMOOTHING)):
            if not 0 <= value <= high:
                raise InputError(f"the {name} is {value:g} s, the limits are 0 and {high:g}")

    def matrices(self, seconds):
        """Matrices (rows, 3, 3) from the view's pixels to the trained picture's, at each raw row.

        ``seconds``: when the first row of the frame was read, from the beginning of the film.

        Raises
        ------
        InputError
            If the gyroscope has no samples of that time.
        """
        begin = seconds + self.offset
        rows = matrices(self.gyroscope.at(begin + self.readout * np.arange(self.rows) / self.rows))
        steady = matrices(self.gyroscope.smooth(begin + self.readout / 2, self.smoothing))
        return view_matrix(self.trained, self.view, rows.mT @ steady @ self.rotation)

    def row_view(self, seconds, limit=MAX_MATRICES):
        """The :class:`~ncdc_spec.view.View` of the frame, with a table of ``limit`` matrices at
        most, or without one if all rows were read at once.

        ``seconds``: as for :meth:`matrices`.

        Raises
        ------
        InputError
            If the gyroscope has no samples of that time, or :func:`~ncdc_spec.view_rows.row_view`
            raises it.
        """
        matrices = self.matrices(seconds)
        if not self.readout:
            return View.of(matrices[0], self.view.size)
        return row_view(matrices, self.view.size, limit)

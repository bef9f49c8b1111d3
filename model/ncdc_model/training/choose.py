"""The smallest network that meets a maximum error."""

import math

import numpy as np

from ncdc_model.errors import InputError
from ncdc_model.evaluate import float_map
from ncdc_model.training.choices import TrainingChoices
from ncdc_model.training.pipeline import describe
from ncdc_model.training.problem import Problem, split
from ncdc_model.training.train import train
from ncdc_model.valid import valid_mask

__all__ = ["MOST_NEURONS", "choose_camera"]

MOST_NEURONS = 16


def choose_camera(source, max_error, choices=TrainingChoices(), progress=None, tried=None):
    """Train networks of 1, 2, ... 16 hidden neurons up to the first that meets ``max_error``.

    The error is the largest distance in distorted pixels of float and of integer network: at
    every valid pixel where the source has the exact map, else at the held-out points inside the
    frame. Each network is that of :func:`ncdc_model.training.pipeline.train_camera`.

    Parameters
    ----------
    source : Source
    max_error : float
        Pixels.
    choices : TrainingChoices
    progress : callable, optional
        Called with (fraction of the present training done, MSE in px^2).
    tried : callable, optional
        Called with (hidden neurons, largest error in px) of every network.

    Returns
    -------
    TrainedCamera
        Its report also has ``max_error_px`` and ``tried``: ``hidden_neurons`` and ``max`` of
        every network.

    Raises
    ------
    InputError
        If no network meets it, no point is held out, or the request is bad.
    """
    if not (math.isfinite(max_error) and max_error > 0):
        raise InputError(f"the maximum error is {max_error:g} px, it must be positive")
    judge = _judge(source, choices.held_out)
    rows = []
    for neurons in range(1, MOST_NEURONS + 1):
        training = train(source.pairs, source.geometry, neurons, choices, progress,
                         source.anchors)
        worst, trained = _worst(float_map(training.network, source.geometry), judge), None
        if worst <= max_error:
            trained = describe(source, training, choices)
            worst = max(worst, trained.report["map_error_fixed_px"]["max"])
        rows.append({"hidden_neurons": neurons, "max": worst})
        if tried:
            tried(neurons, worst)
        if trained and worst <= max_error:
            trained.report.update({"max_error_px": max_error, "tried": rows})
            return trained
    best = min(rows, key=lambda row: row["max"])
    raise InputError(f"no network of 1 to {MOST_NEURONS} hidden neurons has a maximum error of "
                     f"{max_error:g} px or less; the best, of {best['hidden_neurons']}, has "
                     f"{best['max']:.3g} px")


def _judge(source, held_out):
    """The pairs that judge, as a :class:`Problem`."""
    width, height = source.geometry.corrected
    if source.back_map:
        v, u = np.nonzero(valid_mask(source.back_map, source.geometry))
        x, y = source.back_map(u.astype(np.float64), v.astype(np.float64))
        return Problem(u, v, x, y, source.geometry)
    u, v, x, y = source.pairs
    on = split(len(u), held_out) & (u >= 0) & (u <= width - 1) & (v >= 0) & (v <= height - 1)
    if not on.any():
        raise InputError("no point is held out, by which the number of hidden neurons could be "
                         "chosen")
    return Problem(u[on], v[on], x[on], y[on], source.geometry)


def _worst(back_map, pairs):
    x, y = back_map(pairs.u, pairs.v)
    return float(np.hypot(x - pairs.x, y - pairs.y).max())

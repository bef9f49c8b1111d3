"""The smallest network that meets a maximum error."""

import math
from dataclasses import replace
from functools import partial

import numpy as np

from ncdc_model.evaluate import float_map
from ncdc_model.golden.valid import valid_mask
from ncdc_model.training.choices import TrainingChoices
from ncdc_model.training.pipeline import describe
from ncdc_model.training.problem import MIN_POINTS_PER_NEURON, Problem, split
from ncdc_model.training.train import train
from ncdc_spec.errors import InputError

__all__ = ["GOAL", "MOST_NEURONS", "choose_camera"]

MOST_NEURONS = 16
GOAL = .1              # pixels: the largest error that is wanted if none is asked for
NEARLY = 1.1           # of the best largest error: a smaller network is preferred up to that


def choose_camera(source, max_error=None, choices=TrainingChoices(), progress=None, tried=None):
    """Train networks of 1, 2, ... 16 hidden neurons up to the first that meets ``max_error``.

    The error is the largest distance in distorted pixels of float and of integer network: at
    every valid pixel where the source has the exact map, else at the held-out points inside the
    frame and, as estimated, in the whole valid region. Each network is that of
    :func:`ncdc_model.training.pipeline.train_camera`: none depends on those before it. Points too
    few for 16 neurons end the row earlier.

    Parameters
    ----------
    source : Source
    max_error : float, optional
        Pixels that must be met. Without it :data:`GOAL` is tried for, and if no network meets it,
        the smallest is taken whose largest error is at most :data:`NEARLY` times the least.
    choices : TrainingChoices
    progress : callable, optional
        Called with (hidden neurons, fraction of their training done, MSE in px^2).
    tried : callable, optional
        Called with (hidden neurons, largest error in px) of every network.

    Returns
    -------
    TrainedCamera
        Its report also has ``max_error_px``, ``max_error_met`` and ``tried``: ``hidden_neurons``,
        ``max`` and ``mean`` error of every network. Of a network whose float error is above the
        limit these are the float errors.

    Raises
    ------
    InputError
        If no network meets ``max_error``, no point is held out, or the request is bad.
    """
    limit = GOAL if max_error is None else max_error
    if not (math.isfinite(limit) and limit > 0):
        raise InputError(f"the maximum error is {limit:g} px, it must be positive")
    judge = _judge(source, choices.held_out)
    rows, trainings = [], []
    for neurons in range(1, _most(source, choices) + 1):
        training = train(source.pairs, source.geometry, neurons, choices,
                         partial(progress, neurons) if progress else None, source.anchors)
        errors = _errors(float_map(training.network, source.geometry), judge, source.region)
        trained = describe(source, training, choices) if errors["max"] <= limit else None
        if trained:
            errors["max"] = max(errors["max"], trained.report["map_error_fixed_px"]["max"])
        trainings.append(training)
        rows.append({"hidden_neurons": neurons, **errors})
        if tried:
            tried(neurons, errors["max"])
        if trained and errors["max"] <= limit:
            break
    else:
        best = min(rows, key=lambda row: row["max"])
        if max_error is not None:
            raise InputError(f"no network of 1 to {len(rows)} hidden neurons has a maximum error "
                             f"of {limit:g} px or less; the best, of {best['hidden_neurons']}, has "
                             f"{best['max']:.3g} px")
        chosen = next(k for k, row in enumerate(rows) if row["max"] <= NEARLY * best["max"])
        trained = describe(source, trainings[chosen], choices)
    facts = {"max_error_px": limit, "max_error_met": rows[-1]["max"] <= limit, "tried": rows}
    descriptor = replace(trained.descriptor, errors=trained.descriptor.errors | facts)
    return replace(trained, descriptor=descriptor, report=trained.report | facts)


def _most(source, choices):
    """The most hidden neurons that are tried: no more than the points can determine."""
    taught = len(source.pairs[0]) - int(split(len(source.pairs[0]), choices.held_out).sum())
    return max(1, min(MOST_NEURONS, taught // MIN_POINTS_PER_NEURON))


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


def _errors(back_map, pairs, region):
    """``max`` and ``mean`` distance in pixels of a map from ``pairs``, and from a region."""
    x, y = back_map(pairs.u, pairs.v)
    distance = np.hypot(x - pairs.x, y - pairs.y)
    worst = region.errors(back_map)[0]["max"] if region else 0.0
    return {"max": max(float(distance.max()), worst), "mean": float(distance.mean())}

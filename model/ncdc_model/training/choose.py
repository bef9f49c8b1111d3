"""The smallest network that meets a maximum error."""

import math
from dataclasses import replace
from functools import partial

import numpy as np

from ncdc_model.evaluate import fixed_map, float_map
from ncdc_model.golden.valid import valid_mask
from ncdc_model.training.choices import TrainingChoices
from ncdc_model.training.pipeline import describe
from ncdc_model.training.problem import MIN_POINTS_PER_NEURON, Problem, split
from ncdc_model.training.train import train
from ncdc_spec.errors import InputError

__all__ = ["GOAL", "MAX_TRIED", "choose_camera"]

MAX_TRIED = 16
GOAL = .1              # pixels: the wanted limit of the largest error, by default
NEARLY = 1.1           # times the best largest error: a smaller network is preferred up to that


def choose_camera(source, max_error=None, choices=TrainingChoices(), progress=None, tried=None,
                  goal=GOAL):
    """Train networks of 1, 2, ... 16 hidden neurons until one meets ``max_error``.

    The error is the largest distance in distorted pixels of float and of integer network: at
    every valid pixel if the source has the exact map, else at the held-out points inside the
    frame and, as an estimate, in the whole valid region; beyond the points it is that from the
    smooth lens, since what is not known of the lens no network can learn. Each network is that of
    :func:`ncdc_model.training.pipeline.train_camera` and does not depend on the others. With too
    few points for 16 neurons the series ends earlier.

    Parameters
    ----------
    source : Source
    max_error : float, optional
        Limit in pixels that must be met. Without it ``goal`` is wanted. If no network meets
        that, the smallest is taken whose largest error is at most :data:`NEARLY` times the best.
    choices : TrainingChoices
    progress : callable, optional
        Called with (hidden neurons, fraction of their training done, MSE in px^2).
    tried : callable, optional
        Called with (hidden neurons, largest error in px) of every network.
    goal : float
        Pixels; without effect if ``max_error`` is given.

    Returns
    -------
    TrainedCamera
        Its report also has ``max_error_px``, ``max_error_met`` and ``tried``: ``hidden_neurons``,
        ``max`` and ``mean`` error of every network. If its float error is above the
        limit, these are float errors.

    Raises
    ------
    InputError
        If no network meets ``max_error``, no point is held out, or the request is bad.
    """
    limit = goal if max_error is None else max_error
    if not (math.isfinite(limit) and limit > 0):
        raise InputError(f"the maximum error is {limit:g} px, it must be positive")
    reference = _reference_pairs(source, choices.held_out)
    rows, trainings = [], []
    for neurons in range(1, _largest_tried(source, choices) + 1):
        training = train(source.pairs, source.geometry, neurons, choices,
                         partial(progress, neurons) if progress else None, source.anchors)
        errors = _errors(float_map(training.network, source.geometry), reference, source.region)
        trained = describe(source, training, choices) if errors["max"] <= limit else None
        if trained:
            errors["max"] = max(errors["max"], _fixed_error(trained, source, reference))
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
    return replace(trained, descriptor=descriptor,
                   report=trained.report | facts | _unmet(trained.report, facts, source))


def _unmet(report, facts, source):
    """A warning for the report if the limit is met only where the points determine the map."""
    worst = report["map_error_fixed_px"]["max"]
    if not (source.region and facts["max_error_met"] and worst > facts["max_error_px"]):
        return {}
    return {"warnings": [*report.get("warnings", ()), (
        f"the network meets {facts['max_error_px']:g} px at the held-out points and where the "
        f"points determine the map; over the whole valid region the error may be {worst:.3g} px, "
        f"which no more hidden neurons lower")]}


def _largest_tried(source, choices):
    """Largest number of hidden neurons to try: no more than the points can determine."""
    taught = len(source.pairs[0]) - int(split(len(source.pairs[0]), choices.held_out).sum())
    return max(1, min(MAX_TRIED, taught // MIN_POINTS_PER_NEURON))


def _reference_pairs(source, held_out):
    """The pairs for measuring errors, as a :class:`Problem`."""
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


def _fixed_error(trained, source, reference):
    """The same largest error of the integer network."""
    if source.back_map:
        return trained.report["map_error_fixed_px"]["max"]
    return _errors(fixed_map(trained.descriptor), reference, source.region)["max"]


def _errors(back_map, pairs, region):
    """``max`` and ``mean`` error in pixels of a map on ``pairs`` and on a region."""
    x, y = back_map(pairs.u, pairs.v)
    distance = np.hypot(x - pairs.x, y - pairs.y)
    worst = region.learnt(back_map) if region else 0.0
    return {"max": max(float(distance.max()), worst), "mean": float(distance.mean())}

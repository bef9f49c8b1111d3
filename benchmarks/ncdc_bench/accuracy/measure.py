"""The network compared with other maps, fitted to the same noisy dots, on whole frames."""

import time
from dataclasses import dataclass, field, replace

import numpy as np

from ncdc_bench.baselines import BASELINES
from ncdc_bench.reference_lenses import ReferenceLens
from ncdc_model.evaluate import float_map, map_error
from ncdc_model.golden.network import coordinates
from ncdc_model.training.choices import TrainingChoices
from ncdc_model.training.rounding import round_network
from ncdc_model.training.train import train
from ncdc_spec.formats import Formats
from ncdc_spec.geometry import ValidRows

__all__ = ["MODELS", "Fit", "NETWORKS", "fits_of", "jobs_of", "reliability"]

_ALL_DOTS = TrainingChoices(held_out=0)
# By what choices each network is trained; the seed is the job's.
NETWORKS = {"ncdc": _ALL_DOTS, "ncdc-skip": replace(_ALL_DOTS, skip=True),
            "ebp": replace(_ALL_DOTS, trainer="ebp")}
MODELS = (*NETWORKS, *BASELINES)

WITHIN = 1.1           # of the best MSE of all seeds: a seed as good as that is a good one

_BLOCK = 1 << 16       # pixels at a time


@dataclass(frozen=True)
class Fit:
    """A fitted map and its errors.

    Parameters
    ----------
    row : dict
        ``lens``, ``residual`` as times its own, ``model``, ``hidden_neurons`` and ``seed`` (None
        if the map is no network).
        ``mse``, ``mean``, ``max``: errors of :func:`map_error` over every corrected pixel with a
        source, from the true map. ``fixed_mse``, ``fixed_mean``, ``fixed_max``: those of the
        integers. ``fixed_added_max``: largest difference on an axis between integers and real
        numbers. ``dots_mse``: on the dots, noise included. ``seconds``: processor time from dots
        to map.
    back_map : callable
        (u, v) to (x', y'): the integers of a network at whole pixels, else real numbers.
    real_map : callable
        The same in real numbers.
    """
    row: dict
    back_map: object = field(repr=False)
    real_map: object = field(repr=False)


def jobs_of(models, neurons, seeds):
    """(model, hidden neurons or None, seed or None) of all rows of one lens, in order."""
    jobs = []
    for model in models:
        if model in NETWORKS:
            jobs += [(model, hn, seed) for hn in neurons for seed in range(seeds)]
        else:
            jobs.append((model, None, None))
    return jobs


def fits_of(name, jobs, residual=1.0):
    """Yield a :class:`Fit` of each of ``jobs`` on the lens ``name``, a :class:`ReferenceLens`.

    Every map is fitted to all of the lens's noisy dots; the true map, which no fit sees, measures.
    """
    lens = ReferenceLens(name, residual)
    dots, truth = lens.dots(), lens.truth()
    for model, neurons, seed in jobs:
        start = time.process_time()
        if model in NETWORKS:
            network, descriptor = _network(dots, truth, neurons, replace(NETWORKS[model],
                                                                         seed=seed))
            real, fixed = float_map(network, dots.geometry), _integer_map(descriptor)
        else:
            real, fixed = BASELINES[model](dots), None
        seconds = time.process_time() - start
        row = {"lens": name, "residual": residual, "model": model, "hidden_neurons": neurons,
               "seed": seed, **_errors(real, fixed, truth),
               "dots_mse": map_error(real(dots.u, dots.v), (dots.x, dots.y))["mse"],
               "seconds": seconds}
        yield Fit(row, fixed or real, real)


def _network(dots, truth, neurons, choices):
    """The network trained on ``dots``, and its integers, valid where ``truth`` has a source."""
    pairs = dots.u, dots.v, dots.x, dots.y
    network = train(pairs, dots.geometry, neurons, choices).network
    mask = np.zeros(dots.geometry.corrected[::-1], bool)
    mask[truth.v.astype(int), truth.u.astype(int)] = True
    return network, round_network(network, dots.geometry, ValidRows.of_mask(mask), Formats())


def _integer_map(descriptor):
    def back_map(u, v):
        raw = coordinates(descriptor, np.asarray(u).astype(np.int64),
                          np.asarray(v).astype(np.int64))
        return tuple(descriptor.formats.coordinate.real(value) for value in raw)
    return back_map


def _errors(real, fixed, truth):
    """Errors of the map ``real``, and of the integers ``fixed`` or None, on all of ``truth``."""
    exact, approximate, added = [], [], 0.0
    for start in range(0, len(truth), _BLOCK):
        part = slice(start, start + _BLOCK)
        u, v = truth.u[part], truth.v[part]
        at = np.stack(real(u, v))
        exact.append(at)
        if fixed:
            approximate.append(np.stack(fixed(u, v)))
            added = max(added, float(np.abs(approximate[-1] - at).max()))
    errors = map_error(np.concatenate(exact, axis=1), (truth.x, truth.y))
    if fixed:
        integers = map_error(np.concatenate(approximate, axis=1), (truth.x, truth.y))
    return {**errors, **{f"fixed_{name}": integers[name] if fixed else None for name in errors},
            "fixed_added_max": added if fixed else None}


def reliability(rows):
    """Number of seeds within 10 % of the best MSE on the dots, for each lens, model and HN.

    Returns a list of dicts ``lens``, ``model``, ``hidden_neurons``, ``seeds``,
    ``seeds_within_10_percent``; of networks with more than one seed.
    """
    groups = {}
    for row in rows:
        if row["seed"] is not None:
            groups.setdefault((row["lens"], row["model"], row["hidden_neurons"]), []).append(row)
    return [{"lens": lens, "model": model, "hidden_neurons": neurons, "seeds": len(group),
             "seeds_within_10_percent": sum(
                 row["dots_mse"] <= WITHIN * min(r["dots_mse"] for r in group) for row in group)}
            for (lens, model, neurons), group in groups.items() if len(group) > 1]

"""Training of a camera's network: the split, the trainer, the report."""

from dataclasses import dataclass

import numpy as np

from ncdc_model.threads import one_thread
from ncdc_model.training.backprop import train_backprop
from ncdc_model.training.choices import TrainingChoices
from ncdc_model.training.levenberg import train_levenberg
from ncdc_model.training.problem import Problem, errors_of, split
from ncdc_spec.descriptor import MAX_NEURONS, FloatNetwork
from ncdc_spec.errors import InputError

__all__ = ["TRAINERS", "Training", "check_request", "train"]

TRAINERS = {"lm": train_levenberg, "ebp": train_backprop}


@dataclass(frozen=True)
class Training:
    """A trained network, its learning curve and its errors.

    Parameters
    ----------
    network : FloatNetwork
    curve : list of (int, float)
        Learning curve: iterations or epochs, and MSE in px^2 on all training pairs.
    training, held_out : dict
        mse, mean, max (px of the distorted image) and the number of points; without
        points the values are ``nan``.
    """
    network: FloatNetwork
    curve: list
    training: dict
    held_out: dict


def check_request(neurons, choices):
    """Raise :class:`InputError` for a bad request, before any point is known."""
    if not 1 <= neurons <= MAX_NEURONS:
        raise InputError(f"{neurons} hidden neurons are asked for, "
                         f"the limits are 1 and {MAX_NEURONS}")
    trainer = choices.trainer
    if trainer not in TRAINERS:
        raise InputError(f"trainer is {trainer!r}, one of {', '.join(TRAINERS)} is needed")
    if choices.skip and trainer != "lm":
        raise InputError(f"trainer is {trainer!r}, a skip path needs lm")
    split(1, choices.held_out)


@one_thread()
def train(pairs, geometry, neurons, choices=TrainingChoices(), progress=None, anchors=None):
    """Train a network on calibrated ``pairs`` and measure it.

    Parameters
    ----------
    pairs : (u, v, x, y) of ndarray, shape (N,)
        Corrected pixels (u, v) and their sources (x, y) in the distorted image.
    geometry : Geometry
    neurons : int
        Hidden neurons HN.
    choices : TrainingChoices
    progress : callable, optional
        Called with (fraction done, MSE in px^2).
    anchors : (u, v, x, y), optional
        Further training pairs, on which no error is measured.

    Returns
    -------
    Training

    Raises
    ------
    InputError
        If the number of neurons is out of range, the trainer unknown or unable to train the skip
        path, or the points are too few.
    """
    check_request(neurons, choices)
    options = choices.options | ({"skip": True} if choices.skip else {})
    problem = Problem(*pairs, geometry)
    out = split(len(problem), choices.held_out)
    own = problem.take(~out)
    own.check(neurons)
    taught = own
    if anchors is not None:
        both = zip((own.u, own.v, own.x, own.y), anchors)
        taught = Problem(*map(np.concatenate, both), geometry)
    network, curve = TRAINERS[choices.trainer](taught, neurons, seed=choices.seed,
                                               progress=progress, **options)
    return Training(network, curve, errors_of(network, own), errors_of(network, problem.take(out)))

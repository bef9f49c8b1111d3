"""From a source of training pairs to a descriptor with its error table."""

from dataclasses import dataclass, replace

from ncdc_model.calibration.measure import measure_map
from ncdc_model.descriptor import Descriptor, Formats
from ncdc_model.errors import InputError
from ncdc_model.evaluate import evaluate_frame, evaluate_points, float_map
from ncdc_model.geometry import ValidRows
from ncdc_model.training.problem import split
from ncdc_model.training.rounding import check_weight_bits, fitted_formats, round_network
from ncdc_model.training.train import HELD_OUT, Training, train
from ncdc_model.valid import grown, lost_pixels, valid_mask

__all__ = ["TrainedCamera", "describe", "train_camera"]

LEAST_VALID = 0.05     # of the corrected frame; less is no picture

_SMOOTH = 16           # corrected pixels by which the smooth lens may miss the border


@dataclass(frozen=True)
class TrainedCamera:
    """A descriptor, how it was trained, and its errors.

    Parameters
    ----------
    descriptor : Descriptor
    training : Training
    report : dict
        ``hidden_neurons``, ``skip``, ``trainer``, ``seed``; ``training``, ``held_out`` (not if no point is
        held out) and ``frame``, each with ``map_error_float_px`` and ``map_error_fixed_px``
        (``frame`` only where the true map is known); the two of the best evidence there is
        again at the top, ``measured_on`` tells which; ``fixed_minus_float_max_px``;
        ``valid_pixels``, ``valid_percent`` and ``valid_pixels_lost``, those that two spans a
        row cannot hold; of points ``extrapolated_percent``, valid pixels that lie beyond
        the points, where the network follows the smooth lens, ``points_dropped``, points that
        were not used by reason, and the values of
        :func:`ncdc_model.calibration.measure.measure_map`, on held-out points if there are any.
    error_maps : dict
        ``float`` and ``fixed``: distance to the true map in pixels, float32 (height, width),
        ``nan`` where a pixel has no source; empty if the true map is not known.
    """
    descriptor: Descriptor
    training: Training
    report: dict
    error_maps: dict


def train_camera(source, neurons, trainer="lm", seed=0, held_out=HELD_OUT, progress=None,
                 *, formats=Formats(), variant="mmhbc", gamma=1.0, weight_bits=None, **options):
    """Train, quantise and measure a :class:`~ncdc_model.training.source.Source`.

    ``formats``, ``variant``, ``gamma`` and ``weight_bits`` as in :func:`describe`, the further
    arguments as in :func:`ncdc_model.training.train.train`.

    Returns
    -------
    TrainedCamera

    Raises
    ------
    InputError
        If the request is bad, a weight leaves its format, or hardly a pixel has a source.
    """
    if weight_bits is not None:
        check_weight_bits(weight_bits)
    training = train(source.pairs, source.geometry, neurons, trainer, seed, held_out, progress,
                     source.anchors, **options)
    return describe(source, training, trainer, seed, held_out, formats=formats, variant=variant,
                    gamma=gamma, weight_bits=weight_bits)


def describe(source, training, trainer, seed, held_out, *, formats=Formats(), variant="mmhbc",
             gamma=1.0, weight_bits=None):
    """Quantise and measure a :class:`Training` of ``source``.

    The valid region comes from the exact map where the source has one, else from the float
    network, near where the smooth lens has a source. ``formats``, ``variant`` and ``gamma`` are
    those of the descriptor; with ``weight_bits`` the weights and the inputs get formats of so many
    bits that fit this network (:func:`ncdc_model.training.rounding.fitted_formats`). ``trainer``,
    ``seed`` and ``held_out`` are those of the training.

    Returns
    -------
    TrainedCamera

    Raises
    ------
    InputError
        If a weight leaves its format, or hardly a pixel has a source.
    """
    geometry = source.geometry
    neurons = training.network.hidden_neurons
    network = training.network.with_gamma(gamma)
    back_map = source.back_map or float_map(network, geometry)
    within = covered = None
    if source.smooth_map:
        within = grown(valid_mask(source.smooth_map, geometry), _SMOOTH)
    if source.calibrated:
        covered = source.calibrated.mask(back_map, geometry)
    mask = valid_mask(back_map, geometry, within)
    if mask.mean() < LEAST_VALID:
        raise InputError(f"only {100 * mask.mean():.1f} % of the corrected frame has a source with "
                         f"{neurons} hidden neurons, {100 * LEAST_VALID:.0f} % is the limit")
    rows = ValidRows.of_mask(mask)
    provenance = {"trainer": trainer, "seed": seed, **source.provenance}
    if weight_bits is not None:
        formats = fitted_formats(network, formats, weight_bits)
    draft = round_network(network, geometry, rows, formats, variant=variant)
    maps = {}
    frame = evaluate_frame(draft, source.back_map, maps if source.back_map else None)
    out = split(len(source.pairs[0]), held_out)
    report = {"hidden_neurons": neurons, "skip": network.skip_weights is not None,
              "trainer": trainer, "seed": seed}
    parts = {"training": ~out, "held_out": out}
    tables = {name: evaluate_points(draft, *(values[mask] for values in source.pairs))
              for name, mask in parts.items() if mask.any()}
    if source.back_map:
        tables["frame"] = {name: frame[name] for name in ("map_error_float_px",
                                                          "map_error_fixed_px")}
    best = list(tables)[-1]
    report |= {"measured_on": best,
               **{name: tables[best][name] for name in ("map_error_float_px",
                                                        "map_error_fixed_px")},
               "fixed_minus_float_max_px": frame["fixed_minus_float_max_px"],
               "valid_pixels": frame["valid_pixels"],
               "valid_percent": round(100 * frame["valid_pixels"] / mask.size, 3),
               "valid_pixels_lost": lost_pixels(mask, rows), **tables}
    if covered is not None:
        report["extrapolated_percent"] = round(100 * float((mask & ~covered).mean()), 3)
    descriptor = replace(draft, errors=report, provenance=provenance)
    if source.frame:
        report = report | {"points_dropped": source.frame.rejected} | measure_map(
            source.frame, float_map(network, geometry), out if out.any() else None)
    return TrainedCamera(descriptor, training, report, maps)

"""Training of a descriptor from a source of training pairs, with its error table."""

from dataclasses import dataclass, replace

from ncdc_model.calibration.measure import measure_map
from ncdc_model.evaluate import (
    check_curvature,
    evaluate_frame,
    evaluate_points,
    fixed_map,
    float_map,
)
from ncdc_model.golden.nodes import interpolated_map, largest_nodes
from ncdc_model.golden.smooth_masks import smooth_masks
from ncdc_model.golden.valid import connected, lost_pixels, masks_of
from ncdc_model.training.choices import TrainingChoices
from ncdc_model.training.problem import split
from ncdc_model.training.rounding import fitted_formats, round_network
from ncdc_model.training.train import Training, train
from ncdc_model.view_nodes import errors_report, worst_node_errors
from ncdc_spec.descriptor import Descriptor
from ncdc_spec.errors import InputError
from ncdc_spec.geometry import ValidRows
from ncdc_spec.nodes import NODES, check_nodes

__all__ = ["TrainedCamera", "describe", "train_camera"]

MIN_VALID = 0.05     # of the corrected frame

_KINDS = "map_error_float_px", "map_error_fixed_px"


@dataclass(frozen=True)
class TrainedCamera:
    """A descriptor, its training and its errors.

    Parameters
    ----------
    descriptor : Descriptor
    training : Training
    report : dict
        ``hidden_neurons``, ``skip``, ``trainer``, ``seed``; ``training``, ``held_out`` (not if no
        point is held out), ``beyond_points``, ``region`` and ``frame``, each with
        ``map_error_float_px`` and ``map_error_fixed_px``. The two of the best evidence are also
        at the top, and ``measured_on`` names it: ``frame`` if the true map is known, else
        ``region``, estimated over the whole valid region (:mod:`ncdc_model.training.region`).
        ``beyond_points`` is its part beyond the outermost points, ``beyond_points_percent`` the
        size of that part, ``beyond_points_known_px`` how well the map is known there;
        ``nodes``, their distance, and ``nodes_curvature_px``, their error from the network; with a
        range of views ``views`` and ``views_nodes_px``, see
        :func:`ncdc_model.view_nodes.errors_report`;
        ``fixed_minus_float_max_px``;
        ``valid_pixels``, ``valid_percent`` and ``valid_pixels_lost``, those that do not fit in
        two spans a row; for points ``extrapolated_percent``, valid pixels beyond the points,
        where the network follows the smooth lens, ``points_dropped``, unused points by reason,
        and the values of :func:`ncdc_model.calibration.measure.measure_map`, on held-out points
        if there are any; the ``facts`` of the source.
    error_maps : dict
        ``float`` and ``fixed``: distance to the true map in pixels, float32 (height, width),
        ``nan`` where a pixel has no source; empty if the true map is not known.
    """
    descriptor: Descriptor
    training: Training
    report: dict
    error_maps: dict


def train_camera(source, neurons, choices=TrainingChoices(), progress=None):
    """Train, quantise and measure a :class:`~ncdc_model.training.source.Source`.

    Parameters
    ----------
    source : Source
    neurons : int
        Hidden neurons HN.
    choices : TrainingChoices
    progress : callable, optional
        Called with (fraction done, MSE in px^2).

    Returns
    -------
    TrainedCamera

    Raises
    ------
    InputError
        If the request is bad, a weight leaves its format, or too few pixels have a source.
    """
    training = train(source.pairs, source.geometry, neurons, choices, progress, source.anchors)
    return describe(source, training, choices)


def describe(source, training, choices):
    """Quantise and measure a :class:`Training` of ``source`` by the same ``choices``.

    The valid region is that of the exact map if the source has one. Else it is that of the float
    network, near the valid region of the smooth lens.

    Returns
    -------
    TrainedCamera

    Raises
    ------
    InputError
        If a weight leaves its format, too few pixels have a source, or the error of the requested
        nodes is more than ``ncdc_model.golden.nodes.CURVATURE_LIMIT``.
    """
    network = training.network.with_gamma(choices.gamma)
    mask, covered = _regions(source, network)
    formats = choices.formats
    if choices.weight_bits is not None:
        formats = fitted_formats(network, formats, choices.weight_bits)
    draft = round_network(network, source.geometry, ValidRows.of_mask(mask), formats,
                          variant=choices.variant)
    draft, missed = _at_nodes(draft, choices)
    if draft.nodes > 1:
        mask, covered = _regions(source, network, draft.nodes)
        draft = replace(draft, valid=ValidRows.of_mask(mask))
    rows, maps = draft.valid, {}
    frame = evaluate_frame(draft, source.back_map, maps if source.back_map else None)
    out = split(len(source.pairs[0]), choices.held_out)
    tables = _error_tables(draft, source, out, frame)
    best = list(tables)[-1]
    report = {"hidden_neurons": network.hidden_neurons, "skip": network.skip_weights is not None,
              "trainer": choices.trainer, "seed": choices.seed, "measured_on": best,
              **{kind: tables[best][kind] for kind in _KINDS},
              "nodes": draft.nodes, **missed,
              "fixed_minus_float_max_px": frame["fixed_minus_float_max_px"],
              "valid_pixels": frame["valid_pixels"],
              "valid_percent": round(100 * frame["valid_pixels"] / mask.size, 3),
              "valid_pixels_lost": lost_pixels(mask, rows), **tables}
    if source.region:
        report["beyond_points_percent"] = round(100 * source.region.beyond_part, 1)
        report["beyond_points_known_px"] = source.region.uncertain
    if source.blank_beyond is not None:
        report["blank_beyond_px"] = source.blank_beyond
    if covered is not None:
        report["extrapolated_percent"] = round(100 * float((mask & ~covered).mean()), 3)
    descriptor = replace(draft, errors=report, provenance={
        "trainer": choices.trainer, "seed": choices.seed, **source.provenance})
    if source.frame:
        dropped = {reason.value: count for reason, count in source.frame.rejected.items()}
        report = report | {"points_dropped": dropped} | measure_map(
            source.frame, float_map(network, source.geometry), out if out.any() else None)
    return TrainedCamera(descriptor, training, report | _facts(source), maps)


def _facts(source):
    """Facts of ``source`` for the report, with a warning of what is not known beyond its points."""
    sentence = source.region.warning(source.geometry.distorted[0]) if source.region else ""
    if not sentence:
        return source.facts
    return source.facts | {"warnings": [*source.facts.get("warnings", ()), sentence]}


def _at_nodes(draft, choices):
    """``draft`` at nodes of the wanted distance, and entries of the report on their error.

    Raises
    ------
    InputError
        If the error in the trained picture is above the limit, or the picture is too narrow for
        the nodes.
    """
    wanted, views = choices.nodes, choices.views
    if wanted != "auto":
        check_nodes(wanted, draft.geometry.corrected_width)
    found = check_curvature(draft, NODES if wanted == "auto" else (wanted,))
    report, errors = {}, found
    if views:
        in_views = worst_node_errors(draft, views, None if wanted == "auto" else wanted)
        errors = {nodes: max(found[nodes], error) for nodes, (error, _) in in_views.items()
                  if nodes in found}
        report = errors_report(views, in_views)
    nodes = largest_nodes(errors) if wanted == "auto" else wanted
    return replace(draft, nodes=nodes), {"nodes_curvature_px": found[nodes], **report}


def _regions(source, network, nodes=1):
    """Masks of the corrected frame: the valid pixels, and those covered by points (or None).

    If the map itself is not known, they are those of the network at ``nodes``.
    """
    geometry = source.geometry
    masks = masks_of(source.back_map, geometry, source.covering) if source.back_map else (
        smooth_masks(interpolated_map(float_map(network, geometry), nodes), geometry,
                     source.covering))
    mask = connected(masks.unfolded if source.within is None else masks.unfolded & source.within)
    if mask.mean() < MIN_VALID:
        raise InputError(f"only {100 * mask.mean():.1f} % of the corrected frame has a source with "
                         f"{network.hidden_neurons} hidden neurons, {100 * MIN_VALID:.0f} % is "
                         f"the limit")
    return mask, masks.covered


def _error_tables(draft, source, out, frame):
    """Errors of the descriptor ``draft`` on each set of pairs, the best evidence last.

    ``out``: which pairs are held out; ``frame``: result of :func:`evaluate_frame`.
    """
    tables = {name: evaluate_points(draft, *(values[part] for values in source.pairs))
              for name, part in {"training": ~out, "held_out": out}.items() if part.any()}
    if source.back_map:
        tables["frame"] = {kind: frame[kind] for kind in _KINDS}
    elif source.region:
        maps = float_map(draft.network, draft.geometry), fixed_map(draft)
        region, beyond = zip(*(source.region.errors(one, maps[0]) for one in maps))
        seen = [max(table[kind]["max"] for table in tables.values()) for kind in _KINDS]
        if source.region.beyond.any():
            tables["beyond_points"] = dict(zip(_KINDS, beyond))
        tables["region"] = {kind: part | {"max": max(part["max"], worst)}
                            for kind, part, worst in zip(_KINDS, region, seen)}
    return tables

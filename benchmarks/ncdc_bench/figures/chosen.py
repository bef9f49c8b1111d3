"""The numbers of reports that pages may quote: their names and units.

A group is the figures of one command. A name is made of the group's, the table's, the row's and
the field's, joined by dots: ``demo.errors.frame_fixed.mse``.
"""

import re
from collections.abc import Callable
from dataclasses import dataclass

from ncdc_bench.figures import chosen_maps
from ncdc_bench.mutation.golden import score
from ncdc_bench.synth.breakdown import totals

__all__ = ["GROUPS", "Group", "groups_of"]


def _slug(*parts):
    """Parts of a row's name as one word."""
    return re.sub(r"\W+", "_", " ".join(str(part) for part in parts).lower()).strip("_")


def _errors(tables):
    """Rows of error tables: MSE in px², mean and largest distance in px."""
    return {_slug(points, kind): {"points": points, "arithmetic": kind,
                                  **table[f"map_error_{kind}_px"]}
            for points, table in tables.items() for kind in ("float", "fixed")}


def _demo(report):
    pixels = {"compared": report["pixels_compared"], "differ": report["pixels_different"]}
    psnr = {name.removeprefix("psnr_").removesuffix("_db"): value
            for name, value in report.items() if re.fullmatch(r"psnr_\w+_db", name)}
    straightness = {"before": report["straightness_before_rms_px"],
                    "after": report["straightness_rms_px"]}
    return {"dots": report["points_found"], "pixels": pixels,
            "verilog_lines": report["verilog_lines"],
            "clocks_per_pixel": report["clocks_per_pixel"],
            "errors": _errors({"frame": report}), "psnr": psnr, "straightness": straightness}


def _train(report):
    tables = {name.replace("_", " "): report[name]
              for name in ("training", "held_out", "beyond_points", "region")}
    return {"errors": _errors(tables), "nodes_max": report["nodes_curvature_px"],
            "fixed_minus_float_max": report["fixed_minus_float_max_px"]}


def _train_camera(report):
    """A row for each number of neurons: errors in px, MSE in px²; the most that integers add."""
    rows = {str(row["hidden_neurons"]): {
        "neurons": row["hidden_neurons"], "added": row["fixed_minus_float_max_px"],
        **{f"{kind}_{name}": row[f"map_error_{kind}_px"][name]
           for kind in ("float", "fixed") for name in ("mse", "max")}}
        for row in report["rows"]}
    return {"rows": rows, "added_max": max(row["added"] for row in rows.values())}


def _view(report):
    """A row for each lens, px; and how still points stand, px."""
    return {"rows": {_slug(row["lens"]): {"lens": row["lens"], "views": row["views"], **{
        name: row[key] for name, key in (
            ("view_max", "map_error_max_px"), ("lens_max", "lens_error_max_px"),
            ("filled", "wrongly_filled"), ("blank", "wrongly_blank"))}}
        for row in report["rows"]}, "steady": report["steadiness"]}


def _train_points(report):
    """A row for each trainer: MSE in px², of real numbers."""
    return {row["trainer"]: {"trainer": row["trainer"], **{
        name: row[name]["map_error_float_px"]["mse"] for name in ("training", "held_out")}}
        for row in report["rows"]}


def _evaluate(report):
    """A row for each number of neurons: MSE in px² and largest error in px, of the integers."""
    return {str(row["hidden_neurons"]): {
        "neurons": row["hidden_neurons"], "mse": row["map_error_fixed_px"]["mse"],
        "max": row["map_error_fixed_px"]["max"]} for row in report["rows"]}


def _simulate(report):
    return {"compared": report["pixels_compared"], "differ": report["pixels_different"],
            "clocks": report["clocks_per_pixel"], "bytes": report["bytes_read_per_pixel"]}


def _multiport(report):
    """A row for each memory and output; "windows" of a frame are read."""
    rows = {}
    for row in report["rows"]:
        stream = row["output"] == "stream"
        rows[_slug(row["memory"], "stream" * stream)] = {
            "memory": row["memory"] + ", output to a stream" * stream,
            "width": row["data_width"], "clocks": row["clocks_per_pixel"],
            "bytes": row["bytes_read_per_pixel"]}
    return {"windows": report["rows"][0]["windows_fetched"], "memories": rows}


def _follow(report):
    frame = report["pixels_compared"]       # the camera's frame is as large, a sample per clock
    return {"latency": report["follow_latency_clocks"], "bound": report["follow_bound_clocks"],
            "part": 100 * report["follow_latency_clocks"] / frame}


def _is_frame(**settings):
    """Whether a report is of ``ncdc simulate`` with these settings."""
    return lambda report: "verilog_lines" not in report and all(
        report[name] == value for name, value in settings.items())


def _tansig(report):
    names = {"fraction_bits": "bits", "max_ulp": "max", "bound_ulp": "bound", "latency": "latency",
             "stages": "stages", "differences": "differ",
             "adders": "adders", "table_bits": "table", "multipliers": "products"}
    tables = {}
    for row in report["rows"]:
        tables.setdefault(row["variant"], {})[str(row["fraction_bits"])] = {
            "variant": row["variant"], **{name: row[key] for key, name in names.items()},
            "within_half": 100 * row["correctly_rounded"], "mse": row["mse"] / row["mse_ideal"]}
    return tables


def _tansig_size(report):
    tables = _tansig(report)
    for row in report["rows"]:
        tables[row["variant"]][str(row["fraction_bits"])] |= {
            "alm": row["alm"], "ff": row["alm_ff"], "dsp": row["dsp"], "m10k": row["m10k"]}
    return tables


def _synth(report):
    def seeds(row):
        clocks = row["fmax_seeds_mhz"]
        return f"{len(clocks)}: {min(clocks)} to {max(clocks)}" if clocks else "-"

    names = {"lut": "lut", "ff": "ff", "dsp": "dsp", "ram_blocks": "ram", "fmax_mhz": "mhz"}
    return {_slug(row["block"], row["variant"], row["target"]): {
        "block": row["block"], "variant": row["variant"], "target": row["target"],
        "cells": row["alm"] if row["alm"] is not None else row.get("le"),
        **{name: row[key] for key, name in names.items()}, "seeds": seeds(row)}
        for row in report["rows"]}


def _breakdown(report):
    """ALMs, or logic elements, of the modules below the top, the largest first: a row for each,
    with a field for each core."""
    cores = [_slug(run["variant"], run["target"]) for run in report["rows"]]
    modules = {}
    for core, run in zip(cores, report["rows"]):
        for row in totals(run["modules"]):
            if "." not in row["path"]:
                name = row["path"] or "all"
                modules.setdefault(name, {"module": name, **dict.fromkeys(cores)})[core] = (
                    row["alm"] if row["alm"] is not None else row["le"])
    return {"cells": dict(sorted(modules.items(), key=lambda module: -max(
        module[1][core] or 0 for core in cores)))}


def _grid(report):
    rows = {}
    for row in report["rows"]:
        figures = rows.setdefault(_slug(row["picture"], row["sampling"]), {
            "picture": row["picture"], "sampling": row["sampling"]})
        name = "psnr_db" if row["grid"] == "even" else "gain_db"
        figures[f"{row['interpolation']}_{row['grid']}"] = row[name]
    return rows


def _system(report):
    names = {"frames": "frames", "pixels_compared": "pixels", "pixels_different": "wrong",
             "camera_bytes_dropped": "dropped", "clocks_per_pixel": "clocks",
             "predicted_clocks_per_pixel": "predicted", "csi_faults": "csi_faults"}
    return {"camera": {name: row[key] for row in report["rows"] if row["width"] == 640
                       for key, name in names.items() if row[key] is not None}}


def _pictures(report):
    """Figures of all flows of each picture with the map, and of each set in each condition."""
    tables = {"map": {}, "sets": {}}
    for row in report["rows"]:
        if "picture" in row:
            figures = tables["map"].setdefault(_slug(row["picture"]), {})
        else:
            conditions = tables["sets"].setdefault(_slug(row["set"]), {})
            figures = conditions.setdefault(_condition(row), {"pictures": row["pictures"]})
        names = [name for name in row if name.endswith("_db") or name in _PICTURE_FIGURES]
        figures |= {f"{_slug(row['flow'])}_{name.removesuffix('_db')}": row[name] for name in names}
    for figures in tables["map"].values():
        _margins(figures)
    return tables


def _margins(figures):
    """Add by how many dB ours is above the best of OpenCV's flows, compared with each reference."""
    for kind, ours in (("psnr", "directional"), ("psnr_lanczos", "directional_crest")):
        best = max(value for name, value in figures.items()
                   if name.startswith("opencv") and name.endswith(f"_{kind}"))
        figures[f"gain_{kind}"] = figures[f"{ours}_{kind}"] - best


_PICTURE_FIGURES = ("ssim", "false_colour", "edge_colour", "overshoot")


def _condition(row):
    """Name of a condition of ``ncdc bench pictures``."""
    if row["gains"] != [1, 1, 1]:
        return "balanced_first" if row["balanced_first"] else "unbalanced"
    return "linear" if row["linear"] else f"noise_{row['noise']:g}" if row["noise"] else "plain"


def _calibration(report):
    """A row for each command on each set of photos: processor seconds, errors in px."""
    return {"rows": {_slug(row["photos"], row["command"]): {
        "rms": row.get("points_rms_px", row.get("true_rms_px")),
        "reference_rms": row.get("reference_points_rms_px", row.get("reference_true_rms_px")),
        **row} for row in report["rows"]}}


def _model(report):
    rows = {_slug(row["size"], row["interpolation"], row["model"]): {
        **row, "seconds": row["milliseconds"] / 1000} for row in report["rows"]}
    return {"rows": rows, "device": report["device"]}


def _cost(report):
    """A row for each picture and lens."""
    return {"rows": {_slug(f"{row['width']}x{row['height']}", str(row["lens"])): {
        "size": f"{row['width']}x{row['height']}", "cache_kb": row["cache_bytes"] // 1024,
        **{key: row[key] for key in ("lens", "predicted_clocks_per_pixel", "bytes_read_per_pixel",
                                     "amplification", "alm", "m10k", "dsp")}}
        for row in report["rows"]}}


def _mutation_model(report):
    """A row for each module of the golden model, scores in per cent; the mutants of all."""
    rows = {_slug(row["module"]): {**row, "score": 100 * score([row])} for row in report["rows"]}
    return {"rows": {name: {key: row[key] for key in (
        "module", "possible", "mutants", "killed", "equivalent", "survived", "score")}
        for name, row in rows.items()},
        "mutants": sum(row["mutants"] for row in report["rows"])}


@dataclass(frozen=True)
class Group:
    """The figures that pages may quote of one command.

    Parameters
    ----------
    command : str
        The command that makes the report.
    marks : tuple of str
        Keys that its report has, and other commands' have not: its own, or its first row's.
    choose : callable
        Gives the figures of a report: nested dicts, a table as a dict of rows.
    accepts : callable
        Whether a report was made by ``command``, and not by a quicker one.
    """
    command: str
    marks: tuple[str, ...]
    choose: Callable
    accepts: Callable = lambda report: True


_FRAME = "pixels_compared", "bytes_read_per_pixel"
_ACCURACY = "lens", "residual", "dots_mse"
_LENSES = "PC105 PC120 105kb 105br 105dbr 120kb 120br 120dbr"


def _has(*models, residual=1):
    """Whether a report is of ``ncdc bench accuracy`` with these models."""
    return lambda report: all(row["residual"] == residual for row in report["rows"]) and {
        row["model"] for row in report["rows"]} == set(models)


GROUPS = {
    "demo": Group("ncdc demo", ("verilog_lines", "straightness_before_rms_px"), _demo),
    "train": Group("ncdc train demo/points.json --neurons 8 --size 640x480",
                   ("training", "held_out", "beyond_points"), _train,
                   lambda report: report["hidden_neurons"] == 8),
    "train_points": Group("ncdc train demo/points.json --neurons 4 --size 640x480, and with "
                          "--trainer ebp",
                          ("training", "held_out", "beyond_points"), _train_points,
                          lambda report: report["hidden_neurons"] == 4),
    "train_camera": Group("ncdc train demo/camera.toml --neurons N, N from 4 to 12",
                          ("trainer", "map_error_fixed_px"), _train_camera,
                          lambda report: "beyond_points" not in report),
    "evaluate": Group("ncdc evaluate net.toml --reference demo/camera.toml, networks of "
                      "ncdc train demo/points.json --size 640x480",
                      ("measured_on", "map_error_fixed_px"), _evaluate,
                      lambda report: "trainer" not in report),
    "simulate": Group("ncdc simulate demo/net.toml demo/distorted.raw.png --memory sdram",
                      _FRAME, _simulate, _is_frame(strip=256, fetch="cache")),
    "simulate_strip": Group("ncdc simulate demo/net.toml demo/distorted.raw.png --strip 128",
                            _FRAME, _simulate, _is_frame(strip=128, fetch="cache")),
    "simulate_follow": Group(
        "ncdc simulate demo/net.toml demo/distorted.raw.png --to stream --follow",
        (*_FRAME, "follow_latency_clocks"), _follow),
    "simulate_stream": Group("ncdc simulate fast.toml demo/distorted.raw.png --to stream",
                             _FRAME, _simulate, _is_frame(output="stream", fetch="cache")),
    "multiport": Group("ncdc simulate fast.toml demo/distorted.raw.png --fetch multiport, each "
                       "memory, and --to stream",
                       _FRAME, _multiport, _is_frame(fetch="multiport")),
    "tansig": Group("ncdc bench tansig --no-synth", ("max_ulp", "bound_ulp"), _tansig,
                    lambda report: all(row["exhaustive"] for row in report["rows"])),
    "tansig_size": Group("ncdc bench tansig --sampled --no-route", ("max_ulp", "m10k"),
                         _tansig_size,
                         lambda report: not any(row["exhaustive"] for row in report["rows"])),
    "synth": Group("ncdc bench synth --json docs/evidence/synthesis.json",
                   ("block", "fmax_seeds_mhz"), _synth),
    "breakdown": Group("ncdc bench synth --breakdown --block core", ("modules",), _breakdown),
    "grid": Group("ncdc bench grid tests/data/dots/dot_pattern_06.jpg", ("blur_px",), _grid),
    "pictures": Group("ncdc bench pictures rover.png street.jpg chessboard.jpg --set kodak "
                      "--set mcmaster", ("psnr_lanczos_db",), _pictures),
    "calibration": Group("ncdc bench calibration --older ../version-0.1",
                         ("reference_seconds", "ratio"), _calibration),
    "model": Group("ncdc bench model", ("device", "map_milliseconds"), _model,
                   lambda report: len({row["size"] for row in report["rows"]}) > 1),
    "system": Group("ncdc bench system --quick", ("follow_bound_clocks", "frames_torn"), _system,
                    lambda report: report["rows"][0]["camera"] == "mt9p031"),
    "system_csi2": Group("ncdc bench system --camera imx219 --quick",
                         ("follow_bound_clocks", "frames_torn"), _system,
                         lambda report: report["rows"][0]["camera"] == "imx219"),
    "accuracy": Group(f"ncdc bench accuracy --lens {_LENSES} --neurons 10 --model pbm6-shared "
                      "pbm6-separate brown5 opencv-fisheye opencv-full mesh8-bilinear "
                      "mesh128-bicubic ncdc",
                      _ACCURACY, chosen_maps.by_lens,
                      _has("ncdc", "pbm6-shared", "pbm6-separate", "brown5", "opencv-fisheye",
                           "opencv-full", "mesh8-bilinear", "mesh128-bicubic")),
    "accuracy_residual_0": Group(
        f"ncdc bench accuracy --residual 0 --lens {_LENSES} --neurons 8,12 --model brown5 "
        "opencv-fisheye opencv-full mesh128-bicubic ncdc",
        _ACCURACY, chosen_maps.by_lens,
        _has("ncdc", "brown5", "opencv-fisheye", "opencv-full", "mesh128-bicubic", residual=0)),
    "lines": Group("ncdc bench lines --model pbm6-shared pbm6-separate opencv-fisheye "
                   "opencv-full mesh128-bicubic ncdc",
                   ("lines_missed", "straightness_rms_px"), chosen_maps.lines),
    "nodes": Group("ncdc bench nodes", ("curvature_px", "added_max_px"), chosen_maps.nodes),
    "view": Group("ncdc bench view", ("steadiness",), _view),
    "cost": Group("ncdc bench cost", ("hardware_exists", "amplification"), _cost,
                  lambda report: len({row["width"] for row in report["rows"]}) > 1),
    "mutation_model": Group("ncdc bench mutation --model --per-module 120 --seed 49",
                            ("killed", "tests"), _mutation_model),
}


def groups_of(report):
    """Names of the groups whose marks a report has."""
    rows = report.get("rows") or [{}]
    keys = {*report, *rows[0]}
    return [name for name, group in GROUPS.items() if keys.issuperset(group.marks)]

"""The numbers of reports that pages may quote: their names and units.

A group is the figures of one command. A name is made of the group's, the table's, the row's and
the field's, joined by dots: ``demo.errors.frame_fixed.mse``.
"""

import re
from collections.abc import Callable
from dataclasses import dataclass

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
    psnr["gain"] = psnr[report["interpolation"]] - psnr["demosaic"]
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


def _simulate(report):
    return {"compared": report["pixels_compared"], "differ": report["pixels_different"],
            "clocks": report["clocks_per_pixel"], "bytes": report["bytes_read_per_pixel"]}


def _simulated(strip):
    """Whether a report is of ``ncdc simulate`` with strips of this width."""
    return lambda report: "verilog_lines" not in report and report["strip"] == strip


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


def _grid(report):
    rows = {}
    for row in report["rows"]:
        figures = rows.setdefault(_slug(row["picture"], row["sampling"]), {})
        name = "psnr_db" if row["grid"] == "even" else "gain_db"
        figures[f"{row['interpolation']}_{row['grid']}"] = row[name]
    return rows


def _system(report):
    names = {"frames": "frames", "pixels_compared": "pixels", "pixels_different": "wrong",
             "camera_bytes_dropped": "dropped", "clocks_per_pixel": "clocks",
             "predicted_clocks_per_pixel": "predicted"}
    return {"camera": {name: row[key] for row in report["rows"] if row["width"] == 640
                       for key, name in names.items()}}


def _pictures(report):
    rows = {}
    for row in report["rows"]:
        figures = rows.setdefault(_slug(row["picture"]), {"picture": row["picture"]})
        figures |= {f"{_slug(row['flow'])}_{name}": value for name, value in row.items()
                    if isinstance(value, (int, float))}
    return rows


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


GROUPS = {
    "demo": Group("ncdc demo", ("verilog_lines", "straightness_before_rms_px"), _demo),
    "train": Group("ncdc train demo/points.json --neurons 8 --size 640x480",
                   ("training", "held_out", "beyond_points"), _train),
    "simulate": Group("ncdc simulate demo/net.toml demo/distorted.raw.png --memory sdram",
                      ("pixels_compared", "bytes_read_per_pixel"), _simulate, _simulated(256)),
    "simulate_strip": Group("ncdc simulate demo/net.toml demo/distorted.raw.png --strip 128",
                            ("pixels_compared", "bytes_read_per_pixel"), _simulate,
                            _simulated(128)),
    "tansig": Group("ncdc bench tansig --no-synth", ("max_ulp", "bound_ulp"), _tansig,
                    lambda report: all(row["exhaustive"] for row in report["rows"])),
    "tansig_size": Group("ncdc bench tansig --sampled --no-route", ("max_ulp", "m10k"),
                         _tansig_size,
                         lambda report: not any(row["exhaustive"] for row in report["rows"])),
    "synth": Group("ncdc bench synth --json docs/evidence/synthesis.json",
                   ("block", "fmax_seeds_mhz"), _synth),
    "grid": Group("ncdc bench grid tests/data/dots/dot_pattern_06.jpg", ("blur_px",), _grid),
    "pictures": Group("ncdc bench pictures", ("psnr_lanczos_db",), _pictures),
    "system": Group("ncdc bench system --quick", ("follow_bound_clocks", "frames_torn"), _system),
}


def groups_of(report):
    """Names of the groups whose marks a report has."""
    rows = report.get("rows") or [{}]
    keys = {*report, *rows[0]}
    return [name for name, group in GROUPS.items() if keys.issuperset(group.marks)]

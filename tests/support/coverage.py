"""Line and toggle coverage of the Verilog, as Verilator's simulations count it."""

import re
from collections import Counter
from pathlib import Path

__all__ = ["FOLDER", "percentages", "reached", "table"]

FOLDER = Path(__file__).resolve().parents[2] / "build" / "coverage"
KINDS = "line", "toggle"

_POINT = re.compile(r"^C '(.*)' (\d+)$")


def reached(text):
    """Count the corrector's points in a file of Verilator's: {(kind, module): [reached, all]}.

    A branch that is never taken is a line that is not reached; a bit toggles if it both rises and
    falls, each a point.
    """
    found = {}
    for line in text.splitlines():
        if point := _POINT.match(line):
            keys = dict(part.split("\2", 1) for part in point[1].split("\1") if "\2" in part)
            kind, _, module = keys["page"].removeprefix("v_").partition("/")
            if module.startswith("ncdc"):
                kind = "toggle" if kind == "toggle" else "line"
                counts = found.setdefault((kind, module), [0, 0])
                counts[0] += int(point[2]) > 0
                counts[1] += 1
    return found


def percentages(found):
    """Percent reached of each kind, of :func:`reached`'s points."""
    sums = {kind: Counter() for kind in KINDS}
    for (kind, _), (hit, points) in found.items():
        sums[kind].update(hit=hit, points=points)
    return {kind: 100 * count["hit"] / count["points"] for kind, count in sums.items()}


def table():
    """Lines of text: coverage of every run that is stored, and the modules of which least is
    reached, in whichever of the runs reaches most."""
    runs = {path.stem: reached(path.read_text(errors="replace"))
            for path in sorted(FOLDER.glob("*.dat"))}
    lines = [f"{'run':60} {'line %':>7} {'toggle %':>9}"]
    for name, found in runs.items():
        share = percentages(found)
        lines.append(f"{name:60} {share['line']:7.1f} {share['toggle']:9.1f}")
    best = {}
    for found in runs.values():
        for point, (hit, points) in found.items():
            best[point] = max(best.get(point, 0), 100 * hit / points)
    for kind in KINDS:
        low = sorted((share, name) for (one, name), share in best.items() if one == kind)[:5]
        lines.append(f"least {kind}: " + ", ".join(f"{name} {share:.0f}" for share, name in low))
    return lines

"""``ncdc bench truth`` without another part: pages that fill the picture of each lens."""

from ncdc_bench.truth.boards import BOARDS
from ncdc_bench.truth.boards import POSES as BOARD_POSES
from ncdc_bench.truth.corners import corner_row, detect_boards
from ncdc_bench.truth.lenses import LENSES
from ncdc_bench.truth.measure import detect, found_points, measure, page_in_front
from ncdc_bench.truth.render import POSES

__all__ = ["failed", "jobs", "table"]


def jobs(options):
    """(text, function that gives a row) of each lens, with one photo and with several."""
    most = len(POSES if options.target == "dots" else BOARD_POSES)
    return [(f"{lens.name}, {photos} photo{'s' * (photos > 1)}",
             lambda lens=lens, photos=photos: row_of(lens, photos, options))
            for photos in ([options.photos] if options.photos else [1, most])
            for lens in LENSES.values()]


def row_of(lens, photos, options):
    """Row of ``lens``: what was found, and unless only this is asked for, the trained map."""
    target = options.target
    if options.exact:
        pages = [page_in_front(lens, target, number) for number in range(photos)]
        points, found = found_points(lens, pages, target, True), {}
    else:
        points, found = _detected(lens, photos, target)
    row = {"lens": lens.name, "target": target, "photos": photos, "page_share": 1.0, **found}
    return row if options.dots else row | measure(lens, points, options.neurons)


def _detected(lens, photos, target):
    """The points that are detected on the photos, and the row's fields on them."""
    if target in BOARDS:
        points, corners = detect_boards(lens, target, photos)
        return points, corner_row(corners)
    points, dots = detect(lens, photos)
    return points, {"dots_visible": sum(part.visible for part in dots),
                    "dots_used": sum(part.used for part in dots),
                    "dots_false": sum(part.false for part in dots)}


def failed(row):
    """Whether a row shows a defect."""
    return bool(row.get("dots_false") or row.get("corners_misnumbered") or row.get("relief_px")
                or row.get("reported_max_px", 0) < row.get("true_max_px", 0))


def table(rows):
    """The rows as a table in Markdown, as in docs/explanation/calibration.md."""
    boards = any("corners_used" in row for row in rows)
    points = ("corners used; misnumbered; rms / max px" if boards else "whole dots used; false")
    lines = [f"| lens | photos | {points} | relief | map, true: rms / max px | "
             "reported: rms / max px | beyond the points: max px | held-out points: max px |",
             "|---|---|---|---|---|---|---|---|"]
    for row in rows:
        cells = [row["lens"], row["photos"], _points_cell(row)]
        if "true_rms_px" in row:
            beyond = row["reported_beyond_max_px"]
            cells += [f"{row['relief_px']:.3f}",
                      f"{row['true_rms_px']:.3f} / {row['true_max_px']:.3f}",
                      f"{row['reported_rms_px']:.3f} / {row['reported_max_px']:.3f}",
                      "" if beyond is None else f"{beyond:.3f}", f"{row['held_out_max_px']:.3f}"]
        lines.append("| " + " | ".join(map(str, cells)) + " |")
    return "\n".join(lines)


def _points_cell(row):
    """How many points of a row were used, and how well."""
    if "dots_used" not in row and "corners_used" not in row:
        return "exact"
    kind, wrong = (("dots", "dots_false") if "dots_used" in row else
                   ("corners", "corners_misnumbered"))
    used, visible = row[f"{kind}_used"], row[f"{kind}_visible"]
    text = f"{used} of {visible}, {100 * used / max(visible, 1):.1f} %; {row[wrong]}"
    if row.get("corner_rms_px") is not None:
        text += f"; {row['corner_rms_px']:.3f} / {row['corner_max_px']:.3f}"
    return text

"""``ncdc bench calibration``: processor time of calibration and training on large photos."""

import tempfile
from contextlib import nullcontext
from pathlib import Path

from ncdc.cli.common import add_json, write_report
from ncdc.terminal import Steps
from ncdc.text_table import text_table
from ncdc_bench.calibration.measure import rows
from ncdc_bench.calibration.photos import SETS
from ncdc_spec.errors import InputError

__all__ = ["EXAMPLE", "HELP", "add_arguments", "run", "table"]

HELP = ("processor time and true errors of calibrate and train on photos of 8 and 12 million "
        "pixels, compared with another version")
EXAMPLE = "ncdc bench calibration --older ../version-0.1 --json calibration.json"


def add_arguments(parser):
    """Declare the command's arguments on an argparse parser."""
    parser.add_argument("--only", default="", metavar="TEXT",
                        help="sets of photos whose name has this text: " + "; ".join(SETS))
    parser.add_argument("--older", metavar="FOLDER",
                        help="checkout of another version, to be measured in turn")
    parser.add_argument("--folder", metavar="FOLDER",
                        help="where the rendered photos stay for the next time")
    add_json(parser)


def run(args):
    """Render, calibrate, train, compare."""
    names = [name for name in SETS if args.only in name]
    if not names:
        raise InputError(f"no set of photos has {args.only!r} in its name: {'; '.join(SETS)}")
    reference = Path(args.older).resolve() if args.older else None
    if reference and not (reference / "ncdc" / "cli").is_dir():
        raise InputError(f"{args.older} holds no checkout of NCDC")
    if args.folder and not Path(args.folder).is_dir():
        raise InputError(f"the folder {args.folder} does not exist")
    steps = Steps("calibration")
    with nullcontext(args.folder) if args.folder else tempfile.TemporaryDirectory() as folder:
        found = list(rows(Path(folder).resolve(), names, reference, steps))
    steps("done")
    if not write_report({"rows": found}, args.json):
        print(table(found))


def table(found):
    """Rows as text."""
    return text_table(_COLUMNS, found)


def _number(name, form):
    return lambda row: form.format(row[name]) if name in row else "-"


_COLUMNS = (
    ("photos", lambda row: row["photos"]),
    ("command", lambda row: row["command"]),
    ("seconds", _number("seconds", "{:.1f}")),
    ("reference", _number("reference_seconds", "{:.1f}")),
    ("ratio", _number("ratio", "{:.2f}")),
    ("points", _number("points", "{}")),
    ("rms px", lambda row: f"{row.get('points_rms_px', row.get('true_rms_px')):.4f}"),
    ("reference rms px", lambda row: next(
        (f"{row[name]:.4f}" for name in ("reference_points_rms_px", "reference_true_rms_px")
         if name in row), "-")),
)

"""``ncdc bench model``: speed of the bit-exact models."""

from ncdc.cli.common import add_json, report_failures, write_report
from ncdc.terminal import Steps
from ncdc.text_table import text_table
from ncdc_bench.model.measure import SIZES, device_row, model_rows
from ncdc_model.correction import COMPILED

__all__ = ["EXAMPLE", "HELP", "LIMIT", "add_arguments", "run", "table"]

HELP = ("processor time of the compiled and the reference model for a frame, compared with "
        "OpenCV's VNG demosaicing and remapping")
EXAMPLE = "ncdc bench model --json model.json"
LIMIT = 2.0             # times OpenCV's time that the compiled model may take


def add_arguments(parser):
    """Declare the command's arguments on an argparse parser."""
    parser.add_argument("--quick", action="store_true", help="small frames only")
    add_json(parser)


def run(args):
    """Measure and report; 1 if a bit differs or the compiled model takes too long."""
    steps = Steps("model")
    rows = list(model_rows(SIZES[:1] if args.quick else SIZES, steps))
    steps("emulated device")
    device = device_row()
    steps("done")
    if not write_report({"rows": rows, "device": device}, args.json):
        print(table(rows))
        print(f"emulated device, {device['size']} {device['interpolation']}: "
              f"{device['milliseconds']:.1f} ms for a new picture, "
              f"{device['sending_milliseconds']:.1f} ms to send it, "
              f"{device['frames_per_second']:.1f} frames per second on one core")
    name = "{size} {interpolation} {model}".format
    failures = [f"{name(**row)}: {row['bits_different']} bits differ" for row in rows
                if row["bits_different"]]
    failures += [f"{name(**row)}: {row['milliseconds']:.1f} ms, OpenCV takes "
                 f"{row['opencv_milliseconds']:.1f}" for row in rows if row["model"] == COMPILED
                 and row["milliseconds"] > LIMIT * row["opencv_milliseconds"]]
    return report_failures("bench model", failures)


def table(rows):
    """Rows as text."""
    return text_table(_COLUMNS, rows)


_COLUMNS = (
    ("size", lambda row: row["size"]),
    ("interpolation", lambda row: row["interpolation"]),
    ("model", lambda row: row["model"]),
    ("map, ms", lambda row: f"{row['map_milliseconds']:.1f}"),
    ("frame, ms", lambda row: f"{row['milliseconds']:.1f}"),
    ("OpenCV, ms", lambda row: f"{row['opencv_milliseconds']:.1f}"),
    ("bits different", lambda row: str(row["bits_different"])),
)

"""``ncdc bench system``: a running camera, its faults and its readers."""


from ncdc.cli.common import add_json, report_failures, write_report
from ncdc.terminal import Progress
from ncdc.text_table import text_table
from ncdc_bench.system.measure import measure, runs_of

__all__ = ["EXAMPLE", "HELP", "add_arguments", "failures", "run", "table"]

HELP = ("let a camera run from a sensor's pins through memory and corrector, with faults and with "
        "readers at random, and compare every frame with the golden model")
EXAMPLE = "ncdc bench system --quick"
_PREDICTION = .02       # of the clocks, by which the planner may be wrong


def add_arguments(parser):
    """Declare the command's arguments on an argparse parser."""
    parser.add_argument("--camera", default="mt9p031", metavar="NAME",
                        help="sensor: mt9p031 (default), imx219, ...; one with CSI-2 lanes sends "
                             "their bytes to the receiver")
    parser.add_argument("--quick", action="store_true", help="no frames above 640x480: minutes")
    add_json(parser)


def run(args):
    """Measure and report; 1 on a wrong pixel, a torn or lost frame, or an unreported fault."""
    rows = list(measure(runs_of(args.camera, args.quick), lambda run: Progress(str(run))))
    if not write_report({"rows": rows}, args.json):
        print(table(rows))
    return report_failures("bench system", failures(rows))


def failures(rows):
    """Sentences on what went wrong in ``rows``."""
    found = []
    for row in rows:
        name = row["fault"] or f"{row['width']}x{row['height']} on {row['memory']}"
        if row["csi_faults"] and not row["fault"]:
            found.append(f"{name}: the receiver counted {row['csi_faults']} faults")
        if row["pixels_different"]:
            found.append(f"{name}: {row['pixels_different']} pixels differ")
        if row["frames_torn"]:
            found.append(f"{name}: {row['frames_torn']} frames were torn")
        if row["camera_bytes_dropped"] and row["fault"] is None:
            found.append(f"{name}: {row['camera_bytes_dropped']} bytes of the camera were dropped")
        predicted, bound = row["predicted_clocks_per_pixel"], row["follow_bound_clocks"]
        if predicted and abs(row["clocks_per_pixel"] / predicted - 1) > _PREDICTION:
            found.append(f"{name}: {predicted:.4f} clocks per pixel were predicted, "
                         f"{row['clocks_per_pixel']:.4f} are measured")
        if bound and row["follow_latency_clocks"] > bound:
            found.append(f"{name}: a frame that follows its camera came "
                         f"{row['follow_latency_clocks']} clocks after it, the bound is {bound}")
        if row["recovered"] is False:
            found.append(f"{name}: the fault was not reported")
    return found


def table(rows):
    """Rows of :func:`ncdc_bench.system.measure.measure` as text."""
    return text_table(_COLUMNS, rows)


def _clocks(name):
    return lambda row: "-" if row[name] is None else f"{row[name]:.4f}"


_COLUMNS = (
    ("camera", lambda row: row["camera"]),
    ("lanes", lambda row: row["lanes"] or "-"),
    ("size", lambda row: f"{row['width']}x{row['height']}"),
    ("memory", lambda row: row["memory"]),
    ("to", lambda row: row["output"]),
    ("after its camera", lambda row: (
        f"{row['follow_latency_clocks']} of {row['follow_bound_clocks']} clocks"
        if row["follow"] else "-")),
    ("fault", lambda row: row["fault"] or "-"),
    ("frames", lambda row: row["frames"]),
    ("pixels", lambda row: row["pixels_compared"]),
    ("wrong", lambda row: row["pixels_different"]),
    ("torn", lambda row: row["frames_torn"]),
    ("dropped", lambda row: row["camera_bytes_dropped"]),
    ("clocks/px", _clocks("clocks_per_pixel")),
    ("predicted", _clocks("predicted_clocks_per_pixel")),
    ("recovered", lambda row: {None: "-", True: "yes", False: "no"}[row["recovered"]]),
)

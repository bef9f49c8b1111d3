"""``ncdc bench system``: a running camera, its faults and its readers."""

from ncdc.cli.common import add_json, report_failures, write_report
from ncdc.terminal import Progress
from ncdc.text_table import text_table
from ncdc_bench.system import uhd
from ncdc_bench.system.measure import measure, runs_of
from ncdc_spec.errors import InputError

__all__ = ["EXAMPLE", "HELP", "add_arguments", "failures", "run", "table"]

HELP = ("let a camera run from a sensor's pins through memory and corrector, with faults and with "
        "readers at random, and compare every frame with the golden model")
EXAMPLE = "ncdc bench system --quick"
_PREDICTION = .02       # of the clocks, by which the planner may be wrong
_CAMERA = "mt9p031"


def add_arguments(parser):
    """Declare the command's arguments on an argparse parser."""
    parser.add_argument("--camera", metavar="NAME",
                        help=f"sensor: {_CAMERA} (default), imx219, ...; one with CSI-2 lanes "
                             "sends their bytes to the receiver")
    which = parser.add_mutually_exclusive_group()
    which.add_argument("--quick", action="store_true", help="no frames above 640x480: minutes")
    which.add_argument("--uhd", action="store_true",
                       help="only a camera of 3840x2160 at 60 frames per second, four samples and "
                            "four pixels per clock: minutes")
    add_json(parser)


def run(args):
    """Measure and report; 1 on a wrong pixel, a torn or lost frame, or an unreported fault."""
    if args.uhd:
        return _uhd(args)
    runs = runs_of(args.camera or _CAMERA, args.quick)
    rows = list(measure(runs, lambda run: Progress(str(run))))
    if not write_report({"rows": rows}, args.json):
        print(table(rows))
    return report_failures("bench system", failures(rows))


def _uhd(args):
    """Measure and report frames of 3840x2160; 1 if one is wrong, late or lost."""
    if args.camera:
        raise InputError(f"--uhd and --camera {args.camera} are given, the camera of --uhd is none "
                         "of the sensors")
    rows = list(uhd.measure(uhd.RUNS, lambda run: Progress(str(run))))
    if not write_report({"rows": rows}, args.json):
        print(text_table(_UHD_COLUMNS, rows))
    return report_failures("bench system", uhd.failures(rows))


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
_UHD_COLUMNS = (
    ("colour", lambda row: row["interpolation"]),
    ("memory", lambda row: f"{row['memory']}@{row['clock_mhz']}"),
    ("cache", lambda row: f"{row['cache_bytes'] // 1024} KB"),
    ("frames", lambda row: str(row["frames"])),
    ("wrong", lambda row: str(row["pixels_different"])),
    ("skipped", lambda row: str(row["frames_skipped"])),
    ("lost", lambda row: str(row["frames_lost"])),
    ("clocks", lambda row: str(row["clocks"])),
    ("predicted", lambda row: str(row["predicted_clocks"])),
    ("clocks/px", lambda row: f"{row['clocks_per_pixel']:.5f}"),
    ("fps", lambda row: f"{row['frames_per_second']:.2f}"),
    ("MB read", lambda row: f"{row['bytes_read'] / 1e6:.2f}"),
    ("MB written", lambda row: f"{row['bytes_written'] / 1e6:.2f}"),
    ("/distinct", lambda row: f"{row['amplification']:.3f}"),
    ("load", lambda row: f"{row['memory_load']:.0%}"),
)

"""``ncdc bench window``: how long an event keeps the client's window from the next one."""

from pathlib import Path

from ncdc.cli.common import add_json, write_report
from ncdc.terminal import Steps
from ncdc_bench.window.measure import measure, serve

__all__ = ["EXAMPLE", "HELP", "add_arguments", "run"]

HELP = "the client's window on two emulated devices: what an event of its thread takes"
EXAMPLE = "ncdc bench window -o figures"


def add_arguments(parser):
    """Declare the command's arguments on an argparse parser."""
    parser.add_argument("-o", "--output", metavar="DIR", help="folder for screenshots")
    parser.add_argument("--seconds", type=float, default=4.0, metavar="S",
                        help="of each step (default: 4)")
    add_json(parser)


def run(args):
    """Measure and report."""
    step = Steps("window")
    folder = Path(args.output) if args.output else None
    if folder:
        folder.mkdir(parents=True, exist_ok=True)
    step("preparing two devices")
    process, (first, second) = serve()
    try:
        rows = measure((first, second), folder, args.seconds, step)
    finally:
        process.stdin.close()
        process.wait()
    step("done")
    if write_report({"rows": rows}, args.json):
        return
    print(f"{'':20} {'events':>7} {'longest ms':>11} {'CPU ms':>7} {'> 50 ms':>8}  slowest")
    for row in rows:
        print(f"{row['window']:20} {row['events']:7} {row['event_max_ms']:11.1f} "
              f"{row['event_cpu_max_ms']:7.1f} {row['events_over_50_ms']:8}  "
              f"{row['slowest_event']}")

"""``ncdc plan``: cache, scan and speed of a trained map, before any Verilog exists."""

from ncdc_hdl.avalon.register_table import host_values
from ncdc_hdl.cli.common import Progress, add_json, write_report
from ncdc_hdl.corrector import DATA_WIDTHS, OUTPUTS
from ncdc_model.descriptor import Descriptor
from ncdc_model.errors import InputError
from ncdc_model.fetch.plan import CLOCK_MHZ, plan

__all__ = ["EXAMPLE", "HELP", "add_arguments", "add_choices", "frame_places", "run", "summary"]

HELP = "choose cache, split and strips for a trained map, and predict its speed on a memory"
EXAMPLE = "ncdc plan net.toml --memory ddr3 --clock 150 --to stream"


def add_choices(parser):
    """Declare the options that fix what the planner would choose."""
    parser.add_argument("--cache-bytes", type=int, metavar="N",
                        help="samples that the cache holds, a power of two (default: planned)")
    parser.add_argument("--split", type=int, metavar="S",
                        help="log2 of the cache's sets that count columns (default: planned)")
    parser.add_argument("--strip", type=int, metavar="COLUMNS",
                        help="scan strips of so many columns, a multiple of 32; 0: raster "
                             "(default: planned)")


def add_arguments(parser):
    """Declare the command's arguments on an argparse parser."""
    parser.add_argument("descriptor", metavar="NET", help="descriptor of ncdc train")
    parser.add_argument("--memory", default="ddr3", metavar="NAME",
                        help="ideal, sdram, ddr3 (default) or fixed:LATENCY:BYTES, a latency in "
                             "clocks and bytes per clock")
    parser.add_argument("--clock", type=float, default=CLOCK_MHZ, metavar="MHZ",
                        help=f"clock of the corrector (default: {CLOCK_MHZ:g})")
    parser.add_argument("--data-width", type=int, choices=DATA_WIDTHS, metavar="BITS",
                        help="width of the memory port: 32, 64 or 128 (default: 128 on ddr3, "
                             "32 elsewhere)")
    parser.add_argument("--to", choices=OUTPUTS, default="memory",
                        help="where corrected pixels go: memory (default) or a video stream, "
                             "which takes raster order only")
    add_choices(parser)
    parser.add_argument("--rate", type=float, metavar="FPS",
                        help="refuse what does not correct so many frames per second")
    add_json(parser)


def run(args):
    """Plan and report."""
    if not 1 <= args.clock <= 1000:
        raise InputError(f"the clock is {args.clock:g} MHz, the limits are 1 and 1000")
    descriptor = Descriptor.load(args.descriptor)
    width = args.data_width or (128 if args.memory == "ddr3" else 32)
    planned = plan(descriptor, memory=args.memory, clock_mhz=args.clock, data_width=width,
                   stream=args.to == "stream", cache_bytes=args.cache_bytes, split=args.split,
                   strip=args.strip, rate=args.rate, **frame_places(descriptor, width),
                   progress=Progress("planning"))
    report = {"digest": descriptor.digest, "output": args.to, **planned.report()}
    if write_report(report, args.json):
        return
    print(summary(planned))
    print(f"{planned.clocks_per_pixel:.4f} clocks per pixel, {planned.frames_per_second:.1f} "
          f"frames per second predicted ({args.memory}, {width} bits, {args.clock:g} MHz)")
    print(f"{planned.worst:.2f} bytes per pixel in the worst 8192 pixels; "
          f"{planned.live} bytes of tiles in use at once")


def frame_places(descriptor, data_width):
    """Where the frames lie after configuration, as keyword arguments of the planner."""
    values = host_values(descriptor, data_width)
    return {"base": values["SOURCE_BASE"], "pitch": values["SOURCE_PITCH"],
            "target": values["TARGET_BASE"]}


def summary(planned):
    """One line on what a plan chose and reads."""
    report = planned.report()
    scan = f"strips of {planned.strip} columns" if planned.strip else "raster scan"
    return (f"cache of {report['cache_bytes']} bytes, split {planned.split}, {scan}: "
            f"{report['bytes_read_per_pixel']:.3f} bytes read per pixel, "
            f"{planned.amplification:.3f} times the distinct bytes")


"""``ncdc plan``: cache, scan and speed of a trained map, before any Verilog exists."""

from ncdc_hdl.avalon.register_table import host_values
from ncdc_hdl.cli.common import Progress, add_json, write_report
from ncdc_hdl.corrector import DATA_WIDTHS, OUTPUTS
from ncdc_hdl.options import LANES, FetchOptions
from ncdc_model.descriptor import Descriptor
from ncdc_model.errors import InputError
from ncdc_model.fetch.cache_options import CacheOptions
from ncdc_model.fetch.follow import camera_line, follow_bound
from ncdc_model.fetch.lookups import frame_windows
from ncdc_model.fetch.plan import CLOCK_MHZ, candidates, choose, plan
from ncdc_model.fetch.traffic import TILE_BYTES, distinct_bytes
from ncdc_model.memory_timing import memory_timing

__all__ = ["EXAMPLE", "HELP", "add_arguments", "add_choices", "add_follow", "check_follow",
           "frame_places", "planned_fetch", "run"]

HELP = "choose cache, split and strips for a trained map, and predict its speed on a memory"
EXAMPLE = "ncdc plan net.toml --memory ddr3 --clock 150 --to stream"
_LONG = 1 << 20         # pixels of a frame from which on planning shows its progress


def add_choices(parser):
    """Declare the options that fix what the planner would choose."""
    parser.add_argument("--cache-bytes", type=int, metavar="N",
                        help="samples that the cache holds, a power of two (default: planned)")
    parser.add_argument("--cache-split", type=int, metavar="S",
                        help="log2 of the tile pairs along a row that have sets of their own "
                             "(default: planned)")
    parser.add_argument("--strip", type=int, metavar="COLUMNS",
                        help="make pixels in strips of so many columns, a multiple of 32, or row "
                             "by row, 0; a stream takes 0 only (default: planned); same results")


def add_follow(parser):
    """Declare the options of a frame that begins before the camera's is complete."""
    parser.add_argument("--follow", action="store_true",
                        help="begin with the camera's frame, and wait for its rows; raster order "
                             "unless --strip is given")
    parser.add_argument("--camera-line", type=int, metavar="CLOCKS",
                        help="clocks of a row of the camera with --follow, of which it sends a "
                             "sample in each of the first ones (default: its samples)")


def check_follow(args, geometry):
    """Settle what --follow means for the other options.

    Raises
    ------
    InputError
        If a row of the camera does not fit, or is given without --follow.
    """
    if args.camera_line is not None and not args.follow:
        raise InputError(f"the camera's line is {args.camera_line} clocks, which needs --follow")
    if args.follow:
        camera_line(args.camera_line, geometry)
        # A strip needs nearly all rows of the raw frame at once.
        args.strip = args.strip or 0


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
    parser.add_argument("--pixels-per-clock", type=int, choices=LANES, default=1, metavar="N",
                        help="1 (default), 2 or 4")
    parser.add_argument("--rate", type=float, metavar="FPS",
                        help="refuse what does not correct so many frames per second")
    add_follow(parser)
    add_json(parser)


def run(args):
    """Plan and report."""
    if not 1 <= args.clock <= 1000:
        raise InputError(f"the clock is {args.clock:g} MHz, the limits are 1 and 1000")
    descriptor = Descriptor.load(args.descriptor)
    check_follow(args, descriptor.geometry)
    width = args.data_width or (128 if args.memory == "ddr3" else 32)
    planned = plan(descriptor, memory=args.memory, clock_mhz=args.clock, data_width=width,
                   lanes=args.pixels_per_clock,
                   stream=args.to == "stream", cache_bytes=args.cache_bytes, split=args.cache_split,
                   strip=args.strip, rate=args.rate, **frame_places(descriptor, width),
                   progress=Progress("planning"))
    bound = follow_bound(
        descriptor, planned.options, planned.split, memory_timing(
            f"{args.memory}@{args.clock:g}" if args.memory in ("sdram", "ddr3") else args.memory),
        width, strip=planned.strip, lanes=args.pixels_per_clock, stream=args.to == "stream",
        line=args.camera_line, **frame_places(descriptor, width),
        progress=Progress("following")) if args.follow else None
    report = {"digest": descriptor.digest, "output": args.to, **planned.report(),
              **(bound.report() if bound else {})}
    if write_report(report, args.json):
        return
    report = planned.report()
    print(choice_line(planned.options, planned.split, planned.strip,
                      report["bytes_read_per_pixel"], planned.amplification))
    print(f"{planned.clocks_per_pixel:.4f} clocks per pixel, {planned.frames_per_second:.1f} "
          f"frames per second predicted ({args.memory}, {width} bits, {args.clock:g} MHz)")
    print(f"{planned.worst:.2f} bytes per pixel in the worst 8192 pixels; "
          f"{planned.live} bytes of tiles in use at once")
    if bound:
        print(f"with the camera's frame: out at most {bound.clocks} clocks after its last byte, "
              f"{100 * bound.share:.1f} % of its {bound.camera_clocks}")


def frame_places(descriptor, data_width):
    """Where the frames lie after configuration, as keyword arguments of the planner."""
    values = host_values(descriptor, data_width)
    return {"base": values["SOURCE_BASE"], "pitch": values["SOURCE_PITCH"],
            "target": values["TARGET_BASE"]}


def choice_line(options, split, strip, bytes_read, amplification):
    """One line on a choice and what it reads per pixel and per distinct byte."""
    scan = f"strips of {strip} columns" if strip else "raster scan"
    return (f"cache of {options.bytes} bytes, split {split}, {scan}: {bytes_read:.3f} bytes read "
            f"per pixel, {amplification:.3f} times the distinct bytes")


def planned_fetch(args, descriptor):
    """The fetcher that a command's options choose, what they leave open planned for the map.

    Returns
    -------
    FetchOptions
    str or None
        A line on the choice; None where nothing was left open.

    Raises
    ------
    InputError
        If an option is outside its limits.
    """
    fixed = args.cache_bytes, args.cache_split, args.strip
    if args.fetch != "cache":
        return FetchOptions(args.fetch, strip=args.strip or 0), None
    if None not in fixed:
        return FetchOptions("cache", CacheOptions.of_bytes(args.cache_bytes), *fixed[1:]), None
    geometry = descriptor.geometry
    width, height = geometry.corrected
    sizes, strips = candidates(width, stream=args.to == "stream", cache_bytes=args.cache_bytes,
                               split=args.cache_split, strip=args.strip)
    progress = Progress("planning") if width * height >= _LONG else lambda fraction: None
    windows = frame_windows(descriptor, lambda done, total: progress(.7 * done / total))
    distinct = distinct_bytes(windows, geometry)
    choice = choose(windows, distinct, sizes, strips, args.cache_split,
                    lambda fraction: progress(.7 + .3 * fraction))[0]
    read = choice.misses * TILE_BYTES
    return (FetchOptions("cache", choice.options, choice.split, choice.strip),
            choice_line(choice.options, choice.split, choice.strip, read / (width * height),
                        read / max(1, distinct)))

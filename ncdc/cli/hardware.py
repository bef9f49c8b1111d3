"""The options that choose the hardware, and what the planner makes of those left open."""

from dataclasses import replace

from ncdc.terminal import Progress
from ncdc_model.planner.lookups import frame_windows
from ncdc_model.planner.plan import Fixed, choose
from ncdc_model.planner.traffic import distinct_bytes
from ncdc_spec.cache_options import TILE_MEMORIES
from ncdc_spec.frames import check_format, output_format
from ncdc_spec.hardware import (
    BUSES,
    DATA_WIDTHS,
    FETCHERS,
    FORMATS,
    HIDDEN,
    LANES,
    MULTIPLIER_BITS,
    OUTPUTS,
    VIDEOS,
    Hardware,
)
from ncdc_spec.nodes import row_nodes
from ncdc_spec.view_list import MAX_VIEWS
from ncdc_spec.view_rows import MAX_MATRICES, MIN_MATRICES

__all__ = ["add_bus", "add_fixed", "add_format", "add_hardware", "add_lanes", "add_reductions",
           "add_single_view", "add_view_registers", "choice_line", "fixed_of", "front_end_line",
           "hardware_of", "planned"]

_LONG = 1 << 20         # pixels of a frame from which on planning shows its progress


def add_fixed(parser):
    """Declare the options that fix what the planner would choose."""
    parser.add_argument("--cache-bytes", type=int, metavar="N",
                        help="samples that the cache holds, a power of two (default: planned)")
    parser.add_argument("--cache-split", type=int, metavar="S",
                        help="log2 of the tile pairs along a row that have sets of their own "
                             "(default: planned)")
    parser.add_argument("--cache-pending", type=int, metavar="N",
                        help="look-ups that wait for their tiles, at most, a power of two "
                             "(default: 128); more hide more of the memory's latency")
    parser.add_argument("--cache-outstanding", type=int, metavar="N",
                        help="tiles that are asked for and have not come, at most 64 (default: 16 "
                             "of 64 bytes, 32 of 32 bytes)")
    parser.add_argument("--strip", type=int, metavar="COLUMNS",
                        help="make pixels in strips of so many columns, a multiple of 32, or row "
                             "by row, 0; a stream takes 0 only (default: planned); same results")


def add_lanes(parser):
    """Declare the option --pixels-per-clock."""
    parser.add_argument("--pixels-per-clock", type=int, choices=LANES, default=1, metavar="N",
                        help="1 (default), 2 or 4 neighbouring pixels at a time; without nodes "
                             "each has a network of its own; same results")


def add_format(parser):
    """Declare the option --format."""
    parser.add_argument("--format", choices=FORMATS, default=FORMATS[0],
                        help="bytes of a pixel in memory, after configuration: BGRX8 (default; "
                             "blue, green, red, zero), BGR8 without the zero, or Mono8, of a grey "
                             "sensor; a stream has no such choice")


def add_hardware(parser):
    """Declare the options that choose the hardware."""
    parser.add_argument("--fetch", choices=FETCHERS, default=FETCHERS[0],
                        help="how raw windows are read: cache (default), a prefetching cache of "
                             "tiles, or multiport, the paper's three burst readers")
    add_fixed(parser)
    add_lanes(parser)
    parser.add_argument("--data-width", type=int, choices=DATA_WIDTHS, metavar="BITS",
                        help="width of the memory ports: 32 (default), 64 or 128")
    parser.add_argument("--to", choices=OUTPUTS,
                        help="where corrected pixels go: memory (default) or a video stream")
    add_format(parser)
    parser.add_argument("--hidden", choices=HIDDEN, default="multiply",
                        help="hidden neurons: multiply (default), or raster, which add from pixel "
                             "to pixel and need no multiplier; same results")
    parser.add_argument("--share", type=int, metavar="N",
                        help="hidden neurons per tan-sigmoid: a pixel, or a node, every N clocks; "
                             "same results, smaller (default: as many as keep a pixel per "
                             "clock, which without nodes is 1)")
    parser.add_argument("--multiplier-bits", type=int, choices=MULTIPLIER_BITS, metavar="BITS",
                        help="width of the device's multiplier blocks: 27 (default), or 18, for "
                             "which products are cut into parts; same results")
    parser.add_argument("--tile-memory", choices=TILE_MEMORIES, default=TILE_MEMORIES[0],
                        help="of the tile cache: blocks (default) of RAM, or, for a device that is "
                             "short of them, luts for half of it, or shared, half as many blocks, "
                             "a little slower; same results")
    parser.add_argument("--colour", action="store_true",
                        help="with registers for white balance and a tone curve, which change no "
                             "pixel until they are written, and sums of a frame's colours")


def add_single_view(parser):
    """Declare the option --view."""
    parser.add_argument("--view", action="store_true",
                        help="with registers for the matrix of a view (pan, tilt, zoom, roll), "
                             "which changes no pixel until it is written; needs a network at nodes")


def add_view_registers(parser):
    """Declare the options --view, --views and --view-rows."""
    add_single_view(parser)
    parser.add_argument("--views", type=int, default=0, metavar="N",
                        help=f"with --view, a list of up to N views, 2 to {MAX_VIEWS}, that each "
                             "start makes of one raw frame, in parts of one picture in memory")
    parser.add_argument("--view-rows", type=int, default=0, metavar="N",
                        help=f"with a view, and a table of N matrices down the raw frame, "
                             f"{MIN_MATRICES} to {MAX_MATRICES}, for a rolling shutter")


def add_reductions(parser):
    """Declare the options that leave registers out."""
    parser.add_argument("--fixed-lens", action="store_true",
                        help="lens, sizes, format and strips are constants, without registers: "
                             "smaller, and it corrects this camera alone")
    parser.add_argument("--no-follow", action="store_true",
                        help="without early start: a frame begins when its raw frame is complete")
    parser.add_argument("--no-counters", action="store_true",
                        help="without the counters of a frame's clocks, pixels, tiles and stalls")


def add_bus(parser):
    """Declare the option --bus."""
    parser.add_argument("--bus", choices=BUSES, default=BUSES[0],
                        help="ports for Avalon-MM and Avalon-ST (avalon, default), or for AXI4, "
                             "AXI4-Lite and AXI4-Stream (axi); same results")
    parser.add_argument("--video", choices=VIDEOS, default=VIDEOS[0],
                        help="packets of a stream on Avalon: one of pixels per frame (plain, "
                             "default), or those of Intel's Video and Image Processing Suite, with "
                             "a control packet before each frame (vip)")


def fixed_of(args, strip=None):
    """:class:`Fixed` of a command's options; ``strip`` counts where they leave it open."""
    return Fixed(args.cache_bytes, args.cache_split, strip if args.strip is None else args.strip,
                 args.cache_pending, args.cache_outstanding)


def hardware_of(args, board=None):
    """:class:`Hardware` of a command's options; the ``board`` chooses those that are not given.

    Tile cache, split and strips are left to :func:`planned`.
    """
    chosen = {"data_width": args.data_width, "output": args.to,
              "multiplier_bits": args.multiplier_bits}
    if board:
        offered = {"data_width": board.data_width, "output": "stream",
                   "multiplier_bits": board.multiplier_bits}
        chosen = {name: offered[name] if value is None else value for name, value in chosen.items()}
    rows = getattr(args, "view_rows", 0)
    return Hardware(fetcher=args.fetch, hidden=args.hidden, share=args.share,
                    lanes=args.pixels_per_clock, format=args.format, colour=args.colour,
                    raw_balance=(getattr(args, "raw_gains", False)
                                 or getattr(args, "raw_balance", None) is not None),
                    view=getattr(args, "view", False) or rows != 0, view_rows=rows,
                    views=getattr(args, "views", 0),
                    tile_memory=args.tile_memory, fixed_lens=getattr(args, "fixed_lens", False),
                    follow=not getattr(args, "no_follow", False),
                    counters=not getattr(args, "no_counters", False),
                    bus=getattr(args, "bus", BUSES[0]), video=getattr(args, "video", VIDEOS[0]),
                    **{name: value for name, value in chosen.items() if value is not None})


def choice_line(hardware, bytes_read, amplification):
    """One line on tile cache, split and scan, and what is read per pixel and distinct byte."""
    scan = f"strips of {hardware.strip} columns" if hardware.strip else "raster scan"
    return (f"cache of {hardware.cache.bytes} bytes, split {hardware.split}, {scan}: "
            f"{bytes_read:.3f} bytes read per pixel, {amplification:.3f} times the distinct bytes")


def front_end_line(hardware, descriptor):
    """One line on where the network is evaluated, by how many units, and which pixels wait."""
    d = descriptor
    units, share = hardware.units(d.hidden_neurons), hardware.share
    if d.nodes == 1:
        return f"network at every pixel: {units} tan-sigmoids, a coordinate every {share} clocks"
    width = d.geometry.corrected_width
    columns = min(hardware.strip or width, width)
    return (f"network at every {d.nodes}th pixel: {row_nodes(columns, d.nodes)} nodes for "
            f"{columns} columns, a node every {max(share, hardware.min_node_clocks)} clocks from "
            f"{units} tan-sigmoid{'s' if units > 1 else ''} for {d.hidden_neurons} neurons, "
            f"{hardware.node_clocks(d)} would be enough"
            + ("" if hardware.keeps_rate(d) else _waits(hardware, d)))


def _waits(hardware, descriptor):
    """Clocks of a row in which pixels wait for nodes, and a distance of nodes without waits."""
    groups, clocks = hardware.row_clocks(descriptor)
    better = hardware.nodes_at_rate(descriptor)
    return (f": pixels wait for nodes, {clocks} clocks for the {groups} groups of a row"
            + (f"; trained with --nodes {better[0]} they would not" if better else ""))


def planned(hardware, fixed, descriptor):
    """:func:`_planned_cache`, with the number of shared units; raises its errors and those of
    :meth:`Hardware.made_for`."""
    hardware, line = _planned_cache(hardware, fixed, descriptor)
    return hardware.made_for(descriptor), line


def _planned_cache(hardware, fixed, descriptor):
    """``hardware`` with tile cache, split and strips: what is ``fixed``, the rest planned.

    Returns
    -------
    Hardware
    str or None
        A line on the choice; None where nothing was left open.

    Raises
    ------
    InputError
        If an option is outside its limits, or the format would lose the camera's colours.
    """
    geometry = descriptor.geometry
    check_format(output_format(hardware.format), geometry)
    if not hardware.cached:
        return replace(hardware, strip=fixed.strip or 0), None
    if fixed.everything:
        return replace(hardware, cache=fixed.caches(geometry.interpolation)[0],
                       split=fixed.split, strip=fixed.strip), None
    width, height = geometry.corrected
    fixed.strips(width, hardware.stream)        # raises InputError before the long work
    progress = Progress("planning") if width * height >= _LONG else lambda fraction: None
    windows = frame_windows(descriptor, lambda done, total: progress(.7 * done / total))
    distinct = distinct_bytes(windows, geometry)
    choice = choose(windows, distinct, geometry, hardware, fixed,
                    lambda fraction: progress(.7 + .3 * fraction))[0]
    read = choice.bytes_read
    return choice.hardware, choice_line(choice.hardware, read / (width * height),
                                        read / max(1, distinct))

"""``ncdc plan``: cache, scan and speed of a trained map, before any Verilog exists."""

from fractions import Fraction

from ncdc.cli.board_design import add_mode
from ncdc.cli.common import add_json, write_report
from ncdc.cli.field import add_field, field_of, field_report
from ncdc.cli.follow import add_follow, bound_of, follow_strip
from ncdc.cli.hardware import (
    add_fixed,
    add_format,
    add_lanes,
    choice_line,
    fixed_of,
    front_end_line,
)
from ncdc.cli.plan_board import plan_board
from ncdc.cli.renamed import add_renamed
from ncdc.cli.view_range import add_view_range, angles_text, report_lines, view_range_of
from ncdc.terminal import Progress
from ncdc_hdl.corrector import Corrector
from ncdc_model.planner.memory_timing import memory_at
from ncdc_model.planner.plan import CLOCK_MHZ, plan
from ncdc_model.planner.views import ViewPlanner
from ncdc_model.planner.with_camera import clocks_with_camera
from ncdc_model.view_nodes import errors_report, worst_node_errors
from ncdc_spec.descriptor import Descriptor
from ncdc_spec.errors import InputError
from ncdc_spec.hardware import DATA_WIDTHS, OUTPUTS, Hardware
from ncdc_spec.sensors.catalogue import SENSORS
from ncdc_spec.sensors.framing import setup_around

__all__ = ["EXAMPLE", "add_arguments", "run"]

_NAMES = [sensor.name for sensor in SENSORS]
_EXPOSURE_US = 1000.0           # short: the sensor sends as many frames as it can
EXAMPLE = "ncdc plan net.toml --memory ddr3 --core-mhz 150 --to stream"


def add_arguments(parser) -> None:
    """Declare the command's arguments on an argparse parser."""
    parser.add_argument("descriptor", metavar="NET", help="descriptor of ncdc train")
    parser.add_argument("--board", metavar="NAME",
                        help="whether a board of ncdc build carries the picture on its memory and "
                             "its screen, as well as --sensor (default: mt9p031)")
    add_mode(parser)
    parser.add_argument("--system", action="store_true",
                        help="the board with a processor, which sends each corrected picture")
    parser.add_argument("--memory", default="ddr3", metavar="NAME",
                        help="ideal, sdram, ddr3 (default) or fixed:LATENCY:BYTES, a latency in "
                             "clocks and bytes per clock")
    parser.add_argument("--core-mhz", dest="clock", type=float, metavar="MHZ",
                        help=f"clock of the corrector (default: {CLOCK_MHZ:g})")
    add_renamed(parser, "--clock", "--core-mhz", dest="clock", type=float)
    parser.add_argument("--data-width", type=int, choices=DATA_WIDTHS, metavar="BITS",
                        help="width of the memory port: 32, 64 or 128 (default: 128 on ddr3, "
                             "32 elsewhere)")
    parser.add_argument("--to", choices=OUTPUTS, default="memory",
                        help="where corrected pixels go: memory (default) or a video stream, "
                             "which takes raster order only")
    add_fixed(parser)
    add_lanes(parser)
    add_format(parser)
    parser.add_argument("--min-fps", dest="rate", type=float, metavar="FPS",
                        help="exit with an error below so many corrected frames per second")
    add_renamed(parser, "--rate", "--min-fps", dest="rate", type=float)
    parser.add_argument("--sensor", dest="camera", metavar="NAME",
                        help="also the clocks of a running system, in which this sensor's frames "
                             f"come to the same memory meanwhile: {', '.join(_NAMES)}")
    add_renamed(parser, "--camera", "--sensor", dest="camera")
    add_field(parser)
    add_follow(parser)
    add_view_range(parser.add_argument_group("range of views", (
        "for hardware with --view: the plan is that of the slowest view")))
    add_json(parser)


def run(args) -> None:
    """Plan and report."""
    if args.board:
        plan_board(args, Descriptor.load(args.descriptor))
        return
    if args.mode:
        raise InputError(f"--mode {args.mode} is of a board: --board NAME is needed")
    if args.system:
        raise InputError("--system is of a board: --board NAME is needed")
    if args.field is not None and not args.camera:
        raise InputError(f"--field {args.field} is of a sensor: --camera NAME or --board NAME is "
                         "needed")
    args.clock = CLOCK_MHZ if args.clock is None else args.clock
    if not 1 <= args.clock <= 1000:
        raise InputError(f"the clock is {args.clock:g} MHz, the limits are 1 and 1000")
    descriptor = Descriptor.load(args.descriptor)
    views = view_range_of(args, descriptor)
    if views and args.follow:
        raise InputError("--follow is given with a range of views, ncdc simulate --follow has the "
                         "bound of one view")
    framing = setup_around(args.camera, descriptor.geometry, field=field_of(args),
                           exposure_us=_EXPOSURE_US) if args.camera else None
    fixed = fixed_of(args, follow_strip(args, descriptor.geometry))
    width = args.data_width or (128 if args.memory == "ddr3" else 32)
    hardware = Hardware(data_width=width, output=args.to, lanes=args.pixels_per_clock,
                        format=args.format, view=views is not None)
    planned = _planned(args, descriptor, hardware, fixed, views)
    bound = bound_of(args, descriptor, planned.hardware, memory_at(args.memory, args.clock))
    made = planned.hardware.made_for(descriptor)
    report = planned.report() | {"nodes": descriptor.nodes, "share": made.share,
                                 "tansigs": made.units(descriptor.hidden_neurons)}
    report |= _with_camera(args, descriptor, planned, framing, views)
    if views:
        report |= errors_report(views, worst_node_errors(descriptor, views, descriptor.nodes,
                                                         Progress("nodes")))
    if write_report({"digest": descriptor.digest, "output": args.to, **report,
                     **(bound.report() if bound else {})}, args.json):
        return
    print(choice_line(planned.hardware, report["bytes_read_per_pixel"], report["amplification"]))
    print(front_end_line(made, descriptor))
    print(f"{report['predicted_clocks_per_pixel']:.4f} clocks per pixel, "
          f"{report['frames_per_second']:.1f} frames per second predicted ({args.memory}, "
          f"{width} bits, {args.clock:g} MHz)")
    print(f"{report['worst_bytes_per_pixel']:.2f} bytes per pixel in the worst 8192 pixels; "
          f"{report['live_bytes']} bytes of tiles in use at once")
    for line in _view_lines(report):
        print(line)
    if bound:
        print(f"with the camera's frame: out at most {bound.clocks} clocks after its last byte, "
              f"{100 * bound.share:.1f} % of its {bound.camera_clocks}")
    if args.camera:
        print(f"{report['beside_camera_clocks_per_pixel']:.4f} clocks per pixel while the "
              f"{args.camera} writes its next frames, {report['camera_frames_per_second']:.1f} per "
              f"second")


def _planned(args, descriptor, hardware, fixed, views):
    """The :class:`Plan` of the trained picture, or the :class:`ViewPlan` of ``views``."""
    def timing(chosen):
        return Corrector(descriptor, chosen).timing
    options = {"fixed": fixed, "rate": args.rate, "progress": Progress("planning")}
    if views:
        return ViewPlanner(descriptor, args.memory, timing, views, args.clock).plan(
            hardware, **options)
    return plan(descriptor, hardware, args.memory, timing, clock_mhz=args.clock, **options)


def _view_lines(report):
    """Lines on the worst views of a range; none without it."""
    if "views" in report:
        count = report["views_scanned"]
        yield (f"these are of the slowest of {count} view{'s' * (count > 1)} tried, "
               f"{angles_text(report['slowest_view'])}; with a margin for views between them, at "
               f"most {report['bound_clocks_per_pixel']:.4f} clocks per pixel")
        yield (f"at most {report['most_bytes_read_per_pixel']:.3f} bytes are read per pixel, at "
               f"{angles_text(report['most_bytes_view'])}")
        yield from report_lines(report)


def _with_camera(args, descriptor, planned, framing, views):
    """Entries of the report with a running camera; ``framing``: its configuration and crop, or
    None."""
    if framing is None:
        return {}
    setup, crop = framing
    timing = crop.arriving(setup.timing)
    clocks = clocks_with_camera(
        descriptor, planned.hardware, memory_at(args.memory, args.clock),
        Corrector(descriptor, planned.hardware).timing, timing,
        Fraction(args.clock * 1e6) / timing.pixel_clock_hz,
        views.view(planned.slowest_at) if views else None)
    pixels = planned.slowest.pixels if views else planned.pixels
    return {"beside_camera_clocks_per_pixel": clocks / pixels,
            "camera_frames_per_second": setup.timing.frames_per_second,
            **field_report(setup, crop, descriptor.geometry)}

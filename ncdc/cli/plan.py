"""``ncdc plan``: cache, scan and speed of a trained map, before any Verilog exists."""

import re

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
from ncdc.cli.plan_system import (
    add_system,
    camera_of,
    check_carried,
    check_system,
    system_lines,
    system_of,
)
from ncdc.cli.renamed import add_renamed
from ncdc.cli.view_range import add_view_range, angles_text, report_lines, view_range_of
from ncdc.planned_timing import planned_timing
from ncdc.terminal import Progress
from ncdc_model.planner.memory_timing import MEMORY_NAMES, memory_at
from ncdc_model.planner.plan import CLOCK_MHZ, plan
from ncdc_model.planner.scaled import hardware_takes, scaled
from ncdc_model.planner.views import ViewPlanner
from ncdc_model.view_nodes import errors_report, worst_node_errors
from ncdc_spec.descriptor import Descriptor
from ncdc_spec.errors import InputError
from ncdc_spec.geometry import MAX_SIZE
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
    parser.add_argument("--size", metavar="WxH",
                        help="plan the same lens for corrected pictures of another size, with as "
                             "many times more samples; also for larger ones than hardware takes, "
                             f"{MAX_SIZE} pixels a side")
    parser.add_argument("--board", metavar="NAME",
                        help="whether a board of ncdc build carries the picture on its memory and "
                             "its screen, as well as --sensor (default: mt9p031)")
    add_mode(parser)
    parser.add_argument("--system", action="store_true",
                        help="the board with a processor, which sends each corrected picture")
    parser.add_argument("--memory", default="ddr3", metavar="NAME",
                        help=f"one of {MEMORY_NAMES} (default: ddr3)")
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
    system = parser.add_argument_group("whole system", (
        "frames per second and memory traffic with all that shares the memory"))
    system.add_argument("--sensor", dest="camera", metavar="NAME",
                        help="also the clocks of a running system, in which this sensor's frames "
                             f"come to the same memory meanwhile: {', '.join(_NAMES)}")
    add_renamed(parser, "--camera", "--sensor", dest="camera")
    add_field(system)
    add_system(system)
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
        raise InputError(f"--field {args.field} is of a sensor: --sensor NAME or --board NAME is "
                         "needed")
    args.clock = CLOCK_MHZ if args.clock is None else args.clock
    if not 1 <= args.clock <= 1000:
        raise InputError(f"the clock is {args.clock:g} MHz, the limits are 1 and 1000")
    check_system(args)
    trained = Descriptor.load(args.descriptor)
    descriptor = _sized(trained, args.size)
    views = view_range_of(args, descriptor)
    _check_views(args, descriptor, views)
    framing = setup_around(args.camera, descriptor.geometry, field=field_of(args),
                           exposure_us=_EXPOSURE_US) if args.camera else None
    fixed = fixed_of(args, follow_strip(args, descriptor.geometry))
    width = args.data_width or (128 if args.memory.startswith("ddr3") else 32)
    hardware = Hardware(data_width=width, output=args.to, lanes=args.pixels_per_clock,
                        format=args.format, view=views is not None)

    def timing(chosen):
        return planned_timing(trained, descriptor, chosen)
    memory = memory_at(args.memory, args.clock)
    camera = camera_of(args, descriptor.geometry, framing)
    check_carried(args, descriptor.geometry, hardware, memory, camera)
    planned = _planned(args, descriptor, hardware, fixed, views, timing)
    bound = bound_of(args, descriptor, planned.hardware, memory)
    slowest = planned.slowest if views else planned
    system = system_of(args, descriptor, slowest, memory, timing(planned.hardware), camera,
                       views.view(planned.slowest_at) if views else None)
    made = planned.hardware.made_for(descriptor)
    report = planned.report() | {"nodes": descriptor.nodes, "share": made.share,
                                 "tansigs": made.units(descriptor.hidden_neurons)}
    report |= _size_report(args, descriptor.geometry) | _system_report(
        system, slowest, framing, descriptor.geometry)
    if views:
        report |= errors_report(views, worst_node_errors(descriptor, views, descriptor.nodes,
                                                         Progress("nodes")))
    if write_report({"digest": trained.digest, "output": args.to, **report,
                     **(bound.report() if bound else {})}, args.json):
        return
    _print(args, report, made, descriptor)
    if bound:
        print(f"with the camera's frame: out at most {bound.clocks} clocks after its last byte, "
              f"{100 * bound.share:.1f} % of its {bound.camera_clocks}")
    if system:
        print("\n".join(system_lines(system, slowest, args.camera or "camera")))


def _sized(trained, size):
    """The descriptor to plan: the trained one, or the same lens for pictures of ``size``, a text.

    Raises
    ------
    InputError
        If the text is no size, or the size cannot be planned.
    """
    if size is None:
        return trained
    match = re.fullmatch(r"(\d{1,6})x(\d{1,6})", size)
    if not match:
        raise InputError(f"the size is {size!r}, WxH is needed, as in 3840x2160")
    return scaled(trained, tuple(map(int, match.groups())))


def _check_views(args, descriptor, views):
    """Reject what the planner does not predict together."""
    if views and args.follow:
        raise InputError("--follow is given with a range of views, ncdc simulate --follow has the "
                         "bound of one view")
    if (views or args.follow) and not hardware_takes(descriptor.geometry):
        raise InputError(f"--size {args.size} is given with {'views' if views else '--follow'}, "
                         f"which are planned for {MAX_SIZE} pixels a side at most")


def _print(args, report, made, descriptor):
    """The plan of the corrector for people."""
    print(choice_line(made, report["bytes_read_per_pixel"], report["amplification"]))
    print(front_end_line(made, descriptor))
    print(f"{report['predicted_clocks_per_pixel']:.4f} clocks per pixel, "
          f"{report['frames_per_second']:.1f} frames per second predicted ({args.memory}, "
          f"{report['data_width']} bits, {args.clock:g} MHz)")
    print(f"{report['worst_bytes_per_pixel']:.2f} bytes per pixel in the worst 8192 pixels; "
          f"{report['live_bytes']} bytes of tiles in use at once")
    if report.get("hardware_exists") is False:
        print(f"there is no hardware for {args.size}: coordinates, tags and size registers end at "
              f"{MAX_SIZE} pixels a side; the figures are of the same hardware with wider ones")
    for line in _view_lines(report):
        print(line)


def _planned(args, descriptor, hardware, fixed, views, timing):
    """The :class:`Plan` of the trained picture, or the :class:`ViewPlan` of ``views``."""
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


def _size_report(args, geometry):
    """Entries of the report with another size than the trained one."""
    if args.size is None:
        return {}
    return {"width": geometry.corrected_width, "height": geometry.corrected_height,
            "hardware_exists": hardware_takes(geometry)}


def _system_report(system, planned, framing, geometry):
    """Entries of the report on a whole system; ``framing``: its sensor's configuration and crop, or
    None."""
    if system is None:
        return {}
    report = {"beside_camera_clocks_per_pixel": system.clocks / planned.pixels,
              "camera_frames_per_second": system.camera_fps, "system": system.report()}
    if framing:
        configuration, crop = framing
        report |= field_report(configuration, crop, geometry)
    return report

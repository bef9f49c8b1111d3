"""Options of ``ncdc plan`` for a whole system, and the parts of its report on it."""

from ncdc.terminal import Progress
from ncdc.text_table import text_table
from ncdc_model.planner.system import Readers, steady_camera, system_plan, taken
from ncdc_spec.errors import InputError

__all__ = ["add_system", "camera_of", "check_carried", "check_system", "parts_table",
           "system_lines", "system_of"]


def add_system(group):
    """Declare the options on an argparse group."""
    group.add_argument("--camera-fps", type=float, metavar="FPS",
                       help="instead of --sensor, a camera without blanking that sends so many "
                            "raw frames per second")
    group.add_argument("--screen-fps", type=float, metavar="FPS",
                       help="a screen that shows the corrected picture so many times per second; "
                            "with --to memory it reads it there")
    group.add_argument("--network-mbps", type=float, metavar="MBIT",
                       help="a network that takes so many megabits of pixels per second, and each "
                            "picture once; with --to memory it is read there")


def check_system(args):
    """Reject options that need or exclude others."""
    if args.camera and args.camera_fps is not None:
        raise InputError(f"--sensor {args.camera} and --camera-fps {args.camera_fps:g} are given, "
                         "one of them is needed")
    for option, value in (("--screen-fps", args.screen_fps), ("--network-mbps",
                                                              args.network_mbps)):
        if value is not None and not args.camera and args.camera_fps is None:
            raise InputError(f"{option} {value:g} is of a whole system: --sensor NAME or "
                             "--camera-fps FPS is needed")


def camera_of(args, geometry, framing):
    """:class:`~ncdc_spec.sensors.sensor.Timing` of the camera that is chosen; None without one.

    Parameters
    ----------
    args : argparse.Namespace
    geometry : Geometry
    framing : (Setup, Crop) or None
        Of the sensor that is chosen.
    """
    if args.camera_fps is not None:
        return steady_camera(geometry, args.camera_fps)
    return framing and framing[1].arriving(framing[0].timing)


def check_carried(args, geometry, hardware, memory, camera):
    """Raise :class:`InputError` if memory and ports do not carry camera and readers alone."""
    if camera:
        taken(geometry, hardware, memory, args.memory, args.clock, camera, _readers(args))


def _readers(args):
    return Readers(args.screen_fps, args.network_mbps)


def system_of(args, descriptor, planned, memory, timing, camera, view):
    """The :class:`~ncdc_model.planner.system.SystemPlan` of the options; None without a camera.

    Parameters
    ----------
    args : argparse.Namespace
    descriptor : Descriptor
    planned : Plan
    memory : LatencyMemory or DramMemory
    timing : CorrectorTiming
    camera : Timing or None
        As of :func:`camera_of`.
    view : View or None

    Raises
    ------
    InputError
        If the memory does not carry the system, or the system does not reach ``--min-fps``.
    """
    if camera is None:
        return None
    show = Progress("whole system")
    found = system_plan(descriptor, planned, memory, timing, camera,
                        _readers(args), view,
                        lambda done, total: show(done / total))
    show(1)
    if args.rate and found.frames_per_second < args.rate:
        raise InputError(
            f"{found.frames_per_second:.1f} frames per second are predicted for the whole system, "
            f"whose {found.limited_by} is the limit, {args.rate:g} are asked for")
    return found


def system_lines(system, planned, camera):
    """Lines on a system for people; ``camera``: what its camera is called."""
    moves = "" if system.capacity is None else f", which moves {system.capacity / 1e6:.0f} MB/s"
    yield (f"{system.clocks / planned.pixels:.4f} clocks per pixel while the {camera} writes its "
           f"next frames, {system.camera_fps:.1f} per second")
    yield (f"whole system on {planned.memory}{moves}: {system.frames_per_second:.1f} frames per "
           f"second, the {system.limited_by} is the limit")
    yield parts_table(system.report()["parts"])


def parts_table(parts):
    """Rows of :func:`ncdc_model.planner.system.traffic` as text, with their sum."""
    shares = [part["share"] for part in parts]
    whole = {"part": "all", "mb_per_second": sum(part["mb_per_second"] for part in parts),
             "share": None if None in shares else sum(shares)}
    return text_table(_COLUMNS, [*parts, whole], left=1)


_COLUMNS = (
    ("part", lambda row: row["part"]),
    ("MB/s", lambda row: f"{row['mb_per_second']:.1f}"),
    ("of the memory", lambda row: None if row["share"] is None else f"{100 * row['share']:.1f} %"),
)

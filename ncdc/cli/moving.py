"""``ncdc simulate --camera``: frames of a running camera, from a sensor's pins to pictures."""

import sys

from ncdc.cli.common import raw_frame, read_photo, write_report
from ncdc.cli.field import add_field, field_of, field_report
from ncdc.cli.hardware import fixed_of, hardware_of, planned
from ncdc.cli.view_angles import view_options
from ncdc.cli.waves import waves_of
from ncdc.terminal import Progress
from ncdc_hdl.system import System
from ncdc_model.images import check_animation, is_raw, write_animation
from ncdc_sim.sensor.photo import moving_photo, still_raw
from ncdc_sim.system.camera import simulate_camera
from ncdc_spec.errors import InputError
from ncdc_spec.sensors.catalogue import SENSORS
from ncdc_spec.sensors.framing import camera_of, grid_row, setup_around

__all__ = ["add_moving", "run_moving"]

_MAX_FRAMES = 1000
_SHOWN_MS = 200         # each picture: slow enough to look at


def add_moving(parser):
    """Declare the options."""
    group = parser.add_argument_group(
        "a running camera", "frames go through the pins of a sensor and through memory, and are "
        "corrected as they come; OUT is an animation of the corrected pictures")
    # With two spellings: elsewhere too, a sensor is named by --sensor.
    group.add_argument("--camera", "--sensor", dest="sensor", metavar="NAME",
                       help=", ".join(sensor.name for sensor in SENSORS))
    add_field(group)
    group.add_argument("--frames", type=int, default=5, metavar="N", help="default: 5")
    group.add_argument("--velocity", default="12,0", metavar="X,Y",
                       help="corrected pixels to the right and down by which the scene of a colour "
                            "picture moves from frame to frame (default: 12,0)")
    group.add_argument("--exposure-us", type=float, default=1000.0, metavar="X",
                       help="of the sensor, in microseconds (default: 1000)")


def run_moving(args, descriptor):
    """Simulate, compare, write, report; 1 if a pixel differs."""
    if not 1 <= args.frames <= _MAX_FRAMES:
        raise InputError(f"frames is {args.frames}, 1 to {_MAX_FRAMES} are simulated")
    check_animation(args.output)
    velocity = _velocity(args.velocity)
    for option, given in (("--line-clocks", args.line_clocks), ("--tone", args.tone),
                          ("--crest", None if args.crest == "off" else args.crest),
                          ("--white-balance", args.white_balance),
                          ("--raw-balance", args.raw_balance), ("--matrix", args.matrix),
                          *view_options(args)):
        if given is not None:
            raise InputError(f"{option} is given with --camera {args.sensor}, which does not take "
                             f"it")
    hardware, _ = planned(hardware_of(args), fixed_of(args, 0 if args.follow else None), descriptor)
    plan, crop = setup_around(args.sensor, descriptor.geometry, field=field_of(args),
                              exposure_us=args.exposure_us)
    raw, note = raw_frame(args.image, descriptor.geometry, args.raw, args.bits)
    # The first read has printed the warnings.
    photo = read_photo(args.image, args.raw, args.bits, warn=lambda sentence: None).image
    light = (still_raw(plan, crop, raw) if is_raw(photo)
             else moving_photo(descriptor, plan, crop, photo, args.frames, velocity))
    result = simulate_camera(
        System(descriptor, hardware, grid=grid_row(plan, crop), camera=camera_of(plan, crop)),
        plan, light, corner=crop, count=args.frames, follow=args.follow, memory=args.memory,
        simulator=args.simulator, seed=args.seed, waves=waves_of(args),
        progress=Progress("simulating"))
    write_animation(args.output, [frame.picture for frame in result.frames],
                    _SHOWN_MS)
    if note:
        print(note, file=sys.stderr)
    report = result.report() | {
        "sensor": plan.sensor.name, "frames_per_second": plan.timing.frames_per_second,
        "memory": args.memory, "simulator": args.simulator,
        **field_report(plan, crop, descriptor.geometry), **hardware.report(descriptor.geometry)}
    if not write_report(report, args.json):
        print(f"{report['frames']} frames of {plan.sensor.name} at "
              f"{report['frames_per_second']:.1f} per second, {report['pixels_compared']} pixels "
              f"compared, {report['pixels_different']} differ; at most "
              f"{report['clocks_per_pixel']:.3f} clocks per pixel ({args.memory}, "
              f"{args.simulator}); frames dropped: {report['overflows'] + report['frames_missed']}")
    if report["pixels_different"]:
        print(f"ncdc simulate: {report['pixels_different']} pixels differ from the golden model",
              file=sys.stderr)
        return 1
    return 0


def _velocity(text):
    try:
        x, y = (float(part) for part in text.split(","))
    except ValueError:
        raise InputError(f"the velocity is {text!r}, two numbers as in 12,0 are needed") from None
    if not all(abs(value) <= 1000 for value in (x, y)):
        raise InputError(f"the velocity is {text}, at most 1000 pixels per frame are simulated")
    return x, y

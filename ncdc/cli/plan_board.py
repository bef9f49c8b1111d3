"""``ncdc plan --board``: whether a board carries a picture, and how often."""

from ncdc.cli.board_design import planner, print_rates, settings_of
from ncdc.cli.common import write_report
from ncdc.cli.field import field_lines, field_report
from ncdc.cli.hardware import fixed_of
from ncdc.cli.plan_system import parts_table
from ncdc.cli.view_range import views_given
from ncdc_boards.board import Request
from ncdc_boards.catalogue import board_for
from ncdc_model.planner.plan import check_positive
from ncdc_model.planner.system import traffic
from ncdc_spec.errors import InputError
from ncdc_spec.frames import BGRX8
from ncdc_spec.registers.system_values import memory_bytes

__all__ = ["plan_board"]

# What a board brings itself, and what plan has for it otherwise.
_OURS = {"memory": "ddr3", "clock": None, "data_width": None, "to": "memory",
         "format": BGRX8.name}
_OPTIONS = {"clock": "--core-mhz", "data_width": "--data-width"}
# Options of a system of the user's own, or of pictures that were not trained.
_NOT_OURS = "size", "camera_fps", "screen_fps", "network_mbps"


def plan_board(args, descriptor):
    """Plan and report; InputError, in one sentence, for what does not fit."""
    for name, default in _OURS.items():
        if getattr(args, name) != default:
            raise InputError(f"{_OPTIONS.get(name, '--' + name)} and --board {args.board} are "
                             f"given, the board has its own")
    for name in _NOT_OURS:
        if (value := getattr(args, name)) is not None:
            raise InputError(f"--{name.replace('_', '-')} {value:{'' if name == 'size' else 'g'}} "
                             f"and --board {args.board} are given, a board has its own system")
    if views_given(args):
        raise InputError(f"a range of views and --board {args.board} are given, boards have no "
                         f"view")
    if args.follow:
        raise InputError(f"--follow and --board {args.board} are given, a frame that follows is "
                         f"planned without a board only")
    check_positive(args.rate)
    board, lines = board_for("plan", args.board), []
    design = board.design(
        [(args.descriptor, descriptor)],
        Request(args.camera or Request.sensor, args.mode, settings_of(args, "field"),
                lanes=args.pixels_per_clock, processor=args.system),
        planner(fixed_of(args), lines.append))
    (setup, crop), budget = design.sensor, board.budget(design)
    if args.rate and budget.corrected_per_second < args.rate:
        raise InputError(
            f"{budget.corrected_per_second:.1f} frames per second are corrected on {board.name} "
            f"with {'screen and ' * bool(design.mode)}camera, {args.rate:g} are asked for: "
            f"{_what_fits(budget, args)}")
    needed = memory_bytes(design.system.descriptor, design.system.hardware, design.system.stores)
    parts = _traffic(budget)
    report = {"digest": descriptor.digest, "board": board.name,
              "mode": design.mode.name if design.mode else None,
              "clocks": [{"name": name, "target_mhz": mhz}
                         for name, mhz in design.clocks.targets().items()],
              "memory_bytes": needed, "memory_bytes_there": board.memory_bytes,
              "parts": parts, **board.rates(design),
              **field_report(setup, crop, descriptor.geometry)}
    if write_report(report, args.json):
        return
    shown = f", {design.mode.name}: pixel clock {design.clocks.pixel_mhz:.2f} MHz, " \
        if design.mode else ": "
    screen = f"screen takes {budget.screen / 1e6:.0f} MB/s, the " if design.mode else ""
    camera = setup.sensor.name + " takes" * (not design.mode)
    print(f"{board.title}{shown}core {design.clocks.core_mhz:g} MHz")
    print(f"frames of {needed / 1e6:.1f} MB in all, in {board.memory_bytes / 1e6:.1f} MB; the "
          f"{screen}{camera} {budget.camera / 1e6:.0f} MB/s, of {budget.carried / 1e6:.0f} MB/s")
    for line in field_lines(setup, crop, descriptor.geometry):
        print(line)
    print_rates(report)
    print(parts_table(parts))
    for line in filter(None, lines):
        print(line)


def _traffic(budget):
    """Traffic of the board's memory at the rate of the corrected frames, as of
    :func:`ncdc_model.planner.system.traffic`; the share is of what the memory carries."""
    return traffic({"camera, writes": budget.camera,
                    "corrector": budget.frame * budget.corrected_per_second,
                    **({"screen, reads": budget.screen} if budget.screen else {})}, budget.carried)


def _what_fits(budget, args):
    """A text on the rate that would fit."""
    if budget.frames_per_second < args.rate:
        return f"the sensor sends {budget.frames_per_second:.1f}"
    return f"--min-fps {int(budget.corrected_per_second)} or a smaller picture fits"

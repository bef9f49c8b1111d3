"""``ncdc simulate``: runs the generated Verilog on an image and compares every pixel."""

import sys
from dataclasses import replace

from ncdc.cli.colour import add_colour, colour_choice, colour_line, colour_report, has_gains
from ncdc.cli.common import add_json, add_samples, raw_frame, write_report
from ncdc.cli.follow import add_follow, bound_of, follow_strip
from ncdc.cli.hardware import add_hardware, add_view_registers, fixed_of, hardware_of, planned
from ncdc.cli.moving import add_moving, run_moving
from ncdc.cli.simulated_views import run_views
from ncdc.cli.view import add_simulated_view, simulated_view
from ncdc.cli.view_list import add_view_list
from ncdc.cli.waves import add_waves, waves_of
from ncdc.terminal import Progress
from ncdc_model.correction import correct
from ncdc_model.images import check_suffix, write_image
from ncdc_model.planner.follow import camera_line
from ncdc_model.planner.memory_timing import MEMORY_NAMES, DramMemory, LatencyMemory
from ncdc_sim.memory.timing import simulated_memory
from ncdc_sim.system.corrector import simulate_correction
from ncdc_sim.tools import SIMULATORS
from ncdc_spec.colour import Colour
from ncdc_spec.descriptor import Descriptor
from ncdc_spec.errors import InputError
from ncdc_spec.interpolation import CRESTS
from ncdc_spec.view_rows import MAX_MATRICES

__all__ = ["EXAMPLE", "add_arguments", "difference", "run"]

EXAMPLE = "ncdc simulate net.toml frame.png -o corrected.png --memory sdram"


def add_arguments(parser) -> None:
    """Declare the command's arguments on an argparse parser."""
    parser.add_argument("descriptor", metavar="NET", help="descriptor of ncdc train")
    parser.add_argument("image", metavar="IMAGE",
                        help="raw Bayer frame (one channel), or a colour picture to be mosaiced")
    parser.add_argument("-o", "--output", required=True, metavar="OUT",
                        help="picture as the Verilog corrected it")
    add_hardware(parser.add_argument_group("hardware", "none of it changes a pixel"))
    run = parser.add_argument_group("simulation")
    run.add_argument("--memory", default="sdram", metavar="NAME",
                     help=f"simulated memory: one of {MEMORY_NAMES}, or the controller LiteDRAM: "
                          "litedram, litedram-ddr3 (default: sdram)")
    run.add_argument("--simulator", choices=SIMULATORS, default="verilator",
                     help="verilator (default) or icarus, which takes some 100 times as long")
    run.add_argument("--seed", type=int, default=1, metavar="S",
                     help="of the memory's random behaviour (default: 1)")
    add_waves(run)
    add_follow(parser.add_argument_group("low latency"))
    add_moving(parser)
    view = parser.add_argument_group("view")
    add_view_registers(view)
    add_simulated_view(view)
    add_view_list(view)
    add_colour(parser.add_argument_group("colour"))
    add_samples(parser.add_argument_group("samples of the file"))
    add_json(parser)


def run(args) -> int | None:
    """Simulate, compare, write, report; 1 if a pixel or a bound of the planner is not met."""
    if args.seed < 0:
        raise InputError(f"seed is {args.seed}, it must not be negative")
    check_suffix(args.output)
    choice = colour_choice(args)
    simulated_memory(args.memory)
    waves = waves_of(args)
    descriptor = Descriptor.load(args.descriptor)
    if args.view_list is not None:
        return run_views(args, descriptor)
    if args.sensor:
        return run_moving(args, descriptor)
    view = simulated_view(args, descriptor)
    if args.field is not None:
        raise InputError(f"--field {args.field} is of a sensor: --camera NAME is needed")
    fixed = fixed_of(args, follow_strip(args, descriptor.geometry))
    raw, note = raw_frame(args.image, descriptor.geometry, args.raw, args.bits)
    hardware = hardware_of(args)
    hardware = replace(hardware, colour=hardware.colour or has_gains(args),
                       view=hardware.view or view is not None,
                       view_rows=hardware.view_rows or (MAX_MATRICES if view and view.rows else 0))
    hardware, _ = planned(hardware, fixed, descriptor)
    line = camera_line(args.line_clocks, descriptor.geometry) if args.follow else None
    colour = choice(lambda raw_gains: correct(
        descriptor, raw, crest=CRESTS[args.crest], raw_gains=raw_gains,
        view=view)) if choice else Colour()
    simulation = simulate_correction(
        descriptor, raw, hardware, follow_line=line, colour=colour, view=view,
        progress=Progress("simulating"), memory=args.memory, simulator=args.simulator,
        seed=args.seed, waves=waves)
    write_image(args.output, simulation.picture)
    if note:
        print(note, file=sys.stderr)
    bound = _bound(args, descriptor, hardware, view)
    report = simulation.report() | {"hidden_neurons": descriptor.hidden_neurons}
    report |= bound.report() if bound else {}
    report |= colour_report(args, colour) if choice else {}
    if not write_report(report, args.json):
        print(f"{report['pixels_compared']} pixels compared, {report['pixels_different']} differ; "
              f"{report['clocks_per_pixel']:.3f} clocks and {report['bytes_read_per_pixel']:.2f} "
              f"bytes read per pixel ({args.memory}, {args.simulator})")
        if choice:
            print(colour_line(args, colour))
        if args.follow:
            print(f"out {report['follow_latency_clocks']} clocks after the camera's last byte"
                  + (f", at most {bound.clocks} planned" if bound else "")
                  + f"; {report['follow_early_reads']} rows read before they were written")
    message = (difference(simulation) or _sums(simulation) or _outside(simulation)
               or _early(simulation) or _late(report, bound))
    if message:
        print(f"ncdc simulate: {message}", file=sys.stderr)
        return 1
    return 0


def _bound(args, descriptor, hardware, view):
    """The planner's bound; None without --follow, and where its model gives no clocks.

    It has none for the multiport fetcher, random latency, and LiteDRAM's controller.
    """
    memory = simulated_memory(args.memory)
    exact = isinstance(memory, DramMemory) or (isinstance(memory, LatencyMemory)
                                               and memory.latency[0] == memory.latency[1]
                                               and memory.wait_probability == 0)
    if not hardware.cached or not exact:
        return None
    return bound_of(args, descriptor, hardware, memory, view)


def _sums(simulation):
    """A sentence on the first sum of colours that differs; None if none does."""
    for name, expected in simulation.sums_expected.items():
        if (got := simulation.sums[name]) != expected:
            return f"{name} reads {got}, {expected} is the golden model's"
    return None


def _outside(simulation):
    """A sentence on accesses outside both frames; None if there were none."""
    outside = simulation.bytes_outside
    return f"{outside} bytes were read or written that are of neither frame" if outside else None


def _early(simulation):
    """A sentence on rows that were read too early; None if none was."""
    early = simulation.follow.get("follow_early_reads")
    return f"{early} read commands came before the camera had written their row" if early else None


def _late(report, bound):
    """A sentence on a frame that was out later than the planner's bound; None if none was."""
    found = report.get("follow_latency_clocks")
    if bound is None or found <= bound.clocks:
        return None
    return (f"the frame was out {found} clocks after the camera's last byte, {bound.clocks} are "
            f"the planner's limit")


def difference(simulation):
    """A sentence that names the first pixel in which a simulation differs; None if none does."""
    differing = simulation.differing
    if not differing:
        return None
    u, v = differing[0]
    got, expected = (pixels[v, u].tolist() for pixels in (simulation.stored, simulation.expected))
    return (f"{len(differing)} pixels differ from the golden model, the first at column {u}, row "
            f"{v}: {got} instead of {expected}")

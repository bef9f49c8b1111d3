"""``ncdc simulate --view-list``: several views of one raw frame on the generated Verilog."""

import sys
from dataclasses import replace

from ncdc.cli.common import raw_frame, write_report
from ncdc.cli.hardware import fixed_of, hardware_of, planned
from ncdc.cli.view_list import ViewsFile, check_alone
from ncdc.cli.waves import waves_of
from ncdc.terminal import Progress
from ncdc_model.images import write_image
from ncdc_sim.system.view_list import simulate_view_list
from ncdc_spec.frames import output_format

__all__ = ["run_views"]

_MIN_VIEWS = 2          # of hardware with a list


def run_views(args, descriptor):
    """Simulate, compare, write, report; 1 if a pixel differs."""
    check_alone(args, ("--camera", args.sensor), ("--field", args.field),
                ("--follow", args.follow or None), ("--line-clocks", args.line_clocks),
                ("--matrix", args.matrix))
    views = ViewsFile.load(args.view_list)
    hardware = hardware_of(args)
    entries = views.entries(descriptor, output_format(hardware.format))
    hardware = replace(hardware, view=True,
                       views=hardware.views or max(_MIN_VIEWS, len(entries)))
    hardware, _ = planned(hardware, fixed_of(args), descriptor)
    raw, note = raw_frame(args.image, descriptor.geometry, args.raw, args.bits)
    simulation = simulate_view_list(
        descriptor, raw, hardware, entries, views.size, progress=Progress("simulating"),
        memory=args.memory, simulator=args.simulator, seed=args.seed, waves=waves_of(args))
    write_image(args.output, simulation.picture)
    if note:
        print(note, file=sys.stderr)
    report = simulation.report() | {"hidden_neurons": descriptor.hidden_neurons}
    if not write_report(report, args.json):
        print(f"{len(entries)} views, {report['pixels_compared']} pixels compared, "
              f"{report['pixels_different']} differ; {report['clocks']} clocks "
              f"({args.memory}, {args.simulator})")
    if report["pixels_different"] or report["bytes_outside"]:
        print(f"ncdc simulate: {report['pixels_different']} pixels differ from the golden model, "
              f"{report['bytes_outside']} bytes were read or written outside the frames",
              file=sys.stderr)
        return 1
    return 0

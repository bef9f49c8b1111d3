"""``ncdc build`` for a board whose memory is a hard processor's: its project for Intel's tools."""

from ncdc.cli.common import write_report
from ncdc.cli.field import field_lines, field_of, field_report
from ncdc.cli.hardware import planned
from ncdc_boards.camera_board.design import sensor_for
from ncdc_boards.hps_board.core import HpsDesign
from ncdc_boards.hps_board.ports import DATA_WIDTH
from ncdc_boards.hps_board.project import project_files
from ncdc_boards.quartus.project import USER_FILE, project_name
from ncdc_boards.quartus.sdc import check_sensor
from ncdc_hdl.export.drivers.drivers import driver_files
from ncdc_hdl.system import System
from ncdc_hdl.video.modes import mode_for, mode_named
from ncdc_model.planner.plan import Fixed
from ncdc_spec.errors import InputError
from ncdc_spec.files import check_outputs, write_text
from ncdc_spec.frames import BGR8, output_format
from ncdc_spec.hardware import Hardware
from ncdc_spec.registers.system_values import memory_bytes
from ncdc_spec.sensors.framing import grid_row
from ncdc_spec.sensors.waking import wake_times

__all__ = ["build_hps"]

_READERS = 2            # by registers: programs on the processor


def build_hps(args, board, named, output):
    """Write the project; the user's file only if it is not there."""
    check_outputs([output / f"{project_name(board)}.v"], args.descriptor)
    check_sensor(args.pixel_clock_mhz)
    design, setup, corner = _designed(args, board, named)
    files = project_files(design, setup, corner) | driver_files(design.system.corrector, named,
                                                                design.system.table)
    exists = (output / USER_FILE).exists()
    if exists:
        del files[USER_FILE]
    for name, text in files.items():
        write_text(output / name, text)
    report = {"board": board.name, "sensor": args.sensor,
              "clocks": [{"name": name, "target_mhz": mhz}
                         for name, mhz in design.clocks.targets().items()],
              "sensor_frames_per_second": setup.timing.frames_per_second,
              **field_report(setup, corner, named[0][1].geometry),
              "files": [str(output / name) for name in files],
              "kept": [str(output / USER_FILE)] if exists else []}
    if write_report(report, args.json):
        return
    for clock in report["clocks"]:
        print(f"{clock['name']:>16}: {clock['target_mhz']:7.2f} MHz needed")
    print("\n".join(field_lines(setup, corner, named[0][1].geometry)))
    print(f"the sensor sends {setup.timing.frames_per_second:.1f} frames per second")
    for name in report["kept"]:
        print(f"{name}: yours, left as it is")
    print(f"{output}: {len(files)} files; sh {output / 'build.sh'} makes the bitstream, with "
          f"Quartus Prime Lite")


def _designed(args, board, named):
    """The design, the sensor's configuration and where the raw frame begins in its frame;
    InputError if they do not fit."""
    descriptor = named[0][1]
    geometry = descriptor.geometry
    smallest = mode_for(*geometry.corrected)
    mode = mode_named(args.mode) if args.mode else smallest
    if not mode.holds(*geometry.corrected):
        raise InputError(f"the picture has {geometry.corrected_width}x{geometry.corrected_height} "
                         f"pixels, the mode {args.mode} does not hold it: {smallest.name} does")
    clocks = board.clock_plan(mode, board.core_mhz)
    setup, corner = sensor_for(args.sensor, geometry, exposure_us=args.exposure_us,
                               field=field_of(args),
                               pixel_clock_hz=round(args.pixel_clock_mhz * 1e6))
    hardware = Hardware(data_width=DATA_WIDTH, format=BGR8.name,
                        multiplier_bits=board.multiplier_bits)
    hardware, _ = planned(hardware, Fixed(None, None, None), descriptor)
    system = System(descriptor, hardware, readers=_READERS, screens=1,
                    grid=grid_row(setup, corner))
    needed, there = memory_bytes(descriptor, system.hardware, system.stores), board.frames[1]
    if needed > there:
        raise InputError(f"the frames take {needed / 1e6:.1f} MB, {there / 1e6:.1f} MB of the "
                         f"{board.name} are reserved for them: a smaller picture fits")
    pixel = output_format(system.hardware.format).pixel_bytes
    reset_us, _ = wake_times(setup.sensor.waking, setup.settings.clock_hz)
    return HpsDesign(board, system, mode, pixel, clocks, reset_us), setup, corner

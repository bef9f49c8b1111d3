"""``ncdc build``: from descriptors to the bitstream of a board, or to its Quartus project."""

import tempfile
import time
from ipaddress import IPv4Address
from pathlib import Path

from ncdc.cli.board_design import add_mode, board_named, designed, print_rates, rates
from ncdc.cli.build_hps import build_hps
from ncdc.cli.common import add_json, write_report
from ncdc.cli.field import add_field, field_lines, field_of, field_report
from ncdc.terminal import Steps
from ncdc.toolchain.bitstream import (
    clock_nets,
    clock_preferences,
    pack,
    place_and_route,
    resources,
    synthesise_board,
)
from ncdc.toolchain.flows import SynthesisError, check_tools
from ncdc_boards.camera_board.design import hardware_for
from ncdc_boards.catalogue import board as board_of
from ncdc_boards.ecp5.build import clock_cells, prepared
from ncdc_boards.ecp5.build import project_name as ecp5_name
from ncdc_boards.hps_board.board import HpsBoard
from ncdc_boards.quartus.project import USER_FILE, project_files, project_name
from ncdc_boards.quartus.sdc import check_sensor
from ncdc_hdl.export.drivers.drivers import driver_files
from ncdc_spec.descriptor import Descriptor
from ncdc_spec.errors import InputError
from ncdc_spec.files import check_outputs, write_bytes, write_text

__all__ = ["EXAMPLE", "add_arguments", "run"]

EXAMPLE = "ncdc build net.toml --board ulx3s -o board"

_MAX_SEEDS = 20


def add_arguments(parser) -> None:
    """Declare the command's arguments on an argparse parser."""
    parser.add_argument("descriptor", metavar="NET", nargs="+",
                        help="descriptors of ncdc train: the first is shown, push buttons choose "
                             "the others")
    parser.add_argument("--board", default="ulx3s", metavar="NAME",
                        help="ulx3s (default), colorlight-i9: by open tools; de1-soc, de2-115, "
                             "de0-cv, de10-nano: a project for Quartus")
    parser.add_argument("--sensor", default="mt9p031", metavar="NAME",
                        help="mt9p031 (default; Terasic D5M), ov5640, mt9d111")
    add_mode(parser)
    add_field(parser)
    parser.add_argument("--pixel-clock-mhz", type=float, default=0, metavar="MHZ",
                        help="of the sensor, made by its own phase-locked loop (default: 25, "
                             "without)")
    parser.add_argument("--exposure-us", type=float, default=10_000.0, metavar="X",
                        help="of the sensor, in microseconds (default: 10000)")
    parser.add_argument("--system", action="store_true",
                        help="with a processor and its Ethernet: pictures and settings over the "
                             "network as well (de2-115; colorlight-i9 always has it)")
    parser.add_argument("--colour", action="store_true",
                        help="gains and a tone curve, and with a processor automatic white "
                             "balance; not for de10-nano")
    parser.add_argument("--address", default="0.0.0.0", metavar="IPV4",
                        help="of the processor (default: asked of DHCP, or link-local)")
    parser.add_argument("--mac", metavar="XX:XX:XX:XX:XX:XX",
                        help="MAC address of the processor, and its serial number: each board of "
                             "a network needs another one (default: 02:4e:0a:4d:00:0b)")
    parser.add_argument("--seeds", type=int, default=3, metavar="N",
                        help="place-and-route runs with a seed each; the best counts "
                             "(default: 3; not for Quartus)")
    parser.add_argument("-o", "--output", metavar="DIR",
                        help="folder to write to (default: the board's name)")
    add_json(parser)


def run(args) -> None:
    """Check, generate, synthesise, place and route, pack, write."""
    if not 1 <= args.seeds <= _MAX_SEEDS:
        raise InputError(f"seeds is {args.seeds}, 1 to {_MAX_SEEDS} are tried")
    board = board_of(args.board)
    if not isinstance(board, HpsBoard):
        board = board_named(args.board)
    named = [(path, Descriptor.load(path)) for path in args.descriptor]
    output = Path(args.output or board.name)
    if isinstance(board, HpsBoard):
        if args.system:
            raise InputError(f"the {board.name} has a processor of its own, --system is not for it")
        if args.colour:
            raise InputError(f"--colour is not supported on the {board.name}")
        build_hps(args, board, named, output)
        return
    if board.tools == "quartus":
        _quartus(args, board, named, output)
        return
    _open(args, board, named, output)


def _open(args, board, named, output):
    """Make the bitstream by open tools."""
    check_tools()
    name = ecp5_name(board)
    # An output that cannot be written is reported before half an hour of work.
    check_outputs([output / f"{name}.bit"], args.descriptor)
    design, sensor, budget = _design(args, board, named)
    more = _processor(args, design, sensor) if design.processor else {}
    began, steps = time.monotonic(), Steps("ncdc build", quiet=args.json == "-")
    with tempfile.TemporaryDirectory(prefix="ncdc-") as made:
        folder = Path(made)
        steps("generating the design")
        files = prepared(design)
        try:
            steps("synthesis: Yosys")
            nets = clock_nets(synthesise_board(files.rtlil, name, folder, more),
                              clock_cells(design))
            preferences = files.preferences + clock_preferences(nets, design.clocks.targets())
            runs = []
            for seed in range(1, args.seeds + 1):
                steps(f"place and route: nextpnr, seed {seed} of {args.seeds}")
                runs.append(place_and_route(folder, board.device, preferences, nets, seed))
            best = max(runs, key=lambda one: one.slack)
            _check_clocks(best, args.seeds)
            steps("packing the bitstream")
            bits = pack(folder, best.seed)
        except SynthesisError as error:
            steps("failed")
            raise InputError(str(error)) from error
    steps("done")
    texts = {f"{name}.v": files.verilog, f"{name}.lpf": preferences, **more,
             **driver_files(design.system.corrector, named, design.system.table)}
    for file, text in texts.items():
        write_text(output / file, text)
    write_bytes(output / f"{name}.bit", bits)
    geometry = named[0][1].geometry
    report = _report(args, best, runs, bits, budget, time.monotonic() - began)
    report |= field_report(*sensor, geometry)
    report["files"] = [str(output / file) for file in (f"{name}.bit", *texts)]
    if not write_report(report, args.json):
        _print(report, field_lines(*sensor, geometry), output / f"{name}.bit", board.name)


def _quartus(args, board, named, output):
    """Write the project for Quartus; the user's file only if it is not there."""
    check_outputs([output / f"{project_name(board)}.v"], args.descriptor)
    check_sensor(args.pixel_clock_mhz)
    design, sensor, budget = _design(args, board, named)
    more = _processor(args, design, sensor) if args.system else {}
    files = project_files(design, sensor[0], [name for name in more if name.endswith(".v")])
    files |= more | driver_files(design.system.corrector, named, design.system.table)
    exists = (output / USER_FILE).exists()
    if exists:
        del files[USER_FILE]
    for name, text in files.items():
        write_text(output / name, text)
    report = {"board": board.name, "sensor": args.sensor,
              "clocks": [{"name": name, "target_mhz": mhz}
                         for name, mhz in design.clocks.targets().items()],
              **rates(budget), **field_report(*sensor, named[0][1].geometry),
              "files": [str(output / name) for name in files],
              "kept": [str(output / USER_FILE)] if exists else []}
    if write_report(report, args.json):
        return
    for clock in report["clocks"]:
        print(f"{clock['name']:>16}: {clock['target_mhz']:7.2f} MHz needed")
    print("\n".join(field_lines(*sensor, named[0][1].geometry)))
    print_rates(report)
    for name in report["kept"]:
        print(f"{name}: yours, left as it is")
    print(f"{output}: {len(files)} files; sh {output / 'build.sh'} makes the bitstream, with "
          f"Quartus Prime Lite")


def _design(args, board, named):
    """Design, the sensor's configuration and crop, the memory's budget; InputError if they do not
    fit."""
    design, sensor, budget, _ = designed(
        board, named, sensor=args.sensor, mode=args.mode, processor=args.system,
        hardware=hardware_for(board, colour=args.colour),
        settings={"exposure_us": args.exposure_us, "field": field_of(args),
                  "pixel_clock_hz": round(args.pixel_clock_mhz * 1e6)})
    return design, sensor, budget


def _processor(args, design, sensor):
    """Files of the processor, by name."""
    from ncdc_soc.board import processor_files  # LiteX is of the extra [soc]
    from ncdc_soc.firmware import Identity
    try:
        address = str(IPv4Address(args.address))
    except ValueError as error:
        raise InputError(f"the address {args.address!r} is no IPv4 address") from error
    identity = Identity(ip=address, **{} if args.mac is None else {"mac": args.mac})
    files = processor_files(design, sensor, identity)
    return files.verilog | files.memories


def _check_clocks(best, seeds):
    """Raise InputError if the best place-and-route run does not meet timing."""
    for clock in best.clocks:
        if clock.slack < 0:
            raise InputError(
                f"the clock {clock.name} reaches {clock.achieved_mhz:.1f} of "
                f"{clock.target_mhz:.1f} MHz in the best of {seeds} seeds: more --seeds, or a "
                f"smaller network or interpolation, may fit")


def _report(args, best, runs, bits, budget, seconds):
    return {
        "board": args.board, "sensor": args.sensor,
        "clocks": [vars(clock) for clock in best.clocks], **resources(best),
        "seeds": [{"seed": one.seed, "slack": one.slack,
                   "clocks": [vars(clock) for clock in one.clocks]} for one in runs],
        "seed": best.seed, "bitstream_bytes": len(bits), "seconds": round(seconds, 1),
        **rates(budget)}


def _print(report, field, bitstream, loaded):
    """Print the report; ``field``: its lines on the field; ``loaded``: openFPGALoader's name of the
    board."""
    for clock in report["clocks"]:
        slack = 1 - clock["target_mhz"] / clock["achieved_mhz"]
        spare = 1000 / clock["target_mhz"] - 1000 / clock["achieved_mhz"]
        print(f"{clock['name']:>16}: {clock['achieved_mhz']:7.2f} MHz of "
              f"{clock['target_mhz']:7.2f}, slack {spare:.2f} ns, {100 * slack:.0f} %")
    print(f"{report['lut']} LUTs, {report['ff']} flip-flops, {report['dsp']} multipliers, "
          f"{report['ram_blocks']} block RAMs; seed {report['seed']}")
    print("\n".join(field))
    print_rates(report)
    print(f"{bitstream}: {report['bitstream_bytes']} bytes, in {report['seconds']:.0f} s; "
          f"openFPGALoader -b {loaded} {bitstream}")

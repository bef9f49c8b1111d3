"""``ncdc build``: from descriptors to the bitstream of a board, or to its Quartus project."""

import time
from ipaddress import IPv4Address
from pathlib import Path

from ncdc.cli.board_design import add_mode, planner, print_rates, settings_of
from ncdc.cli.build_open import implemented, print_implemented
from ncdc.cli.common import add_json, write_report
from ncdc.cli.field import add_field, field_lines, field_report
from ncdc.terminal import Steps
from ncdc.toolchain.flows import check_tools
from ncdc_boards.board import Request, project_name
from ncdc_boards.catalogue import board_for
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
                        help="mt9p031 (default; Terasic D5M), ov5640, mt9d111; imx219, ov5647: the "
                             "camera modules 2 and 1 of the Raspberry Pi, with CSI-2 (ulx3s); "
                             "pattern: no camera, a test card in block RAM (ulx3s)")
    add_mode(parser)
    add_field(parser)
    parser.add_argument("--pixel-clock-mhz", type=float, metavar="MHZ",
                        help="of the sensor, made by its own phase-locked loop (default: 25, "
                             "without)")
    parser.add_argument("--exposure-us", type=float, metavar="X",
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
    parser.add_argument("--synthesize-only", action="store_true",
                        help="stop before place and route: the netlist instead of the bitstream "
                             "(not for Quartus)")
    parser.add_argument("-o", "--output", metavar="DIR",
                        help="folder to write to (default: the board's name)")
    add_json(parser)


def run(args) -> None:
    """Check, generate, synthesise, place and route, pack, write."""
    if not 1 <= args.seeds <= _MAX_SEEDS:
        raise InputError(f"seeds is {args.seeds}, 1 to {_MAX_SEEDS} are tried")
    board = board_for("build", args.board)
    named = [(path, Descriptor.load(path)) for path in args.descriptor]
    output, opened = Path(args.output or board.name), board.tools == "open"
    if opened:
        check_tools()
    elif args.synthesize_only:
        raise InputError(f"--synthesize-only is given, the design of the {board.name} is "
                         "synthesised by Quartus")
    kind = "v" if not opened else "json" if args.synthesize_only else "bit"
    # An output that cannot be written is reported before half an hour of work.
    check_outputs([output / f"{project_name(board)}.{kind}"], args.descriptor)
    design = board.design(named, _request(args), planner())
    began, steps = time.monotonic(), Steps("ncdc build", quiet=args.json == "-" or not opened)
    sources = _processor(args, design) if design.processor else {}
    steps("generating the design")
    files = board.files(design, [name for name in sources if name.endswith(".v")])
    report = {"board": board.name, "sensor": args.sensor,
              "clocks": [{"name": name, "target_mhz": mhz}
                         for name, mhz in design.clocks.targets().items()],
              **board.rates(design), **field_report(*design.sensor, named[0][1].geometry)}
    if opened:
        files, made = implemented(design, files, sources, steps, seeds=args.seeds,
                                  synthesize_only=args.synthesize_only)
        report |= made | {"seconds": round(time.monotonic() - began, 1)}
        steps("done")
    files |= sources | driver_files(design.system.corrector, named, design.system.table)
    report |= _written(board, output, files)
    if not write_report(report, args.json):
        _print(report, board, output, design)


def _request(args):
    """The :class:`Request` of the command's options."""
    settings = settings_of(args, "exposure_us", "field")
    if args.pixel_clock_mhz is not None:
        settings["pixel_clock_hz"] = round(args.pixel_clock_mhz * 1e6)
    return Request(args.sensor, args.mode, settings, colour=args.colour, processor=args.system)


def _written(board, output, files):
    """Write the files, but no file of the user that is there; their part of the report."""
    existing = [name for name in board.user_files if (output / name).exists()]
    files = {name: content for name, content in files.items() if name not in existing}
    for name, content in files.items():
        write = write_bytes if isinstance(content, bytes) else write_text
        write(output / name, content)
    return {"files": [str(output / name) for name in files],
            "kept": [str(output / name) for name in existing]}


def _processor(args, design):
    """Files of the processor, by name."""
    from ncdc_soc.board import processor_files  # LiteX is of the extra [soc]
    from ncdc_soc.firmware import Identity
    try:
        address = str(IPv4Address(args.address))
    except ValueError as error:
        raise InputError(f"the address {args.address!r} is no IPv4 address") from error
    identity = Identity(ip=address, **{} if args.mac is None else {"mac": args.mac})
    files = processor_files(design, design.sensor, identity)
    return files.verilog | files.memories


def _print(report, board, output, design):
    """Print the report of what was written to the folder ``output``."""
    for clock in report["clocks"]:
        if "achieved_mhz" not in clock:
            print(f"{clock['name']:>16}: {clock['target_mhz']:7.2f} MHz needed")
            continue
        slack = 1 - clock["target_mhz"] / clock["achieved_mhz"]
        spare = 1000 / clock["target_mhz"] - 1000 / clock["achieved_mhz"]
        print(f"{clock['name']:>16}: {clock['achieved_mhz']:7.2f} MHz of "
              f"{clock['target_mhz']:7.2f}, slack {spare:.2f} ns, {100 * slack:.0f} %")
    for line in field_lines(*design.sensor, design.system.descriptor.geometry):
        print(line)
    print_rates(report)
    for name in report["kept"]:
        print(f"{name}: yours, left as it is")
    if board.tools == "open":
        print_implemented(report, board, output)
    else:
        print(f"{output}: {len(report['files'])} files; sh {output / 'build.sh'} makes the "
              f"bitstream, with Quartus Prime Lite")

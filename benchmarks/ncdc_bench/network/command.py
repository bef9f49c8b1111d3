"""``ncdc bench network``: the whole system in simulation, on a network, with others' clients."""

from operator import itemgetter

from ncdc.cli.common import add_json, report_failures, write_report
from ncdc.terminal import Steps
from ncdc.text_table import text_table
from ncdc_boards.catalogue import board
from ncdc_spec.errors import InputError

__all__ = ["EXAMPLE", "HELP", "add_arguments", "failures", "run", "table"]

HELP = ("the system with processor and Ethernet in simulation: pictures that Aravis and "
        "viva-genicam take, clocks per command")
EXAMPLE = "ncdc bench network --quick --json -"
_SIZE, _QUICK_SIZE = (640, 480), (64, 48)
_LIMITS = {"GVCP": 3000, "Table I": 25000}      # clocks per command; twice that while streaming
_COLUMNS = ("peer", "what", "frames", "pixels_different", "megabytes_per_second", "underruns",
            "resent", "clocks_per_command", "most_clocks_per_command", "clocks_per_pixel")
_BOARD_COLUMNS = ("peer", "what", "format", "frames", "pixels_different", "frames_per_second",
                  "slowest_per_second", "megabytes_per_second", "underruns", "dropped", "lost",
                  "memory_percent", "clocks_per_pixel")
_CORE_MHZ = 75, 100     # of the projects that ncdc build writes; what the goals are for
_SIZES = ("part", "target", "alm", "lut", "ff", "dsp", "ram_blocks")


def add_arguments(parser):
    """Declare the command's arguments on an argparse parser."""
    parser.add_argument("--quick", action="store_true", help="pictures of 64x48: two minutes")
    instead = parser.add_mutually_exclusive_group()
    instead.add_argument("--sizes", action="store_true",
                         help="the sizes of the parts on Cyclone V and ECP5 instead, by Yosys")
    instead.add_argument("--board", metavar="NAME",
                         help="pictures of 1280x1024 that a board's own memory, camera, corrector "
                              "and packetiser send on a gigabit line instead: de2-115")
    parser.add_argument("--core-mhz", type=int, choices=_CORE_MHZ,
                        help="with --board: clock of its core and SDRAM (default: 100)")
    parser.add_argument("--screen", action="store_true",
                        help="with --board: once more with a screen that shows them")
    add_json(parser)


def run(args):
    """Measure and report; 1 if a row is not as it has to be."""
    for option in ("screen", "core_mhz"):
        if getattr(args, option) and not args.board:
            raise InputError(f"--{option.replace('_', '-')} is given without --board, to which it "
                             "belongs")
    from ncdc_bench.network.board import CORE_MHZ, FULL, board_rows, shortfalls
    from ncdc_bench.network.measure import rows_of
    from ncdc_bench.network.sizes import sizes_of
    if args.sizes:
        rows = list(sizes_of(_QUICK_SIZE if args.quick else _SIZE, Steps("sizes")))
        if not write_report({"rows": rows}, args.json):
            print(table(rows, _SIZES))
        return 0
    if args.board:
        rows = board_rows(board(args.board), _QUICK_SIZE if args.quick else FULL, Steps("board"),
                          args.core_mhz or CORE_MHZ, args.screen)
    else:
        rows = rows_of(_QUICK_SIZE if args.quick else _SIZE, Steps("network"))
    if not write_report({"rows": rows}, args.json):
        print(table(rows, _BOARD_COLUMNS if args.board else _COLUMNS))
    return report_failures("bench network",
                           failures(rows) + (shortfalls(rows) if args.board else []))


def failures(rows):
    """Sentences on what is wrong in ``rows``."""
    found = []
    for row in rows:
        name = f"{row['peer']}, {row['what']}"
        if row["pixels_different"]:
            found.append(f"{name}: {row['pixels_different']} pixels differ")
        if row["underruns"]:
            found.append(f"{name}: {row['underruns']} frames broke on the wire")
        clocks, limit = row["clocks_per_command"], _LIMITS.get(row["peer"])
        if clocks is not None:
            limit *= 1 if row["what"] == "idle" else 2
            if clocks > limit:
                found.append(f"{name}: a command takes {clocks} clocks, {limit} is the limit")
    return found


def table(rows, columns=_COLUMNS):
    """The rows as text."""
    return text_table([(name.replace("_", " "), itemgetter(name)) for name in columns], rows,
                      left=2)

"""``ncdc generate``: writes the corrector's Verilog and what belongs to it."""

from pathlib import Path

from ncdc_boards.catalogue import board as board_of, board_names
from ncdc_boards.project import check_board, project_files
from ncdc_hdl.cli.common import add_json, write_report
from ncdc_hdl.cli.plan import add_choices, planned_fetch
from ncdc_hdl.corrector import DATA_WIDTHS, OUTPUTS, Corrector
from ncdc_hdl.export.drivers import driver_files
from ncdc_hdl.export.fusesoc import fusesoc_core
from ncdc_hdl.export.platform_designer import COMPONENT, hw_tcl
from ncdc_hdl.export.verilog import TOP, verilog_of
from ncdc_hdl.export.waivers import verilator_config
from ncdc_hdl.options import FETCHERS, HIDDEN, LANES, PRODUCTS, FrontEndOptions
from ncdc_model.descriptor import Descriptor
from ncdc_model.files import write_text

__all__ = ["EXAMPLE", "HELP", "add_arguments", "add_hardware", "hardware", "run"]

HELP = "write the Verilog of the corrector and its drivers"
EXAMPLE = "ncdc generate net.toml -o hardware --data-width 32"


def add_hardware(parser):
    """Declare the options that choose the hardware."""
    parser.add_argument("--fetch", choices=FETCHERS, default=FETCHERS[0],
                        help="how raw windows are read: cache (default), a prefetching cache of "
                             "tiles, or multiport, the paper's three burst readers")
    add_choices(parser)
    parser.add_argument("--pixels-per-clock", type=int, choices=LANES, default=1, metavar="N",
                        help="1 (default), 2 or 4 neighbouring pixels at a time, each with a "
                             "network of its own; same results")
    parser.add_argument("--data-width", type=int, choices=DATA_WIDTHS, default=32, metavar="BITS",
                        help="width of the memory ports: 32 (default), 64 or 128")
    parser.add_argument("--to", choices=OUTPUTS, default="memory",
                        help="where corrected pixels go: memory (default) or a video stream")
    parser.add_argument("--hidden", choices=HIDDEN, default="multiply",
                        help="hidden neurons: multiply (default), or raster, which add from pixel "
                             "to pixel and need no multiplier; same results")
    parser.add_argument("--share", type=int, default=1, metavar="N",
                        help="hidden neurons per tan-sigmoid (default: 1); one pixel every N "
                             "clocks, same results, smaller")
    parser.add_argument("--products", type=int, choices=PRODUCTS, default=27, metavar="BITS",
                        help="width of the device's multiplier blocks: 27 (default), or 18, for "
                             "which products are cut into parts; same results")


def hardware(args, descriptor):
    """The chosen hardware, as keyword arguments of Corrector and corrector_verilog, and a line on
    what was planned, None if nothing was."""
    fetch, planned = planned_fetch(args, descriptor)
    return {"data_width": args.data_width, "output": args.to,
            "front_end": FrontEndOptions(hidden=args.hidden, share=args.share,
                                         products=args.products, lanes=args.pixels_per_clock),
            "fetch": fetch}, planned


def add_arguments(parser):
    """Declare the command's arguments on an argparse parser."""
    parser.add_argument("descriptor", metavar="NET", help="descriptor of ncdc train")
    parser.add_argument("-o", "--output", required=True, metavar="DIR", help="folder to write to")
    add_hardware(parser)
    parser.add_argument("--lens", action="append", default=[], metavar="NET",
                        help="another descriptor that the same hardware may be given at run time, "
                             "for the drivers; may be repeated")
    parser.add_argument("--board", metavar="NAME",
                        help=f"write a Quartus project too: {', '.join(board_names())}; the board "
                             f"chooses --data-width, --to and --products unless they are given")
    parser.set_defaults(data_width=None, to=None, products=None)
    add_json(parser)


def _settle(args, board):
    """Fill in what the user left open: the board's choice, or ours."""
    chosen = {"data_width": 32, "to": "memory", "products": 27}
    if board:
        chosen = {"data_width": board.data_width, "products": board.multiplier_bits,
                  "to": "stream"}
    for name, value in chosen.items():
        if getattr(args, name) is None:
            setattr(args, name, value)


def _fetch_report(fetch, descriptor):
    """What the cache is, under the names in reports; zeros without one."""
    if fetch.fetcher != "cache":
        return {"cache_bytes": 0, "cache_split": 0, "strip": fetch.strip}
    geometry = descriptor.geometry
    return {"cache_bytes": fetch.cache_for(geometry).bytes,
            "cache_split": fetch.split_for(geometry), "strip": fetch.strip}


def run(args):
    """Generate and write; files that would not change are left alone."""
    descriptor = Descriptor.load(args.descriptor)
    lenses = [(args.descriptor, descriptor), *((path, Descriptor.load(path)) for path in args.lens)]
    board = board_of(args.board) if args.board else None
    _settle(args, board)
    if board:
        check_board(board, descriptor, args.to)
    chosen, planned = hardware(args, descriptor)
    corrector = Corrector(descriptor, **chosen)
    files = {f"{TOP}.v": verilog_of(corrector),
             **driver_files(corrector, lenses), f"{TOP}.core": fusesoc_core(corrector, TOP),
             f"{COMPONENT}_hw.tcl": hw_tcl(corrector),
             f"{TOP}.vlt": verilator_config()}
    if board:
        files |= project_files(board, corrector)
    folder = Path(args.output)
    for name, text in files.items():
        write_text(folder / name, text)
    report = {"hidden_neurons": descriptor.hidden_neurons, "digest": descriptor.digest,
              "fetch": args.fetch, "data_width": args.data_width, "output": args.to,
              "hidden": args.hidden, "share": args.share, "products": args.products,
              **_fetch_report(chosen["fetch"], descriptor),
              "pixels_per_clock": args.pixels_per_clock,
              "board": args.board, "left_to_user": board.left_to_user if board else {},
              "files": [str(folder / name) for name in files]}
    if not write_report(report, args.json):
        if planned:
            print(planned)
        for name, text in files.items():
            print(f"{folder / name}: {len(text.splitlines())} lines")
        for what, why in report["left_to_user"].items():
            print(f"left to the user: {what}: {why}")

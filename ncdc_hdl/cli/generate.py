"""``ncdc generate``: writes the corrector's Verilog and what belongs to it."""

from pathlib import Path

from ncdc_hdl.cli.common import add_json, write_report
from ncdc_hdl.corrector import DATA_WIDTHS, OUTPUTS
from ncdc_hdl.export.c_header import c_header
from ncdc_hdl.export.verilog import TOP, corrector_verilog
from ncdc_hdl.options import HIDDEN, PRODUCTS, FrontEndOptions
from ncdc_model.descriptor import Descriptor
from ncdc_model.files import write_text

__all__ = ["EXAMPLE", "FETCHERS", "HELP", "add_arguments", "add_hardware", "hardware",
           "run"]

HELP = "write the Verilog of the corrector and its register header"
EXAMPLE = "ncdc generate net.toml -o hardware --data-width 32"
FETCHERS = ("multiport",)


def add_hardware(parser):
    """Declare the options that choose the hardware."""
    parser.add_argument("--fetch", choices=FETCHERS, default="multiport",
                        help="how raw windows are read: multiport, the paper's three burst readers")
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


def hardware(args):
    """The chosen hardware, as keyword arguments of Corrector and corrector_verilog."""
    return {"data_width": args.data_width, "output": args.to,
            "front_end": FrontEndOptions(hidden=args.hidden, share=args.share,
                                         products=args.products)}


def add_arguments(parser):
    """Declare the command's arguments on an argparse parser."""
    parser.add_argument("descriptor", metavar="NET", help="descriptor of ncdc train")
    parser.add_argument("-o", "--output", required=True, metavar="DIR", help="folder to write to")
    add_hardware(parser)
    add_json(parser)


def run(args):
    """Generate and write; files that would not change are left alone."""
    descriptor = Descriptor.load(args.descriptor)
    files = {f"{TOP}.v": corrector_verilog(descriptor, **hardware(args)),
             "ncdc_registers.h": c_header(descriptor, args.data_width)}
    folder = Path(args.output)
    for name, text in files.items():
        write_text(folder / name, text)
    report = {"hidden_neurons": descriptor.hidden_neurons, "digest": descriptor.digest,
              "fetch": args.fetch, "data_width": args.data_width, "output": args.to,
              "hidden": args.hidden, "share": args.share, "products": args.products,
              "files": [str(folder / name) for name in files]}
    if not write_report(report, args.json):
        for name, text in files.items():
            print(f"{folder / name}: {len(text.splitlines())} lines")

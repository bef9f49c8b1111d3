"""``ncdc generate``: writes the corrector's Verilog and what belongs to it."""

from pathlib import Path

from ncdc_hdl.cli.common import add_json, write_report
from ncdc_hdl.corrector import DATA_WIDTHS, OUTPUTS
from ncdc_hdl.export.c_header import c_header
from ncdc_hdl.export.verilog import TOP, corrector_verilog
from ncdc_model.descriptor import Descriptor
from ncdc_model.files import write_text

__all__ = ["EXAMPLE", "FETCHERS", "HELP", "add_arguments", "add_hardware", "run"]

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


def add_arguments(parser):
    """Declare the command's arguments on an argparse parser."""
    parser.add_argument("descriptor", metavar="NET", help="descriptor of ncdc train")
    parser.add_argument("-o", "--output", required=True, metavar="DIR", help="folder to write to")
    add_hardware(parser)
    add_json(parser)


def run(args):
    """Generate and write; files that would not change are left alone."""
    descriptor = Descriptor.load(args.descriptor)
    files = {f"{TOP}.v": corrector_verilog(descriptor, data_width=args.data_width, output=args.to),
             "ncdc_registers.h": c_header(descriptor, args.data_width)}
    folder = Path(args.output)
    for name, text in files.items():
        write_text(folder / name, text)
    report = {"hidden_neurons": descriptor.hidden_neurons, "digest": descriptor.digest,
              "fetch": args.fetch, "data_width": args.data_width, "output": args.to,
              "files": [str(folder / name) for name in files]}
    if not write_report(report, args.json):
        for name, text in files.items():
            print(f"{folder / name}: {len(text.splitlines())} lines")

"""``ncdc lot export``: the image of each unit's EEPROM."""

import tempfile
from pathlib import Path

from ncdc.cli.common import add_json, write_report
from ncdc.cli.lot_run import database_at
from ncdc.lot.figures import LOOK, PASS
from ncdc.terminal import Progress
from ncdc_spec.descriptor import Descriptor
from ncdc_spec.eeprom import pack
from ncdc_spec.errors import InputError
from ncdc_spec.files import write_bytes

__all__ = ["EXAMPLE", "add_arguments", "run"]

EXAMPLE = "ncdc lot export lot -o eeprom --neurons 8"


def add_arguments(parser) -> None:
    """Declare the action's arguments on an argparse parser."""
    parser.add_argument("lot", metavar="LOT", help="folder or address of ncdc lot run -o")
    parser.add_argument("-o", "--output", default="eeprom", metavar="FOLDER",
                        help="folder for SERIAL.bin of each unit (default: eeprom)")
    parser.add_argument("--neurons", type=int, metavar="N",
                        help="hidden neurons of the hardware, for networks with fewer (default: "
                             "those of each network)")
    parser.add_argument("--look", action="store_true",
                        help="also the units to look at, not only those that pass")
    add_json(parser)


def run(args) -> None:
    """Write the images."""
    database = database_at(args.lot)
    wanted = {PASS, LOOK} if args.look else {PASS}
    count, progress = sum(database.counts()[verdict] for verdict in wanted), Progress("export")
    if not count:
        raise InputError(f"{args.lot} has no unit to export: none has the verdict "
                         f"{' or '.join(sorted(wanted))}")
    for row in database.rows():
        if row["verdict"] in wanted and args.neurons is not None and row["neurons"] > args.neurons:
            raise InputError(f"the unit {row['serial']} has {row['neurons']:g} hidden neurons, the "
                             f"hardware has {args.neurons}")
    written, largest = 0, 0
    for row in database.rows():
        if row["verdict"] in wanted:
            image = pack(row["serial"], _descriptor(database.descriptor(row["serial"])),
                         args.neurons)
            write_bytes(Path(args.output) / f"{row['serial']}.bin", image)
            written, largest = written + 1, max(largest, len(image))
            progress(written / count)
    database.close()
    if not write_report({"images": written, "largest_bytes": largest}, args.json):
        print(f"{written} images of up to {largest} bytes in {args.output}")


def _descriptor(text):
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "net.toml"
        path.write_text(text)
        return Descriptor.load(path)

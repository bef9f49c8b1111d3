"""``ncdc eeprom``: the image of a camera's EEPROM."""

from ncdc.cli.common import add_json, write_report
from ncdc_spec.descriptor import Descriptor
from ncdc_spec.eeprom import check_like, pack, unpack
from ncdc_spec.errors import reading
from ncdc_spec.files import check_outputs, read_bytes, write_bytes

__all__ = ["EXAMPLE", "add_arguments", "run"]

EXAMPLE = "ncdc eeprom write net.toml --serial A0017 -o A0017.bin"


def add_arguments(parser) -> None:
    """Declare one subcommand per action on an argparse parser."""
    actions = parser.add_subparsers(dest="action", metavar="ACTION", required=True)
    show = _action(actions, "show", "print what an image holds, or why it is rejected")
    show.add_argument("eeprom", metavar="IMAGE", help="bytes of the EEPROM")
    _add_like(show)
    add_json(show)
    write = _action(actions, "write", "write the image of a descriptor")
    write.add_argument("descriptor", metavar="NET", help="descriptor of ncdc train")
    write.add_argument("--serial", required=True, metavar="TEXT",
                       help="serial number, 1 up to 32 characters")
    write.add_argument("--neurons", type=int, metavar="N",
                       help="hidden neurons of the hardware (default: those of the network)")
    write.add_argument("-o", "--output", required=True, metavar="IMAGE", help="file to write")
    read = _action(actions, "read", "write the descriptor in an image")
    read.add_argument("eeprom", metavar="IMAGE", help="bytes of the EEPROM")
    _add_like(read)
    read.add_argument("-o", "--output", required=True, metavar="NET", help="descriptor to write")


def _action(actions, name, text):
    return actions.add_parser(name, help=text, description=text, epilog=f"example: {EXAMPLE}")


def _add_like(parser):
    parser.add_argument("--for", dest="like", metavar="NET",
                        help="descriptor of the hardware: an image for other hardware is rejected")


def run(args) -> None:
    """Show, write or read."""
    if args.action == "write":
        image = pack(args.serial, Descriptor.load(args.descriptor), args.neurons)
        write_bytes(args.output, image)
        print(f"{args.output}: {len(image)} bytes")
        return
    with reading(args.eeprom):
        image = unpack(read_bytes(args.eeprom))
        if args.like:
            check_like(image, Descriptor.load(args.like))
    if args.action == "read":
        check_outputs([args.output], [args.eeprom, *filter(None, [args.like])])
        image.descriptor.save(args.output)
        print(f"{args.output}: the lens of {image.serial}")
        return
    one = image.descriptor
    report = {"serial": image.serial, "digest": one.digest, "hidden_neurons": one.hidden_neurons,
              "skip": one.skip_weights is not None, "corrected": list(one.geometry.corrected),
              "distorted": list(one.geometry.distorted), "bayer": one.geometry.bayer,
              "interpolation": one.geometry.interpolation.name, "nodes": one.nodes,
              "tansig": one.variant}
    if not write_report(report, args.json):
        for name, value in report.items():
            text = "x".join(map(str, value)) if isinstance(value, list) else value
            print(f"{name.replace('_', ' '):<16} {text}")

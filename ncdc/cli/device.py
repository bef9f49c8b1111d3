"""``ncdc device``: an emulated device on the network."""

import signal
import sys
import time
from ipaddress import IPv4Address

from ncdc.cli.commands import COMMANDS
from ncdc.cli.common import add_samples, raw_frame
from ncdc.cli.field import add_field, field_of
from ncdc.cli.renamed import add_renamed
from ncdc.terminal import say
from ncdc_host.device.emulated import Announcer, DeviceOptions, EmulatedDevice, lens_corrections
from ncdc_model.correction import default_model
from ncdc_spec.descriptor import Descriptor
from ncdc_spec.eeprom import LOADED, NO_CHIP, start
from ncdc_spec.errors import InputError
from ncdc_spec.files import read_bytes
from ncdc_spec.protocols.gvcp import PORT
from ncdc_spec.protocols.table_one import TCP_PORT

__all__ = ["EXAMPLE", "add_arguments", "run"]

EXAMPLE = "ncdc device serve net.toml --photo photo.raw.png --count 3"
_COUNT_MAX = 16


def add_arguments(parser) -> None:
    """Declare the command's arguments on an argparse parser."""
    serve = parser.add_subparsers(dest="action", metavar="ACTION", required=True).add_parser(
        "serve", help=COMMANDS["device"], description=COMMANDS["device"],
        epilog=f"example: {EXAMPLE}")
    serve.add_argument("descriptors", metavar="NET", nargs="+",
                       help="descriptors of ncdc train, one a lens, all of one size")
    serve.add_argument("--photo", metavar="IMAGE",
                       help="what the camera looks at: a raw frame, or a colour picture to be "
                       "mosaiced (default: the built-in scene, in motion)")
    add_samples(serve.add_argument_group("samples of the file"))
    serve.add_argument("--address", default="127.0.0.2", metavar="IPV4",
                       help="of this machine; further devices take the following ones "
                       "(default: 127.0.0.2)")
    serve.add_argument("--count", type=int, default=1, metavar="N", help="devices (default: 1)")
    serve.add_argument("--sensor", default="mt9p031", metavar="NAME",
                       help="of the device: mt9p031 (default), imx219, ov5647; its registers, "
                       "limits and test patterns are those of a device with that sensor")
    add_field(serve)
    serve.add_argument("--eeprom", metavar="IMAGE",
                       help="content of the camera's EEPROM, as of ncdc lot export: its lens "
                       "replaces the first one, unless the image is rejected")
    serve.add_argument("--fps", type=float, default=30.0, metavar="F",
                       help="frames per second after reset (default: 30)")
    serve.add_argument("--packet-loss", type=float, default=0.0, metavar="P",
                       help="part of the stream's packets that gets lost on purpose, as 0.01 "
                       "(default: 0)")
    add_renamed(serve, "--loss", "--packet-loss", type=float)
    serve.add_argument("--resend-loss", type=float, default=0.0, metavar="P",
                       help="part of those sent again that gets lost (default: 0)")
    add_renamed(serve, "--loss-again", "--resend-loss", type=float)
    serve.add_argument("--noise", type=float, default=1.0, metavar="S",
                       help="read noise of the sensor, grey levels; 0: no noise at all "
                       "(default: 1)")
    serve.add_argument("--tcp-port", type=int, default=TCP_PORT, metavar="P",
                       help=f"of Table I (default: {TCP_PORT})")


def _frame(args, geometry):
    """Raw frame of the photo, or None without one."""
    if args.photo is None:
        return None
    return raw_frame(args.photo, geometry, args.raw, args.bits)[0]


def _started(path, built_in):
    """The first lens, and the state of the EEPROM with the content at ``path``, or without one."""
    if path is None:
        return built_in, NO_CHIP
    descriptor, state, text = start(read_bytes(path), built_in)
    print(f"{path}: {text}" + ("" if state == LOADED else "; the built-in lens stays"),
          file=sys.stderr, flush=True)
    return descriptor, state


def run(args) -> None:
    """Serve until a signal ends the process."""
    if not 1 <= args.count <= _COUNT_MAX:
        raise InputError(f"{args.count} devices are asked for, the limits are 1 and {_COUNT_MAX}")
    if not 0 <= args.tcp_port <= 0xFFFF:
        raise InputError(f"the TCP port is {args.tcp_port}, the limits are 0 and 65535")
    descriptors = [Descriptor.load(path) for path in args.descriptors]
    descriptors[0], state = _started(args.eeprom, descriptors[0])
    image = _frame(args, descriptors[0].geometry)
    try:
        first = IPv4Address(args.address)
        addresses = [str(first + k) for k in range(args.count)]
    except ValueError as error:
        raise InputError(f"the address {args.address!r} is no IPv4 address") from error
    every = [DeviceOptions(address, fps=args.fps, loss=args.packet_loss, noise=args.noise,
                           loss_again=args.resend_loss, tcp_port=args.tcp_port,
                           field=field_of(args), sensor=args.sensor, eeprom=state)
             for address in addresses]
    default_model(say)          # says so if the pictures will be slow
    print("preparing the correction", file=sys.stderr, flush=True)
    corrections = lens_corrections(descriptors)
    devices, announcer = [], None
    try:
        for options in every:
            devices.append(EmulatedDevice(corrections, options, image))
            print(f"{options.serial} at {options.address}: Table I on TCP port "
                  f"{devices[-1].table.port}, GVCP on UDP port {PORT}", flush=True)
        announcer = Announcer(devices)
        signal.signal(signal.SIGTERM, lambda *_: sys.exit(0))
        print("Ctrl-C ends it", file=sys.stderr, flush=True)
        while True:
            time.sleep(3600)
    except KeyboardInterrupt:
        pass
    finally:
        if announcer is not None:
            announcer.close()
        for device in devices:
            device.close()

"""``ncdc soc``: the whole system in simulation, processor and Ethernet, for network programs."""

import signal
import sys
import tempfile
from dataclasses import replace

import numpy as np

from ncdc.cli.common import add_json, add_samples, raw_frame, write_report
from ncdc.cli.field import add_field, field_of
from ncdc.cli.hardware import add_single_view
from ncdc.cli.renamed import add_renamed
from ncdc_model.golden.corrector import check_raw
from ncdc_model.images import check_suffix, write_image
from ncdc_sim.link.namespaces import CLIENT, TAP, TapNetwork
from ncdc_spec.descriptor import Descriptor
from ncdc_spec.eeprom import start
from ncdc_spec.errors import InputError, reading
from ncdc_spec.files import read_bytes

__all__ = ["EXAMPLE", "add_arguments", "run"]

EXAMPLE = "ncdc soc run --sim net.toml --photo photo.png"
_EXPOSURES_US = (1.0, 1e6)
_LOSS_STEPS = 1000              # in which the simulation counts lost packets


def add_arguments(parser) -> None:
    """Declare the command's arguments on an argparse parser."""
    actions = parser.add_subparsers(dest="action", metavar="ACTION", required=True)
    for name, text in (("build", "compile the simulation and the firmware"),
                       ("run", "run it on a network of its own, until interrupted")):
        action = actions.add_parser(name, help=text, description=text,
                                    epilog=f"example: {EXAMPLE}")
        action.add_argument("--sim", required=True, metavar="NET", dest="descriptor",
                            help="descriptor of ncdc train")
        action.add_argument("--exposure-us", type=float, default=1000.0, metavar="X",
                            help="of the sensor at first, in microseconds; then the light is as in "
                                 "the photo (default: 1000)")
        action.add_argument("--sensor", default="mt9p031", metavar="NAME",
                            help="of the system: mt9p031 (default), imx219, ov5647")
        add_field(action)
        action.add_argument("--colour", action="store_true",
                            help="gains of the colours and automatic white balance")
        add_single_view(action)
        if name == "build":
            add_json(action)
            continue
        action.add_argument("--photo", required=True, dest="image", metavar="IMAGE",
                            help="what the camera looks at: a raw frame, or a colour picture to be "
                                 "mosaiced")
        action.add_argument("--eeprom", metavar="IMAGE",
                            help="content of the EEPROM on the sensor's bus, as of ncdc lot export "
                                 "(default: there is none)")
        action.add_argument("--packet-loss", type=float, default=0.0, metavar="P",
                            help="part of the packets of pictures that gets lost, as 0.01, in "
                                 "steps of 0.001 (default: 0)")
        add_renamed(action, "--loss", "--packet-loss", type=int,
                    convert=lambda steps: steps / _LOSS_STEPS)
        action.add_argument("-o", "--output", metavar="IMAGE",
                            help="write the picture that clients receive, by the golden model: not "
                                 "that of ncdc correct, as the sensor has a black level")
        add_samples(action.add_argument_group("samples of the file"))


def run(args) -> int | None:
    """Build, or build and run."""
    low, high = _EXPOSURES_US
    if not low <= args.exposure_us <= high:
        raise InputError(f"the exposure is {args.exposure_us:g} us, the limits are {low:g} and "
                         f"{high:g}")
    if args.action == "run" and not 0 <= args.packet_loss <= 1:
        raise InputError(f"the packet loss is {args.packet_loss:g}, the limits are 0 and 1")
    descriptor = Descriptor.load(args.descriptor)
    return _build(args, descriptor) if args.action == "build" else _run(args, descriptor)


def _model(args, descriptor, raw):
    from ncdc_sim.system.soc import HARDWARE, SocModel  # LiteX is of the extra [soc]
    hardware = replace(HARDWARE, colour=args.colour, view=args.view)
    return SocModel(descriptor, raw, args.exposure_us, hardware, field=field_of(args),
                    sensor=args.sensor)


def _build(args, descriptor):
    # The program is the same whatever the camera looks at.
    model = _model(args, descriptor, np.zeros(descriptor.geometry.distorted[::-1], np.uint8))
    report = {"program": str(model.program), "code_bytes": model.code_bytes,
              "ram_bytes": model.ram_bytes}
    if not write_report(report, args.json):
        print(f"{model.program}; firmware of {model.code_bytes} bytes, {model.ram_bytes} bytes of "
              f"RAM without its stack")
    return 0


def _eeprom(path):
    from ncdc_sim.system.soc import check_eeprom
    content = read_bytes(path)
    with reading(path):
        check_eeprom(content)
    return content


def _run(args, descriptor):
    raw, note = raw_frame(args.image, descriptor.geometry, args.raw, args.bits)
    if note:
        print(note, file=sys.stderr)
    check_raw(raw, descriptor.geometry)
    if args.output:
        check_suffix(args.output)
    eeprom = _eeprom(args.eeprom) if args.eeprom else None
    model = _model(args, descriptor, raw)
    if args.output:
        lens = descriptor if eeprom is None else start(eeprom, descriptor)[0]
        write_image(args.output, model.golden(lens=lens).picture)
    address = model.identity.ip
    with TapNetwork() as network, tempfile.TemporaryDirectory(prefix="ncdc-") as folder:
        model.fill(folder, eeprom)
        print(f"the device is {address}, this side of its network {CLIENT}; programs join it by\n"
              f"    nsenter --preserve-credentials -U -n -t {network.holder} PROGRAM\n"
              f"the speed is printed once per second; Ctrl-C ends the run", file=sys.stderr)
        # The end of the network ends the simulation, too.
        for number in (signal.SIGTERM, signal.SIGHUP):
            signal.signal(number, lambda *_: sys.exit(0))
        loss = f"+loss={round(_LOSS_STEPS * args.packet_loss)}"
        process = network.start(model.command(f"+tap={TAP}", loss, "+rate"), cwd=folder)
        try:
            return process.wait()
        except KeyboardInterrupt:
            process.terminate()
            process.wait()
    return 0

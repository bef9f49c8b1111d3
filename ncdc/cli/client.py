"""``ncdc client``: devices on the network."""

import sys
from pathlib import Path

from ncdc.cli.common import add_json, write_report
from ncdc.terminal import Progress, percent
from ncdc_host.client import discover, open_device, record
from ncdc_host.client.devices import SCHEMES
from ncdc_host.client.errors import printable
from ncdc_spec.errors import InputError
from ncdc_spec.files import check_outputs

__all__ = ["EXAMPLE", "add_arguments", "run"]

EXAMPLE = "ncdc client grab 10 -o frames --device tcp://127.0.0.2"


def add_arguments(parser) -> None:
    """Declare the command's arguments on an argparse parser."""
    actions = parser.add_subparsers(dest="action", metavar="ACTION", required=True)
    listing = actions.add_parser("list", help="devices that answer a broadcast")
    listing.add_argument("--interface", metavar="NAME", help="network interface to ask on "
                         "(default: all)")
    listing.add_argument("--back-end", choices=("gige", "aravis"), default="gige",
                         help="who asks: viva-genicam or Aravis (default: gige)")
    listing.set_defaults(run_action=_list)
    show = actions.add_parser("show", help="features of a device, with limits")
    show.set_defaults(run_action=_show)
    grab = actions.add_parser("grab", help="write pictures as PNG files")
    grab.add_argument("count", type=int, metavar="N", help="pictures")
    grab.add_argument("-o", "--output", required=True, metavar="DIR", help="folder to write to")
    grab.add_argument("--timeout", type=float, default=5.0, metavar="SECONDS",
                      help="to wait for each picture; a simulated device is slow (default: 5)")
    grab.add_argument("--packet-size", type=int, metavar="BYTES",
                      help="of a GVSP packet (default: the device's)")
    grab.set_defaults(run_action=_grab)
    setting = actions.add_parser("set", help="write features")
    setting.add_argument("assignments", nargs="+", metavar="NAME=VALUE")
    setting.set_defaults(run_action=_set)
    window = actions.add_parser("gui", help="a window: live pictures, settings, lenses")
    window.add_argument("urls", nargs="*", metavar="URL",
                        help="devices to open (default: none; the window lists those it finds)")
    window.add_argument("--demo", action="store_true", help="with two emulated devices")
    window.set_defaults(run_action=_gui)
    for action in (show, grab, setting):
        action.add_argument("--device", metavar="URL", help=f"{', '.join(SCHEMES)} with an "
                            "address, as in tcp://127.0.0.2 (default: the only one that answers)")
    for action in (listing, show, grab, setting):
        add_json(action)


def run(args) -> int | None:
    """Run the action."""
    return args.run_action(args)


def _open(url, monitor=False):
    if url is None:
        found = discover()
        if len(found) != 1:
            names = ", ".join(one.url for one in found) or "none"
            raise InputError(f"{len(found)} devices answer ({names}): say which one by --device")
        url = found[0].url
    return open_device(url, monitor)


def _list(args):
    found = discover(interface=args.interface, back_end=args.back_end)
    if not write_report({"devices": [vars(one) for one in found]}, args.json):
        for one in found:
            print(f"{one.url:<24} {one.mac}  {one.vendor} {one.model} {one.serial}".rstrip())
        if not found:
            print("no device answers", file=sys.stderr)


def _show(args):
    with _open(args.device, monitor=True) as device:
        features = device.features()
    report = {"device": device.url, "features": {name: vars(info)
                                                 for name, info in features.items()}}
    if write_report(report, args.json):
        return
    category = None
    for info in features.values():
        if info.category != category:
            category = info.category
            print(category)
        print(f"  {info.name:<22} {_value(info):<28} {_limits(info)}".rstrip())


def _value(info):
    if info.kind == "command":
        return "(command)"
    value = f"{info.value:g}" if info.kind == "float" else str(info.value)
    return f"{value} {info.unit}".strip()


def _limits(info):
    if info.choices:
        return ", ".join(info.choices)
    if info.minimum is None or info.kind not in ("integer", "float") or info.maximum >= 2**32 - 1:
        return ""
    step = f", step {info.increment:g}" if info.increment not in (None, 1) else ""
    return f"{info.minimum:g} to {info.maximum:g}{step}"


def _grab(args):
    if args.count < 1:
        raise InputError(f"{args.count} pictures are asked for, 1 is the limit")
    if not args.timeout > 0:
        raise InputError(f"the timeout is {args.timeout:g} seconds, it must be more than 0")
    check_outputs([Path(args.output) / "frames.csv"], [])
    with _open(args.device) as device, device.stream(args.packet_size) as frames:
        paths = record(frames, args.count, args.output, args.timeout,
                       percent(Progress("grabbing")))
        counted = frames.statistics
    report = {"device": device.url, "files": [str(path) for path in paths], **vars(counted)}
    if not write_report(report, args.json):
        print(f"{args.output}: {len(paths)} pictures; {counted.lost} lost, {counted.skipped} "
              f"skipped, {counted.resent} packets resent")


def _gui(args):
    try:
        from ncdc_host.gui.application import run as run_window
    except ImportError as error:
        if (error.name or "").partition(".")[0] == "PySide6" and "lib" not in str(error):
            raise               # the extra [gui] is not installed
        raise InputError(f"Qt cannot be loaded: {error}; on Debian: apt install libegl1 libgl1 "
                         "libxkbcommon0 libfontconfig1 libdbus-1-3") from None
    return run_window(args.urls, args.demo)


def _set(args):
    pairs = [assignment.partition("=") for assignment in args.assignments]
    for name, sign, _ in pairs:
        if not sign or not name:
            raise InputError(f"{name!r} is no NAME=VALUE")
    with _open(args.device) as device:
        values = {name: device.set(name, value) for name, _, value in pairs}
    if not write_report({"device": device.url, "values": values}, args.json):
        for name, value in values.items():
            print(f"{name} = {printable(value)}")

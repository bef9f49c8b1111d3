"""``ncdc generate``: writes the corrector's Verilog, its drivers and scripts."""

from pathlib import Path

from ncdc.cli.common import add_json, raw_frame, write_report
from ncdc.cli.hardware import (
    add_bus,
    add_hardware,
    add_reductions,
    add_view_registers,
    fixed_of,
    front_end_line,
    hardware_of,
    planned,
)
from ncdc_boards.catalogue import board_for
from ncdc_boards.platform_designer.niosv import NIOSV, niosv_tcl
from ncdc_hdl.axi.top import AxiTop
from ncdc_hdl.corrector import Corrector
from ncdc_hdl.export.drivers.drivers import driver_files
from ncdc_hdl.export.ip.axi import axi_files
from ncdc_hdl.export.ip.axi.component import IP_XACT, component_name
from ncdc_hdl.export.ip.fusesoc import fusesoc_core
from ncdc_hdl.export.ip.platform_designer import hw_tcl, packetiser_hw_tcl, system_hw_tcl
from ncdc_hdl.export.testbench import bench_files, instantiation
from ncdc_hdl.export.testbench.bench import pattern
from ncdc_hdl.export.verilog import TOP, module_verilog, verilog_of
from ncdc_hdl.export.verilog.axi_cover import AXI_SYSTEM, AXI_TOP
from ncdc_hdl.export.verilog.names import check_module_name
from ncdc_hdl.export.verilog.system_cover import SYSTEM, system_verilog
from ncdc_hdl.export.waivers import SYSTEM_WAIVERS, verilator_config
from ncdc_hdl.link.top import PACKETISER, PacketiserTop
from ncdc_hdl.system import System
from ncdc_hdl.usb.layouts import CHIPS
from ncdc_hdl.usb.system import UsbSystem
from ncdc_model.golden.corrector import check_raw
from ncdc_spec.camera_port import CSI2, PARALLEL, SAMPLE_BITS, SAMPLES_PER_CLOCK, camera_port
from ncdc_spec.descriptor import Descriptor
from ncdc_spec.errors import InputError
from ncdc_spec.files import write_text
from ncdc_spec.hardware import VIDEOS
from ncdc_spec.sensors.catalogue import SENSORS, sensor_named

__all__ = ["EXAMPLE", "add_arguments", "run"]

_NAMES = (TOP, AXI_TOP, SYSTEM, AXI_SYSTEM)     # of modules without --name
_SENSORS = [sensor.name for sensor in SENSORS]

EXAMPLE = "ncdc generate net.toml -o hardware --data-width 32"


def add_arguments(parser) -> None:
    """Declare the command's arguments on an argparse parser."""
    parser.add_argument("descriptor", metavar="NET", help="descriptor of ncdc train")
    parser.add_argument("-o", "--output", required=True, metavar="DIR", help="folder to write to")
    hardware = parser.add_argument_group("hardware", "none of it changes a pixel")
    add_hardware(hardware)
    hardware.add_argument("--raw-gains", action="store_true",
                          help="with registers for white balance of raw frames, before "
                               "interpolation, which change no pixel until they are written; for "
                               "raw frames that NCDC's own camera has not balanced")
    add_view_registers(hardware)
    add_reductions(hardware)
    add_bus(hardware)
    more = parser.add_argument_group("what is written")
    more.add_argument("--name", metavar="NAME",
                      help="name of the module, of those below it and of the hardware's files "
                           "(default: ncdc, with _system, _axi); two cores in one design need "
                           "two")
    more.add_argument("--lens", action="append", default=[], metavar="NET",
                      help="another descriptor that the same hardware may be given at run time, "
                           "for the drivers; may be repeated")
    more.add_argument("--board", metavar="NAME",
                      help="write a project for Platform Designer too: faka2; the board chooses "
                           "--data-width, --to and --multiplier-bits unless they are given")
    more.add_argument("--system", action="store_true",
                      help="write ncdc_system.v instead: a camera and stores of frames before "
                           "the corrector, which corrects each frame by itself")
    more.add_argument("--camera", metavar="KIND",
                      help="with --system, how the camera's samples come: parallel, a sensor's "
                           "pins (default); axis, AXI4-Stream video; avalon-st, Avalon-ST video, "
                           "avalon-st:vip with packets' types; csi2:1, csi2:2 or csi2:4, bytes of "
                           "as many CSI-2 lanes")
    more.add_argument("--samples-per-clock", type=int, choices=SAMPLES_PER_CLOCK, metavar="N",
                      help="of --camera axis and avalon-st: 1 (default), 2 or 4")
    more.add_argument("--sample-bits", type=int, choices=SAMPLE_BITS, metavar="BITS",
                      help="of the same: 8, 10, 12 (default) or 16, of which the upper 12 count")
    more.add_argument("--usb", choices=[name.lower() for name in CHIPS], metavar="CHIP",
                      help="with --system: registers, pictures and Table I over an FTDI chip, "
                           "ft232h or ft601; needs --sensor")
    more.add_argument("--sensor", choices=_SENSORS, metavar="NAME",
                      help=f"the sensor on the I2C bus: {', '.join(_SENSORS)}")
    more.add_argument("--packetiser", action="store_true",
                      help="write ncdc_packetiser.v too, which sends frames in memory as "
                           "Ethernet packets, and its component of Platform Designer")
    more.add_argument("--niosv", action="store_true",
                      help="with --system and --packetiser: also a script that joins them with a "
                           "Nios V and Altera's MAC in Platform Designer")
    more.add_argument("--testbench", nargs="?", const="", metavar="FRAME",
                      help="write a self-checking test bench for any simulator too, with the raw "
                           "frame and the expected picture; of FRAME, or of a pattern")
    add_json(parser)


def run(args) -> None:
    """Generate and write; files that would not change are left alone."""
    descriptor = Descriptor.load(args.descriptor)
    lenses = [(args.descriptor, descriptor), *((path, Descriptor.load(path)) for path in args.lens)]
    board = board_for("generate", args.board) if args.board else None
    hardware = hardware_of(args, board)
    _check_options(args, hardware)
    module = args.name or _default_name(args, hardware)
    hardware, choice = planned(hardware, fixed_of(args), descriptor)
    if args.system:
        system = System(descriptor, hardware, camera=camera_port(
            args.camera or PARALLEL, args.samples_per_clock, args.sample_bits))
        corrector = system.corrector
        if args.usb:
            system = UsbSystem(system, CHIPS[args.usb.upper()], sensor_named(args.sensor))
        files = _system_files(system, lenses, module)
    else:
        corrector = Corrector(descriptor, hardware)
        files = _corrector_files(corrector, lenses, module)
        if args.testbench is not None:
            files |= _bench(corrector, files[f"{module}.v"], module, args.testbench)
    if args.packetiser:
        packetiser = PacketiserTop(hardware.data_width)
        files |= _packetiser_files(packetiser, args.name)
        if args.niosv:
            files[f"{NIOSV}.tcl"] = niosv_tcl(hardware.data_width, system, packetiser)
    files[f"{module}_template.vh"] = instantiation(files[f"{module}.v"], module)
    if board:
        files |= board.files(corrector)
    folder = Path(args.output)
    _check_component(folder, files, module)
    for name, text in files.items():
        write_text(folder / name, text)
    report = {"hidden_neurons": descriptor.hidden_neurons, "digest": descriptor.digest,
              "nodes": descriptor.nodes, **corrector.hardware.report(descriptor.geometry),
              "board": args.board, "left_to_user": board.left_to_user if board else {},
              "files": [str(folder / name) for name in files]}
    if not write_report(report, args.json):
        if choice:
            print(choice)
        if descriptor.nodes > 1:
            print(front_end_line(corrector.hardware, descriptor))
        for name, text in files.items():
            print(f"{folder / name}: {len(text.splitlines())} lines")
        for what, why in report["left_to_user"].items():
            print(f"left to the user: {what}: {why}")


def _check_component(folder, files, module):
    """Reject a folder with the IP-XACT file of another core: every core's has the same name.

    The default names replace each other; ``module`` and a found name of --name do not.
    """
    path = folder / IP_XACT
    if IP_XACT not in files or not path.is_file():
        return
    found = component_name(path.read_text(errors="replace"))
    if found != module and not {found, module} <= set(_NAMES):
        raise InputError(f"{path} is of the core {found}, {module} needs another folder")


def _default_name(args, hardware):
    """Name of the module without --name."""
    if args.system:
        return AXI_SYSTEM if hardware.axi else SYSTEM
    return AXI_TOP if hardware.axi else TOP


def _check_options(args, hardware):
    """Reject options that exclude each other, and options without those that they need."""
    if args.name is not None:
        check_module_name(args.name)
    name, board, usb = (f"--{key} {getattr(args, key)}" for key in ("name", "board", "usb"))
    bench, packets = args.testbench is not None, hardware.video != VIDEOS[0]
    one_core, plain = "its scripts know one core, of the default name", "plain video only"
    for option in ("camera", "samples_per_clock", "sample_bits"):
        if getattr(args, option) is not None and not args.system:
            raise InputError(f"--{option.replace('_', '-')} {getattr(args, option)} is given, it "
                             "needs --system: a corrector alone reads its frames from memory")
    left_out = next((f"--{key.replace('_', '-')}" for key in
                     ("fixed_lens", "no_follow", "no_counters") if getattr(args, key)), None)
    for wrong, sentence in (
            (left_out and (args.system or args.board),
             f"{left_out} and --{'system' if args.system else 'board'} are given, only a corrector "
             f"alone can leave parts out"),
            (args.fixed_lens and args.lens,
             f"--fixed-lens and --lens {(args.lens or [''])[0]} are given, no other lens can be "
             f"loaded"),
            (args.system and args.board,
             f"--system and {board} are given, its project is of a corrector alone"),
            (hardware.axi and args.board,
             f"--bus axi and {board} are given, its project is for avalon"),
            (args.name and args.board, f"{name} and --board are given, {one_core}"),
            (args.name and args.niosv, f"{name} and --niosv are given, {one_core}"),
            (args.niosv and not (args.system and args.packetiser and not hardware.axi),
             "--niosv is given, it needs --system and --packetiser, for avalon: these are what it "
             "joins"),
            (args.usb and not args.system,
             f"{usb} is given, it needs --system: its pictures are those of a frame store"),
            (args.usb and hardware.axi,
             f"{usb} and --bus axi are given, USB is there for avalon only"),
            (bool(args.usb) != bool(args.sensor),
             "--usb and --sensor are given together: Table I reads and writes the sensor's "
             "registers"),
            (args.sensor and sensor_named(args.sensor).lanes
             and not (args.camera or "").startswith(CSI2),
             f"--sensor {args.sensor} is given, it has CSI-2 lanes: --camera csi2:2 is needed"),
            (args.system and bench,
             "--testbench and --system are given, the test bench is of a corrector alone"),
            (packets and args.board, f"--video {hardware.video} and --board are given, the "
                                     f"projects of boards take {plain}"),
            (packets and bench, f"--video {hardware.video} and --testbench are given, the test "
                                f"bench takes {plain}")):
        if wrong:
            raise InputError(sentence)


def _packetiser_files(packetiser, name):
    """Text of the packetiser's files, by file name; ``name``: of --name."""
    module = f"{name}_packetiser" if name else PACKETISER
    return {f"{module}.v": module_verilog(packetiser, module),
            f"{module}_hw.tcl": packetiser_hw_tcl(packetiser, module)}


def _system_files(system, lenses, module):
    """Text of what belongs to a camera system, by file name."""
    drivers = _drivers(module, driver_files(system.corrector, lenses, system.table))
    if system.hardware.axi:
        return axi_files(AxiTop(system), module) | drivers
    return {f"{module}.v": system_verilog(system, name=module), **drivers,
            f"{module}_hw.tcl": system_hw_tcl(system, module),
            f"{module}.vlt": verilator_config(module, SYSTEM_WAIVERS)}


def _bench(corrector, verilog, module, frame):
    """Text of the test bench of ``module`` in ``verilog``, by file name.

    Its raw frame is that of the file ``frame``, or a pattern if ``frame`` is empty.
    """
    geometry = corrector.descriptor.geometry
    raw = pattern(geometry)
    if frame:
        raw, _ = raw_frame(frame, geometry)
        check_raw(raw, geometry)
    return bench_files(corrector, verilog, module, raw)


def _corrector_files(corrector, lenses, module):
    """Text of what belongs to a corrector alone, by file name."""
    drivers = _drivers(module, driver_files(corrector, lenses))
    if corrector.hardware.axi:
        return axi_files(AxiTop(corrector), module) | drivers
    return {f"{module}.v": verilog_of(corrector, module),
            **drivers, f"{module}.core": fusesoc_core(corrector, module),
            f"{module}_hw.tcl": hw_tcl(corrector, module),
            f"{module}.vlt": verilator_config(module)}


def _drivers(module, files):
    """The drivers' ``files``, in a folder of their own if the module was named by --name.

    Their names are always the same: two named cores would overwrite each other's.
    """
    if module in _NAMES:
        return files
    return {f"{module}_drivers/{name}": text for name, text in files.items()}

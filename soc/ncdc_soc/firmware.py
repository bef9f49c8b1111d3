"""The firmware: its image, and its configuration from the tables that all of NCDC shares."""

import io
import math
import re
import struct
import subprocess
import zipfile
from dataclasses import dataclass
from importlib.metadata import version
from importlib.resources import files
from pathlib import Path

from ncdc_boards.camera_board.programs import I2C_HZ
from ncdc_hdl.camera.i2c import quarter_clocks
from ncdc_hdl.export.drivers.c_header import c_header
from ncdc_hdl.export.drivers.lenses import Lens
from ncdc_hdl.link.processor import LINK_BASE
from ncdc_soc.lwip import FILES, lwip_source
from ncdc_soc.mac import SLOT_BYTES
from ncdc_soc.processor import MAP
from ncdc_spec import view
from ncdc_spec.errors import InputError
from ncdc_spec.frames import output_format
from ncdc_spec.needs import check_programs
from ncdc_spec.pixel_formats import raw_format
from ncdc_spec.protocols import auto_control, gvcp, gvcp_tables, gvsp
from ncdc_spec.protocols.features import VIEW_FEATURES, feature, features_of, features_with
from ncdc_spec.protocols.genicam import genicam_xml
from ncdc_spec.protocols.table_one import IDLE_SECONDS, RATE, SYSTEM_WORDS, TCP_PORT, VIEW
from ncdc_spec.registers.link_map import LINK, TEMPLATES
from ncdc_spec.registers.register_map import (
    CTRL_COMMIT,
    STATUS_COMMITTED,
    network_registers,
    registers,
)
from ncdc_spec.sensors.catalogue import controlled_sensor
from ncdc_spec.sensors.framing import Crop, field_values
from ncdc_spec.sensors.waking import wake_times
from ncdc_spec.view_matrix import LIMITS
from ncdc_spec.white_balance import GAIN_BITS, LARGEST_GAIN, UNITY

__all__ = ["DRIVER", "FIRMWARE", "SOURCES", "Identity", "config", "firmware_image"]

FIRMWARE = Path(__file__).resolve().parent / "firmware_source"
DRIVER = tuple(Path(str(files("ncdc_hdl.export.drivers") / "host" / name))
               for name in ("ncdc.c", "ncdc_eeprom.c"))
"""Sources of the C driver that the firmware has: lenses, and the image of an EEPROM."""

_SPECS = "picolibc.specs"       # of the C library
_COMPILER = "riscv64-unknown-elf-gcc"
_I2C_QUARTER_MIN = 8      # clocks
_USERS = 8                  # of Table I at a time
SOURCES = ("start.S", "main.c", "net.c", "table.c", "gvcp.c", "gvcp_control.c", "gvcp_read.c",
           "gvcp_write.c", "auto.c", "stream.c", "frames.c", "mraw.c", "words.c", "view_matrix.c",
           "sensor.c", "eeprom.c", "interrupt.c", "phy.c", "mdio.c", "ip.c", "eth.c", "uart.c",
           "memory.c")
# Of these what answers GVCP has no part that takes long.
_SLOW = ("main.c", "table.c", "mraw.c", "gvcp_write.c", "auto.c", "words.c", "view_matrix.c",
         "sensor.c", "eeprom.c", "phy.c", "mdio.c", "uart.c")
_OPTIONS = ("-mabi=ilp32", "-ffunction-sections", "-fdata-sections",
            "-ffreestanding", "-fbuiltin", "-fno-tree-loop-distribute-patterns",
            "-std=c11", "-Wall", "-Wextra", "-Werror", "-nostartfiles", f"--specs={_SPECS}",
            "-Wl,--gc-sections")
_FAST = ("-O2",)                        # of ours, what answers GVCP
_SMALL = ("-Os", "-msave-restore")      # the rest, and lwIP


@dataclass(frozen=True)
class Identity:
    """Identity of the device on the network.

    Parameters
    ----------
    ip, mask, mac : str
        With the address 0.0.0.0 it asks DHCP, and takes a link-local one without an answer. Each
        device of a network needs a MAC address of its own.
    time_scale : int
        So many times faster pass lwIP's milliseconds, for simulations that wait for its time-outs.
    """
    ip: str = "10.77.0.11"
    mask: str = "255.255.255.0"
    mac: str = "02:4e:0a:4d:00:0b"
    time_scale: int = 1

    def __post_init__(self):
        if not re.fullmatch("[0-9a-fA-F]{2}(:[0-9a-fA-F]{2}){5}", self.mac):
            raise InputError(f"the MAC address is {self.mac!r}, six pairs of hexadecimal digits "
                             "with colons are needed, as in 02:4e:0a:4d:00:0c")
        if int(self.mac[:2], 16) & 1 or not int(self.serial, 16):
            raise InputError(f"the MAC address is {self.mac}, one of a single device is needed: "
                             "its first byte is even, and not all bytes are 0")

    @property
    def serial(self):
        """Serial number, which identifies the device: the digits of the MAC address."""
        return self.mac.replace(":", "").upper()


def config(system, capacity, soc, setup, corner, identity=Identity(), *, sets_up=1,
           first_reader=0):
    """Text of ``config.h``: the figures of the system that the C sources use.

    Parameters
    ----------
    system : System
    capacity : int
        Bytes of a packet's payload, at most: as of :class:`Packetiser`.
    soc : ProcessorVerilog
    setup : Setup
        Configuration of the sensor.
    corner : Crop
        The part of the sensor's frames that capture keeps.
    identity : Identity
    sets_up : int
        0: another part of the design initialises camera and sensor. Else the firmware does, with
        the sensor's times and the I2C bus so many times faster than on a board: 1, more in
        simulations.
    first_reader : int
        Number of the firmware's first reader among the readers of frames.

    Raises
    ------
    InputError
        If the firmware does not know the sensor.
    """
    abilities = RATE | (VIEW if system.hardware.view else 0)
    features = _features(setup)
    lines = ["/* Made by ncdc_soc.firmware. */", "#ifndef CONFIG_H", "#define CONFIG_H"]
    lines += [f"#define {name} {value}" for name, value in {
        **_hardware(capacity, soc), **_registers(system), **_pictures(system, setup),
        **_field(setup, Crop(*corner), system.descriptor.geometry),
        **_sensor(setup, soc.clock_hz, max(1, sets_up)),
        **_protocols(identity, soc.clock_hz, genicam_xml(
            system.hardware.colour, features_with(features, abilities))),
        **_automatic(system, setup), **_view(system), **_lens(system), "ABILITIES": f"{abilities}u",
        "SETS_UP": int(sets_up > 0), "FIRST_READER": f"{first_reader}u"}.items()]
    own = _own((*features, *(VIEW_FEATURES if abilities & VIEW else ())))
    lines.append("enum feature_id {" + ", ".join(f"FEATURE_{one.name}" for one in own) + "};")
    lines += [f"#define CONFIG_CHOICES {_choices(own)}", f"#define CONFIG_PARTS {_parts(own)}",
              f"#define CONFIG_FEATURES {_table(own)}",
              f"#define SYSTEM_SETTINGS {_settings(system, setup, corner, _quarter(soc, sets_up))}"]
    lines.append(c_header(system.corrector.registers.table))
    return "\n".join([*lines, "#endif"]) + "\n"


def _hex(value):
    return f"0x{value:x}u"


def _text(value):
    return '"' + value.replace("\\", "\\\\").replace('"', '\\"') + '"'


def _braced(values):
    return "{" + ", ".join(values) + "}"


def _hardware(capacity, soc):
    return {
        **{f"CSR_{name}": _hex(address) for name, address in soc.registers.items()},
        "CLOCK_HZ": f"{soc.clock_hz}u", "NCDC_BASE": _hex(MAP["ncdc"]),
        "FRAMES_BASE": _hex(MAP["frames"]),
        "ETHMAC_RX_BASE": _hex(MAP["ethmac_rx"]), "ETHMAC_TX_BASE": _hex(MAP["ethmac_tx"]),
        "ETHMAC_SLOT_BYTES": f"{SLOT_BYTES}u",
        "SYSTEM_INTERRUPT": f"{soc.interrupt}u", "LINK_CAPACITY": f"{capacity}u",
        "LINK_TEMPLATES": _hex(MAP["ncdc"] + 4 * (LINK_BASE + TEMPLATES)),
        **({"PHY_FIRST": f"{soc.chip.addresses[0]}u", "PHY_LAST": f"{soc.chip.addresses[-1]}u",
            "PHY_DELAYS": int(soc.chip.delays)} if soc.chip else {})}


def _registers(system):
    """Byte address of each register, and the flags of those that have some."""
    found = {}
    for prefix, base, table in (("NCDC_", 0, system.table),
                                ("", LINK_BASE, LINK)):
        for register in table:
            found[prefix + register.name] = _hex(MAP["ncdc"] + 4 * (base + register.address))
            for flag in register.flags:
                found[f"{prefix}{register.name}_{flag.name}"] = _hex(flag.mask)
                shift = (flag.mask & -flag.mask).bit_length() - 1
                if flag.mask & flag.mask - 1:
                    found[f"{prefix}{register.name}_{flag.name}_SHIFT"] = shift
    return found


def _pictures(system, setup):
    geometry = system.descriptor.geometry
    form = output_format(system.hardware.format).sent
    raw = raw_format(geometry)
    width, height = geometry.corrected
    timing = setup.timing
    rate = round(10 * timing.frames_per_second)
    return {
        "CORRECTED_WIDTH": f"{width}u", "CORRECTED_HEIGHT": f"{height}u",
        "CORRECTED_SIZE": f"{width * height * form.pixel_bytes}u",
        "CORRECTED_PFNC": _hex(form.pfnc), "CORRECTED_MRAW": _hex(form.mraw),
        "RAW_WIDTH": f"{geometry.distorted_width}u", "RAW_HEIGHT": f"{geometry.distorted_height}u",
        "RAW_PFNC": _hex(raw.pfnc), "RAW_MRAW": _hex(raw.mraw),
        "LINE_TIME_NS": f"{round(1e9 * timing.line_clocks / timing.pixel_clock_hz)}u",
        "RATE_TENTHS": f"{max(1, rate)}u",
        "RATE_TENTHS_MAX": f"{max(rate, feature('AcquisitionFrameRate').high)}u"}


def _quarter(soc, sets_up):
    """Clocks of a quarter of a bit of the I2C bus, with ``sets_up`` of :func:`config`."""
    return max(_I2C_QUARTER_MIN, quarter_clocks(soc.clock_hz, I2C_HZ) // max(1, sets_up))


def _field(setup, crop, geometry):
    """The part of the sensor that raw frames show."""
    values = field_values(setup, crop, geometry)
    at = {word.address: values[word.name] for word in SYSTEM_WORDS if word.name in values}
    first = min(at)
    return {"FIELD_FIRST": _hex(first),
            "CONFIG_FIELD": _braced(str(at[first + k]) for k in range(len(values)))}


def _sensor(setup, clock_hz, time_scale):
    sensor = setup.sensor
    # The reset pin is not the firmware's: the firmware begins with the end of that reset, or later.
    awake_us = sum(wake_times(sensor.waking, setup.settings.clock_hz))
    (identity, value), *_ = sensor.chip_id
    writes = [f"{{0x{w.register:x}, 0x{w.value:x}, {w.wait_us}}}" for w in setup.writes]
    return {
        "SENSOR_I2C": _hex(sensor.i2c_address), "SENSOR_POINTER_BITS": sensor.pointer_bits,
        "SENSOR_VALUE_BITS": sensor.value_bits, "SENSOR_ID_ADDRESS": _hex(identity),
        "SENSOR_ID": _hex(value)[:-1], "SENSOR_SET_UP": _braced(writes),
        "SENSOR_WAIT_CLOCKS": f"{max(1, -(-clock_hz // (10**6 * time_scale)))}u",
        "SENSOR_REST_CLOCKS": f"{awake_us * clock_hz // (10**6 * time_scale)}u",
        "SENSOR_USER": _braced(
            _braced([_hex(one.address), _hex(one.mask), _hex(low), _hex(high)])
            for one in sensor.user_registers for low, high in one.ranges),
        "SENSOR_LAST": _hex(sensor.last_register),
        "SENSOR_CACHED": _braced(map(_hex, sensor.controls.addresses)),
        **{f"SENSOR_GAIN_{name.upper()}": getattr(sensor.controls.gain, name)
           for name in ("m0", "c0", "m1", "c1")}}


def _automatic(system, setup):
    """Constants of the rule of :mod:`~ncdc_spec.protocols.auto_control`, and byte offsets of the
    corrector's registers that the white balance needs."""
    descriptor, colour = system.descriptor, system.hardware.colour
    at = {one.name: 4 * one.address for one in registers(
        descriptor.hidden_neurons, descriptor.formats, descriptor.nodes, colour=True)}
    return {
        "AUTO_TARGET": f"{auto_control.TARGET}u", "AUTO_BAND": f"{auto_control.BAND}u",
        "AUTO_STEP_FACTOR": f"{auto_control.STEP_FACTOR}u",
        "AUTO_GAIN_MIN": f"{auto_control.GAIN_MIN}u",
        "AUTO_GAIN_MAX": f"{setup.sensor.controls.gain.high}u",
        "AUTO_SAMPLES": f"{auto_control.SAMPLES}u", "AUTO_LEVEL_SHIFT": auto_control.LEVEL_SHIFT,
        "AUTO_BALANCE_BAND": f"{auto_control.BALANCE_BAND}u",
        "AUTO_BALANCE_DARK": f"{auto_control.BALANCE_DARK}u",
        "AUTO_LINES_MIN": f"{setup.sensor.limits.lines[0]}u",
        "AUTO_LINES_MAX": f"{_frame_exposure(setup)}u",
        "AUTO_COLOUR": int(colour), "AUTO_RATIO_UNITY": f"{UNITY}u",
        "AUTO_RATIO_MAX": f"{LARGEST_GAIN}u", "AUTO_RATIO_BITS": GAIN_BITS,
        "CORRECTOR_FRAMES": _hex(at["FRAMES"]), "CORRECTOR_SUMS": _hex(at["RED_SUM"]),
        "CORRECTOR_PIXELS": _hex(at["VALID_PIXELS"])}


def _lens(system):
    """The built-in lens as ``struct ncdc_lens`` of the C driver has it, without its valid rows,
    which are in the corrector from the beginning."""
    lens = Lens.of(system.corrector, system.descriptor)
    parameters = [one.name for one in network_registers(lens.neurons, system.descriptor.formats)]
    return {
        "LENS_NEURONS": f"{lens.neurons}u",
        "LENS_INTERPOLATION": f"NCDC_CAPABILITIES_{lens.interpolation.upper()}",
        "CONFIG_LENS_KIND": _braced(map(str, lens.kind)),
        "CONFIG_LENS_PARAMETERS": _braced(f"NCDC_{name}" for name in parameters),
        "CONFIG_LENS_VALUES": _braced(
            _braced([f"NCDC_{name}", _hex(value & 0xFFFFFFFF)])
            for name, value in lens.values.items() if name not in parameters)}


def _view(system):
    """Constants of :mod:`~ncdc_spec.view_matrix` and :mod:`~ncdc_spec.view` for the picture."""
    descriptor = system.descriptor
    at = {one.name: 4 * one.address for one in registers(
        descriptor.hidden_neurons, descriptor.formats, descriptor.nodes, view=True)}
    angles = [feature(name.capitalize()) for name in LIMITS]
    columns = view.outer_columns(descriptor.geometry.corrected_width)
    focal, *_ = view.CAMERA_FORMATS
    return {
        "HAS_VIEW": int(system.hardware.view), "VIEW_PI": repr(math.pi),
        "VIEW_LOW": _braced(str(one.low) for one in angles),
        "VIEW_HIGH": _braced(str(one.high) for one in angles),
        "VIEW_FRACTIONS": _braced(str(q.f_bits) for row in view.FORMATS for q in row),
        "CAMERA_FRACTIONS": _braced(str(q.f_bits) for q in view.CAMERA_FORMATS.values()),
        "FOCAL_FRACTION": view.CAMERA_FORMATS[focal].f_bits,
        "FOCAL_STEPS": feature("ViewFocal").scale[1],
        "VIEW_FIRST_NODE": columns[0], "VIEW_LAST_NODE": columns[1],
        "VIEW_DEPTH_MAX": repr(view.MAX_DEPTH), "VIEW_DEPTH_MIN": repr(view.MIN_DEPTH),
        "CORRECTOR_VIEW": _hex(at[view.VIEW_REGISTERS[0]]), "CORRECTOR_CAMERA": _hex(at[focal]),
        "CORRECTOR_CTRL": _hex(at["CTRL"]), "CORRECTOR_STATUS": _hex(at["STATUS"]),
        "CORRECTOR_COMMIT": f"{CTRL_COMMIT}u", "CORRECTOR_COMMITTED": f"{STATUS_COMMITTED}u"}


def _frame_exposure(setup):
    """Lines of the longest exposure that leaves a frame as long as it is."""
    sensor = setup.sensor
    return max(sensor.limits.lines[0], setup.timing.frame_lines - sensor.controls.margin)


def _enumerated(table):
    """The names and codes of a table of :mod:`ncdc_spec.protocols.gvcp_tables`, for a C enum."""
    return ", ".join(f"{one.name} = 0x{one.code:x}" for one in table)


def _protocols(identity, clock_hz, xml):
    # Packed it takes an eighth of the ROM, and of the time that a client needs to read it.
    xml = _zipped(gvcp.XML_NAME, xml)
    url = f"Local:{Path(gvcp.XML_NAME).stem}.zip;{gvcp.XML_BASE:X};{len(xml):X}"
    texts = {"DeviceVendorName": "NCDC", "DeviceModelName": "NCDC camera",
             "DeviceVersion": version("ncdc"), "DeviceManufacturerInfo": "distortion correction",
             "DeviceSerialNumber": identity.serial, "DeviceUserID": "", "FirstUrl": url,
             "SecondUrl": ""}
    return {
        **{f"WORD_{word.name}": _hex(word.address) for word in SYSTEM_WORDS},
        **{f"BOOT_{one.name}": _hex(one.address) for one in gvcp.BOOTSTRAP},
        "GVCP_FEATURE_BASE": _hex(gvcp.FEATURE_BASE), "GVCP_XML_BASE": _hex(gvcp.XML_BASE),
        "GVCP_CORRECTOR_BASE": _hex(gvcp.CORRECTOR_BASE),
        "GVCP_CORRECTOR_BYTES": _hex(gvcp.CORRECTOR_BYTES),
        "GVCP_CAPABILITY": _hex(gvcp.CAPABILITY),
        "GVCP_CONFIGURATION": _hex(gvcp.CONFIGURATION_PENDING_ACK),
        "GVCP_PENDING_MS": f"{gvcp.PENDING_MS}u",
        "GVCP_DISCOVERY_BYTES": _hex(gvcp.DISCOVERY_BYTES),
        "TABLE_PORT": f"{TCP_PORT}u", "TABLE_USERS": f"{_USERS}",
        "CONFIG_GVCP_COMMANDS": _enumerated(gvcp_tables.COMMANDS),
        "CONFIG_GVCP_STATUSES": _enumerated(gvcp_tables.STATUSES),
        "GVCP_KEY": _hex(gvcp.KEY), "GVCP_MEMORY_MAX": f"{gvcp.MEMORY_BYTES_MAX}u",
        "GVCP_PENDING_ACK": _hex(gvcp.PENDING_ACK),
        "GVCP_REGISTERS_MAX": f"{gvcp.REGISTERS_MAX}u",
        "GVCP_FORCEIP_BYTES": f"{gvcp.FORCE_IP.size}u",
        "STREAM_HEADERS": f"{gvsp.HEADERS_BYTES}u", "STREAM_STEP": f"{gvsp.PAYLOAD_STEP}u",
        "PACKET_MIN": f"{gvsp.MIN_PACKET}u",
        "PACKET_MAX": f"{gvsp.MAX_PACKET}u",
        "PACKET_DELAY_MAX": f"{feature('GevSCPD').high}u",
        "HEARTBEAT_MS": f"{gvcp.HEARTBEAT_MS}u",
        "HEARTBEAT_MIN_MS": f"{gvcp.HEARTBEAT_MIN_MS}u",
        "HEARTBEAT_MAX_MS": f"{gvcp.HEARTBEAT_MAX_MS}u", "TABLE_IDLE_MS": f"{1000 * IDLE_SECONDS}u",
        "MILLISECOND_CLOCKS": f"{clock_hz // 1000 // identity.time_scale}u",
        "PACKET_DO_NOT_FRAGMENT": _hex(gvcp.SCPS_DO_NOT_FRAGMENT),
        "CONFIG_VERSION": _text(version("ncdc")), "CONFIG_IP": _hex(_address(identity.ip)),
        "CONFIG_MASK": _hex(_address(identity.mask)),
        "CONFIG_MAC": _braced(f"0x{part}" for part in identity.mac.split(":")),
        "CONFIG_TEXTS": _braced(
            _braced([_hex(gvcp.register(name).address), str(gvcp.register(name).length),
                     _text(text)])
            for name, text in texts.items()),
        "CONFIG_XML": _braced(map(str, xml))}


def _zipped(name, data):
    """A ZIP archive of one file, of whole words; the same bytes for the same data."""
    for blanks in range(4):
        archive = io.BytesIO()
        with zipfile.ZipFile(archive, "w") as file:
            file.writestr(zipfile.ZipInfo(name), data, zipfile.ZIP_DEFLATED, 9)
            file.comment = b" " * blanks
        if len(archive.getvalue()) % 4 == 0:
            break
    return archive.getvalue()


def _address(text):
    return int.from_bytes(bytes(map(int, text.split("."))), "big")


def _features(setup):
    """The features of the sensor in this configuration: one whose frames do not become longer by
    themselves has no longer exposures than they allow."""
    sensor = controlled_sensor(setup.sensor.name)
    return features_of(sensor,
                       None if sensor.controls.stretches else _frame_exposure(setup))


def _own(features):
    """Those with a register of their own, in the order of their addresses, without a gap."""
    found = [one for one in features if one.address >= gvcp.FEATURE_BASE]
    assert [one.address for one in found] == [gvcp.FEATURE_BASE + 4 * k for k in range(len(found))]
    return found


def _choices(features):
    return " ".join(
        f"static const struct choice CHOICES_{one.name}[] = "
        + _braced(f"{{{_hex(choice.value)}, {_hex(choice.word)}}}" for choice in one.choices) + ";"
        for one in features if one.choices and one.parts)


def _parts(features):
    """The parts of all features, one after the other."""
    return _braced(_braced([_hex(part.address), *map(str, (part.shift, part.width, part.low))])
                   for one in features for part in one.parts)


def _table(features):
    access = {"ro": "'r'", "wo": "'w'", "rw": "'b'"}
    rows, first = [], 0
    for one in features:
        choices, count = "0", "0"
        if one.choices and one.parts:
            choices, count = f"CHOICES_{one.name}", str(len(one.choices))
        rows.append(_braced([
            f"FEATURE_{one.name}", access[one.access], str(first), str(len(one.parts)),
            count, str(one.low), _hex(one.high & 0xFFFFFFFF), choices]))
        first += len(one.parts)
    return _braced(rows)


def _settings(system, setup, corner, quarter):
    """Registers of the camera, before the sensor is set up."""
    crop = Crop(*corner)
    values = {"GRID_WEIGHT": crop.weight, "GRID_BIN": crop.binning} if crop.grid else {}
    values |= {"CSI_CHANNEL": 0, "CSI_TYPE": setup.link.data_type} if setup.link else {}
    values |= {
        "SENT_WIDTH": setup.timing.width, "SENT_HEIGHT": setup.timing.height,
        "WINDOW_LEFT": crop.left, "WINDOW_TOP": crop.top, "BLACK_LEVEL": setup.sensor.black,
        "CLOCK_LIMIT": 2 * setup.timing.frame_clocks, "I2C_QUARTER": quarter}
    addresses = {r.name: r.address for r in system.table}
    return _braced(_braced([_hex(MAP["ncdc"] + 4 * addresses[name]), _hex(value)])
                   for name, value in values.items())


def firmware_image(text, soc, folder):
    """Compile the firmware with the ``config.h`` of that text, in an existing ``folder``.

    Returns (words of the ROM, bytes of code and constants, bytes of RAM without the stack).

    Raises
    ------
    InputError
        If there is no source or no compiler, or it reports an error.
    """
    if not FIRMWARE.is_dir():
        raise InputError(f"{FIRMWARE} is missing, which NCDC's wheel has: install NCDC again")
    check_programs("compiles the firmware", _COMPILER)
    # The compiler answers with the bare name of a file that it does not find.
    if not Path(_run([_COMPILER, f"-print-file-name={_SPECS}"]).strip()).is_absolute():
        raise InputError("picolibc is not installed, which the firmware is linked with: apt "
                         "install picolibc-riscv64-unknown-elf")
    folder = Path(folder)
    (folder / "config.h").write_text(text)
    symbols = [f"-Wl,--defsym={name.upper()}_{what}={value:#x}" for name in ("rom", "sram")
              for what, value in zip(("BASE", "BYTES"), soc.memories[name])]
    lwip = lwip_source()
    options = [f"-march=rv32im{'ac' * soc.compressed}", *_OPTIONS]
    # lwIP's headers are third-party code, whose warnings are ignored.
    headers = [f"-I{folder}", f"-I{FIRMWARE}", f"-I{FIRMWARE / 'lwip_port'}",
               f"-I{DRIVER[0].parent}", "-isystem", str(lwip / "include")]
    fast = [FIRMWARE / name for name in SOURCES if name not in _SLOW]
    slow = [*(FIRMWARE / name for name in _SLOW), *DRIVER]
    for name, optimisation, sources in (("fast", _FAST, fast), ("slow", _SMALL, slow),
                                        ("lwip", _SMALL, [lwip / name for name in FILES])):
        (folder / name).mkdir(exist_ok=True)
        _run([_COMPILER, *optimisation, *options, *headers, "-c", *map(str, sources)],
             folder / name)
    objects = sorted(map(str, folder.glob("*/*.o")))
    _run([_COMPILER, *options, f"-T{FIRMWARE / 'link.ld'}", *symbols, *objects, "-o",
          str(folder / "firmware.elf")])
    binary = folder / "firmware.bin"
    _run(["riscv64-unknown-elf-objcopy", "-O", "binary", str(folder / "firmware.elf"),
          str(binary)])
    sizes = _run(["riscv64-unknown-elf-size", str(folder / "firmware.elf")]).splitlines()[1].split()
    code, data, zeros = map(int, sizes[:3])
    image = binary.read_bytes()
    words = [word for word, in struct.iter_unpack("<I", image + bytes(-len(image) % 4))]
    return words, code + data, data + zeros


def _run(command, folder=None):
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True)
    if done.returncode:
        raise InputError(f"the firmware does not compile: {done.stderr.strip()}")
    return done.stdout

"""The first screen of ``ncdc_system.v``."""

import textwrap
from functools import partial
from importlib.metadata import version

from ncdc_hdl.export.verilog.convert import convert
from ncdc_hdl.export.verilog.cover import name_option
from ncdc_hdl.export.verilog.port_list import (
    AGENT,
    CLOCK,
    READ_HOST,
    STREAM,
    WRITE_HOST,
    port_lines,
)
from ncdc_spec.camera_port import AVALON_ST, AXIS, CSI2, LANES, PARALLEL, VIP

__all__ = ["SYSTEM", "pins", "system_header", "system_verilog"]

SYSTEM = "ncdc_system"

_PARALLEL = {
    "clock": "of the sensor; its rising edge samples the pins",
    "frame_valid": "high in a frame", "line_valid": "high with the samples of a row",
    "data": "sample; a shorter one is in the upper bits"}
_AXIS = {
    "clock": "of the stream", "tdata": "samples, the first one lowest",
    "tuser": "first beat of a frame", "tlast": "last beat of a row",
    "tvalid": "samples are there, held until tready",
    "tready": "they are taken; low after a frame only"}
_AVALON_ST = {
    "clock": "of the stream", "data": "samples, the first one lowest",
    "empty": "samples of a packet's last beat that do not count",
    "startofpacket": "first beat of a packet", "endofpacket": "last beat of a packet",
    "valid": "samples are there, held until ready",
    "ready": "they are taken; low after a packet only"}
_LANE = {
    "data": "a byte, the first bit lowest", "valid": "high from the first byte on: RxValidHS",
    "active": "high during the burst: RxActiveHS"}
_CSI2 = {"clock": "of the bytes", **{f"lane{k}_{name}": text for k in range(max(LANES))
                                     for name, text in _LANE.items()}}
_CAMERAS = {
    PARALLEL: ("parallel sensor", _PARALLEL), AXIS: ("camera: AXI4-Stream video sink", _AXIS),
    AVALON_ST: ("camera: Avalon-ST video sink", _AVALON_ST),
    VIP: ("camera: Avalon-ST video sink, packets with types", _AVALON_ST),
    CSI2: ("camera: bytes of CSI-2 lanes, PHY protocol interface", _CSI2)}
_I2C = {
    "scl_low": "pull SCL low, or release it", "sda_low": "pull SDA low, or release it",
    "scl": "the line, asynchronous", "sda": "the line, asynchronous"}
_STATUS = {
    "irq": "STATUS.DONE or an event of CAMERA_STATUS",
    "front_end_idle": "the network is idle: its clock may stop"}
_USB = {
    "clock": "from the chip; the pins are synchronous to it", "rxf_n": "low: the chip has a word",
    "txe_n": "low: the chip takes a word", "data_i": "of the bus, from the chip",
    "be_i": "bytes of it that count; 1 where the chip has no BE",
    "data_o": "to the bus", "be_o": "bytes of it that count",
    "data_oe": "drive the bus, and BE with it", "oe_n": "the chip drives the bus",
    "rd_n": "a word is taken", "wr_n": "a word is offered"}
_INTERFACES = (
    ("clock and reset", ("clk", "rst", "memory_rst"), CLOCK | {
        "clk": "for all ports but the sensor's and the I2C lines"}),
    ("registers: Avalon-MM agent, 32 bits", "csr_", AGENT),
    ("raw frames: Avalon-MM burst read host", "read0_", READ_HOST),
    ("raw frames, second row of a window: Avalon-MM burst read host", "read1_", READ_HOST),
    ("raw frames, third row of a window: Avalon-MM burst read host", "read2_", READ_HOST),
    ("USB: FTDI chip in 245 synchronous FIFO mode", "usb_", _USB),
    ("raw and corrected frames: Avalon-MM burst write host", "write_", WRITE_HOST | {
        "writedata": "samples, or pixels in the format of OUTPUT_FORMAT"}),
    ("corrected frames: Avalon-ST video source", "stream_", STREAM),
)


def system_verilog(system, platform=None, name=SYSTEM):
    """Verilog text of a :class:`ncdc_hdl.system.System`, or one with USB, module ``name``.

    ``platform``: as in :func:`ncdc_hdl.export.verilog.module_verilog`.
    """
    return convert(system, name, system_header(system, name_option(name, SYSTEM)),
                   partial(port_lines, interfaces=_interfaces(system)), platform)


def pins(camera):
    """Interfaces of a system outside the buses of memory and registers, for its ``camera``."""
    title, texts = _CAMERAS[camera.kind]
    return ((title, "sensor_", texts), ("I2C bus of the sensor: open drain", tuple(_I2C), _I2C),
            ("status", tuple(_STATUS), _STATUS))


def _interfaces(system):
    """Interfaces of a system; with USB the link's read port is after the corrector's."""
    usb = f"{getattr(system, 'port', '')}_"
    camera, i2c, status = pins(system.camera)
    return tuple(("frames for USB: Avalon-MM burst read host", which, texts)
                 if which == usb else (title, which, texts) for title, which, texts in (
                     *_INTERFACES[:2], camera, i2c, *_INTERFACES[2:], status))


def system_header(system, options=()):
    """Lines that open the Verilog of a system: generator and descriptor.

    ``options``: of ``ncdc generate``, in addition to those of the hardware.
    """
    descriptor, g = system.descriptor, system.descriptor.geometry
    stores = system.stores
    command = " ".join(["ncdc generate NET.toml -o DIR --system", *options,
                        *system.options, *system.hardware.options(g)])
    return [
        f"NCDC {version('ncdc')}: camera, frame stores and corrector, made with Amaranth "
        f"{version('amaranth')}.",
        "Do not edit; it was made by",
        *textwrap.wrap(command, 90, initial_indent="    ", subsequent_indent="        ",
                       break_long_words=False, break_on_hyphens=False),
        f"from the descriptor {descriptor.digest}: {descriptor.hidden_neurons} hidden neurons, "
        f"{g.distorted_width}x{g.distorted_height} raw {g.bayer} samples to",
        f"{g.corrected_width}x{g.corrected_height} corrected pixels. {stores.raw} raw and "
        f"{stores.corrected} corrected buffers, {stores.readers} readers by registers.",
        "",
        "Every distinct module is here once, the top first, each below a line with its source,",
        "what it does and its latency in clocks."]

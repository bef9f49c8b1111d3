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

__all__ = ["PINS", "SYSTEM", "system_header", "system_verilog"]

SYSTEM = "ncdc_system"

_SENSOR = {
    "clock": "of the sensor; its rising edge samples the pins",
    "frame_valid": "high in a frame", "line_valid": "high with the samples of a row",
    "data": "sample; a shorter one is in the upper bits"}
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
PINS = (("parallel sensor", "sensor_", _SENSOR),
        ("I2C bus of the sensor: open drain", tuple(_I2C), _I2C),
        ("status", tuple(_STATUS), _STATUS))
"""Interfaces of a system outside the buses of memory and registers."""

_INTERFACES = (
    ("clock and reset", ("clk", "rst", "memory_rst"), CLOCK | {
        "clk": "for all ports but the sensor's and the I2C lines"}),
    ("registers: Avalon-MM agent, 32 bits", "csr_", AGENT),
    *PINS[:2],
    ("raw frames: Avalon-MM burst read host", "read0_", READ_HOST),
    ("raw frames, second row of a window: Avalon-MM burst read host", "read1_", READ_HOST),
    ("raw frames, third row of a window: Avalon-MM burst read host", "read2_", READ_HOST),
    ("USB: FTDI chip in 245 synchronous FIFO mode", "usb_", _USB),
    ("raw and corrected frames: Avalon-MM burst write host", "write_", WRITE_HOST | {
        "writedata": "samples, or pixels in the format of OUTPUT_FORMAT"}),
    ("corrected frames: Avalon-ST video source", "stream_", STREAM),
    PINS[2],
)


def system_verilog(system, platform=None, name=SYSTEM):
    """Verilog text of a :class:`ncdc_hdl.system.System`, or one with USB, module ``name``.

    ``platform``: as in :func:`ncdc_hdl.export.verilog.module_verilog`.
    """
    return convert(system, name, system_header(system, name_option(name, SYSTEM)),
                   partial(port_lines, interfaces=_interfaces(system)), platform)


def _interfaces(system):
    """Interfaces of a system; with USB the link's read port is after the corrector's."""
    usb = f"{getattr(system, 'port', '')}_"
    return tuple(("frames for USB: Avalon-MM burst read host", which, texts)
                 if which == usb else (title, which, texts) for title, which, texts in _INTERFACES)


def system_header(system, options=()):
    """Lines that open the Verilog of a system: generator and descriptor.

    ``options``: of ``ncdc generate``, in addition to those of the hardware.
    """
    descriptor, g = system.descriptor, system.descriptor.geometry
    stores = system.stores
    command = " ".join(["ncdc generate NET.toml -o DIR --system", *options,
                        *getattr(system, "options", []), *system.hardware.options(g)])
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

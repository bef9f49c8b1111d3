"""Timing constraints of a Quartus board, for the Timing Analyzer."""

from ncdc_boards.quartus.names import CYCLONE_IV
from ncdc_spec.errors import InputError

__all__ = ["CHAIN_PORTS", "FREE", "GRAY_COUNTERS", "PROCESSOR_GRAY_COUNTERS", "SDRAM_NS", "TRACE",
           "check_sensor", "constraints", "generated", "ports_like"]

# Pin of output k of a loop, as Quartus names it; `derive_pll_clocks` gives its clock the same name.
_CYCLONE_IV_PIN = "*{loop}|auto_generated|pll1|clk[{k}]"
_CYCLONE_V_PIN = "*{loop}|general[{k}].gpll~PLL_OUTPUT_COUNTER|divclk"

TRACE = .25        # ns: largest difference between traces of a group
SDRAM_NS = {"setup": 1.5, "hold": .8, "access": 5.4, "output_hold": 2.7}
"""ISSI, IS42S16320D, AC electrical characteristics, grade 7, CAS latency 3."""
# Analog Devices, ADV7123, timing specifications, rounded up, in ns.
_DAC_SETUP, _DAC_HOLD = .5, 1.5
_DAC_LESS_NS = 10   # a resistor network has no clock: its pins shall change within this time
# MT9P031/D, I/O timing: PIXCLK's falling edge to data, frame valid, line valid; rounded outwards,
# and not checked again with the data sheet.
_SENSOR_MIN, _SENSOR_MAX = 0, 6
# RGMII 1.3: setup and hold at a receiver; 2.0: at the pins of a chip that sends its clock late.
_RGMII_NS = {"sent": 1.0, "received": 1.2}
_RGMII_EDGES = 4    # ns between them, at 1000 Mbit/s
_CHAIN_CLOCK = "altera_reserved_tck"
_CHAIN_NS = 33.333  # 30 MHz: Intel, USB-Blaster II runs at 24 MHz
_INPUT = 1.5        # ns: approximate setup of an input of the device to its clock

FREE = {
    "button_*": (("from",), "pressed by hand, synchronised"),
    "led_*": (("to",), "seen by eye"),
    "uart_0__rx__io": (("from",), "a serial line has no clock; synchronised"),
    "uart_0__tx__io": (("to",), "a serial line has no clock"),
    "camera_0__scl__io": (("from", "to"), "I2C, 100 kHz, synchronised"),
    "camera_0__sda__io": (("from", "to"), "I2C, 100 kHz, synchronised"),
    "camera_0__reset_n__io": (("to",), "changes once"),
    "camera_0__standby__io": (("to",), "constant"),
    "vga_0__sync_n__io": (("to",), "constant"),
    **{f"altera_reserved_{name}": ((way,), "timed by the cable")
       for name, way in (("tdi", "from"), ("tms", "from"), ("tdo", "to"))},
    "eth_rgmii_0__mdc__io": (("to",), "2.5 MHz at most, bit by bit by the processor"),
    "eth_rgmii_0__mdio__io": (("from", "to"), "with it; synchronised"),
    "eth_rgmii_0__rst__io": (("to",), "changes once"),
    "hdmi_0__scl__io": (("from", "to"), "I2C, 100 kHz, synchronised"),
    "hdmi_0__sda__io": (("from", "to"), "I2C, 100 kHz, synchronised"),
}
"""Ports without timing: whether paths begin or end there, and why they have none."""

CHAIN_PORTS = tuple(f"altera_reserved_{name}" for name in ("tck", "tdi", "tms", "tdo"))
"""Ports of the JTAG chain, which Quartus adds to the top."""

_CLOCKS = {"sync": "core", "memory": "memory", "sensor_reference": "reference", "pixel": "pixel",
           "ethernet": "ethernet", "ethernet_late": "ethernet_late"}

_SYNCHRONISERS = """\
# Only the first register of each synchroniser may be reached from another clock.
set_false_path -to [get_registers {*altera_std_synchronizer:*|din_s1}]
# A reset begins at once; its end goes through synchronisers.
set_false_path -to [get_pins -nowarn -compatibility_mode {*altera_std_synchronizer*|clrn}]
# Settings of the camera, which are locked while it is captured.
set_false_path -from [get_registers {*:page|values*}] -to [get_clocks {sensor}]
# Gains of capture, stable from before their flag reaches the sensor's clock until they are taken.
set_false_path -from [get_registers {*:balance|offered*}] -to [get_clocks {sensor}]
"""
GRAY_COUNTERS = (("*|produce_w_gry*", "*:produce_cdc|*din_s1"),
                 ("*|consume_r_gry*", "*:consume_cdc|*din_s1"))
"""Registers of the queues' Gray counters, and first registers of their synchronisers."""
PROCESSOR_GRAY_COUNTERS = ((
    "*ncdc_processor:processor|*graycounter*_q*",
    "*ncdc_processor:processor|*multiregimpl*_regs0*"),)
"""The same for LiteX's queues."""
# Part of a period that the route of each bit of a Gray counter may take.
_GRAY_PART = .8


def check_sensor(settings):
    """:class:`InputError` if the sensor's pins come too late for the pixel clock in its settings.

    They change with its falling edge and are taken with its rising one, half a period later.
    """
    mhz = settings.get("pixel_clock_hz", 0) / 1e6
    limit = 500 / (_SENSOR_MAX + TRACE + _INPUT)
    if mhz > limit:
        raise InputError(f"the sensor's pixel clock is {mhz:g} MHz, its pins come {_SENSOR_MAX} "
                         f"ns after it: {int(limit)} MHz fit")


def constraints(design, sensor_mhz, ports, groups=None):
    """Text for the .sdc after the oscillator's clock, which Amaranth writes.

    Parameters
    ----------
    design : ncdc_boards.camera_board.core.Design
    sensor_mhz : number
        Pixel clock of the sensor.
    ports : sequence of str
        Port names of the top.
    groups : sequence of str, optional
        Lines that replace those of the SDRAM, the VGA port and the JTAG chain.
    """
    board, core_ns = design.board, 1000 / design.clocks.core_mhz
    period = min(core_ns, 1000 / sensor_mhz, 1000 / design.clocks.pixel_mhz)
    pin = _CYCLONE_IV_PIN if board.family == CYCLONE_IV else _CYCLONE_V_PIN
    pins = {_CLOCKS[name]: pin.format(loop=loop, k=k)
            for loop, names in design.clocks.loops().items() for k, name in enumerate(names)}
    lines = [
        f"create_clock -name sensor -period {1000 / sensor_mhz:.3f} "
        "[get_ports {camera_0__pixclk__io}]",
        "derive_pll_clocks", "derive_clock_uncertainty",
        *(f"set {name} {{{text}}}" for name, text in pins.items()),
        *_sensor(),
        *([*_sdram(), *_screen(board, design.clocks.pixel_mhz), *_chain(),
           *(_ethernet() if design.processor else [])] if groups is None else groups),
        _SYNCHRONISERS + "\n".join(_gray(GRAY_COUNTERS, period))]
    lines += _free([*ports, *(CHAIN_PORTS if groups is None else ())])
    return "\n".join(lines) + "\n"


def generated(name, source, port, invert=False):
    """A clock that is an output of the device."""
    return (f"create_generated_clock -name {name} -source [get_pins -compatibility_mode ${source}] "
            f"{'-invert ' * invert}[get_ports {{{port}}}]")


def ports_like(patterns):
    """The collection of the ports that match."""
    return "[get_ports {" + " ".join(patterns) + "}]"


def _sdram():
    """Constraints of the SDRAM, whose clock comes 3 ns before the core's next edge."""
    outputs = ports_like(f"sdram_0__{name}__io*" for name in (
        "clk_en", "cs", "we", "ras", "cas", "ba", "a", "dqm", "dq"))
    inputs = ports_like(["sdram_0__dq__io*"])
    return [
        "# SDRAM",
        generated("sdram_pin", "memory", "sdram_0__clk__io"),
        f"set_output_delay -clock sdram_pin -max {SDRAM_NS['setup'] + TRACE} {outputs}",
        f"set_output_delay -clock sdram_pin -min {-SDRAM_NS['hold'] - TRACE} {outputs}",
        f"set_input_delay -clock sdram_pin -max {SDRAM_NS['access'] + TRACE} {inputs}",
        f"set_input_delay -clock sdram_pin -min {SDRAM_NS['output_hold'] - TRACE} {inputs}",
        "# Data of the SDRAM are sampled at the second edge of the core's clock after its own: the",
        "# first edge comes before the access time is over.",
        "set_multicycle_path -setup -from [get_clocks {sdram_pin}] -to [get_clocks $core] 2"]


def _sensor():
    """Constraints of the sensor, whose pins change with the falling edge of its clock."""
    inputs = ports_like(f"camera_0__{name}__io*" for name in ("d", "fval", "lval"))
    return [
        "# Sensor",
        generated("sensor_reference_pin", "reference", "camera_0__xclk__io"),
        f"set_input_delay -clock sensor -clock_fall -max {_SENSOR_MAX + TRACE} "
        f"{inputs}",
        f"set_input_delay -clock sensor -clock_fall -min {_SENSOR_MIN - TRACE} "
        f"{inputs}"]


def _screen(board, pixel_mhz):
    """Constraints of the screen's pins."""
    parts = ["hs", "vs", "r", "g", "b"] + ["blank_n"] * board.dac
    outputs = ports_like(f"vga_0__{name}__io*" for name in parts)
    if board.dac:
        return [
            "# Screen",
            generated("vga_pin", "pixel", "vga_0__clk__io", invert=True),
            f"set_output_delay -clock vga_pin -max {_DAC_SETUP + TRACE} {outputs}",
            f"set_output_delay -clock vga_pin -min {-_DAC_HOLD - TRACE} {outputs}"]
    return [
        "# Screen, through resistors: all pins change shortly after the pixel clock.",
        f"set_output_delay -clock [get_clocks $pixel] -max {1000 / pixel_mhz - _DAC_LESS_NS:.3f} "
        f"{outputs}",
        f"set_output_delay -clock [get_clocks $pixel] -min 0 {outputs}"]


def _chain():
    """Constraints of the JTAG chain that configures the device; Quartus adds its ports."""
    return [
        "# JTAG chain, with the fastest cable and a margin.",
        "# The name is that of Quartus' own JTAG cell: two names would be two clocks.",
        f"create_clock -name {_CHAIN_CLOCK} -period {_CHAIN_NS} [get_ports {{{_CHAIN_CLOCK}}}]",
        "# A request is stable from before its flag reaches the core until it is answered, the",
        "# answer from before its flag reaches the chain.",
        "set_false_path -from [get_registers {*:jtag|request*}] -to [get_clocks $core]",
        "set_false_path -from [get_registers {*:jtag|answer*}] "
        f"-to [get_clocks {{{_CHAIN_CLOCK}}}]"]


def _ethernet():
    """RGMII, whose clock is 2 ns after the data in both directions, and the MAC's crossings."""
    inputs = ports_like(f"eth_rgmii_0__{name}__io*" for name in ("rx_ctl", "rx_data"))
    outputs = ports_like(f"eth_rgmii_0__{name}__io*" for name in ("tx_ctl", "tx_data"))
    sent, changed = _RGMII_NS["sent"], _RGMII_NS["received"]
    received, lines = "eth_rgmii_0__rx_clk__io", [
        "# Ethernet: both edges of a clock, each with its data.",
        generated("ethernet_pin", "ethernet_late", "eth_rgmii_0__tx_clk__io")]
    for edge in ("", "-clock_fall -add_delay "):
        lines += [
            # Data change after an edge, and are stable before the next one.
            f"set_input_delay -clock {received} {edge}-max "
            f"{_RGMII_EDGES - changed + TRACE:.2f} {inputs}",
            f"set_input_delay -clock {received} {edge}-min {changed - TRACE:.2f} {inputs}",
            f"set_output_delay -clock ethernet_pin {edge}-max {sent + TRACE} {outputs}",
            f"set_output_delay -clock ethernet_pin {edge}-min {-sent - TRACE} {outputs}"]
    return [*lines,
            "# First registers of LiteX's synchronisers, and both registers that end a reset.",
            "set_false_path -to [get_registers {*ncdc_processor:processor|*multiregimpl*_regs0*}]",
            "set_false_path -to [get_registers {*ncdc_processor:processor|*ars_cd_eth_*}]",
            *_gray(PROCESSOR_GRAY_COUNTERS, 2 * _RGMII_EDGES)]


def _gray(counters, period):
    """Limits of the routes of Gray counters' bits, which cross domains together.

    Two bits that change one period after the other must not arrive in the other order. Every route
    between a counter and its synchronisers is shorter than :data:`_GRAY_PART` of the shortest
    period. The same paths are cut, also by the attribute of the synchroniser cell. A limit of
    skew or delay would be ignored there. A limit of net delay is not (Intel, Quartus Prime
    Standard Timing Analyzer, 683068, timing constraint precedence).

    Parameters: pairs of patterns of registers; ns.
    """
    return ["# Bits of Gray counters cross together.",
            *(f"set_net_delay -max {_GRAY_PART * period:.3f} -from [get_registers {{{source}}}] "
              f"-to [get_registers {{{sink}}}]" for source, sink in counters)]


def _free(ports):
    """False paths for the ports of :data:`FREE` that the top has."""
    lines = ["# Ports without timing"]
    for pattern, (ways, why) in FREE.items():
        if any(name.startswith(pattern.rstrip("*")) for name in ports):
            lines += [f"# {pattern}: {why}",
                      *(f"set_false_path -{way} [get_ports {{{pattern}}}]" for way in ways)]
    return lines

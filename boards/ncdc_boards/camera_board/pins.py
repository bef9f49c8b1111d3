"""Connects a board's core to the pins that boards name alike."""

from amaranth.lib import io

__all__ = ["buffer", "join_buttons", "join_camera", "join_leds", "join_sdram",
           "join_sensor_control", "join_uart", "request"]


def buffer(m, port):
    """The buffer of a port, a submodule."""
    name = port.p.name if hasattr(port, "p") else port.io.name
    m.submodules[f"{name}_buffer"] = made = io.Buffer(port.direction, port)
    return made


def request(platform, name, signals, number=0):
    """A resource of several signals, without buffers."""
    return platform.request(name, number, dir=dict.fromkeys(signals, "-"))


def join_sdram(m, platform, core, domain="sync"):
    """Registers in the pins' cells, of a ``domain`` that has the core's clock and no reset.

    Returns the port of the chip's clock, which the board drives.
    """
    there = tuple(part.name for part in platform.lookup("sdram").ios)
    pins, ports = core.sdram, request(platform, "sdram", there)
    for name, value in (("clk_en", pins.cke), ("cs", ~pins.cs_n), ("we", ~pins.we_n),
                        ("ras", ~pins.ras_n), ("cas", ~pins.cas_n), ("ba", pins.ba),
                        ("a", pins.a), ("dqm", pins.dqm)):
        if name not in there:
            continue                # wired to its supply or to ground
        m.submodules[f"sdram_{name}"] = register = io.FFBuffer(
            "o", getattr(ports, name), o_domain=domain)
        m.d.comb += register.o.eq(value)
    m.submodules.sdram_dq = dq = io.FFBuffer("io", ports.dq, i_domain=domain, o_domain=domain)
    m.d.comb += [dq.o.eq(pins.dq_o), dq.oe.eq(pins.dq_oe), pins.dq_i.eq(dq.i)]
    return ports.clk


def join_camera(m, platform, core):
    """The sensor; the port of the clock to it, which the board connects."""
    there = tuple(part.name for part in platform.lookup("camera").ios)
    wires = request(platform, "camera", there)
    m.d.comb += [
        core.sensor_clock.eq(buffer(m, wires.pixclk).i),
        core.sensor.frame_valid.eq(buffer(m, wires.fval).i),
        core.sensor.line_valid.eq(buffer(m, wires.lval).i),
        core.sensor.data.eq(buffer(m, wires.d).i),
    ]
    if "standby" in there:          # else it is wired to ground
        m.d.comb += buffer(m, wires.standby).o.eq(0)
    join_sensor_control(m, core, wires)
    return wires.xclk


def join_sensor_control(m, core, wires):
    """Reset and I2C bus of a sensor."""
    m.d.comb += buffer(m, wires.reset_n).o.eq(core.sensor_reset_n)
    for name in ("scl", "sda"):
        line = buffer(m, getattr(wires, name))
        m.d.comb += [line.o.eq(0), line.oe.eq(getattr(core, f"{name}_low")),
                     getattr(core, name).eq(line.i)]


def join_uart(m, platform, core, signals=("rx", "tx")):
    """The serial port; ``signals`` are those of the board's resource."""
    uart = request(platform, "uart", signals)
    m.d.comb += [core.receive.eq(buffer(m, uart.rx).i), buffer(m, uart.tx).o.eq(core.send)]


def join_buttons(m, platform, core, buttons):
    """``buttons``: {member of the core: (resource, number)}."""
    for name, (resource, number) in buttons.items():
        m.d.comb += getattr(core, name).eq(
            buffer(m, platform.request(resource, number, dir="-")).i)


def join_leds(m, platform, leds):
    """Drive the first LEDs of the board with the value ``leds``."""
    for k in range(len(leds)):
        m.d.comb += buffer(m, platform.request("led", k, dir="-")).o.eq(leds[k])

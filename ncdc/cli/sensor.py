"""``ncdc sensor``: the register writes that set up an image sensor."""

import dataclasses

from ncdc.cli.commands import COMMANDS
from ncdc.cli.common import add_json, write_report
from ncdc_spec.files import write_text
from ncdc_spec.sensors.catalogue import SENSORS, sensor_named, setup
from ncdc_spec.sensors.sensor import Settings

__all__ = ["EXAMPLE", "add_arguments", "run"]

EXAMPLE = "ncdc sensor show mt9p031 --width 1280 --height 1024 --exposure-us 10000 --gain-db 6"

_TEXTS = {
    "width": "samples of a row (default: of all columns)",
    "height": "rows of them (default: of all rows)",
    "left": "first column, of the active pixels (default: 0)", "top": "first row (default: 0)",
    "skip": "active columns per sample, and rows: of 2 N two are sent (default: 1)",
    "bins": "columns, and rows, whose mean a sample is (default: 1)",
    "exposure_us": "microseconds (default: 10000)", "gain_db": "decibels (default: 0)",
    "mirror_columns": "the picture left to right", "mirror_rows": "the picture upside down",
    "test_pattern": "picture that the sensor makes itself (default: Off)",
    "frames_per_second": "default: as many as the exposure allows",
    "clock_hz": "external clock of the sensor (default: its usual one)",
    "pixel_clock_hz": "default: the sensor's usual one",
    "lane_hz": "bits per second of a CSI-2 lane (default: the sensor's usual ones)",
}

# `ncdc train --skip` is of the network.
_OPTIONS = {"skip": "--sensor-skip", "bins": "--sensor-bin"}


def add_arguments(parser) -> None:
    """Declare the command's arguments on an argparse parser."""
    show = parser.add_subparsers(dest="action", metavar="ACTION", required=True).add_parser(
        "show", help=COMMANDS["sensor"], description=COMMANDS["sensor"],
        epilog=f"example: {EXAMPLE}")
    show.add_argument("sensor", metavar="SENSOR",
                      help=", ".join(f"{sensor.name} ({sensor.title})" for sensor in SENSORS))
    for field in dataclasses.fields(Settings):
        option = _OPTIONS.get(field.name, f"--{field.name.replace('_', '-')}")
        kind = type(field.default)
        if kind is bool:
            show.add_argument(option, dest=field.name, action="store_true",
                              help=_TEXTS[field.name])
        else:
            show.add_argument(option, dest=field.name, type=kind, default=field.default,
                              metavar={int: "N", float: "X", str: "NAME"}[kind],
                              help=_TEXTS[field.name])
    show.add_argument("--c", metavar="FILE",
                      help="write the registers as a C array into this file")
    add_json(show)


def run(args) -> None:
    """Print the writes, and the timing and field that result from them."""
    sensor = sensor_named(args.sensor)
    plan = setup(sensor, Settings(**{field.name: getattr(args, field.name)
                                     for field in dataclasses.fields(Settings)}))
    if args.c is not None:
        write_text(args.c, c_array(plan))
    if not write_report(plan.report(), args.json):
        print(_table(plan))
        print("\n".join(f"{name:<18} {text}" for name, text in _summary(plan)))


def _summary(plan):
    timing, sensor, link = plan.timing, plan.sensor, plan.link
    lanes = () if link is None else (
        ("CSI-2", f"{link.lanes} lanes of {link.lane_hz / 1e6:g} Mb/s, {link.data_type.name}, "
                  f"{link.embedded_rows} rows of embedded data"),)
    return (
        ("I2C address", f"0x{sensor.i2c_address:02X}, registers of {sensor.value_bits} bits at "
                        f"addresses of {sensor.pointer_bits}"),
        ("chip id", ", ".join(f"0x{value:0{sensor.value_bits // 4}X} at 0x{register:02X}"
                              for register, value in sensor.chip_id)),
        ("exposure", f"{plan.exposure_us:.3f} us of {plan.settings.exposure_us:g} us asked for"),
        ("gain", f"{plan.gain_db:.3f} dB of {plan.settings.gain_db:g} dB asked for"),
        ("line", f"{timing.line_clocks} clocks of {timing.pixel_clock_hz} Hz, "
                 f"{timing.line_us:.3f} us"),
        ("frame", f"{timing.frame_lines} lines, {timing.frames_per_second:.3f} per second"),
        ("samples", f"{timing.width}x{timing.height} {plan.bayer}, {sensor.bits} bits; black is "
                    f"{sensor.black} of 4095"),
        ("field", _field(plan)), *lanes)


def _field(plan):
    """The part of the sensor that the samples cover, and how many pixels each stands for."""
    asked, sensor = plan.settings, plan.sensor
    width, height = asked.skip * asked.width, asked.skip * asked.height
    reduced = "every pixel" if asked.skip == 1 else \
        f"1 of {asked.skip} columns and rows, each the mean of {asked.bins}" if asked.bins > 1 \
        else f"1 of {asked.skip} columns and rows"
    return (f"{width}x{height}+{asked.left}+{asked.top} of {sensor.columns}x{sensor.rows}: "
            f"{100 * width / sensor.columns:.1f} % of the width, "
            f"{100 * height / sensor.rows:.1f} % of the height; {reduced}")


def _table(plan):
    wide = plan.sensor.pointer_bits // 4, plan.sensor.value_bits // 4
    lines = ["register  value   meaning"]
    for write in plan.writes:
        wait = f"; then wait {write.wait_us} us" if write.wait_us else ""
        register, value = (f"0x{number:0{digits}X}"
                           for number, digits in zip((write.register, write.value), wide))
        lines.append(f"{register:<8}  {value:<6}  {write.meaning}{wait}")
    return "\n".join(lines)


def c_array(plan):
    """C source: the writes as an array of a struct that it declares."""
    sensor, timing = plan.sensor, plan.timing
    pointer, value = sensor.pointer_bits, sensor.value_bits
    lines = [
        f"/* {sensor.title}: {timing.width}x{timing.height} {plan.bayer}, "
        f"{plan.exposure_us:.3f} us, {plan.gain_db:.3f} dB,",
        f" * {timing.frames_per_second:.3f} frames per second. I2C address "
        f"0x{sensor.i2c_address:02X}, upper byte first. */",
        "#include <stdint.h>", "",
        f"struct {sensor.name}_write {{",
        f"    uint{pointer}_t address;", f"    uint{value}_t value;",
        "    uint16_t wait_us;   /* after the write */", "};", "",
        f"static const struct {sensor.name}_write {sensor.name}_setup[] = {{"]
    lines += [f"    {{0x{write.register:0{pointer // 4}X}, 0x{write.value:0{value // 4}X}, "
              f"{write.wait_us}}},  /* {write.meaning} */" for write in plan.writes]
    return "\n".join((*lines, "};", ""))

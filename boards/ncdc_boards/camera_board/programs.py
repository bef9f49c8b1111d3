"""Programs that configure a board without a host: sensor, registers, lenses."""

from ncdc_hdl.camera.csi2.burst_start import settle_clocks
from ncdc_hdl.camera.i2c import quarter_clocks
from ncdc_hdl.export.drivers.lenses import Lens
from ncdc_hdl.registers.program import Op
from ncdc_spec.registers.register_map import CTRL_COMMIT, STATUS_BANK, STATUS_COMMITTED, TABLE
from ncdc_spec.registers.system_map import I2C_COMMAND_FLAGS
from ncdc_spec.sensors.framing import Crop

__all__ = ["I2C_HZ", "camera_values", "lens_program", "register_addresses", "configuration_program"]

I2C_HZ = 100_000
"""Standard mode: the pull-ups of an FPGA's pins, some 25 kOhm, are too weak for 400 kHz."""
_HELD_SECONDS = .025            # longest time with SCL low (SMBus specification)
_FLAGS = {name: mask for name, mask, _ in I2C_COMMAND_FLAGS}
_BUSY, _FAILED = 0x100, 0xE00   # bits of I2C_RESULT: not over; NACK, LOST, TIMEOUT


def register_addresses(system):
    """Word address of each register of a system, by name."""
    return {r.name: r.address for r in (*system.corrector.registers.table, *system.table)}


def camera_values(setup, corner, clock_hz, i2c_hz=I2C_HZ):
    """Values of the camera's registers for a sensor's setup, by name; parameters as of
    :func:`configuration_program`."""
    timing, crop = setup.timing, Crop(*corner)
    grid = {"GRID_WEIGHT": crop.weight, "GRID_BIN": crop.binning} if crop.grid else {}
    lanes = {} if setup.link is None else {
        "CSI_CHANNEL": 0, "CSI_TYPE": setup.link.data_type,
        "CSI_SETTLE": settle_clocks(setup.link.lane_hz)}
    return grid | lanes | {
        "I2C_QUARTER": quarter_clocks(clock_hz, i2c_hz),
        "I2C_LIMIT": round(clock_hz * _HELD_SECONDS),
        "SENT_WIDTH": timing.width, "SENT_HEIGHT": timing.height,
        "WINDOW_LEFT": crop.left, "WINDOW_TOP": crop.top, "BLACK_LEVEL": setup.sensor.black,
        "CLOCK_LIMIT": 2 * clock_hz * timing.line_clocks // timing.pixel_clock_hz + clock_hz // 100}


def configuration_program(system, setup, corner, clock_hz, waits=True, i2c_hz=I2C_HZ):
    """Steps that configure the sensor and begin to correct its frames.

    If the sensor does not answer, the program begins anew. It may run again later. Frames that
    were captured before the sensor is configured are invalid; registers are locked meanwhile.

    Parameters
    ----------
    system : System
    setup : Setup
        A sensor without writes is not accessed.
    corner : Crop
        Crop of the sensor's frame; or column and row where the raw frame begins.
    clock_hz : int
        Clock of the registers in Hz.
    waits : bool
        Whether to wait for the sensor's phase-locked loop, which its model lacks.
    i2c_hz : int
        Bits per second of the bus to the sensor.
    """
    at = register_addresses(system)
    steps = [(Op.WRITE, at["CAMERA_ENABLE"], 0), (Op.WRITE, at["RUN"], 0)]
    steps += [(Op.WRITE, at[name], value)
              for name, value in camera_values(setup, corner, clock_hz, i2c_hz).items()]
    running = [(Op.WRITE, at["RUN"], 1), (Op.WRITE, at["CAMERA_ENABLE"], 1)]
    if not setup.writes:
        return steps + running
    # A target that a reset interrupted in the middle of a byte ends it. The result is ignored.
    steps += _command(at, 0, "READ", "NACK", "STOP")
    *writes, last = setup.writes
    for write in writes:
        steps += _sensor_write(at, setup.sensor, write)
        if waits and write.wait_us:
            steps.append((Op.PAUSE, 0, -(-write.wait_us * clock_hz // 10**6)))
    return steps + running + _sensor_write(at, setup.sensor, last)


def _command(at, data, *flags):
    """A command on the I2C bus, with the wait for its end."""
    word = data | sum(_FLAGS[name] for name in flags)
    return [(Op.WRITE, at["I2C_COMMAND"], word), (Op.UNTIL_ZERO, at["I2C_RESULT"], _BUSY)]


def _sensor_write(at, sensor, write):
    """Write a register of the sensor."""
    data = [*write.register.to_bytes(sensor.pointer_bits // 8, "big"),
            *write.value.to_bytes(sensor.value_bits // 8, "big")]
    guard = [(Op.GUARD, at["I2C_RESULT"], _FAILED)]
    steps = _command(at, sensor.i2c_address << 1, "START", "WRITE") + guard
    for byte in data[:-1]:
        steps += _command(at, byte, "WRITE") + guard
    return steps + _command(at, data[-1], "WRITE", "STOP") + guard


def lens_program(system, descriptor):
    """Steps that load the lens of ``descriptor``; it takes effect with the next frame."""
    at, lens = register_addresses(system), Lens.of(system.corrector, descriptor)
    return [
        (Op.UNTIL_ZERO, at["STATUS"], STATUS_COMMITTED),
        *((Op.WRITE, at[name], value) for name, value in lens.values.items()),
        (Op.LOOK, at["STATUS"], STATUS_BANK), (Op.WRITE_NOT, at["VALID_WINDOW"], 0),
        *((Op.WRITE, TABLE + k, word) for k, word in enumerate(lens.valid_rows)),
        (Op.WRITE_NOT, at["VALID_BANK"], 0), (Op.WRITE, at["CTRL"], CTRL_COMMIT)]

"""Driver of NCDC's camera system in Python; needs nothing but ncdc_registers.py beside it."""

import time
from collections import namedtuple

import ncdc_registers as registers

__all__ = ["Camera", "CameraError", "Frame"]

_EVENTS = ("RAW_FRAME", "RAW_BAD", "CORRECTED_FRAME", "CORRECTED_BAD", "TAKEN", "I2C_DONE",
           "REFUSED")
_FIRST_EVENT = registers.CAMERA_STATUS_RAW_FRAME.bit_length() - 1
_TRIES = 3          # of a transfer on the I2C bus
_POLLS = 100_000    # of a command on it

Frame = namedtuple("Frame", "base size number time")
Frame.__doc__ = """A frame that a reader holds: byte address and bytes of its place, number of its
raw frame from 1 on, clocks from the reset to that frame's beginning."""


class CameraError(RuntimeError):
    """The sensor does not answer, or the system refused something."""


def _field(word, mask):
    """The bits of ``word`` under ``mask``, a run of ones, as a number."""
    return (word & mask) // (mask & -mask)


class Camera:
    """The camera, the frame stores and the I2C bus of one system, reached through two functions.

    Parameters
    ----------
    read : callable
        ``read(offset)`` gives the 32-bit word at a byte offset of the system's registers.
    write : callable
        ``write(offset, value)``.
    pause : callable
        Called again and again while a byte is under way on the I2C bus.

    Attributes
    ----------
    i2c_errors : list of str
        What ended transfers: flags of `I2C_RESULT`.
    """

    def __init__(self, read, write, pause=lambda: None):
        self.read, self.write, self.pause = read, write, pause
        self.i2c_errors = []

    def get(self, name):
        """Value of the register ``name``."""
        return self.read(registers.OFFSET[name])

    def put(self, **values):
        """Write registers by name, in this order.

        Raises
        ------
        CameraError
            If one is refused, as camera or corrector are at work with it.
        """
        for name, value in values.items():
            self.write(registers.OFFSET[name], value & 0xFFFFFFFF)
        refused = registers.CAMERA_STATUS_REFUSED
        if self.get("CAMERA_STATUS") & refused:
            self.write(registers.OFFSET["CAMERA_STATUS"], refused)
            raise CameraError(f"a write was refused, of {', '.join(values)}: the camera is active, "
                              f"or the corrector runs")

    def start(self):
        """Correct every frame that begins from now on."""
        self.put(RUN=1, CAMERA_ENABLE=1)

    def stop(self):
        """Let the frames under way end, and begin no other."""
        self.put(CAMERA_ENABLE=0, RUN=0)

    def listen(self, *events):
        """Let the interrupt follow these events, by the names of `CAMERA_STATUS`."""
        self.put(CAMERA_IRQ_ENABLE=sum(1 << _EVENTS.index(name) for name in events))

    def events(self):
        """Names of the events since they were asked for last, which are forgotten."""
        status = self.get("CAMERA_STATUS") >> _FIRST_EVENT
        self.write(registers.OFFSET["CAMERA_STATUS"], status << _FIRST_EVENT)
        return {name for k, name in enumerate(_EVENTS) if status >> k & 1}

    def claim(self, reader, corrected=True):
        """Claim the newest corrected, or raw, frame, in place of what ``reader`` held.

        Returns
        -------
        Frame or None
            None if there is none yet.
        """
        name = f"READER{reader}"
        flag = "CLAIM_CORRECTED" if corrected else "CLAIM_RAW"
        self.put(**{name: getattr(registers, f"{name}_{flag}")})
        word = self.get(name)
        if not word & getattr(registers, f"{name}_HELD"):
            return None
        store = "CORRECTED" if corrected else "RAW"
        buffer = f"{store}{_field(word, getattr(registers, f'{name}_BUFFER'))}"
        return Frame(self.get(f"{buffer}_BASE"), self.get(f"{store}_BYTES"),
                     self.get(f"{buffer}_NUMBER"),
                     self.get(f"{buffer}_TIME_LOW") | self.get(f"{buffer}_TIME_HIGH") << 32)

    def lost(self, reader):
        """Whether the frame was taken away from ``reader``: what it read may be of two frames."""
        return bool(self.get(f"READER{reader}") & getattr(registers, f"READER{reader}_LOST"))

    def release(self, reader):
        """Give back what ``reader`` holds."""
        self.put(**{f"READER{reader}": getattr(registers, f"READER{reader}_RELEASE")})

    def set_up(self, setup):
        """Write the set-up of a sensor.

        Parameters
        ----------
        setup : dict
            As ``ncdc sensor show --json`` gives it.

        Raises
        ------
        CameraError
            If the sensor does not answer, or is another one.
        """
        for register, value in setup["chip_id"]:
            if (found := self.read_sensor(setup, register)) != value:
                raise CameraError(f"register {register:#x} of the sensor reads {found:#x}, the "
                                  f"{setup['sensor']} has {value:#x}")
        for write in setup["writes"]:
            self.write_sensor(setup, write["register"], write["value"])
            if write["wait_us"]:
                time.sleep(write["wait_us"] * 1e-6)

    def write_sensor(self, setup, register, value):
        """Write a register of the sensor of ``setup``."""
        words = _bytes(register, setup["pointer_bits"]) + _bytes(value, setup["value_bits"])

        def transfer():
            self._i2c(setup["i2c_address"] << 1, "START", "WRITE")
            for word in words[:-1]:
                self._i2c(word, "WRITE")
            self._i2c(words[-1], "WRITE", "STOP")
        self._persistently(transfer)

    def read_sensor(self, setup, register):
        """Value of a register of the sensor of ``setup``."""
        def transfer():
            self._i2c(setup["i2c_address"] << 1, "START", "WRITE")
            for word in _bytes(register, setup["pointer_bits"]):
                self._i2c(word, "WRITE")
            self._i2c(setup["i2c_address"] << 1 | 1, "START", "WRITE")
            upper = self._i2c(0, "READ") if setup["value_bits"] == 16 else 0
            return upper << 8 | self._i2c(0, "READ", "NACK", "STOP")
        return self._persistently(transfer)

    def _persistently(self, transfer):
        """Try more than once, and let a target that was left in mid-byte end it before."""
        for _ in range(_TRIES - 1):
            try:
                return transfer()
            except CameraError:
                try:
                    self._i2c(0, "READ", "NACK", "STOP")
                except CameraError:
                    pass
        return transfer()

    def _i2c(self, data, *flags):
        """One command; the byte received."""
        self.put(I2C_COMMAND=data | sum(getattr(registers, f"I2C_COMMAND_{name}")
                                        for name in flags))
        for _ in range(_POLLS):
            result = self.get("I2C_RESULT")
            if not result & registers.I2C_RESULT_BUSY:
                break
            self.pause()
        for name, what in (("NACK", "nobody acknowledges"), ("LOST", "the bus is not free"),
                           ("TIMEOUT", "SCL is held"), ("BUSY", "a command does not end")):
            if result & getattr(registers, f"I2C_RESULT_{name}"):
                self.i2c_errors.append(name)
                raise CameraError(f"I2C: {what}")
        return result & registers.I2C_RESULT_DATA


def _bytes(value, bits):
    """A number of 8 or 16 bits, the upper byte first."""
    return list(value.to_bytes(bits // 8, "big"))

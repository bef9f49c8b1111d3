"""Driver of NCDC's camera system in Python; it needs only ncdc_registers.py in the same folder."""

import time
import warnings
from collections import namedtuple

import ncdc_registers as registers

__all__ = ["CameraError", "CameraSystem", "HeldFrame"]

_EVENTS = ("RAW_FRAME", "RAW_BAD", "CORRECTED_FRAME", "CORRECTED_BAD", "TAKEN", "I2C_DONE",
           "REFUSED")
_FIRST_EVENT = registers.CAMERA_STATUS_RAW_FRAME.bit_length() - 1
_GAINS = (registers.CAPTURE_GAINS_RED, registers.CAPTURE_GAINS_GREEN,
          registers.CAPTURE_GAINS_BLUE)
_TRIES = 3          # attempts of a transfer on the I2C bus
_POLLS = 100_000    # polls of a command on it
_RENAMED = {"Camera": "CameraSystem", "Frame": "HeldFrame"}

HeldFrame = namedtuple("HeldFrame", "base size number time")
HeldFrame.__doc__ = """A frame that a reader holds: byte address and bytes of its buffer, number of
its raw frame from 1 on, clocks from the reset to that frame's beginning."""


class CameraError(RuntimeError):
    """The sensor does not answer, or the system rejected a write."""


def _field(word, mask):
    """The bits of ``word`` under ``mask``, a run of ones, as a number."""
    return (word & mask) // (mask & -mask)


class CameraSystem:
    """The camera, the frame stores and the I2C bus of one system, reached through two functions.

    Parameters
    ----------
    read : callable
        ``read(offset)`` returns the 32-bit word at a byte offset of the system's registers.
    write : callable
        ``write(offset, value)``.
    pause : callable
        Called repeatedly while a byte is under way on the I2C bus.

    Attributes
    ----------
    i2c_errors : list of str
        Causes of failed transfers: flags of `I2C_RESULT`.
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
            If one is rejected, as camera or corrector use it.
        """
        for name, value in values.items():
            self.write(registers.OFFSET[name], value & 0xFFFFFFFF)
        rejected = registers.CAMERA_STATUS_REFUSED
        if self.get("CAMERA_STATUS") & rejected:
            self.write(registers.OFFSET["CAMERA_STATUS"], rejected)
            raise CameraError(f"a write of {', '.join(values)} was rejected: the camera is active, "
                              f"or the corrector runs")

    def start(self):
        """Correct every frame that begins from now on."""
        self.put(RUN=1, CAMERA_ENABLE=1)

    def stop(self):
        """Let the frames under way end, and begin no other."""
        self.put(CAMERA_ENABLE=0, RUN=0)

    @property
    def gains(self):
        """Gains of red, green and blue samples at capture, before interpolation, in 256ths.

        Set at any time; frames of the sensor that begin afterwards have them. Setting raises
        ``ValueError`` unless there are three integers of 0 to 1023.
        """
        word = self.get("CAPTURE_GAINS")
        return tuple(_field(word, mask) for mask in _GAINS)

    @gains.setter
    def gains(self, values):
        values = tuple(values)
        if len(values) != len(_GAINS):
            raise ValueError(f"there are {len(values)} gains, {len(_GAINS)} are needed")
        for value, mask in zip(values, _GAINS):
            if value not in range(_field(mask, mask) + 1):
                raise ValueError(f"a gain is {value}, an integer of 0 to {_field(mask, mask)} is "
                                 f"needed")
        self.put(CAPTURE_GAINS=sum(int(value) * (mask & -mask)
                                   for value, mask in zip(values, _GAINS)))

    def listen(self, *events):
        """Enable the interrupt for these events, by the names of `CAMERA_STATUS`."""
        self.put(CAMERA_IRQ_ENABLE=sum(1 << _EVENTS.index(name) for name in events))

    def events(self):
        """Names of the events since the last call, which clears them."""
        status = self.get("CAMERA_STATUS") >> _FIRST_EVENT
        self.write(registers.OFFSET["CAMERA_STATUS"], status << _FIRST_EVENT)
        return {name for k, name in enumerate(_EVENTS) if status >> k & 1}

    def claim(self, reader, corrected=True):
        """Claim the newest corrected, or raw, frame, and release the one that ``reader`` held.

        Returns
        -------
        HeldFrame or None
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
        return HeldFrame(self.get(f"{buffer}_BASE"), self.get(f"{store}_BYTES"),
                     self.get(f"{buffer}_NUMBER"),
                     self.get(f"{buffer}_TIME_LOW") | self.get(f"{buffer}_TIME_HIGH") << 32)

    def lost(self, reader):
        """Whether the frame was taken away from ``reader``: data read may be of two frames."""
        return bool(self.get(f"READER{reader}") & getattr(registers, f"READER{reader}_LOST"))

    def release(self, reader):
        """Release the frame that ``reader`` holds."""
        self.put(**{f"READER{reader}": getattr(registers, f"READER{reader}_RELEASE")})

    def set_up(self, setup):
        """Write the configuration of a sensor.

        Parameters
        ----------
        setup : dict
            The output of ``ncdc sensor show --json``.

        Raises
        ------
        CameraError
            If the sensor does not answer, or is of another type.
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
        """Try more than once; between tries let an interrupted target end its byte."""
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
        """Send one command; return the byte received."""
        self.put(I2C_COMMAND=data | sum(getattr(registers, f"I2C_COMMAND_{name}")
                                        for name in flags))
        for _ in range(_POLLS):
            result = self.get("I2C_RESULT")
            if not result & registers.I2C_RESULT_BUSY:
                break
            self.pause()
        for name, what in (("NACK", "no acknowledge"), ("LOST", "the bus is not free"),
                           ("TIMEOUT", "SCL is held"), ("BUSY", "a command does not end")):
            if result & getattr(registers, f"I2C_RESULT_{name}"):
                self.i2c_errors.append(name)
                raise CameraError(f"I2C: {what}")
        return result & registers.I2C_RESULT_DATA


def _bytes(value, bits):
    """A number of 8 or 16 bits, the upper byte first."""
    return list(value.to_bytes(bits // 8, "big"))


def __getattr__(name):
    """The classes by their names of the last release."""
    if name not in _RENAMED:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    warnings.warn(f"{name} is called {_RENAMED[name]}; the old name will be removed", FutureWarning,
                  stacklevel=2)
    return globals()[_RENAMED[name]]

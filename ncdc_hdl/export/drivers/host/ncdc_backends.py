"""Ways to the registers for ncdc_driver.Corrector: mapped memory, a serial port, System
Console, and the JTAG chain that configures a board."""

import mmap
import os
import struct
import subprocess
import time
import warnings

__all__ = ["JtagChain", "Mapped", "Serial", "SystemConsole"]

_BYTES = 1 << 16        # bytes of the registers
_RENAMED = {"ScanChain": "JtagChain"}


class Mapped:
    """Registers mapped into memory: ``Corrector(*Mapped("/dev/uio0"))``.

    Parameters
    ----------
    path : str
        "/dev/uio0" and the like, whose map 0 is the corrector's, or "/dev/mem".
    offset : int
        Byte address of the registers in the file, a multiple of the page; 0 for map 0 of a UIO
        device.
    size : int
        Bytes of the registers; twice as many for a camera system.
    """

    def __init__(self, path, offset=0, size=_BYTES):
        self.file = os.open(path, os.O_RDWR | os.O_SYNC)
        self.words = memoryview(mmap.mmap(self.file, size, offset=offset)).cast("I")

    def __iter__(self):
        return iter((self.read, self.write))

    def read(self, offset):
        """The word at a byte offset; in one access of 32 bits."""
        return self.words[offset // 4]

    def write(self, offset, value):
        """Write the word at a byte offset; one access of 32 bits."""
        self.words[offset // 4] = value

    def wait_for_interrupt(self):
        """Allow the interrupt of a UIO device and sleep until it comes: an ``idle``."""
        os.write(self.file, struct.pack("I", 1))
        os.read(self.file, 4)


class Serial:
    """Registers at a serial port: ``Corrector(*Serial("/dev/ttyUSB0"))``.

    Each access is a request of some bytes and an answer, both with a check. One without a correct
    answer is repeated. A register is then written twice, which for ``READERk`` and
    ``I2C_COMMAND`` means two claims or two commands.

    Parameters
    ----------
    port : str or file
        Name of the port, which needs the package pyserial; or an object with ``read(size)``, which
        returns fewer bytes after a timeout, and ``write(bytes)``.
    baud : int
    tries : int
        Number of attempts of each access.
    pause : float
        Seconds of silence after which the device expects a new request.
    """

    def __init__(self, port, baud=1_000_000, tries=3, pause=.01):
        if isinstance(port, str):
            import serial
            port = serial.Serial(port, baud, timeout=.2)
        self.port, self.tries, self.pause = port, tries, pause

    def __iter__(self):
        return iter((self.read, self.write))

    def read(self, offset):
        """The word at a byte offset."""
        return int.from_bytes(self._ask(b"R" + self._address(offset), b"r", 4), "big")

    def write(self, offset, value):
        """Write the word at a byte offset."""
        self._ask(b"W" + self._address(offset) + value.to_bytes(4, "big"), b"w", 0)

    @staticmethod
    def _address(offset):
        return (offset // 4).to_bytes(2, "big")

    @staticmethod
    def _check(data):
        """CRC of eight bits, polynomial 7, initial value 255."""
        value = 0xFF
        for byte in data:
            value ^= byte
            for _ in range(8):
                value = (value << 1 ^ (7 if value & 0x80 else 0)) & 0xFF
        return bytes([value])

    def _ask(self, request, letter, size):
        """Send a request; return the data after the letter of its answer."""
        for _ in range(self.tries):
            self.port.write(request + self._check(request))
            answer = self.port.read(size + 2)
            if (len(answer) == size + 2 and answer[:1] == letter
                    and answer[-1:] == self._check(answer[:-1])):
                return answer[1:-1]
            time.sleep(self.pause)
            while self.port.read(1):        # drop the rest of a wrong answer
                pass
        raise OSError("no right answer came from the serial port")


class _Tcl:
    """A program of Quartus that reads Tcl at its standard input."""

    def __init__(self, command, begin):
        self.program = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE,
                                        text=True, bufsize=1)
        self._ask(begin)

    def __iter__(self):
        return iter((self.read, self.write))

    def close(self):
        """End the program."""
        self.program.communicate("exit\n")

    def _ask(self, command):
        """Result of a command; OSError with its message if it fails."""
        # An echo of the command is no answer: the C is escaped in it.
        self.program.stdin.write(f"if {{[catch {{{command}}} said]}} "
                                 '{puts "NCD\\x43-ERROR $said"} else {puts "NCD\\x43 $said"}\n')
        for line in self.program.stdout:
            if "NCDC-ERROR" in line:
                raise OSError(line.split("NCDC-ERROR")[1].strip())
            if "NCDC" in line:
                return line.split("NCDC")[1].strip()
        raise OSError(f"{self.program.args[0]} ended without an answer")


class SystemConsole(_Tcl):
    """Registers at a JTAG host, through Quartus' System Console.

    Parameters
    ----------
    base : int
        Byte address of the registers in the host's map; by default that of the generated
        systems.
    command : sequence of str
        The console; its standard input reads Tcl.
    master : int
        Number of the board's host.
    """

    def __init__(self, base=0x1000_0000, command=("system-console", "--cli"), master=0):
        self.base = base
        super().__init__(command, "set ncdc [claim_service master "
                                  f"[lindex [get_service_paths master] {master}] ncdc]")

    def read(self, offset):
        """The word at a byte offset."""
        return int(self._ask(f"master_read_32 $ncdc {self.base + offset:#x} 1"), 0)

    def write(self, offset, value):
        """Write the word at a byte offset."""
        self._ask(f"master_write_32 $ncdc {self.base + offset:#x} {value:#x}")


class JtagChain(_Tcl):
    """Registers of a board of ``ncdc build`` with Quartus, through the cable that configures it.

    Parameters
    ----------
    command : sequence of str
        Quartus' program for the cable; its standard input reads Tcl.
    cable : int
        Number of the computer's cable.
    device : str
        Regular expression of the device's name, as ``jtagconfig`` prints it: by default the first
        Cyclone IV or V, not the hard processor in the same chain.
    tries : int
        Scans after which a request without an answer fails.
    """

    _KINDS = {"read": 1, "write": 2}

    def __init__(self, command=("quartus_stp", "-s"), cable=0, device="[ /](5C|EP4C)", tries=50):
        self.tries, self.tag = tries, 0
        super().__init__(command, f"""
            set cable [lindex [get_hardware_names] {cable}]
            set devices [get_device_names -hardware_name $cable]
            set device [lsearch -inline -regexp $devices {{{device}}}]
            if {{$device eq {{}}}} {{ error {{no such device is in the chain}} }}
            open_device -hardware_name $cable -device_name $device
            device_lock -timeout 10000
            device_virtual_ir_shift -instance_index 0 -ir_value 1 -no_captured_ir_value
            """.replace("\n", ";"))

    def close(self):
        """Unlock the chain, and end the program."""
        self._ask("device_unlock; close_device")
        super().close()

    def read(self, offset):
        """The word at a byte offset."""
        return self._access("read", offset, 0)

    def write(self, offset, value):
        """Write the word at a byte offset."""
        self._access("write", offset, value)

    def _access(self, kind, offset, word):
        """Scan a request in, and scan until its answer comes; return its word."""
        self.tag = (self.tag + 1) % 256
        kind = self._KINDS[kind]
        request = kind << 56 | self.tag << 48 | offset // 4 << 32
        self._scan(request | word)
        for _ in range(self.tries):
            answer = self._scan(0)
            if answer >> 32 == request >> 32:
                return answer & 0xFFFF_FFFF
        raise OSError(f"no answer came from the JTAG chain in {self.tries} scans")

    def _scan(self, value):
        """Shift a value into the register; return the value shifted out."""
        return int(self._ask("device_virtual_dr_shift -instance_index 0 -length 64 "
                             f"-dr_value {value:016X} -value_in_hex"), 16)


def __getattr__(name):
    """The class by its name of the last release."""
    if name not in _RENAMED:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    warnings.warn(f"{name} is called {_RENAMED[name]}; the old name will be removed", FutureWarning,
                  stacklevel=2)
    return globals()[_RENAMED[name]]

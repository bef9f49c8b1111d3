"""Ways to the registers for ncdc_driver.Corrector: memory that is mapped, a serial port, and System
Console."""

import mmap
import os
import struct
import subprocess
import time

__all__ = ["Mapped", "Serial", "SystemConsole"]

_BYTES = 1 << 16        # of the registers


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
        Bytes of the registers; twice as many of a camera system.
    """

    def __init__(self, path, offset=0, size=_BYTES):
        self.file = os.open(path, os.O_RDWR | os.O_SYNC)
        self.words = memoryview(mmap.mmap(self.file, size, offset=offset)).cast("I")

    def __iter__(self):
        return iter((self.read, self.write))

    def read(self, offset):
        """The word at a byte offset; one access of 32 bits."""
        return self.words[offset // 4]

    def write(self, offset, value):
        """Write the word at a byte offset; one access of 32 bits."""
        self.words[offset // 4] = value

    def wait_for_interrupt(self):
        """Allow the interrupt of a UIO device and sleep until it comes: an ``idle``."""
        os.write(self.file, struct.pack("I", 1))
        os.read(self.file, 4)


class Serial:
    """Registers behind a serial port: ``Corrector(*Serial("/dev/ttyUSB0"))``.

    Each access is a request of some bytes and an answer, both with a check. One that gets no right
    answer is asked again: a register is written twice then, which for ``READERk`` and
    ``I2C_COMMAND`` means two claims or two commands.

    Parameters
    ----------
    port : str or file
        Name of the port, which needs the package pyserial; or what has ``read(size)``, which
        gives fewer bytes after some time without any, and ``write(bytes)``.
    baud : int
    tries : int
        Of each access.
    pause : float
        Seconds of silence after which the other side begins anew.
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
        """CRC of eight bits, polynomial 7, from 255 on."""
        value = 0xFF
        for byte in data:
            value ^= byte
            for _ in range(8):
                value = (value << 1 ^ (7 if value & 0x80 else 0)) & 0xFF
        return bytes([value])

    def _ask(self, request, letter, size):
        """Send a request; what stands in its answer behind the letter."""
        for _ in range(self.tries):
            self.port.write(request + self._check(request))
            answer = self.port.read(size + 2)
            if (len(answer) == size + 2 and answer[:1] == letter
                    and answer[-1:] == self._check(answer[:-1])):
                return answer[1:-1]
            time.sleep(self.pause)
            while self.port.read(1):        # what is left of a wrong answer
                pass
        raise OSError("no right answer came from the serial port")


class SystemConsole:
    """Registers behind a JTAG host, through Quartus' System Console.

    Parameters
    ----------
    base : int
        Byte address of the registers as the host sees them; that of the generated systems if
        absent.
    command : sequence of str
        The console; its standard input takes Tcl.
    master : int
        Which of the board's hosts.
    """

    def __init__(self, base=0x1000_0000, command=("system-console", "--cli"), master=0):
        self.base = base
        self.console = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE,
                                        text=True, bufsize=1)
        self._ask(f"set ncdc [claim_service master [lindex [get_service_paths master] {master}] "
                  f"ncdc]; puts {{NCDC 0}}")

    def __iter__(self):
        return iter((self.read, self.write))

    def read(self, offset):
        """The word at a byte offset."""
        return int(self._ask(f'puts "NCDC [master_read_32 $ncdc {self.base + offset:#x} 1]"'), 0)

    def write(self, offset, value):
        """Write the word at a byte offset."""
        self._ask(f"master_write_32 $ncdc {self.base + offset:#x} {value:#x}; puts {{NCDC 0}}")

    def close(self):
        """End the console."""
        self.console.communicate("exit\n")

    def _ask(self, command):
        """Run Tcl that prints a line with NCDC and an answer; the answer."""
        self.console.stdin.write(command + "\n")
        for line in self.console.stdout:
            if "NCDC " in line:
                return line.split("NCDC ")[1].split()[0]
        raise OSError("System Console ended without an answer")

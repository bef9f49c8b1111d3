"""Ways to the registers for ncdc_driver.Corrector: memory that is mapped, and System Console."""

import mmap
import os
import struct
import subprocess

__all__ = ["Mapped", "SystemConsole"]

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

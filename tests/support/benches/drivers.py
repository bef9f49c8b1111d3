"""The drivers in C and Python with the corrector: their bus is the simulated Avalon-MM agent."""

import ctypes
import runpy
import subprocess
import sys
import tempfile
from pathlib import Path

import cocotb
import numpy as np
from cocotb.task import bridge, resume

from benches.avalon import Host, read_memory, write_memory
from benches.common import settings, start
from ncdc_model.correction import correct
from ncdc_spec.descriptor import Descriptor
from ncdc_spec.frames import frame_bytes, raw_image, stored_picture
from ncdc_spec.registers.host_values import host_values

__all__ = ["c_driver_alternates_lenses", "c_driver_corrects_one_frame", "c_driver_names_errors",
           "console_corrects_frames", "python_driver_alternates_lenses"]

_STEP = 8192        # bytes from frame to frame in memory
_FRAMES = 5
_REGISTERS, _MEMORY = 0x1000_0000, 0x4000_0000     # what System Console's host sees, and where
_READ = ctypes.CFUNCTYPE(ctypes.c_uint32, ctypes.c_void_p, ctypes.c_uint32)
_WRITE = ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_uint32, ctypes.c_uint32)


class Device(ctypes.Structure):
    """``struct ncdc`` of ncdc.h."""
    _fields_ = [("read", _READ), ("write", _WRITE), ("context", ctypes.c_void_p)]


class Buffer(ctypes.Structure):
    """``struct ncdc_buffer`` of ncdc.h."""
    _fields_ = [("address", ctypes.c_uint32), ("bytes", ctypes.c_uint32)]


class Bench:
    """The corrector between memory agents, with the raw frames of all cameras in memory."""

    def __init__(self, dut):
        s = settings()
        self.dut = dut
        self.cameras = [Descriptor.load(path) for path in s["descriptors"]]
        rng = np.random.default_rng(5)
        self.raws = [rng.integers(0, 256, d.geometry.distorted[::-1], np.uint8)
                     for d in self.cameras]
        self.memory = bytearray(b"\xa5" * (_STEP * (len(self.cameras) + _FRAMES)))
        self.source = [_STEP * k for k in range(len(self.cameras))]
        self.target = _STEP * len(self.cameras)
        for address, d, raw in zip(self.source, self.cameras, self.raws):
            pitch = host_values(d)["SOURCE_PITCH"]
            image = raw_image(raw, pitch)
            self.memory[address:address + len(image)] = image
        self.sources = (Buffer * 2)(*((address, _STEP) for address in self.source))
        self.targets = (Buffer * _FRAMES)(*((self.target + k * _STEP, _STEP)
                                            for k in range(_FRAMES)))
        self.errors = []        # ctypes drops what a callback raises

    async def begin(self):
        """Reset and start the memory; returns blocking read(offset) and write(offset, value)."""
        dut = self.dut
        readers = [r for r in range(3) if hasattr(dut, f"read{r}_read")]
        await start(dut, csr_read=0, csr_write=0, csr_address=0, csr_writedata=0,
                    write_waitrequest=0, memory_rst=0,
                    **{f"read{r}_{name}": 0 for r in readers
                       for name in ("waitrequest", "readdata", "readdatavalid")})
        for r in readers:
            cocotb.start_soon(read_memory(dut, f"read{r}", self.memory, wait=.3, latency=(1, 9),
                                          seed=r))
        cocotb.start_soon(write_memory(dut, "write", self.memory, wait=.3))
        host = Host(dut, "csr")
        return (resume(lambda offset: host.read(offset >> 2)),
                resume(lambda offset, value: host.write(offset >> 2, value)))

    def device(self, read, write):
        """``struct ncdc`` whose functions are ``read`` and ``write``."""
        def guarded(function, *arguments):
            try:
                return function(*arguments)
            except Exception as error:
                self.errors.append(error)
                return 0

        return Device(_READ(lambda _, offset: guarded(read, offset)),
                      _WRITE(lambda _, offset, value: guarded(write, offset, value)), None)

    def library(self):
        """The compiled driver with the samples of the documentation."""
        return ctypes.CDLL(settings()["library"])

    def check(self, frames):
        """Frame k in memory is camera k mod n's, for every k below ``frames``; no other follows."""
        assert not self.errors, self.errors
        for k in range(_FRAMES):
            d, raw = (part[k % len(self.cameras)] for part in (self.cameras, self.raws))
            address, size = self.target + k * _STEP, frame_bytes(d.geometry)
            stored = np.frombuffer(bytes(self.memory[address:address + _STEP]), np.uint8)
            if k >= frames:
                assert (stored == 0xA5).all(), f"frame {k} was written"
                continue
            width, height = d.geometry.corrected
            np.testing.assert_array_equal(
                stored_picture(stored[:size].reshape(height, width, 4)), correct(d, raw).picture,
                f"frame {k}")


@cocotb.test()
async def c_driver_corrects_one_frame(dut):
    """The first sample: load, set addresses, start, wait, counters."""
    bench = Bench(dut)
    device, library = bench.device(*await bench.begin()), bench.library()
    counters = (ctypes.c_uint32 * len(settings()["counters"]))()
    result = await bridge(lambda: library.correct_one(
        ctypes.byref(device), bench.sources, bench.targets, counters))()
    assert result == 0
    bench.check(1)
    width, height = bench.cameras[0].geometry.corrected
    named = dict(zip(settings()["counters"], counters))
    assert named["PIXELS"] == width * height and named["FRAMES"] == 1
    assert named["CLOCKS"] > named["PIXELS"]


@cocotb.test()
async def c_driver_alternates_lenses(dut):
    """The second sample: another lens with every frame, each started while the last one runs."""
    bench = Bench(dut)
    device, library = bench.device(*await bench.begin()), bench.library()
    result = await bridge(lambda: library.alternate(
        ctypes.byref(device), bench.sources, bench.targets, _FRAMES))()
    assert result == 0
    bench.check(_FRAMES)


@cocotb.test()
async def c_driver_names_errors(dut):
    """The driver's errors, and that it leaves a waiting commit alone."""
    bench = Bench(dut)
    read, write = await bench.begin()
    device, library = bench.device(read, write), bench.library()
    here = ctypes.byref(device)
    wide = ctypes.c_char.in_dll(library, "ncdc_lens_wide")

    def errors():
        assert library.ncdc_wait(here, 3) == 5, "timeout"
        assert library.ncdc_load(here, ctypes.byref(wide)) == 0
        lens, small = ctypes.byref(wide), Buffer(bench.target, 64)
        assert library.ncdc_altered(here) == 1, "loaded"
        assert library.ncdc_place(here, lens, bench.sources, ctypes.byref(small)) == 10, "too small"
        odd = Buffer(bench.source[0] + 2, _STEP - 2)
        assert library.ncdc_place(here, lens, ctypes.byref(odd), bench.targets) == 9, "alignment"
        assert library.ncdc_place(here, lens, bench.sources, bench.targets) == 0
        library.ncdc_commit_and_start(here)
        library.ncdc_commit(here)
        before = [read(offset) for offset in range(0x20, 0x58, 4)]
        assert library.ncdc_load(here, ctypes.byref(wide)) == 3, "a commit waits"
        assert library.ncdc_place(here, lens, bench.sources, bench.targets) == 3, "a commit waits"
        assert [read(offset) for offset in range(0x20, 0x58, 4)] == before
        assert library.ncdc_wait(here, 0) == 0
        # A frame with invalid parameters is rejected with its fault.
        write(0x24, 0)
        library.ncdc_commit_and_start(here)
        assert library.ncdc_wait(here, 0) == 11, "pitch 0"
        assert library.ncdc_faults(here) == 8 and library.ncdc_faults(here) == 0
        assert library.ncdc_load(here, ctypes.byref(wide)) == 0
        library.ncdc_commit(here)
        # With an interrupt, and by a callback that gives up at its third call.
        result = ctypes.c_int(-1)
        library.ncdc_enable_interrupt(here, 1)
        assert library.ncdc_interrupted(here, ctypes.byref(result)) == 0
        library.ncdc_start(here)
        calls = []
        idle = ctypes.CFUNCTYPE(ctypes.c_int, ctypes.c_void_p)(
            lambda _: calls.append(1) or len(calls) == 3)
        assert library.ncdc_wait_calling(here, idle, None) == 5 and len(calls) == 3
        while not library.ncdc_interrupted(here, ctypes.byref(result)):
            pass
        assert result.value == 0 and not read(0x10) & 2
        library.ncdc_enable_interrupt(here, 0)
        library.ncdc_start(here)
        library.ncdc_abort(here)
        assert library.ncdc_wait(here, 0) == 6, "aborted"
        other = bench.device(lambda offset: read(offset + 4), write)
        assert library.ncdc_check(ctypes.byref(other)) == 1, "no ID"
        # Another master commits between the driver's read of STATUS and its writes.
        stolen = bench.device(lambda offset: read(offset) & ~8, write)
        library.ncdc_start(here)
        library.ncdc_commit(here)
        assert library.ncdc_place(ctypes.byref(stolen), lens, bench.sources, bench.targets) == 4
        assert library.ncdc_wait(here, 0) == 0
        return True

    assert await bridge(errors)()
    bench.check(1)


@cocotb.test()
async def python_driver_alternates_lenses(dut):
    """The sample in Python, over the same two functions."""
    bench = Bench(dut)
    read, write = await bench.begin()
    sys.path.insert(0, settings()["python"])
    sample = runpy.run_path(f"{settings()['python']}/samples.py")
    counters = await bridge(lambda: sample["alternate"](
        read, write, [(address, _STEP) for address in bench.source],
        [(bench.target + k * _STEP, _STEP) for k in range(_FRAMES)]))()
    bench.check(_FRAMES)
    assert counters["FRAMES"] == _FRAMES


class Console:
    """System Console's commands, asked for by a Tcl shell, on the simulated registers and memory.

    Parameters
    ----------
    bench : Bench
    read, write : callable
        As of :meth:`Bench.begin`.
    """

    def __init__(self, bench, read, write):
        self.bench, self.read, self.write = bench, read, write

    def run(self, commands):
        """Output of the shell, without its prompts, for Tcl ``commands``."""
        with tempfile.NamedTemporaryFile("w", suffix=".tcl") as script:
            script.write(commands)
            script.flush()
            shell = subprocess.Popen(
                ["tclsh", settings()["console"], f"{settings()['python']}/ncdc_console.tcl",
                 script.name], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
            said = []
            for line in shell.stdout:
                kind, _, rest = line.rstrip("\n").partition(" ")
                if kind != "ASK":
                    said.append(line.rstrip("\n"))
                    continue
                print(self._answer(*rest.split()), file=shell.stdin, flush=True)
            assert shell.wait() == 0
        return said

    def _answer(self, kind, *words):
        memory = self.bench.memory
        if kind == "read":
            return self.read(int(words[0]) - _REGISTERS)
        if kind == "write":
            return self.write(int(words[0]) - _REGISTERS, int(words[1]))
        path, at = Path(words[0]), int(words[1]) - _MEMORY
        if kind == "from":
            data = path.read_bytes()
            assert 0 <= at <= at + len(data) <= len(memory)
            memory[at:at + len(data)] = data
        else:
            path.write_bytes(memory[at:at + int(words[2])])
        return 0


@cocotb.test()
async def console_corrects_frames(dut):
    """A frame of each lens from a file into a picture, by the script for System Console."""
    bench = Bench(dut)
    console = Console(bench, *await bench.begin())
    bench.memory[:] = bytes(len(bench.memory))
    with tempfile.TemporaryDirectory() as folder:
        for name, raw in zip(("wide", "tele"), bench.raws):
            Path(folder, f"{name}.raw").write_bytes(raw.tobytes())
        connect = f"ncdc::connect {_REGISTERS} {_MEMORY}\n"
        said = await bridge(lambda: console.run(
            f"cd {folder}\n" + connect + "".join(
                f"ncdc::load {name}\nputs [ncdc::correct {name}.raw {name}.ppm 4096]\n"
                for name in ("wide", "tele")) + "puts [dict get [ncdc::counters] FRAMES]\n"
            "ncdc::disconnect\n"))()
        assert said[-1] == "2" and len(said) == 3, said
        for name, d, raw, line in zip(("wide", "tele"), bench.cameras, bench.raws, said):
            width, height = d.geometry.corrected
            assert line.startswith(f"{name}.ppm: {width}x{height}, "), line
            header = f"P6 {width} {height} 255\n".encode()
            assert Path(folder, f"{name}.ppm").read_bytes() == \
                header + correct(d, raw).picture.tobytes()
        assert {path.suffix for path in Path(folder).iterdir()} == {".raw", ".ppm"}
        Path(folder, "short.raw").write_bytes(b"1234")
        needed = bench.cameras[0].geometry
        for commands, sentence in (
                ("ncdc::load fish", "the lens is fish, there are wide, tele"),
                ("ncdc::correct wide.raw x.ppm", "no lens is loaded, there are wide, tele"),
                ("ncdc::load wide\nncdc::correct short.raw x.ppm",
                 f"short.raw has 4 bytes, a raw frame of {needed.distorted_width}x"
                 f"{needed.distorted_height} has "
                 f"{needed.distorted_width * needed.distorted_height}")):
            said = await bridge(lambda commands=commands: console.run(
                f"cd {folder}\n{connect}{commands}\n"))()
            assert said == [f"SAID {sentence}"]
        assert not Path(folder, "x.ppm").exists()

"""A LiteX system with the corrector as a module, on a raw frame, compared with the golden model:
``python -m ncdc_sim.system.litex net.toml``."""

import argparse
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ncdc_model.correction import correct
from ncdc_sim.runner import HDL, build, command_of, run
from ncdc_sim.tools import SimulationError
from ncdc_soc.module_soc import MAIN_RAM, REGISTERS, module_soc_verilog
from ncdc_spec.descriptor import Descriptor
from ncdc_spec.errors import InputError
from ncdc_spec.frames import (
    FrameAddresses,
    output_format,
    raw_image,
    source_bytes,
    stored_bytes,
    target_bytes,
)
from ncdc_spec.hardware import Hardware
from ncdc_spec.registers.register_map import CTRL_START, STATUS_DONE, registers

__all__ = ["CPUS", "ModuleRun", "simulate_module"]

CPUS = ("none", "idle", "polls", "copies")
"""No processor; one that runs in its cache; one that reads a register of the corrector without a
pause; one that copies memory without a pause."""

_TOOLS = "riscv64-unknown-elf-"
_PROGRAMS = {
    "idle": "1: j 1b\n",
    "polls": """
        li   t0, {status:#x}
    1:  lw   t1, 0(t0)
        j    1b
    """,
    # Over 1 MB and more, so that each line is read from memory; every store goes there anyway.
    "copies": """
    0:  li   t0, {copied:#x}
        li   t1, {copied:#x} + 0x400000
        li   t2, {copied:#x} + 0x100000
    1:  lw   t3, 0(t0)
        lw   t4, 4(t0)
        sw   t3, 0(t1)
        sw   t4, 4(t1)
        addi t0, t0, 8
        addi t1, t1, 8
        bne  t0, t2, 1b
        j    0b
    """}
_COPIED = MAIN_RAM + 0x200_0000
_RECORDED = 0x180_0000      # where in memory LiteDRAM's DMA writes the video
_READ_WORDS = 1 << 20       # of memory, of which one at a time is read at random
_WRITTEN = 400              # clocks in which its queue is empty


@dataclass(frozen=True)
class ModuleRun:
    """Results of a run.

    Parameters
    ----------
    pixels, different : int
        Pixels of all frames: compared, and those that are not the golden model's.
    clocks : tuple of int
        Clocks of each frame, start to last pixel: the corrector's own counter.
    interrupts : tuple of int
        Clocks from each start's write to the interrupt.
    pending : tuple of int
        The event manager's pending bit after each frame, and after the end of its interrupt.
    ends : tuple of (int, int)
        Numbers of the pixels that were the first and last of a frame, of a stream.
    waits : tuple of (int, int, int)
        For each frame with a master that reads words of memory: their number, the clocks of all,
        those of the slowest.
    errors : tuple of str
        Rules of bus and stream that were broken.
    """
    pixels: int
    different: int
    clocks: tuple
    interrupts: tuple
    pending: tuple
    ends: tuple
    waits: tuple
    errors: tuple


def simulate_module(descriptor, raw, hardware=Hardware(format="BGR8"), cpu="none", frames=1,
                    sink=256, cut=(), reads=False):
    """:class:`ModuleRun` of a system that corrects the ``raw`` frame ``frames`` times.

    Parameters
    ----------
    descriptor : Descriptor
    raw : ndarray of uint8, shape (distorted height, distorted width)
    hardware : Hardware
    cpu : str
        One of ``CPUS``.
    frames : int
    sink : int or None
        How often, of 256 clocks, the sink of a stream is ready. None: the sink is LiteDRAM's DMA,
        which writes into memory.
    cut : sequence of int
        Frames before these: the whole system is reset so many clocks after each one's start.
    reads : bool
        Whether the master on the bus reads words of memory at random, one after the other, while
        frames are corrected.

    Raises
    ------
    InputError
        If the hardware does not fit, or the compiler for the processor's program is missing.
    SimulationError
        If the system does not compile or the frames do not end in time.
    """
    record = sink is None
    with tempfile.TemporaryDirectory(prefix="ncdc-") as name:
        folder = Path(name)
        rom = None if cpu == "none" else _assembled(cpu, _rows(descriptor)["STATUS"], folder)
        soc = module_soc_verilog(descriptor, hardware, rom and "vexriscv", folder, record)
        sources = [("ncdc_litex.v", soc.text),
                   *((Path(path).name, Path(path).read_text()) for path in soc.sources)]
        # LiteX's Verilog and the processor's are others': their warnings are not ours to mend.
        program = build("litex", "ncdc_litex", sources, main=HDL / "litex_main.cpp",
                        options=("-Wno-fatal", "-CFLAGS", "-fno-tree-slp-vectorize"))
        if rom:
            (folder / "ncdc_litex_rom.init").write_text(rom)
            (folder / "ncdc_litex_sram.init").write_text("0\n")
        geometry = descriptor.geometry
        _fill(folder, soc, descriptor, hardware, raw, (cut, frames, record, reads))
        lines = []
        limit = 200_000 + 100 * (raw.size + frames * geometry.corrected_width
                                 * geometry.corrected_height)
        run([*command_of(program), f"+clocks={limit}", f"+sink={sink or 0}"], folder, lines.append)
        if any(line.startswith("FAILED") for line in lines):
            raise SimulationError("\n".join(lines[-20:]))
        at_the_pins = hardware.stream and not record
        output = (folder / ("video.bin" if at_the_pins else "output.bin")).read_bytes()
    return _result(_expected(descriptor, hardware, raw, record), output, lines, frames,
                   soc.registers)


def _fill(folder, soc, descriptor, hardware, raw, frames):
    """Write what the program reads: the raw frame, the operations."""
    geometry = descriptor.geometry
    buffers = FrameAddresses.after_reset(geometry, hardware.data_width)
    stored = output_format("BGRX8" if hardware.stream else hardware.format)
    record = frames[2]
    size = 0 if hardware.stream and not record else target_bytes(geometry, hardware.data_width,
                                                                 stored)
    target = _RECORDED if record else buffers.target
    source = raw_image(raw, buffers.pitch).ljust(source_bytes(geometry, buffers.pitch), b"\0")
    (folder / "source.bin").write_bytes(source)
    operations = _program(descriptor, soc.registers, target, size, frames)
    (folder / "program.txt").write_text("\n".join(operations) + "\n")


def _program(descriptor, csrs, target, size, frames):
    """Operations of the master on the bus, see ``litex_main.cpp``.

    ``frames``: the clocks after which some are cut, the number of others, whether LiteDRAM's DMA
    writes them, whether words of memory are read meanwhile.
    """
    cut, whole, record, reads = frames
    rows, pending = _rows(descriptor), csrs["ncdc_ev_pending"]
    yield f"l {MAIN_RAM:x}"
    for clocks in cut:
        yield from (f"w {rows['CTRL']:x} {CTRL_START:x}", f"p {clocks:x}", "x 1")
    yield f"w {rows['IRQ_ENABLE']:x} 1"
    yield f"w {csrs['ncdc_ev_enable']:x} 1"
    for _ in range(whole):
        yield from (f"w {MAIN_RAM + target + k:x} 5a5a5a5a" for k in range(0, min(size, 64), 4))
        if record:
            yield from (f"w {csrs[f'writer_{name}']:x} {value:x}" for name, value in (
                ("base", target), ("length", size), ("enable", 0), ("enable", 1)))
        yield f"w {rows['CTRL']:x} {CTRL_START:x}"
        if reads:
            yield f"m {_COPIED:x} {_READ_WORDS:x}"
        yield "i"
        yield f"r {pending:x}"
        yield f"w {rows['STATUS']:x} {STATUS_DONE:x}"
        yield f"r {pending:x}"
        yield f"r {rows['CLOCKS']:x}"
        if record:
            yield f"p {_WRITTEN:x}"
        if size:
            yield f"d {MAIN_RAM + target:x} {size:x}"


def _rows(descriptor):
    """Byte addresses of the corrector's registers, by name."""
    table = registers(descriptor.hidden_neurons, descriptor.formats, descriptor.nodes)
    return {one.name: REGISTERS + 4 * one.address for one in table}


def _expected(descriptor, hardware, raw, record):
    """Bytes of each pixel of a frame, (pixels, bytes of one)."""
    picture = correct(descriptor, raw).picture
    if record:
        picture = stored_bytes(picture, output_format("BGRX8"))
    elif not hardware.stream:
        picture = stored_bytes(picture, output_format(hardware.format))
    return picture.reshape(-1, picture.shape[-1])


def _result(expected, output, lines, frames, csrs):
    """The :class:`ModuleRun` of what was printed and written."""
    per_frame = -(-expected.size // 4) * 4 if len(output) % expected.size else expected.size
    if len(output) != frames * per_frame:
        raise SimulationError(f"{len(output)} bytes came out, not {frames * per_frame}")
    got = np.frombuffer(output, np.uint8).reshape(frames, -1)[:, :expected.size]
    different = (got.reshape(frames, *expected.shape) != expected).any(axis=2).sum()
    words = [line.split() for line in lines]
    pending = f"{csrs['ncdc_ev_pending']:08x}"
    reads = [(line[1], int(line[2], 16)) for line in words if line[0] == "READ"]

    def numbers(kind):
        return [int(line[1]) for line in words if line[0] == kind]

    return ModuleRun(
        frames * len(expected), int(different),
        clocks=tuple(value for address, value in reads if address != pending),
        interrupts=tuple(numbers("IRQ")),
        pending=tuple(value for address, value in reads if address == pending),
        ends=tuple(zip(numbers("FIRST"), numbers("LAST"))),
        waits=tuple(tuple(map(int, line[1:])) for line in words if line[0] == "WAITS"),
        errors=tuple(line for line in lines if "-ERROR" in line))


def _assembled(cpu, status, folder):
    """Words of the processor's program, as a memory's file of them; STATUS is at ``status``."""
    text = _PROGRAMS[cpu].format(copied=_COPIED, status=status)
    (folder / "rom.S").write_text(f".globl _start\n_start:\n{text}")
    for command in (
            [f"{_TOOLS}gcc", "-march=rv32i", "-mabi=ilp32", "-nostdlib", "-Wl,-Ttext=0", "-o",
             "rom.elf", "rom.S"],
            [f"{_TOOLS}objcopy", "-O", "binary", "-j", ".text", "rom.elf", "rom.bin"]):
        try:
            subprocess.run(command, cwd=folder, check=True)
        except FileNotFoundError as error:
            raise InputError(f"{command[0]} is not installed, which a processor's program needs: "
                             f"apt install gcc-riscv64-unknown-elf") from error
    words = np.frombuffer((folder / "rom.bin").read_bytes(), "<u4")
    return "".join(f"{word:08x}\n" for word in words)


def _raw(path, geometry):
    """The raw frame of a file, or one of noise."""
    width, height = geometry.distorted
    if path is None:
        return np.random.default_rng(1).integers(0, 256, (height, width), np.uint8)
    data = Path(path).read_bytes()
    if len(data) != width * height:
        raise InputError(f"{path} has {len(data)} bytes, a raw frame of {width}x{height} needs "
                         f"{width * height}")
    return np.frombuffer(data, np.uint8).reshape(height, width)


def main(arguments=None):
    """The command; its exit status."""
    parser = argparse.ArgumentParser(prog="python -m ncdc_sim.system.litex", description=__doc__)
    parser.add_argument("net")
    parser.add_argument("raw", nargs="?", help="bytes of a raw frame; noise if absent")
    parser.add_argument("--to", choices=("memory", "stream"), default="memory")
    parser.add_argument("--cpu", choices=CPUS, default="none")
    parser.add_argument("--sink", type=int, default=256,
                        help="how often, of 256 clocks, the stream's sink is ready")
    parser.add_argument("--reads", action="store_true",
                        help="a master on the bus reads words of memory at random meanwhile")
    args = parser.parse_args(arguments)
    try:
        descriptor = Descriptor.load(args.net)
        hardware = Hardware(output=args.to, **({"format": "BGR8"} if args.to == "memory" else {}))
        done = simulate_module(descriptor, _raw(args.raw, descriptor.geometry), hardware, args.cpu,
                               sink=args.sink, reads=args.reads)
    except (InputError, SimulationError) as error:
        print(error, file=sys.stderr)
        return 2 if isinstance(error, InputError) else 1
    print(f"{done.pixels} pixels compared, {done.different} differ; "
          f"{done.clocks[0] / done.pixels:.3f} clocks per pixel (LiteDRAM, {args.to}, "
          f"processor {args.cpu}); {len(done.errors)} rules broken")
    for words, clocks, longest in done.waits:
        print(f"{words} words read meanwhile: {clocks / words:.1f} clocks for one, {longest} for "
              "the slowest")
    return int(bool(done.different or done.errors))


if __name__ == "__main__":
    sys.exit(main())

"""The firmware: its size, and the same C on this machine under sanitizers, fed with anything."""

import re
import subprocess
from dataclasses import replace

import pytest

from cameras import barrel_descriptor
from firmware_host import host_program
from ncdc_soc.board import MEMORY_BYTES
from ncdc_soc.core import SocCore
from ncdc_soc.firmware import FIRMWARE, config, firmware_image
from ncdc_soc.processor import MAP
from ncdc_soc.soc import soc_verilog
from ncdc_spec.hardware import Hardware
from ncdc_spec.sensors.framing import setup_around
from peers import need

_RAM_BYTES = 56 * 1024


@pytest.fixture(scope="module")
def soc():
    """(ProcessorVerilog, text of config.h)."""
    descriptor = barrel_descriptor()
    core = SocCore(descriptor, Hardware(bus="axi", format="BGR8"))
    verilog = soc_verilog(core)
    return verilog, config(core.system, core.packetiser.capacity, verilog,
                           *setup_around("mt9p031", descriptor.geometry))


@pytest.mark.longer
def test_the_sensor_gets_its_times_as_on_a_board(soc):
    """But in simulations, which say by how much they are faster."""
    verilog, text = soc
    mhz = verilog.clock_hz // 10**6
    values = dict(re.findall(r"^#define (\w+) (\d+)u$", text, re.M))
    assert int(values["SENSOR_WAIT_CLOCKS"]) == mhz
    assert int(values["SENSOR_REST_CLOCKS"]) >= 45_000 * mhz
    core = SocCore(barrel_descriptor(), Hardware(bus="axi", format="BGR8"))
    quarter = next(r.address for r in core.system.table if r.name == "I2C_QUARTER")
    setting = f"{{{MAP['ncdc'] + 4 * quarter:#x}u, (0x\\w+)u}}"
    assert int(re.search(setting, text)[1], 16) == mhz * 10 // 4      # 100 kHz
    fast = config(core.system, core.packetiser.capacity, verilog,
                  *setup_around("mt9p031", barrel_descriptor().geometry), sets_up=1000)
    assert int(re.search(setting, fast)[1], 16) == 8
    assert f"#define SENSOR_REST_CLOCKS {45 * mhz}u\n" in fast


@pytest.mark.longer
def test_it_fits(soc, tmp_path):
    need("riscv64-unknown-elf-gcc")
    verilog, text = soc
    words, code, ram = firmware_image(text, verilog, tmp_path)
    assert 0 < 4 * len(words) <= MEMORY_BYTES[False][0] and 0 < code <= MEMORY_BYTES[False][0]
    assert 0 < ram <= _RAM_BYTES


@pytest.mark.longer
def test_it_is_a_fifth_smaller_with_compressed_instructions(soc, tmp_path):
    """Both fit a board's ROM and SRAM, with its stack: the linker rejects what does not."""
    need("riscv64-unknown-elf-gcc")
    verilog, text = soc
    images = []
    for compressed, sizes in MEMORY_BYTES.items():
        memories = {name: (MAP[name], size) for name, size in zip(("rom", "sram"), sizes)}
        (tmp_path / str(compressed)).mkdir()
        images.append(firmware_image(
            text, replace(verilog, compressed=compressed, memories=memories),
            tmp_path / str(compressed)))
    plain, small = images
    assert small[1] < .8 * plain[1] and small[2] == plain[2]


def fuzzed(program, frames, seed):
    """What a run printed, as numbers; a fault ends the program, and this test."""
    done = subprocess.run([program, str(frames), str(seed)], capture_output=True, text=True)
    assert not done.returncode, done.stderr
    return list(map(int, done.stdout.split()))


@pytest.fixture(scope="module")
def program(soc, tmp_path_factory):
    return host_program(soc[1], tmp_path_factory.mktemp("host"), "fuzz")


def reached(frames, answers, commands, pictures, resends, requests, packages):
    """Whether a run reached what it is there for."""
    return (answers > frames // 4 and commands > frames // 4 and pictures > 0
            and requests > frames // 500 and packages > frames // 2000)


def test_any_frames(program):
    assert reached(*fuzzed(program, 100_000, 1))


@pytest.mark.many_clocks
@pytest.mark.regress
def test_a_million_frames(program):
    for seed in range(2, 6):
        assert reached(*fuzzed(program, 1_000_000, seed))


@pytest.mark.longer
def test_a_planted_overflow_is_found(soc, tmp_path):
    sources = tmp_path / "firmware"
    subprocess.run(["cp", "-r", str(FIRMWARE), str(sources)], check=True)
    text = (sources / "gvcp.c").read_text()
    rule = "count > GVCP_MEMORY_MAX"
    assert text.count(rule) == 1
    (sources / "gvcp.c").write_text(text.replace(rule, "count > GVCP_MEMORY_MAX + 64"))
    planted = host_program(soc[1], tmp_path, "fuzz", sources)
    done = subprocess.run([planted, "100000", "1"], capture_output=True, text=True)
    assert done.returncode and "AddressSanitizer" in done.stderr

"""Files for a host: C and Python drivers, lenses, SystemRDL; run against the Verilog."""

import json
import re
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from systemrdl import RDLCompileError, RDLCompiler
from systemrdl.node import FieldNode, MemNode, RegNode

from cameras import barrel_descriptor
from kept import kept_folder, run_cocotb
from ncdc.cli import main
from ncdc_hdl.corrector import Corrector
from ncdc_hdl.export.registers.drivers import driver_files
from ncdc_hdl.export.registers.lenses import Lens, lens_name
from ncdc_model.descriptor import Descriptor, FloatNetwork
from ncdc_model.errors import InputError
from ncdc_model.fetch.cache_options import CacheOptions
from ncdc_model.fetch.lookups import frame_windows, lookups
from ncdc_model.fetch.tags import accesses, misses
from ncdc_model.geometry import Geometry, ValidRows
from ncdc_model.hardware import Hardware
from ncdc_model.interface.host_values import host_values, table_words
from ncdc_model.interface.register_map import TABLE, counters, registers
from ncdc_model.interpolation import GRADIENT
from ncdc_sim.cocotb_run import design_of
from ncdc_sim.tools import SimulationError

PAGE = Path(__file__).resolve().parents[2] / "docs" / "drivers.md"
WIDE = barrel_descriptor((20, 16), (24, 18), hidden_neurons=3)
TELE = barrel_descriptor((18, 14), (22, 20), hidden_neurons=3, seed=5, bayer="GBRG",
                         strength=0.1, fill=(250, 20, 3))
ROWS = registers(WIDE.hidden_neurons, WIDE.formats)
COUNTERS = [r.name for r in counters(ROWS)]
C = ["gcc", "-std=c99", "-Wall", "-Wextra", "-Werror", "-pedantic"]


def samples(language):
    """The code of that language in the documentation, as one text."""
    return "\n".join(re.findall(rf"^```{language}\n(.*?)^```$", PAGE.read_text(),
                                re.MULTILINE | re.DOTALL))


def compile_c(folder, *arguments):
    done = subprocess.run([*C, *arguments], cwd=folder, text=True, capture_output=True)
    assert not done.returncode, done.stderr


@pytest.fixture(scope="module")
def corrector():
    return Corrector(WIDE)


@pytest.fixture(scope="module")
def kept(corrector, tmp_path_factory):
    """Folder with both descriptors, all that a host needs, and the documentation's samples.

    Nobody writes there; its name says what is in it, so that a bench on it is kept.
    """
    lenses = tmp_path_factory.mktemp("lenses")
    named = [(lenses / "wide.toml", WIDE), (lenses / "tele.toml", TELE)]
    for path, descriptor in named:
        descriptor.save(path)
    texts = driver_files(corrector, named) | {path.name: path.read_text() for path, _ in named}
    texts |= {"samples.c": samples("c"), "samples.py": samples("py")}

    def build(folder):
        for name, text in texts.items():
            (folder / name).write_text(text)
        compile_c(folder, "-shared", "-fPIC", "-o", "samples.so", "samples.c", "ncdc.c",
                  "ncdc_lenses.c")

    compiler = subprocess.run([C[0], "--version"], check=True, text=True, stdout=subprocess.PIPE)
    return kept_folder("drivers", build, json.dumps(texts), " ".join(C), compiler.stdout)


@pytest.fixture(scope="module")
def folder(kept, tmp_path_factory):
    """A copy of it to write in."""
    return shutil.copytree(kept, tmp_path_factory.mktemp("drivers"), dirs_exist_ok=True)


def run_drivers(corrector, folder, simulator, library):
    run_cocotb(design_of(corrector, top="dut_corrector"), "drivers", simulator,
               library=str(library / "samples.so"), python=str(folder), counters=COUNTERS,
               descriptors=[str(folder / "wide.toml"), str(folder / "tele.toml")])


@pytest.mark.parametrize("simulator", [
    "verilator", pytest.param("icarus", marks=pytest.mark.regress)])
def test_drivers_run_against_the_verilog(corrector, kept, simulator):
    run_drivers(corrector, kept, simulator, library=kept)


@pytest.mark.regress
@pytest.mark.parametrize("file,right,wrong", [
    ("ncdc.c", "NCDC_STATUS_BANK ? 0 : 1", "NCDC_STATUS_BANK ? 1 : 0"),
    ("ncdc.c", "NCDC_CTRL_COMMIT | NCDC_CTRL_START", "NCDC_CTRL_START"),
    ("ncdc.c", "NCDC_SOURCE_BASE, source", "NCDC_TARGET_BASE, source"),
    ("ncdc.c", "NCDC_TARGET_LIMIT, target->address +", "NCDC_TARGET_LIMIT, target->address + 4 -"),
    ("ncdc_lenses.c", "NCDC_OUTPUT_Y_BIAS", "NCDC_OUTPUT_X_BIAS")])
def test_a_wrong_driver_is_found(corrector, folder, tmp_path, file, right, wrong):
    for path in folder.glob("*.[ch]"):
        text = path.read_text()
        assert path.name != file or right in text
        (tmp_path / path.name).write_text(text.replace(right, wrong) if path.name == file else text)
    (tmp_path / "samples.py").write_text((folder / "samples.py").read_text())
    compile_c(tmp_path, "-shared", "-fPIC", "-o", "samples.so", "samples.c", "ncdc.c",
              "ncdc_lenses.c")
    with pytest.raises(SimulationError, match="failed: .*c_driver"):
        run_drivers(corrector, folder, "verilator", library=tmp_path)


def test_sample_for_a_mapped_bus(folder):
    (folder / "mapped.c").write_text("""#include <stdio.h>
#include "ncdc.h"
struct ncdc mapped_corrector(void *base);
int main(void)
{
    static uint32_t bus[1 << 14];
    struct ncdc device = mapped_corrector(bus);
    int before = ncdc_check(&device);
    bus[NCDC_ID / 4] = NCDC_ID_VALUE;
    if (ncdc_check(&device) != NCDC_ERROR_VERSION)
        return 1;
    bus[NCDC_CAPABILITIES / 4] = NCDC_VERSION;
    ncdc_start(&device);
    printf("%d %d %u", before, ncdc_check(&device), (unsigned)bus[NCDC_CTRL / 4]);
    return 0;
}
""")
    compile_c(folder, "-o", "mapped", "mapped.c", "samples.c", "ncdc.c", "ncdc_lenses.c")
    done = subprocess.run([folder / "mapped"], check=True, text=True, stdout=subprocess.PIPE)
    assert done.stdout == "1 0 1"


OTHER_INTERPOLATION = """#include <stdio.h>
#include "ncdc_lenses.h"
static uint32_t bus[1 << 14], writes;
static uint32_t get(void *context, uint32_t offset) { (void)context; return bus[offset / 4]; }
static void put(void *context, uint32_t offset, uint32_t value)
{
    (void)context, (void)offset, (void)value;
    ++writes;
}
int main(void)
{
    struct ncdc device = {get, put, 0};
    uint32_t known = NCDC_VERSION | 1u << 12;
    enum ncdc_result other;

    bus[NCDC_NEURONS / 4] = 3, bus[NCDC_LARGEST / 4] = 20u << 16 | 31u;
    bus[NCDC_CAPABILITIES / 4] = known | NCDC_CAPABILITIES_GRADIENT;
    other = ncdc_load(&device, &ncdc_lens_wide);
    printf("%d %u ", other == NCDC_ERROR_INTERPOLATION, (unsigned)writes);
    bus[NCDC_CAPABILITIES / 4] = known | NCDC_CAPABILITIES_FAST;
    other = ncdc_load(&device, &ncdc_lens_wide);
    printf("%d %d", other, writes > 0);
    return 0;
}
"""


def test_the_c_driver_refuses_a_lens_of_another_interpolation(folder):
    (folder / "other.c").write_text(OTHER_INTERPOLATION)
    compile_c(folder, "-o", "other", "other.c", "ncdc.c", "ncdc_lenses.c")
    done = subprocess.run([folder / "other"], check=True, text=True, stdout=subprocess.PIPE)
    assert done.stdout == "1 0 0 1"


def test_c_files_hold_the_table_and_the_lenses(corrector, folder):
    """Every offset and mask, and every value of both lenses, as a C program sees them."""
    flags = [(r, flag) for r in ROWS for flag in r.flags]
    names = [f"NCDC_{r.name}" for r in ROWS] + ["NCDC_VALID_ROWS", "NCDC_ID_VALUE",
                                            "NCDC_VERSION", "NCDC_SOURCE_BEYOND"]
    names += [f"NCDC_{r.name}_{flag.name}" for r, flag in flags]
    prints = "".join(f'    printf("{name} %u\\n", (unsigned){name});\n' for name in names)
    (folder / "values.c").write_text(f"""#include <stdio.h>
#include "ncdc_lenses.h"
#include "ncdc_lenses.h"
static void list(const struct ncdc_lens *lens) {{
    uint32_t k;
    printf("lens %s %u %x %u %u %u %u\\n", lens->digest, (unsigned)lens->neurons,
           (unsigned)lens->interpolation, (unsigned)lens->width, (unsigned)lens->height,
           (unsigned)lens->source_bytes, (unsigned)lens->target_bytes);
    for (k = 0; k < lens->value_count; ++k)
        printf("%u %u\\n", (unsigned)lens->values[k].offset, (unsigned)lens->values[k].value);
    for (k = 0; k < lens->span_count; ++k)
        printf("%u %u\\n", (unsigned)(NCDC_VALID_ROWS + 4 * k), (unsigned)lens->valid_rows[k]);
}}
int main(void) {{
{prints}    list(&ncdc_lens_wide);
    list(&ncdc_lens_tele);
    return 0;
}}
""")
    compile_c(folder, "-o", "values", "values.c", "ncdc.c", "ncdc_lenses.c")
    done = subprocess.run([folder / "values"], check=True, text=True, stdout=subprocess.PIPE)
    head, *lenses = done.stdout.split("lens ")
    assert dict(line.split() for line in head.splitlines()) == {
        **{f"NCDC_{r.name}": str(4 * r.address) for r in ROWS},
        "NCDC_VALID_ROWS": str(4 * TABLE), "NCDC_ID_VALUE": str(0x4E434443),
        "NCDC_VERSION": "3", "NCDC_SOURCE_BEYOND": "12",
        **{f"NCDC_{r.name}_{flag.name}": str(flag.mask) for r, flag in flags}}
    for d, text in zip((WIDE, TELE), lenses, strict=True):
        first, *pairs = text.splitlines()
        values = host_values(d, corrector.hardware)
        width, height = d.geometry.corrected
        target = values["TARGET_LIMIT"] - values["TARGET_BASE"]
        assert 0 <= target - 4 * width * height < corrector.hardware.data_width // 8
        assert first == (f"{d.digest} {d.hidden_neurons} 400 {width} {height} "
                         f"{values['SOURCE_LIMIT']} {target}")
        for name in ("SOURCE_BASE", "SOURCE_LIMIT", "TARGET_BASE", "TARGET_LIMIT", "VALID_BANK",
                     "FOLLOW"):
            del values[name]
        address = {r.name: 4 * r.address for r in ROWS}
        expected = [(address[name], value % 2**32) for name, value in values.items()]
        expected += [(4 * word, value) for word, value in table_words(d.valid)]
        assert [tuple(map(int, pair.split())) for pair in pairs] == expected
    assert {r.name for r in ROWS if r.access == "shadow"} == set(host_values(WIDE))


def test_several_c_files_may_include_everything(folder):
    for name in ("wide", "tele"):
        (folder / f"{name}.c").write_text(
            '#include "ncdc_lenses.h"\n' f"const struct ncdc_lens *{name}(void);\n"
            f"const struct ncdc_lens *{name}(void) {{ return &ncdc_lens_{name}; }}\n")
    compile_c(folder, "-shared", "-fPIC", "-o", "both.so", "wide.c", "tele.c", "ncdc.c",
              "ncdc_lenses.c")
    for name in ("ncdc.h", "ncdc_lenses.h"):
        subprocess.run(["g++", "-Wall", "-Wextra", "-Werror", "-fsyntax-only", "-x", "c++", name],
                       cwd=folder, check=True)


def test_python_files_hold_the_table_and_the_lenses(folder):
    done = subprocess.run([sys.executable, "-c", """
import json, ncdc_registers as r, ncdc_lenses
flags = {k: v for k, v in vars(r).items() if isinstance(v, int)}
print(json.dumps([r.OFFSET, flags, r.COUNTERS, ncdc_lenses.LENSES]))
"""], cwd=folder, check=True, text=True, stdout=subprocess.PIPE)
    offset, flags, names, lenses = json.loads(done.stdout)
    assert offset == {r.name: 4 * r.address for r in ROWS} and names == COUNTERS
    assert flags == {"VALID_ROWS": 4 * TABLE, "ID_VALUE": 0x4E434443, "VERSION": 3,
                     "SOURCE_BEYOND": 12,
                     **{f"{r.name}_{flag.name}": flag.mask for r in ROWS for flag in r.flags}}
    for name, d in (("wide", WIDE), ("tele", TELE)):
        lens = lenses[name]
        assert (lens["digest"], lens["neurons"]) == (d.digest, 3)
        assert lens["interpolation"] == "fast"
        assert lens["values"].items() <= host_values(d).items()
        assert lens["valid_rows"] == [value for _, value in table_words(d.valid)]


PYTHON_ERRORS = """
import ncdc_registers as r
from ncdc_driver import Corrector, CorrectorError
from ncdc_lenses import LENSES
words = {r.OFFSET["ID"]: r.ID_VALUE, r.OFFSET["NEURONS"]: 3, r.OFFSET["LARGEST"]: 20 << 16 | 31,
         r.OFFSET["CAPABILITIES"]: r.VERSION | r.CAPABILITIES_FAST | 2 << 12 | 8 << 16}
written = []
status = r.OFFSET["STATUS"]

def attempt(action, *arguments):
    del written[:]
    try:
        action(*arguments)
    except CorrectorError as error:
        print(len(written), error)

read = lambda offset: words.get(offset, 0)
write = lambda offset, value: written.append((offset, value))
attempt(Corrector, lambda offset: 0xDEAD, write)
corrector = Corrector(read, write)
attempt(corrector.wait, 2)
attempt(corrector.load, LENSES["wide"] | {"neurons": 5})
attempt(corrector.load, LENSES["wide"] | {"interpolation": "gradient"})
attempt(corrector.load, LENSES["wide"] | {"width": 32})
attempt(corrector.load, LENSES["wide"] | {"width": 21})
wide = LENSES["wide"]
source, target = (8, wide["source_bytes"]), (1 << 20, wide["target_bytes"])
attempt(corrector.place, wide, (12, 9999), target)
attempt(corrector.place, wide, source, (16, 8))
attempt(corrector.place, wide, (8, 1 << 32), target)
looks = []
attempt(corrector.wait, 4, lambda: looks.append(1))
assert len(looks) == 3
words[status] = r.STATUS_COMMITTED
attempt(corrector.load, LENSES["wide"])
attempt(corrector.place, wide, source, target)
words[status] = r.STATUS_REFUSED
attempt(corrector.place, wide, source, target)
assert written == [(r.OFFSET["SOURCE_BASE"], 8), (r.OFFSET["SOURCE_LIMIT"], sum(source)),
                   (r.OFFSET["TARGET_BASE"], 1 << 20), (r.OFFSET["TARGET_LIMIT"], sum(target)),
                   (status, r.STATUS_REFUSED)]
words[status], words[r.OFFSET["FAULT"]] = r.STATUS_DONE | r.STATUS_FAULT, 5
attempt(corrector.wait)
assert written[-1] == (r.OFFSET["FAULT"], 5)
for ended in (r.STATUS_DONE, r.STATUS_DONE | r.STATUS_ABORTED):
    words[status] = ended
    attempt(corrector.wait)
    assert written == [(status, r.STATUS_DONE)]
attempt(corrector.abort)
assert written == [(r.OFFSET["CTRL"], r.CTRL_ABORT)]
for bank in (0, 1):
    words[status] = r.STATUS_BANK if bank else 0
    attempt(corrector.load, LENSES["wide"])
    assert written[-1] == (r.OFFSET["VALID_BANK"], 1 - bank)
    assert (r.OFFSET["VALID_WINDOW"], 1 - bank) in written
    assert all(0 <= value < 1 << 32 for _, value in written)
"""


def test_python_driver_names_errors(folder):
    done = subprocess.run([sys.executable, "-c", PYTHON_ERRORS], cwd=folder, text=True,
                          capture_output=True)
    assert not done.returncode, done.stderr
    assert done.stdout.splitlines() == [
        "0 ID reads 0x0000dead, 0x4e434443 is needed",
        "0 no frame is complete after 2 polls",
        "0 the lens has 5 hidden neurons, the corrector 3",
        "0 the lens is for the interpolation gradient, the corrector has fast",
        "0 the lens makes 32x16 pixels, the corrector up to 31x20 in rows that are a multiple of 2",
        "0 the lens makes 21x16 pixels, the corrector up to 31x20 in rows that are a multiple of 2",
        "0 the source is at 0xc, a multiple of 8 below 4 GB is needed",
        f"0 the target has 8 bytes, the lens needs {4 * 20 * 16}",
        "0 the source is at 0x8, a multiple of 8 below 4 GB is needed",
        "0 no frame is complete after 4 polls",
        "0 a commit waits for its frame boundary: nothing was written",
        "0 a commit waits for its frame boundary: nothing was written",
        "5 the corrector refused a write",
        "2 the corrector refused: SOURCE, ALIGNMENT",
        "1 the frame was aborted"]


# SystemRDL.

def compiled(path):
    compiler = RDLCompiler()
    compiler.compile_file(str(path))
    return compiler.elaborate().top


def test_system_rdl_is_the_table(corrector, folder):
    top, found = compiled(folder / "ncdc.rdl"), {}
    for node in top.children():
        if isinstance(node, RegNode):
            found[node.inst_name] = node
    assert list(found) == [r.name for r in ROWS]
    values = {**corrector.registers.values, **corrector.registers.constants}
    for r in ROWS:
        node = found[r.name]
        assert node.absolute_address == 4 * r.address and node.get_property("regwidth") == 32
        fields = [child for child in node.children() if isinstance(child, FieldNode)]
        if r.flags:
            assert [(f.inst_name, f.lsb, f.msb) for f in fields] == [
                (flag.name, flag.low, flag.bit) for flag in r.flags]
            for f, flag in zip(fields, r.flags):
                assert f.is_sw_readable == (flag.access != "w1"), flag
                assert f.is_sw_writable == (flag.access != "ro"), flag
                assert (f.get_property("onwrite") is not None) == (flag.access == "w1c"), flag
            continue
        field, = fields
        assert (field.lsb, field.msb) == (0, r.shape.width - 1), r.name
        assert field.is_sw_writable == (r.access in ("rw", "shadow")), r.name
        assert field.get_property("reset") == values.get(r.name, 0) % 2**r.shape.width, r.name
    memory, = (node for node in top.children() if isinstance(node, MemNode))
    assert memory.absolute_address == 4 * TABLE and memory.get_property("memwidth") == 32
    assert top.size == memory.absolute_address + memory.size == 1 << 16


def test_peakrdl_accepts_the_file(folder):
    for command in (["dump", "ncdc.rdl"], ["ip-xact", "ncdc.rdl", "-o", "ncdc.xml"]):
        done = subprocess.run([Path(sys.executable).parent / "peakrdl", *command], cwd=folder,
                              text=True, capture_output=True)
        assert not done.returncode, done.stderr
    assert all(f"<ipxact:name>{r.name}<" in (folder / "ncdc.xml").read_text() for r in ROWS)


def test_registers_in_one_place_are_not_accepted(folder, tmp_path):
    """The compiler's silence above means something."""
    text = (folder / "ncdc.rdl").read_text().replace("} STATUS @ 0x0010", "} STATUS @ 0x000C")
    (tmp_path / "wrong.rdl").write_text(text)
    with pytest.raises(RDLCompileError):
        compiled(tmp_path / "wrong.rdl")


CONSOLE = """
import sys
words = {}
for line in sys.stdin:
    if line.startswith("exit"):
        break
    if "master_read_32" in line:
        print("noise\\n% NCDC", hex(words.get(int(line.split()[4], 0), 0)), flush=True)
    else:
        if "master_write_32" in line:
            _, _, address, value, *_ = line.replace(";", "").split()
            words[int(address, 0)] = int(value, 0)
        print("% NCDC 0", flush=True)
"""
BACKENDS = """
import sys
from ncdc_backends import Mapped, SystemConsole
for backend in (Mapped("registers.bin"), SystemConsole(command=(sys.executable, "console.py"))):
    read, write = backend
    write(0x10, 0xFFFFFFFE)
    write(0xFFFC, 7)
    print(read(0x10), read(0xFFFC), read(0x14))
backend.close()
"""


def test_back_ends_reach_the_registers(folder):
    """A file stands for the mapped device, a script for System Console."""
    (folder / "registers.bin").write_bytes(bytes(1 << 16))
    (folder / "console.py").write_text(CONSOLE)
    done = subprocess.run([sys.executable, "-c", BACKENDS], cwd=folder, text=True,
                          capture_output=True)
    assert done.stdout.splitlines() == [f"{0xFFFFFFFE} 7 0"] * 2, done.stderr
    assert (folder / "registers.bin").read_bytes()[0x10:0x14] == b"\xfe\xff\xff\xff"


def test_a_rotated_lens_brings_the_split_that_suits_it():
    """The columns of its picture are rows of the raw frame: the unrotated lens' split would read
    half as many tiles again."""
    g = Geometry(192, 192, 192, 192)
    upright = np.eye(2) * 0.2
    networks = [FloatNetwork(hidden, np.zeros(2), np.eye(2) * 95 * 2 / 0.2, np.full(2, 95.5))
                for hidden in (upright, upright[::-1])]
    valid = ValidRows.everything(192, 192)
    plain, rotated = (Descriptor.quantise(network, g, valid) for network in networks)
    corrector = Corrector(plain, Hardware(cache=CacheOptions(64)))
    own, other = (Lens.of(corrector, d).values["CACHE_SPLIT"] for d in (plain, rotated))
    accessed = accesses(lookups(frame_windows(rotated)))
    read = [len(misses(accessed, corrector.hardware.cache, split)) for split in range(5)]
    assert read[other] == min(read) and read[own] > 1.4 * read[other]


# What is no lens of a corrector.

@pytest.mark.parametrize("other,message", [
    (barrel_descriptor((20, 16), (24, 18), hidden_neurons=4),
     "hidden neurons 4 does not fit a corrector made for 3"),
    (barrel_descriptor((20, 16), (24, 18), hidden_neurons=3, interpolation=GRADIENT),
     "interpolation gradient does not fit a corrector made for fast"),
    (barrel_descriptor((20, 17), (24, 18), hidden_neurons=3),
     "the corrected image has 17 rows, the corrector's table of valid rows holds 16"),
    (barrel_descriptor((32, 16), (40, 18), hidden_neurons=3),
     "the corrected image has 32 columns, the corrector's table of valid rows counts to 31")])
def test_a_lens_that_does_not_fit(corrector, other, message):
    with pytest.raises(InputError, match=f"tele.toml: {message}"):
        driver_files(corrector, [("wide.toml", WIDE), ("tele.toml", other)])


def test_a_lens_of_odd_width():
    pairs = Corrector(WIDE, Hardware(lanes=2))
    odd = barrel_descriptor((19, 16), (24, 18), hidden_neurons=3)
    with pytest.raises(InputError, match="odd.toml: the corrected width is 19, 2 pixels per clock"):
        driver_files(pairs, [("wide.toml", WIDE), ("odd.toml", odd)])


def test_two_lenses_of_one_name(corrector):
    with pytest.raises(InputError, match="the lenses a/x.toml and b/x.toml would both be called x"):
        driver_files(corrector, [("a/x.toml", WIDE), ("b/x.toml", TELE)])


@pytest.mark.parametrize("path,name", [("net.toml", "net"), ("a b/my-lens 2.toml", "my_lens_2"),
                                       ("105.toml", "105"), ("é.toml", "_")])
def test_name_of_a_lens(path, name):
    assert lens_name(path) == name


def test_command_writes_them_all(corrector, folder, tmp_path):
    assert main(["generate", str(folder / "wide.toml"), "--lens", str(folder / "tele.toml"),
                 "-o", str(tmp_path), "--fetch", corrector.hardware.fetcher,
                 "--cache-bytes", str(corrector.hardware.cache.bytes)]) == 0
    for name in driver_files(corrector, [("wide.toml", WIDE)]):
        assert (tmp_path / name).read_text() == (folder / name).read_text(), name

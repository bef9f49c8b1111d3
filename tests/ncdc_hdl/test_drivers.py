"""C and Python drivers: run with the Verilog, and on words that stand for registers."""

import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import pytest
from systemrdl import RDLCompiler
from systemrdl.node import RegNode

from cameras import barrel_descriptor
from cocotb_run import design_of, run_cocotb
from drivers import COUNTERS, WIDE, compile_c
from ncdc_hdl.corrector import Corrector
from ncdc_hdl.export.drivers.drivers import driver_files
from ncdc_model.golden.tone import tone_named
from ncdc_sim.tools import SimulationError
from ncdc_spec.hardware import Hardware

TCL = Path(__file__).parents[1] / "support" / "tcl"


def run_drivers(corrector, folder, simulator, library):
    run_cocotb(design_of(corrector, top="dut_corrector"), "drivers", simulator,
               library=str(library / "samples.so"), python=str(folder), counters=COUNTERS,
               console=str(TCL / "console.tcl"),
               descriptors=[str(folder / "wide.toml"), str(folder / "tele.toml")])


@pytest.mark.longer
@pytest.mark.parametrize("simulator", [
    "verilator", pytest.param("icarus", marks=pytest.mark.regress)])
def test_drivers_run_with_the_verilog(corrector, folder, simulator):
    run_drivers(corrector, folder, simulator, library=folder)


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
        "0 the source is at 0xc, a multiple of 8 below 4 GB is needed",
        f"0 the target has 8 bytes, the lens needs {4 * 20 * 16}",
        "0 the source is at 0x8, a multiple of 8 below 4 GB is needed",
        "0 no frame is complete after 4 polls",
        "0 a commit waits for its frame boundary: nothing was written",
        "0 a commit waits for its frame boundary: nothing was written",
        "5 the corrector rejected a write",
        "2 the corrector rejected: SOURCE, ALIGNMENT",
        "1 the frame was aborted"]


BACKENDS = """
from ncdc_backends import Mapped, JtagChain, SystemConsole
for backend in (Mapped("registers.bin"), SystemConsole(command=("tclsh", "{tcl}")),
                JtagChain(command=("tclsh", "{tcl}"))):
    read, write = backend
    write(0x10, 0xFFFFFFFE)
    write(0xFFFC, 7)
    print(read(0x10), read(0xFFFC), read(0x14))
    if not isinstance(backend, Mapped):
        backend.close()
for options in ({{"device": "MAX"}}, {{"cable": 3}}):
    try:
        JtagChain(command=("tclsh", "{tcl}"), **options)
    except OSError as error:
        print(error)
chain = JtagChain(command=("tclsh", "{tcl}"))
try:
    chain.read(0x20000)
except OSError as error:
    print(error)
"""


def test_back_ends_reach_the_registers(folder):
    """A file stands for the mapped device, a script for Quartus's programs, which repeats what it
    is reported; where the chain answers nothing, or there is none, the reason is reported."""
    (folder / "registers.bin").write_bytes(bytes(1 << 16))
    done = subprocess.run([sys.executable, "-c", BACKENDS.format(tcl=TCL / "programs.tcl")],
                          cwd=folder, text=True, capture_output=True, timeout=60)
    assert done.stdout.splitlines() == [
        *[f"{0xFFFFFFFE} 7 0"] * 3, "no such device is in the chain", "no such cable",
        "no answer came from the JTAG chain in 50 scans"], done.stderr
    assert (folder / "registers.bin").read_bytes()[0x10:0x14] == b"\xfe\xff\xff\xff"


COLOUR = """
import ncdc_registers as r
from ncdc_driver import Corrector, CorrectorError, grey_world
words = {r.OFFSET["ID"]: r.ID_VALUE,
         r.OFFSET["CAPABILITIES"]: r.VERSION | r.CAPABILITIES_COLOUR | r.CAPABILITIES_RAW_GAINS,
         r.OFFSET["RED_SUM"]: 100, r.OFFSET["GREEN_SUM"]: 200, r.OFFSET["BLUE_SUM"]: 160}
corrector = Corrector(lambda offset: words.get(offset, 0), words.__setitem__)
corrector.white_balance(grey_world(corrector.colour_sums()))
print([words[r.OFFSET[f"GAIN_{name}"]] for name in ("RED", "GREEN", "BLUE")])
corrector.tone(r.TONES["sRGB"])
print([words[r.OFFSET[f"TONE{k}"]] for k in range(17)])
print(sorted(corrector.counters())[-1])
corrector.raw_balance(grey_world(corrector.colour_sums(), (256, 512, 256)))
print([words[r.OFFSET[f"RAW_GAIN_{name}"]] for name in ("RED", "GREEN", "BLUE")])
before = dict(words)
for action, values in ((corrector.white_balance, (256, 256)), (corrector.tone, (257,) * 17),
                       (corrector.white_balance, (256, 1.5, 256)),
                       (corrector.white_balance, (256, 1024, 256))):
    try:
        action(values)
    except CorrectorError as error:
        print(error)
assert words == before
words[r.OFFSET["CAPABILITIES"]] = r.VERSION
without = Corrector(lambda offset: words.get(offset, 0), None)
for action in (without.colour_sums, lambda: without.raw_balance((256, 256, 256))):
    try:
        action()
    except CorrectorError as error:
        print(error)
"""


def test_drivers_of_a_corrector_with_colour(tmp_path):
    """The Python driver balances by the sums; C and SystemRDL know the registers too."""
    made = Corrector(WIDE, Hardware(colour=True, raw_balance=True))
    for name, text in driver_files(made, [("wide.toml", WIDE)]).items():
        (tmp_path / name).write_text(text)
    done = subprocess.run([sys.executable, "-c", COLOUR], cwd=tmp_path, text=True,
                          capture_output=True)
    assert not done.returncode, done.stderr
    assert done.stdout.splitlines() == [
        "[512, 256, 320]", str(list(tone_named("sRGB"))), "VALID_PIXELS", "[410, 410, 256]",
        "there are 2 values, 3 are needed, each a gain",
        "a node of the tone curve is 257, an integer of 0 to 256 is needed",
        "a gain is 1.5, an integer of 0 to 1023 is needed",
        "a gain is 1024, an integer of 0 to 1023 is needed",
        "the corrector has no registers for colour: it was generated without --colour",
        "the corrector has no gains before interpolation: it was generated without --raw-gains"]
    (tmp_path / "colour.c").write_text("""#include <stdio.h>
#include "ncdc.h"
int main(void)
{
    static const unsigned tone[] = NCDC_TONE_GAMMA_2_2;
    struct ncdc_counters counters = {0};

    counters.valid_pixels = tone[1];
    printf("%u %u %u", (unsigned)NCDC_GAIN_RED, (unsigned)NCDC_TONE16,
           (unsigned)counters.valid_pixels);
    return 0;
}
""")
    compile_c(tmp_path, "-o", "colour", "colour.c", "ncdc.c", "ncdc_lenses.c")
    done = subprocess.run([tmp_path / "colour"], check=True, text=True, stdout=subprocess.PIPE)
    assert done.stdout == f"256 384 {tone_named('gamma:2.2')[1]}"
    compiler = RDLCompiler()
    compiler.compile_file(str(tmp_path / "ncdc.rdl"))
    top = compiler.elaborate().top
    names = {node.inst_name for node in top.descendants() if isinstance(node, RegNode)}
    assert {"GAIN_RED", "RAW_GAIN_RED", "TONE16", "VALID_PIXELS"} <= names


VIEW = """
import ncdc_registers as r
from ncdc_driver import Corrector, CorrectorError
words = {r.OFFSET["ID"]: r.ID_VALUE, r.OFFSET["CAPABILITIES"]: r.VERSION | r.CAPABILITIES_VIEW}
corrector = Corrector(lambda offset: words.get(offset, 0), words.__setitem__)
corrector.view([-1, 2, 3, 4, 5, 6, 7, 8, 9])
print([words[r.OFFSET["VIEW_X_U"] + 4 * k] for k in range(9)])
for values in ((1 << 31,) * 9, (0,) * 8):
    try:
        corrector.view(values)
    except CorrectorError as error:
        print(error)
words[r.OFFSET["CAPABILITIES"]] = r.VERSION
try:
    Corrector(lambda offset: words.get(offset, 0), None).view((0,) * 9)
except CorrectorError as error:
    print(error)
"""


VIEW_ROWS = """
import ncdc_registers as r
from ncdc_driver import Corrector, CorrectorError
words = {r.OFFSET["ID"]: r.ID_VALUE, r.OFFSET["CAPABILITIES"]: r.VERSION | r.CAPABILITIES_VIEW,
         r.OFFSET["VIEW_ROWS_STATUS"]: 3}
corrector = Corrector(lambda offset: words.get(offset, 0), words.__setitem__)
corrector.view([1] * 9)
corrector.view_rows(16, [range(1, 10), [-1] * 9])
table = r.VIEW_MATRICES + 4096
print(words[table + 24], words[table + 64 + 32], [
    words[r.OFFSET[name]] for name in ("VIEW_ROWS", "VIEW_ROWS_STEP", "VIEW_ROWS_BANK")])
words[r.OFFSET["VIEW_ROWS_STATUS"]] = 3 | r.VIEW_ROWS_STATUS_BANK
corrector.view_rows(8, [[7] * 9])
print(words[r.VIEW_MATRICES], words[r.OFFSET["VIEW_ROWS_BANK"]])
for step, matrices in ((9, []), (8, [[0] * 9] * 4), (8, [[0] * 8]), (8, [[1 << 26] * 9])):
    try:
        corrector.view_rows(step, matrices)
    except CorrectorError as error:
        print(error)
def read(offset):
    if offset == r.OFFSET["STATUS"]:    # a commit has ended just before
        words[r.OFFSET["VIEW_ROWS_STATUS"]] ^= r.VIEW_ROWS_STATUS_BANK
    return words.get(offset, 0)
Corrector(read, words.__setitem__).view_rows(8, [[5] * 9])
print(words[table], words[r.OFFSET["VIEW_ROWS_BANK"]])
del r.OFFSET["VIEW_ROWS"]
try:
    corrector.view_rows(8, [])
except CorrectorError as error:
    print(error)
"""

VIEW_ROWS_C = """#include <stdio.h>
#include "ncdc.h"
static uint32_t words[0x4000];
static uint32_t taken;      /* changes when a commit ends, just before STATUS is read */
static uint32_t read_word(void *context, uint32_t offset)
{
    (void)context;
    if (offset == NCDC_STATUS)
        words[NCDC_VIEW_ROWS_STATUS / 4] |= taken;
    return words[offset / 4];
}
static void write_word(void *context, uint32_t offset, uint32_t value)
{
    (void)context;
    words[offset / 4] = value;
}
int main(void)
{
    static const struct ncdc device = {read_word, write_word, 0};
    static const int32_t matrices[2][9] = {{1, 2, 3, 4, 5, 6, 7, 8, 9}, {-1}};

    words[NCDC_VIEW_ROWS_STATUS / 4] = 2;
    printf("%d ", ncdc_view_rows(&device, 1, matrices, 2));
    printf("%d ", (int)words[NCDC_VIEW_ROWS_BANK / 4]);
    printf("%d %d ", (int)words[(NCDC_VIEW_MATRICES + 4096 + 24) / 4],
           (int)words[(NCDC_VIEW_MATRICES + 4096 + 64) / 4]);
    printf("%d %d ", ncdc_view_rows(&device, 1, matrices, 3) == NCDC_ERROR_SIZE,
           ncdc_view_rows(&device, 4, matrices, 1) == NCDC_ERROR_SIZE);
    taken = NCDC_VIEW_ROWS_STATUS_BANK;
    printf("%d ", ncdc_view_rows(&device, 1, matrices, 2));
    printf("%d %d", (int)words[NCDC_VIEW_ROWS_BANK / 4],
           (int)words[(NCDC_VIEW_MATRICES + 24) / 4]);
    return 0;
}
"""


def test_the_drivers_write_a_table_of_matrices(tmp_path):
    lens = replace(barrel_descriptor((160, 32), (168, 36), hidden_neurons=3, strength=.02),
                   nodes=8)
    made = Corrector(lens, Hardware(view=True, view_rows=3))
    for name, text in driver_files(made, [("wide.toml", lens)]).items():
        (tmp_path / name).write_text(text)
    done = subprocess.run([sys.executable, "-c", VIEW_ROWS], cwd=tmp_path, text=True,
                          capture_output=True)
    assert done.stdout.splitlines() == [
        "6 4294967295 [2, 1, 1]", "7 0",
        "the step is 9 rows, one of 8, 16, 32, 64 is needed",
        "there are 4 matrices, the limit is 3",
        "matrix 0 is [0, 0, 0, 0, 0, 0, 0, 0], nine integers of -67108864 to 67108863 are needed",
        f"matrix 0 is {[1 << 26] * 9}, nine integers of -67108864 to 67108863 are needed",
        "5 1",
        "the corrector has no table of matrices: it was generated without --view-rows"], done.stderr
    (tmp_path / "rows.c").write_text(VIEW_ROWS_C)
    compile_c(tmp_path, "-o", "rows", "rows.c", "ncdc.c", "ncdc_lenses.c")
    done = subprocess.run([tmp_path / "rows"], check=True, text=True, stdout=subprocess.PIPE)
    assert done.stdout == "0 1 6 -1 1 1 0 0 6"
    compiler = RDLCompiler()
    compiler.compile_file(str(tmp_path / "ncdc.rdl"))
    names = {node.inst_name for node in compiler.elaborate().top.descendants()}
    assert {"VIEW_ROWS", "VIEW_ROWS_STATUS", "VIEW_MATRICES"} <= names


def test_the_python_driver_writes_a_view(tmp_path):
    lens = replace(barrel_descriptor((160, 32), (168, 36), hidden_neurons=3, strength=.02),
                   nodes=8)
    made = Corrector(lens, Hardware(view=True))
    for name, text in driver_files(made, [("wide.toml", lens)]).items():
        (tmp_path / name).write_text(text)
    done = subprocess.run([sys.executable, "-c", VIEW], cwd=tmp_path, text=True,
                          capture_output=True)
    assert done.stdout.splitlines() == [
        "[4294967295, 2, 3, 4, 5, 6, 7, 8, 9]",
        "a number of the view's matrix is 2147483648, an integer of -2147483648 to 2147483647 is "
        "needed", "there are 8 values, 9 are needed, each a number of the view's matrix",
        "the corrector has no view: it was generated without --view"], done.stderr
    header = (tmp_path / "ncdc_registers.h").read_text()
    assert "NCDC_VIEW_Z_0" in header and "NCDC_PLANE_HEIGHT" in header

"""Which lens a corrector takes: one list of cases for the drivers in C, Python and Tcl."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

from cameras import barrel_descriptor
from drivers import TELE, WIDE, compile_c
from ncdc_hdl.corrector import Corrector
from ncdc_hdl.export.drivers.drivers import driver_files
from ncdc_hdl.export.drivers.lenses import Lens
from ncdc_spec.hardware import Hardware
from ncdc_spec.interpolation import DIRECTIONAL, FAST, GRADIENT
from ncdc_spec.registers.host_values import network_values
from ncdc_spec.registers.register_map import (
    FIXED_LENS_BIT,
    ID,
    INTERPOLATION_BITS,
    STATUS_BANK,
    STATUS_COMMITTED,
    VERSION,
    registers,
)

CONSOLE = Path(__file__).resolve().parents[1] / "support" / "tcl" / "console.tcl"
OFFSETS = {r.name: 4 * r.address for r in registers(WIDE.hidden_neurons, WIDE.formats)}
# NCDC_ERROR_... in C, a word of the message in Python and Tcl.
OK, NEURONS, INTERPOLATION, SIZE, COMMITTED, FIXED = range(6)
WORDS = {NEURONS: "hidden neurons", INTERPOLATION: "interpolation", SIZE: "20x16 pixels",
         COMMITTED: "commit", FIXED: "fixed lens"}


def machine(neurons=3, interpolation=FAST, largest=(31, 20), lanes=1, status=0, fixed=None):
    """Registers of a corrector, by name; with a ``fixed`` lens of that digest."""
    return {"ID": ID, "DIGEST": int((fixed or "0" * 12)[:8], 16), "NEURONS": neurons,
            "LARGEST": largest[1] << 16 | largest[0],
            "CAPABILITIES": (VERSION | INTERPOLATION_BITS[interpolation.name] | lanes << 12
                             | 4 << 16 | (FIXED_LENS_BIT if fixed else 0)),
            "STATUS": status}


# The lens is that of WIDE: 3 neurons, fast, 20x16 pixels.
CASES = {
    "it fits": (machine(), OK), "the other bank": (machine(status=STATUS_BANK), OK),
    "just as large": (machine(largest=(20, 16)), OK), "four lanes": (machine(lanes=4), OK),
    "fewer neurons": (machine(neurons=2), NEURONS), "more neurons": (machine(neurons=4), NEURONS),
    "gradient": (machine(interpolation=GRADIENT), INTERPOLATION),
    "directional": (machine(interpolation=DIRECTIONAL), INTERPOLATION),
    "too narrow": (machine(largest=(19, 20)), SIZE), "too low": (machine(largest=(31, 15)), SIZE),
    "three lanes": (machine(lanes=3), SIZE),
    "a commit waits": (machine(status=STATUS_COMMITTED), COMMITTED),
    "neurons first": (machine(neurons=2, lanes=3), NEURONS),
    "another fixed lens": (machine(fixed=TELE.digest), FIXED),
    "its fixed lens": (machine(fixed=WIDE.digest), OK),
}

C = """#include <stdio.h>
#include <stdlib.h>
#include "ncdc_lenses.h"
static uint32_t bus[1 << 14], writes;
static uint32_t get(void *context, uint32_t offset) { (void)context; return bus[offset / 4]; }
static void put(void *context, uint32_t offset, uint32_t value)
{
    (void)context, (void)offset, (void)value;
    ++writes;
}
int main(int count, char **words)
{
    struct ncdc device = {get, put, 0};
    enum ncdc_result result;
    int k;

    for (k = 1; k + 1 < count; k += 2)
        bus[strtoul(words[k], 0, 0) / 4] = strtoul(words[k + 1], 0, 0);
    result = ncdc_load(&device, &ncdc_lens_wide);
    printf("%d %u", result == NCDC_OK ? 0 : result == NCDC_ERROR_NEURONS ? 1
                  : result == NCDC_ERROR_INTERPOLATION ? 2 : result == NCDC_ERROR_SIZE ? 3
                  : result == NCDC_ERROR_COMMITTED ? 4
                  : result == NCDC_ERROR_FIXED_LENS ? 5 : 9, (unsigned)writes);
    return 0;
}
"""

PYTHON = """
import json, sys
import ncdc_registers as r
from ncdc_driver import Corrector, CorrectorError
from ncdc_lenses import LENSES
words, written = json.loads(sys.argv[1]), []
corrector = Corrector(lambda offset: words.get(str(offset), 0), lambda *pair: written.append(pair))
try:
    corrector.load(LENSES["wide"])
    print(len(written), "")
except CorrectorError as error:
    print(len(written), error)
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Folder with the drivers of a corrector for WIDE, and the C program."""
    path = tmp_path_factory.mktemp("lenses")
    for name, text in driver_files(Corrector(WIDE, Hardware()),
                                   [("wide.toml", WIDE), ("tele.toml", TELE)]).items():
        (path / name).write_text(text)
    (path / "main.c").write_text(C)
    compile_c(path, "-o", "main", "main.c", "ncdc.c", "ncdc_lenses.c")
    return path


def by_c(folder, words):
    pairs = [str(number) for pair in words.items() for number in pair]
    done = subprocess.run([folder / "main", *pairs], check=True, text=True, capture_output=True)
    return tuple(map(int, done.stdout.split()))


def verdict(message):
    return next((code for code, words in WORDS.items() if words in message), 9) if message else OK


def by_python(folder, words):
    done = subprocess.run([sys.executable, "-c", PYTHON, json.dumps(words)], cwd=folder,
                          check=True, text=True, capture_output=True)
    writes, _, message = done.stdout.strip().partition(" ")
    return verdict(message), int(writes)


def by_tcl(folder, words):
    """System Console's script, whose reads and writes are lines."""
    process = subprocess.Popen(["tclsh", CONSOLE, folder / "ncdc_console.tcl", folder / "script"],
                               stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
    writes, message = 0, ""
    with process:
        for line in process.stdout:
            kind, *numbers = line.removeprefix("ASK ").split()
            if not line.startswith("ASK "):
                message += line
                continue
            writes += kind == "write"
            answer = words.get(int(numbers[0]) - 0x10000000, 0) if kind == "read" else ""
            process.stdin.write(f"{answer}\n")
            process.stdin.flush()
    return verdict(message), writes


@pytest.mark.parametrize("case", CASES)
def test_three_drivers_agree(folder, case):
    device, expected = CASES[case]
    words = {OFFSETS[name]: value for name, value in device.items()}
    (folder / "script").write_text("ncdc::connect\n"
                                   "if {[catch {ncdc::load wide} said]} {puts $said}\n")
    lens = Lens.of(Corrector(WIDE, Hardware()), WIDE)
    # The values and the valid rows, bank and window; nothing if the lens is rejected, or fixed.
    fixed = device["CAPABILITIES"] & FIXED_LENS_BIT
    writes = 0 if expected or fixed else len(lens.values) + len(lens.valid_rows) + 2
    found = {name: run(folder, words) for name, run in
             (("C", by_c), ("Python", by_python), ("Tcl", by_tcl))}
    assert found == dict.fromkeys(found, (expected, writes))


def test_a_lens_of_fewer_neurons_is_written_with_zeros():
    small = barrel_descriptor((20, 16), (24, 18), hidden_neurons=2)
    corrector = Corrector(WIDE, Hardware())
    lens = Lens.of(corrector, small)
    assert lens.neurons == 3 and lens.digest == small.digest
    whole, own = network_values(small, 3), network_values(small)
    assert whole.keys() == network_values(WIDE).keys()
    assert all(lens.values[name] == value for name, value in whole.items())
    assert {name: value for name, value in whole.items() if name in own} == own
    added = {name: value for name, value in whole.items() if name not in own}
    assert len(added) == 5 and set(added.values()) == {0}

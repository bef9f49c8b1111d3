"""Drivers of a corrector with a list of views, in C and in Python, on words that stand for
registers."""

import json
import subprocess
import sys
from dataclasses import replace

import pytest

from cameras import barrel_descriptor
from drivers import compile_c
from ncdc_hdl.corrector import Corrector
from ncdc_hdl.export.drivers.drivers import driver_files
from ncdc_spec.hardware import Hardware
from ncdc_spec.registers.register_map import registers
from ncdc_spec.view import View
from ncdc_spec.view_list import list_values, quad

HARDWARE = Hardware(view=True, views=4)
LENS = replace(barrel_descriptor((160, 32), (168, 36), hidden_neurons=3, strength=.02), nodes=8)
ROWS = {r.name: r for r in registers(3, LENS.formats, 8, view=True, views=4)}
VALUES = list_values(quad([View.of([[1, 0, -k], [0, 1, k], [0, 0, 1]], (80, 16))
                           for k in range(4)]), HARDWARE, LENS.geometry)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """The files for a host of that corrector."""
    folder = tmp_path_factory.mktemp("views")
    made = Corrector(LENS, HARDWARE)
    for name, text in driver_files(made, [("wide.toml", LENS)]).items():
        (folder / name).write_text(text)
    return folder


PYTHON = """
import json, sys
import ncdc_registers as r
from ncdc_driver import Corrector, CorrectorError
words = {r.OFFSET["ID"]: r.ID_VALUE, r.OFFSET["CAPABILITIES"]: r.VERSION | r.CAPABILITIES_VIEW,
         r.OFFSET["VIEWS_STATE"]: 4}
before = dict(words)
corrector = Corrector(lambda offset: words.get(offset, 0), words.__setitem__)
entries = json.loads(sys.argv[1])
for wrong in ([], 2 * entries, [{"ANGLE": 3}], [{"PITCH": 1 << 16}]):
    try:
        corrector.views(wrong)
    except CorrectorError as error:
        print(error)
assert words == before
corrector.views(entries)
print(json.dumps({name: words[offset] for name, offset in r.OFFSET.items()
                  if offset in words and offset not in before}))
del r.OFFSET["VIEWS"]
try:
    corrector.views(entries)
except CorrectorError as error:
    print(error)
"""


def test_the_python_driver_writes_a_list(folder):
    entries = [{name.removeprefix(f"VIEW{k}_"): value for name, value in VALUES.items()
                if name.startswith(f"VIEW{k}_")} for k in range(4)]
    done = subprocess.run([sys.executable, "-c", PYTHON, json.dumps(entries)], cwd=folder,
                          text=True, capture_output=True)
    none, many, unknown, wide, written, without = done.stdout.splitlines()
    assert none == "there are 0 views, the limits are 1 and 4"
    assert many == "there are 8 views, the limits are 1 and 4"
    assert unknown == "VIEW0_ANGLE is no register of the list of views"
    assert wide == "VIEW0_PITCH is 65536, the limits are 0 and 65535"
    assert json.loads(written) == {name: value & 0xFFFFFFFF for name, value in VALUES.items()}
    assert without == "the corrector has no list of views: it was generated without --views"


C = """#include <stdio.h>
#include "ncdc.h"
static uint32_t words[1 << 14];
static uint32_t get(void *context, uint32_t offset) { (void)context; return words[offset / 4]; }
static void put(void *context, uint32_t offset, uint32_t value)
{
    (void)context;
    words[offset / 4] = value;
}
int main(void)
{
    static const struct ncdc device = {get, put, 0};
    static const struct ncdc_view views[4] = {%s}, wide = {.pitch = 1 << 16};
    unsigned k;

    words[NCDC_VIEWS_STATE / 4] = 4;
    printf("%%d %%d %%d ", ncdc_views(&device, views, 0), ncdc_views(&device, views, 5),
           ncdc_views(&device, &wide, 1));
    words[NCDC_STATUS / 4] = NCDC_STATUS_COMMITTED;
    printf("%%d ", ncdc_views(&device, views, 4));
    words[NCDC_STATUS / 4] = 0;
    printf("%%u ", (unsigned)words[NCDC_VIEWS / 4]);
    printf("%%d\\n", ncdc_views(&device, views, 4));
    for (k = 0; k < sizeof words / sizeof *words; ++k)
        if (words[k])
            printf("%%u %%u\\n", k, (unsigned)words[k]);
    return 0;
}
"""


def test_the_c_driver_writes_a_list(folder):
    entries = []
    for k in range(4):
        words = [value for name, value in VALUES.items() if name.startswith(f"VIEW{k}_")]
        entries.append("{{%s}, %s}" % tuple(", ".join(map(str, part))
                                            for part in (words[:9], words[9:])))
    (folder / "views.c").write_text(C % ", ".join(entries))
    compile_c(folder, "-o", "views", "views.c", "ncdc.c", "ncdc_lenses.c")
    first, *lines = subprocess.run([folder / "views"], check=True, text=True,
                                   stdout=subprocess.PIPE).stdout.splitlines()
    # NCDC_ERROR_SIZE three times, NCDC_ERROR_COMMITTED, nothing written yet, NCDC_OK.
    assert first == "8 8 8 3 0 0"
    written = {int(address): int(word) for address, word in map(str.split, lines)}
    expected = {ROWS[name].address: value & 0xFFFFFFFF for name, value in VALUES.items()}
    assert written == {address: word for address, word in
                       (expected | {ROWS["VIEWS_STATE"].address: 4}).items() if word}


def test_a_corrector_without_a_list_has_no_such_function(tmp_path):
    for name, text in driver_files(Corrector(LENS, Hardware(view=True)),
                                   [("wide.toml", LENS)]).items():
        (tmp_path / name).write_text(text)
    assert "NCDC_VIEWS" not in (tmp_path / "ncdc_registers.h").read_text()
    compile_c(tmp_path, "-c", "ncdc.c")

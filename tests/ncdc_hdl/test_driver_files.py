"""What stands in a host's files: the table of registers, and the lenses that fit a corrector."""

import json
import subprocess
import sys
from importlib.resources import files
from types import ModuleType
from unittest.mock import MagicMock

import numpy as np
import pytest

from cameras import barrel_descriptor
from drivers import COUNTERS, ROWS, TELE, WIDE, compile_c
from ncdc.cli import main
from ncdc_hdl.corrector import Corrector
from ncdc_hdl.export.drivers.drivers import driver_files
from ncdc_hdl.export.drivers.lenses import Lens, lens_name
from ncdc_model.planner.lookups import frame_windows, lookups
from ncdc_model.planner.tags import accesses, misses
from ncdc_spec.cache_options import CacheOptions
from ncdc_spec.descriptor import Descriptor, FloatNetwork
from ncdc_spec.errors import InputError
from ncdc_spec.geometry import Geometry, ValidRows
from ncdc_spec.hardware import Hardware
from ncdc_spec.interpolation import GRADIENT
from ncdc_spec.registers.host_values import host_values, table_words
from ncdc_spec.registers.register_map import TABLE, VERSION


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
        "NCDC_VERSION": str(VERSION), "NCDC_SOURCE_BEYOND": "12",
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
                     "FOLLOW", "CREST"):
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
    assert flags == {"VALID_ROWS": 4 * TABLE, "ID_VALUE": 0x4E434443, "VERSION": VERSION,
                     "SOURCE_BEYOND": 12,
                     **{f"{r.name}_{flag.name}": flag.mask for r in ROWS for flag in r.flags}}
    for name, d in (("wide", WIDE), ("tele", TELE)):
        lens = lenses[name]
        assert (lens["digest"], lens["neurons"]) == (d.digest, 3)
        assert lens["interpolation"] == "fast"
        assert lens["values"].items() <= host_values(d).items()
        assert lens["valid_rows"] == [value for _, value in table_words(d.valid)]


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
     "the lens has 4 hidden neurons, the hardware has 3"),
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
    with pytest.raises(InputError, match="the lenses a/x.toml and b/x.toml both have the name x"):
        driver_files(corrector, [("a/x.toml", WIDE), ("b/x.toml", TELE)])


@pytest.mark.parametrize("path,name", [("net.toml", "net"), ("a b/my-lens 2.toml", "my_lens_2"),
                                       ("105.toml", "105"), ("é.toml", "_")])
def test_name_of_a_lens(path, name):
    assert lens_name(path) == name


@pytest.mark.longer
def test_command_writes_them_all(corrector, folder, tmp_path):
    assert main(["generate", str(folder / "wide.toml"), "--lens", str(folder / "tele.toml"),
                 "-o", str(tmp_path), "--fetch", corrector.hardware.fetcher,
                 "--cache-bytes", str(corrector.hardware.cache.bytes)]) == 0
    for name in driver_files(corrector, [("wide.toml", WIDE)]):
        assert (tmp_path / name).read_text() == (folder / name).read_text(), name


@pytest.mark.parametrize("module,old,new", [("ncdc_backends", "ScanChain", "JtagChain"),
                                            ("ncdc_camera", "Camera", "CameraSystem")])
def test_classes_have_their_old_names_with_a_warning(monkeypatch, module, old, new):
    if module == "ncdc_camera":
        monkeypatch.setitem(sys.modules, "ncdc_registers", MagicMock(CAMERA_STATUS_RAW_FRAME=256))
    host = files("ncdc_hdl.export.drivers") / "host" / f"{module}.py"
    loaded = ModuleType(module)
    exec(compile(host.read_text(), module, "exec"), vars(loaded))
    with pytest.warns(FutureWarning, match=f"{old} is called {new}"):
        assert getattr(loaded, old) is getattr(loaded, new)
    with pytest.raises(AttributeError, match="nothing"):
        loaded.nothing

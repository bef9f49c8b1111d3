"""Images of EEPROMs: one list of damaged ones for Python and for the driver in C."""

import struct
import subprocess
import zlib
from dataclasses import replace

import numpy as np
import pytest

from cameras import barrel_descriptor
from drivers import WIDE, compile_c
from ncdc_hdl.corrector import Corrector
from ncdc_hdl.export.drivers.drivers import driver_files
from ncdc_hdl.export.drivers.lenses import Lens
from ncdc_spec.descriptor import Descriptor
from ncdc_spec.eeprom import ERRORS, EepromError, check_like, pack, unpack
from ncdc_spec.errors import InputError
from ncdc_spec.hardware import Hardware
from ncdc_spec.registers.register_map import registers

OTHER = barrel_descriptor((20, 16), (24, 18), hidden_neurons=3, seed=9, strength=0.12,
                          bayer="GBRG", fill=(1, 2, 250))
GOOD = pack("A0017", OTHER)
OFFSETS = {r.name: 4 * r.address for r in registers(WIDE.hidden_neurons, WIDE.formats)}


def summed(content):
    """The image with a checksum that is right again."""
    return content[:-4] + struct.pack("<I", zlib.crc32(content[:-4]))


def changed(at, *values):
    """The good image with other bytes from ``at`` on, and the checksum right."""
    return summed(GOOD[:at] + bytes(values) + GOOD[at + len(values):])


def shortened(size):
    """The good image without some bytes of its rows; length and checksum are right."""
    content = GOOD[:-4 - size] + bytes(4)
    return summed(content[:8] + struct.pack("<H", len(content)) + content[10:])


def lengthened():
    content = GOOD[:-4] + bytes(8)
    return summed(content[:8] + struct.pack("<H", len(content)) + content[10:])


# Offsets as in docs/reference/eeprom.md.
DAMAGED = {
    "all zeros": (bytes(4096), "EMPTY"), "all ones": (b"\xff" * 4096, "EMPTY"),
    "nothing": (b"", "EMPTY"), "another file": (b"GIF89a" + bytes(200), "MAGIC"),
    "bytes swapped": (GOOD[3::-1] + GOOD[4:], "MAGIC"), "three bytes": (b"NCD", "MAGIC"),
    "no version": (b"NCDE", "VERSION"),
    "a later version": (changed(4, 2), "VERSION"), "only the header": (GOOD[:60], "LENGTH"),
    "cut": (GOOD[:-1], "LENGTH"), "a length of zero": (changed(8, 0, 0), "LENGTH"),
    "too long": (changed(8, 255, 255), "LENGTH"),
    "a bit of a weight": (GOOD[:90] + bytes([GOOD[90] ^ 4]) + GOOD[91:], "CHECKSUM"),
    "a wrong checksum": (GOOD[:-1] + bytes([GOOD[-1] ^ 1]), "CHECKSUM"),
    "unknown flags": (changed(6, 2), "CONTENT"),
    "a skip path without a format": (changed(6, 1), "CONTENT"),
    "a serial number with a line break": (changed(30, 10), "CONTENT"),
    "a serial number that goes on after a zero": (changed(59, 65), "CONTENT"),
    "no such filter": (changed(7, 5), "CONTENT"),
    "a weight out of range": (changed(82, 0, 0, 0, 1), "CONTENT"),
    "rows cut": (shortened(1), "CONTENT"), "a byte after the rows": (lengthened(), "CONTENT"),
    "a span that ends beyond the picture":
        (summed(GOOD[:150] + bytes([0x02, 42]) + GOOD[152:]), "CONTENT"),
    "more neurons": (pack("A", barrel_descriptor((20, 16), (24, 18), hidden_neurons=4)), "NEURONS"),
    "a larger picture": (pack("A", barrel_descriptor((24, 16), (24, 18), hidden_neurons=3)),
                         "SIZE"),
    "a larger sensor": (pack("A", barrel_descriptor((20, 16), (26, 18), hidden_neurons=3)), "SIZE"),
    "another interpolation": (changed(60, 1), "KIND"),
    "another tan-sigmoid": (changed(62, 2), "KIND"),
}

C = """#include <stdio.h>
#include "ncdc_eeprom.h"
static uint8_t image[1 << 16];
static struct ncdc_value values[200];
static uint32_t rows[64];
int main(int count, char **names)
{
    struct ncdc_eeprom_lens into = {.values = values, .valid_rows = rows};
    int k;
    for (k = 1; k < count; ++k) {
        FILE *file = fopen(names[k], "rb");
        uint32_t bytes = (uint32_t)fread(image, 1, sizeof image, file), n;
        int result = ncdc_eeprom_read(image, bytes, &ncdc_lens_wide, &into);
        fclose(file);
        printf("%d\\n", result);
        if (result || k > 1)
            continue;
        printf("%s %s\\n", into.serial, into.lens.digest);
        for (n = 0; n < into.lens.value_count; ++n)
            printf("%u %u\\n", (unsigned)into.lens.values[n].offset,
                   (unsigned)into.lens.values[n].value);
        for (n = 0; n < into.lens.span_count; ++n)
            printf("%u\\n", (unsigned)into.lens.valid_rows[n]);
        puts("end");
    }
    return 0;
}
"""


def verdict(content):
    try:
        check_like(unpack(content), WIDE)
    except EepromError as error:
        assert str(error).startswith(f"the image is rejected: {ERRORS[error.name]}")
        return error.name
    return "OK"


def test_an_image_gives_the_descriptor_again():
    image = unpack(GOOD + b"\xff" * 100)
    assert image.serial == "A0017" and image.descriptor.digest == OTHER.digest
    assert image.descriptor.geometry == OTHER.geometry
    assert verdict(GOOD) == "OK" and len(GOOD) < 220


def test_an_image_of_a_large_picture_with_nodes_and_a_skip_path():
    plain = barrel_descriptor((320, 240), (320, 240), hidden_neurons=8)
    network = replace(plain.network, skip_weights=np.array([[1.5, -2.0], [0.25, 3.0]]))
    one = Descriptor.quantise(network, plain.geometry, plain.valid, nodes=8, variant="table")
    content = pack("B-1", one)
    assert unpack(content).descriptor.digest == one.digest and len(content) < 1500
    padded = unpack(pack("B-1", one, neurons=10)).descriptor
    assert padded.hidden_neurons == 10 and not padded.hidden_weights[8:].any()
    np.testing.assert_array_equal(padded.output_weights[:, :8], one.output_weights)


@pytest.mark.parametrize("serial", ["", "A" * 33, "ä", "A\n"])
def test_a_serial_number_that_does_not_fit_is_rejected(serial):
    with pytest.raises(InputError, match="up to 32 characters of ASCII"):
        pack(serial, OTHER)


def test_python_rejects_every_damaged_image():
    assert len(DAMAGED) >= 20
    assert {name: verdict(content) for name, (content, _) in DAMAGED.items()} == {
        name: expected for name, (_, expected) in DAMAGED.items()}
    assert {expected for _, expected in DAMAGED.values()} == ERRORS.keys()


def test_no_flipped_bit_is_accepted():
    for at in range(len(GOOD)):
        for bit in range(8):
            assert verdict(GOOD[:at] + bytes([GOOD[at] ^ 1 << bit]) + GOOD[at + 1:]) != "OK"


def test_the_driver_in_c_reads_and_rejects_the_same(tmp_path):
    corrector = Corrector(WIDE, Hardware())
    for name, text in driver_files(corrector, [("wide.toml", WIDE)]).items():
        (tmp_path / name).write_text(text)
    (tmp_path / "main.c").write_text(C)
    compile_c(tmp_path, "-fsanitize=address,undefined", "-fno-sanitize-recover", "-o", "main",
              "main.c", "ncdc_eeprom.c", "ncdc_lenses.c", "ncdc.c")
    (tmp_path / "good").write_bytes(GOOD)
    for number, (content, _) in enumerate(DAMAGED.values()):
        (tmp_path / f"{number}").write_bytes(content)
    done = subprocess.run(["./main", "good", *map(str, range(len(DAMAGED)))], cwd=tmp_path,
                          check=True, text=True, stdout=subprocess.PIPE)
    good, _, rest = done.stdout.partition("end\n")
    result, about, *numbers = good.splitlines()
    lens = Lens.of(corrector, OTHER)
    assert result == "0" and about == f"A0017 {OTHER.digest}"
    split = ("CACHE_SPLIT",)            # of the built-in lens: the sizes are the same
    expected = [f"{OFFSETS[name]} {value & 0xFFFFFFFF}" for name, value in lens.values.items()
                if name not in split]
    assert [line for line in numbers if " " not in line] == list(map(str, lens.valid_rows))
    assert [line for line in numbers if " " in line and not line.startswith(
        f"{OFFSETS['CACHE_SPLIT']} ")] == expected
    names = list(ERRORS)
    assert {name: names[int(code) - 1] for name, code in zip(DAMAGED, rest.split())} == {
        name: expected for name, (_, expected) in DAMAGED.items()}

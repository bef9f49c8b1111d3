"""Images of EEPROMs: one list of damaged ones for Python, the driver in C, and the firmware."""

import struct
import subprocess
from dataclasses import replace

import numpy as np
import pytest

from cameras import barrel_descriptor
from drivers import compile_c
from eeprom_images import BUILT_IN, DAMAGED, GOOD, OTHER
from firmware_wire import Wire
from ncdc_hdl.corrector import Corrector
from ncdc_hdl.export.drivers.drivers import driver_files
from ncdc_hdl.export.drivers.lenses import Lens
from ncdc_spec.descriptor import Descriptor
from ncdc_spec.eeprom import ERRORS, STATES, EepromError, check_like, pack, start, unpack
from ncdc_spec.errors import InputError
from ncdc_spec.hardware import Hardware
from ncdc_spec.protocols import gvcp
from ncdc_spec.protocols.features import feature
from ncdc_spec.registers.register_map import TABLE, registers
from ncdc_spec.view import CAMERA_FORMATS
from ncdc_spec.view_matrix import camera_values

OFFSETS = {r.name: 4 * r.address for r in registers(BUILT_IN.hidden_neurons, BUILT_IN.formats)}

C = """#include <stdio.h>
#include "ncdc_eeprom.h"
#include "ncdc_lenses.h"
static uint8_t image[1 << 16];
static struct ncdc_value values[200];
static uint32_t rows[96];
int main(int count, char **names)
{
    struct ncdc_eeprom_lens into = {.values = values, .valid_rows = rows};
    int k;
    for (k = 1; k < count; ++k) {
        FILE *file = fopen(names[k], "rb");
        uint32_t bytes = (uint32_t)fread(image, 1, sizeof image, file), n;
        int result = ncdc_eeprom_read(image, bytes, &ncdc_lens_built_in, &into);
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
        check_like(unpack(content), BUILT_IN)
    except EepromError as error:
        assert str(error).startswith(f"the image is rejected: {ERRORS[error.name]}")
        return error.name
    return "OK"


def test_an_image_gives_the_descriptor_again():
    image = unpack(GOOD + b"\xff" * 100)
    assert image.serial == "A0017" and image.descriptor.digest == OTHER.digest
    assert image.descriptor.geometry == OTHER.geometry
    assert verdict(GOOD) == "OK" and len(GOOD) < 320


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


def read_in_c(tmp_path, corrector, built_in, images):
    """What the driver says of images: the first one's lens, and the results of the others."""
    for name, text in driver_files(corrector, [("built_in.toml", built_in)]).items():
        (tmp_path / name).write_text(text)
    (tmp_path / "main.c").write_text(C)
    compile_c(tmp_path, "-fsanitize=address,undefined", "-fno-sanitize-recover", "-o", "main",
              "main.c", "ncdc_eeprom.c", "ncdc_lenses.c", "ncdc.c")
    for number, content in enumerate(images):
        (tmp_path / f"{number}").write_bytes(content)
    done = subprocess.run(["./main", *map(str, range(len(images)))], cwd=tmp_path,
                          check=True, text=True, stdout=subprocess.PIPE)
    good, _, rest = done.stdout.partition("end\n")
    return good, rest


def test_the_driver_in_c_reads_and_rejects_the_same(tmp_path):
    corrector = Corrector(BUILT_IN, Hardware())
    good, rest = read_in_c(tmp_path, corrector, BUILT_IN,
                           [GOOD, *(content for content, _ in DAMAGED.values())])
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


def test_a_lens_of_an_image_does_not_have_the_camera_of_the_built_in_one(tmp_path):
    built_in = replace(barrel_descriptor((200, 40), (210, 50), hidden_neurons=2), nodes=8,
                       provenance={"frame": [60.0, 20.0, 15.0]})
    assert all(camera_values(built_in).values())
    corrector = Corrector(built_in, Hardware(view=True))
    good, _ = read_in_c(tmp_path, corrector, built_in, [pack("A0017", built_in)])
    result, _, *numbers = good.splitlines()
    values = dict(line.split() for line in numbers if " " in line)
    offsets = {r.name: str(4 * r.address) for r in corrector.registers.table}
    assert result == "0"
    assert {name: values[offsets[name]] for name in CAMERA_FORMATS} == dict.fromkeys(
        CAMERA_FORMATS, "0")


# In a chip an image that is cut goes on, with ones.
CHIPS = {name: content.ljust(4096, b"\xff")[:4096] for name, (content, _) in DAMAGED.items()}
ON_CHIP = {name: expected for name, (_, expected) in DAMAGED.items()} | {
    "only the header": "CHECKSUM", "cut": "CHECKSUM"}


def status_of(wire):
    """What the firmware answers of EepromStatus."""
    answer, = wire.datagram(gvcp.command_packet(
        gvcp.READREG, 1, struct.pack(">I", gvcp.register("EepromStatus").address)))
    status, _, _, data = gvcp.parse_acknowledge(answer)
    assert status == gvcp.SUCCESS
    return STATES[int.from_bytes(data, "big")]


def core_of(wire, lens):
    """Registers of the corrector that a lens is in: values by name, words of the valid rows."""
    return ({name: wire.peek(OFFSETS[name] // 4) for name in lens.values},
            [wire.peek(TABLE + k) for k in range(len(lens.valid_rows))],
            [wire.peek(OFFSETS[name] // 4) for name in ("VALID_BANK", "CTRL")])


@pytest.fixture
def chip(tmp_path):
    """``chip(content)``: arguments of the firmware with that content of its EEPROM."""
    def made(content, address_bytes=2, busy=0, waiting=0, rejected=0):
        path = tmp_path / "chip.bin"
        path.write_bytes(content)
        return path, address_bytes, busy, waiting, rejected
    return made


@pytest.mark.longer
@pytest.mark.parametrize("address_bytes,busy,waiting,rejected", [
    (1, 0, 0, 0), (2, 0, 0, 0), (2, 11, 0, 0), (2, 5, 5, 0), (2, 0, 0, 1)])
def test_the_firmware_loads_the_lens(plain_firmware, chip, address_bytes, busy, waiting, rejected):
    """Every register and valid row is that of the lens, in the other bank, and committed; after a
    write of the chip, after another commit, and after a write that was rejected."""
    corrector = Corrector(BUILT_IN, Hardware(bus="axi", format="BGR8", colour=True))
    lens = Lens.of(corrector, OTHER)
    with Wire(plain_firmware, *chip(GOOD, address_bytes, busy, waiting, rejected)) as wire:
        values, rows, (bank, control) = core_of(wire, lens)
        assert status_of(wire) == "Loaded"
    expected = {name: value & 0xFFFFFFFF for name, value in lens.values.items()}
    # The split of the cache stays that of the built-in lens.
    assert values | {"CACHE_SPLIT": 0} == expected | {"CACHE_SPLIT": 0}
    assert rows == list(lens.valid_rows) and (bank, control) == (1, 2)


@pytest.mark.longer
def test_the_firmware_rejects_the_same_and_changes_nothing(plain_firmware, chip):
    lens = Lens.of(Corrector(BUILT_IN, Hardware(bus="axi", format="BGR8")), BUILT_IN)
    found = {}
    for name, content in CHIPS.items():
        with Wire(plain_firmware, *chip(content)) as wire:
            found[name] = status_of(wire).upper()
            values, rows, rest = core_of(wire, lens)
            assert not any((*values.values(), *rows, *rest)), name
    assert found == ON_CHIP
    assert found == {name: STATES[start(content, BUILT_IN)[1]].upper()
                     for name, content in CHIPS.items()}


@pytest.mark.longer
@pytest.mark.parametrize("content,address_bytes,busy,expected", [
    (b"", 1, 0, "Empty"), (bytes(2048), 1, 0, "Empty"), (b"GIF89a", 1, 0, "Magic"),
    (GOOD[:100], 1, 0, "Checksum"), (b"NCDE\x01", 1, 0, "Length"), (GOOD, 2, 12, "NoChip")])
def test_other_chips(plain_firmware, chip, content, address_bytes, busy, expected):
    """With addresses of a byte; one that ends no write in 10 ms."""
    with Wire(plain_firmware, *chip(content, address_bytes, busy)) as wire:
        assert status_of(wire) == expected


@pytest.mark.longer
def test_without_a_chip(plain_firmware):
    with Wire(plain_firmware) as wire:
        assert status_of(wire) == "NoChip"


@pytest.mark.longer
def test_a_view_knows_nothing_of_the_camera_of_a_lens_of_the_chip(wire_firmware, chip):
    """Its focal length is 0, and the matrix is committed anew."""
    address = feature("ViewFocal").address
    with Wire(wire_firmware, *chip(pack("A0017", replace(OTHER, nodes=8)))) as wire:
        assert status_of(wire) == "Loaded"
        answer, = wire.datagram(gvcp.command_packet(gvcp.READREG, 1, struct.pack(">I", address)))
        assert gvcp.parse_acknowledge(answer)[3] == bytes(4)
        assert len(wire.commits) == 2

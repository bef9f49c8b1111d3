"""Text in a descriptor: whatever a camera or a file is called, the file can be read again."""

from dataclasses import replace

import pytest

from cameras import barrel_descriptor
from ncdc_spec.descriptor import Descriptor

NAMES = ['two\nlines\r\n', 'a "quoted" name', "back\\slash\\n", "tab\tand\x00\x1b\x7f\x85",
         "Weitwinkel äöü 相机 \U0001F4F7"]


@pytest.mark.parametrize("name", NAMES)
def test_a_name_is_read_as_it_was_written(tmp_path, name):
    descriptor = replace(barrel_descriptor((20, 16), (24, 18), hidden_neurons=2),
                         provenance={"camera": name, "files": [name, name]})
    descriptor.save(tmp_path / "net.toml")
    read = Descriptor.load(tmp_path / "net.toml")
    assert read.provenance == {"camera": name, "files": [name, name]}
    assert read.digest == descriptor.digest


def test_a_file_name_that_is_no_utf_8_can_be_read_again(tmp_path):
    name = b"photo\xff.png".decode("utf-8", "surrogateescape")
    descriptor = replace(barrel_descriptor((20, 16), (24, 18), hidden_neurons=2),
                         provenance={"photo": name})
    descriptor.save(tmp_path / "net.toml")
    assert Descriptor.load(tmp_path / "net.toml").provenance == {"photo": r"photo\udcff.png"}

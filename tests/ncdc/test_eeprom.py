"""``ncdc eeprom`` and ``ncdc lot export``: images as files."""

import json

import pytest

from cameras import barrel_descriptor
from lots import begun, driven, outcome
from ncdc.cli import main
from ncdc_spec.descriptor import Descriptor
from ncdc_spec.eeprom import unpack

LENS = barrel_descriptor((20, 16), (24, 18))


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    LENS.save("net.toml")
    barrel_descriptor((24, 16), (24, 18)).save("wide.toml")
    return tmp_path


def test_an_image_is_written_shown_and_read(folder, capsys):
    assert main("eeprom write net.toml --serial A17 -o a.bin".split()) == 0
    assert main("eeprom show a.bin --for net.toml --json -".split()) == 0
    report = json.loads(capsys.readouterr().out.partition("\n")[2])
    assert report["serial"] == "A17" and report["digest"] == LENS.digest
    assert report["corrected"] == [20, 16]
    assert main("eeprom show a.bin".split()) == 0
    assert "corrected        20x16" in capsys.readouterr().out
    assert main("eeprom read a.bin -o again.toml".split()) == 0
    assert Descriptor.load("again.toml").digest == LENS.digest


@pytest.mark.parametrize("arguments,message", [
    ("show nothing.bin", "cannot read nothing.bin"),
    ("show net.toml", "net.toml: the image is rejected: it does not begin with NCDE"),
    ("show a.bin --for wide.toml", "another size of picture ((20, 16, 24, 18), (24, 16, 24, 18)"),
    ("read a.bin -o a.bin", "the output a.bin would replace the input a.bin"),
    ("read a.bin --for net.toml -o net.toml", "net.toml would replace the input net.toml"),
    ("write net.toml --serial A --neurons 300 -o b.bin", "300 hidden neurons are asked for"),
    ("write net.toml --serial ä -o b.bin", "up to 32 characters of ASCII"),
    ("write net.toml --serial A --neurons 2 -o b.bin", "has 3 hidden neurons, the hardware has 2")])
def test_bad_input_is_one_sentence(folder, capsys, arguments, message):
    assert main("eeprom write net.toml --serial A17 -o a.bin".split()) == 0
    before = {path.name: path.read_bytes() for path in folder.iterdir()}
    capsys.readouterr()
    assert main(["eeprom", *arguments.split()]) == 2
    said = capsys.readouterr().err
    assert message in said and said.count("\n") == 1, said
    assert {path.name: path.read_bytes() for path in folder.iterdir()} == before


def test_a_lot_is_exported(folder, capsys):
    text = (folder / "net.toml").read_text()

    def answer(serial, number):
        one = outcome(neurons=3, max_error_px=.9 if serial == "U2" else .1)
        one.descriptor, one.warnings = text, ["noisy"] if serial == "U3" else []
        return one
    database = begun(folder, 3)
    driven(database, answer)
    database.close()
    assert main("lot export . -o images --neurons 5".split()) == 0
    assert "1 images of up to " in capsys.readouterr().out
    assert main("lot export . -o all --look".split()) == 0
    assert sorted(path.name for path in (folder / "all").iterdir()) == ["U1.bin", "U3.bin"]
    image = unpack((folder / "images" / "U1.bin").read_bytes())
    assert image.serial == "U1" and image.descriptor.hidden_neurons == 5
    for number in (2, 300):
        assert main(f"lot export . -o small --neurons {number}".split()) == 2
    assert not (folder / "small").exists()


def test_a_lot_without_a_passing_unit_is_not_exported(folder, capsys):
    begun(folder, 2).close()
    assert main("lot export . -o images".split()) == 2
    assert "has no unit to export: none has the verdict pass" in capsys.readouterr().err
    assert not (folder / "images").exists()

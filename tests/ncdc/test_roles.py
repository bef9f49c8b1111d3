"""A file of another kind: the sentence names it, and what to type."""

import pytest

from cameras import barrel_descriptor
from ncdc.cli import main
from ncdc_model.example import noise_picture
from ncdc_model.images import write_image


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    folder = tmp_path_factory.mktemp("roles")
    barrel_descriptor().save(folder / "net.toml")
    for name in ("photo.png", "photo.jpg"):
        write_image(folder / name, noise_picture(48, 40))
    (folder / "clip.mp4").write_bytes(b"\0\0\0\x20ftypisom" + bytes(40))
    (folder / "photo.heic").write_bytes(b"\0\0\0\x18ftypheic\0\0\0\0mif1heic")
    (folder / "photo.avif").write_bytes(b"\0\0\0\x18ftypavif\0\0\0\0mif1avif")
    (folder / "points.json").write_text('{\n "format": "ncdc points",\n "version": 1}')
    return folder


CALIBRATE = (r"ncdc calibrate {} -o points.json, then ncdc train points.json --neurons 8 "
             r"-o net.toml")


@pytest.mark.parametrize("command,said", [
    ("correct photo.png net.toml -o out.png",
     "photo.png is a picture and net.toml a descriptor: they are swapped, the descriptor comes "
     "first"),
    ("simulate photo.jpg net.toml -o out.png",
     "photo.jpg is a picture and net.toml a descriptor: they are swapped, the descriptor comes "
     "first"),
    ("correct photo.png photo.jpg -o out.png",
     "photo.png is a picture, a descriptor is needed: " + CALIBRATE.format("photo.png")),
    ("correct net.toml net.toml -o out.png",
     "net.toml is a descriptor of ncdc train, a picture is needed"),
    ("correct net.toml points.json -o out.png", "points.json is a points file, a picture is"),
    ("generate points.json -o out",
     "points.json is a points file, a descriptor is needed: ncdc train points.json --neurons 8 -o "
     "net.toml"),
    ("generate net.toml --lens photo.png -o out", "photo.png is a picture, a descriptor is needed"),
    ("build net.toml photo.png -o out", "photo.png is a picture, a descriptor is needed"),
    ("soc build --sim photo.png", "photo.png is a picture, a descriptor is needed"),
    ("device serve photo.png", "photo.png is a picture, a descriptor is needed"),
    ("device serve net.toml --photo net.toml", "net.toml is a descriptor of ncdc train, a picture"),
    ("train photo.jpg --neurons 4 -o out.toml",
     "photo.jpg is a picture, points, a camera file or a map are needed: "
     + CALIBRATE.format("photo.jpg")),
    ("train net.toml --neurons 4 -o out.toml",
     "net.toml is a descriptor of ncdc train, points, a camera file or a map are needed"),
    ("train clip.mp4 -o out.toml",
     "clip.mp4 is a video (MP4 or QuickTime), which is not supported; a photo is needed: extract a "
     "frame as PNG, as by ffmpeg -ss 1 -i VIDEO -frames:v 1 frame.png"),
    ("train photo.heic -o out.toml",
     "photo.heic is a HEIF photo (HEIC), which is not supported; save the photo as PNG or TIFF, as "
     "by heif-convert PHOTO photo.png (libheif-examples)"),
    ("train photo.avif -o out.toml", "photo.avif is a picture, points, a camera file or a map are"),
    ("evaluate net.toml --reference photo.png",
     "photo.png is a picture, points, a camera file or a"),
    ("export photo.png -o out.csv", "photo.png is a picture, a descriptor or points are needed"),
    ("calibrate photo.png net.toml -o out.json", "net.toml is a descriptor of ncdc train, a pict")])
def test_a_file_of_another_kind(files, monkeypatch, capsys, command, said):
    monkeypatch.chdir(files)
    before = sorted(files.iterdir())
    assert main(command.split()) == 2
    out, err = capsys.readouterr()
    assert err.startswith(f"ncdc {command.split()[0]}: {said}") and err.count("\n") == 1 and not out
    assert sorted(files.iterdir()) == before


def test_a_file_of_the_right_kind_is_none_of_this(files, monkeypatch, capsys):
    monkeypatch.chdir(files)
    assert main("correct net.toml photo.png -o out.png".split()) == 0
    (files / "out.png").unlink()


def test_what_cannot_be_opened_is_left_to_the_command(files, monkeypatch, capsys):
    monkeypatch.chdir(files)
    assert main("correct none.toml photo.png -o out.png".split()) == 2
    assert capsys.readouterr().err == (
        "ncdc correct: cannot read none.toml: No such file or directory\n")

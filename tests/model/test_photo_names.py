"""Photos by folders and patterns, in natural order; those that cannot be read are left out."""

import json

import pytest

from ncdc.cli import main
from ncdc.target.draw import page
from ncdc.target.layout import layout_of
from ncdc_model.images import write_image
from ncdc_model.photo.names import photos_of
from ncdc_spec.errors import InputError
from vector_pages import painted


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for name in ("img10.png", "img9.png", "IMG2.JPG", "img01.tif", "notes.txt", "points.json",
                 ".hidden.png", "points.overlay-1-img2.png"):
        (tmp_path / name).write_text("")
    (tmp_path / "img3.png").mkdir()
    return tmp_path


PHOTOS = ["img01.tif", "IMG2.JPG", "img9.png", "img10.png"]


def test_a_folder_s_photos(folder):
    assert photos_of(["."]) == PHOTOS
    assert photos_of([str(folder)]) == [str(folder / name) for name in PHOTOS]


def test_a_pattern(folder):
    assert photos_of(["img*.png"]) == ["img9.png", "img10.png"]
    assert photos_of(["*[0-9].*"]) == PHOTOS


def test_names_as_a_shell_sorts_them(folder):
    assert photos_of(["img10.png", "img9.png"]) == ["img9.png", "img10.png"]
    assert photos_of(["a/img10.png", "b/img1.png"]) == ["a/img10.png", "b/img1.png"]


def test_another_order_is_meant(folder):
    assert photos_of(["img9.png", "img01.tif", "img10.png"]) == ["img9.png", "img01.tif",
                                                                  "img10.png"]


def test_a_file_whose_name_is_like_a_pattern(folder):
    (folder / "a[1].png").write_text("")
    assert photos_of(["a[1].png"]) == ["a[1].png"]


def test_numbers_of_any_length_and_names_without(folder):
    names = [f"a{n}" for n in (3, 20, 10**30, 100)] + ["b", "a", "a03"]
    assert photos_of(sorted(names)) == ["a", "a03", "a3", "a20", "a100", f"a{10**30}", "b"]


@pytest.mark.parametrize("given,said", [
    ("empty", "the folder empty holds no photo"), ("x*.png", "no photo has a name like x*.png")])
def test_where_there_is_none(folder, given, said):
    (folder / "empty").mkdir()
    with pytest.raises(InputError) as error:
        photos_of([given])
    assert str(error.value) == said


@pytest.fixture
def boards(tmp_path, monkeypatch):
    """A folder of two photos of a board, and two files that are none."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "shots").mkdir()
    picture = painted(page(layout_of("chessboard:6x5", (297, 210)), "svg"), 1)
    write_image("shots/img10.png", picture)
    write_image("shots/img2.png", picture[::-1, ::-1].copy())
    (tmp_path / "shots" / "img3.png").write_text("no picture")
    (tmp_path / "shots" / "clip.mp4").write_bytes(b"\0\0\0\x20ftypisom" + bytes(40))
    return tmp_path


def test_what_cannot_be_read_is_left_out_with_a_word(boards, capsys):
    assert main(["calibrate", "shots", "--target", "chessboard:6x5", "-o", "points.json"]) == 0
    out, err = capsys.readouterr()
    assert "60 points (chessboard, 6 columns x 5 rows) in 2 of 4 photos" in out
    assert "\nnot used: shots/img3.png holds no image that can be decoded\n" in err
    assert "\nnot used: shots/clip.mp4 is a video (MP4 or QuickTime), which" in err
    photos = [photo["name"] for photo in json.loads((boards / "points.json").read_text())["photos"]]
    assert photos == ["img2.png", "img10.png"]


def test_where_none_can_be_read(boards, capsys):
    assert main(["calibrate", "shots/img3.png", "shots/clip.mp4", "-o", "points.json"]) == 2
    said = capsys.readouterr().err
    assert "no photo shows the target (" in said and "img3.png holds no image" in said
    assert main(["calibrate", "shots/img3.png", "-o", "points.json"]) == 2
    said = capsys.readouterr().err
    assert said.endswith("ncdc calibrate: shots/img3.png holds no image that can be decoded\n")
    assert not (boards / "points.json").exists()

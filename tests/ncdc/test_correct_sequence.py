"""``ncdc correct`` of many pictures: files, films, raw frames on standard input."""

import io
import json
import sys

import cv2
import numpy as np
import pytest

from cameras import barrel_descriptor
from ncdc.cli import main
from ncdc_model.golden.colour import ColourSums, coloured
from ncdc_model.golden.corrector import correct
from ncdc_model.images import mosaic, read_image, write_image
from ncdc_model.remap_tables import remap_tables
from ncdc_spec.colour import Colour
from ncdc_spec.interpolation import GRADIENT
from ncdc_spec.white_balance import grey_world

SIZE = 96, 64


@pytest.fixture(scope="module")
def lens():
    return barrel_descriptor(SIZE, SIZE, strength=.4, interpolation=GRADIENT, fill=(9, 80, 7))


@pytest.fixture
def folder(lens, tmp_path, monkeypatch):
    """The working folder, with a descriptor and three raw frames in ``frames``."""
    monkeypatch.chdir(tmp_path)
    lens.save("net.toml")
    for k, raw in enumerate(raws(3)):
        write_image(f"frames/{k}.png", raw)
    return tmp_path


def raws(count):
    return list(np.random.default_rng(1).integers(0, 256, (count, *SIZE[::-1]), np.uint8))


@pytest.mark.parametrize("images,names", [
    (["frames"], "012"), (["frames/[12].png"], "12"), (["frames/2.png", "frames/0.png"], "20")])
def test_files_are_corrected_into_a_folder(folder, lens, images, names):
    assert main(["correct", "net.toml", *images, "-o", "out/made", "--json", "report.json"]) == 0
    assert sorted(path.name for path in (folder / "out/made").iterdir()) == sorted(
        f"{name}.png" for name in names)
    for name in names:
        np.testing.assert_array_equal(read_image(f"out/made/{name}.png"),
                                      correct(lens, raws(3)[int(name)]).picture)
    report = json.loads((folder / "report.json").read_text())
    assert report["pictures"] == len(names) and report["frames_per_second"] > 0


def test_all_have_the_white_balance_of_the_first(folder, lens):
    assert main(["correct", "net.toml", "frames", "-o", "out", "--white-balance",
                 "grey-world"]) == 0
    first, *_, last = (correct(lens, raw) for raw in raws(3))
    colour = Colour(grey_world(ColourSums.of(first).colours))
    np.testing.assert_array_equal(read_image("out/2.png"), coloured(last, colour))


def test_a_note_is_printed_once(folder, capsys):
    assert main(["correct", "net.toml", "frames", "-o", "out"]) == 0
    assert capsys.readouterr().err.count("taken as the raw RGGB frame") == 1


@pytest.mark.parametrize("images,output,message", [
    (["frames"], "frames", "the output frames/0.png would replace an input"),
    (["empty"], "out", "empty names no file"),
    (["frames/x*.png"], "out", "frames/x*.png names no file"),
    (["frames", "net.toml"], "net.toml", "net.toml is a descriptor of ncdc train"),
    (["frames", "frames/../frames/0.png"], "out", "out/0.png would be written for"),
    (["frames/0.png", "frames/1.png"], "net.toml", "net.toml is no folder"),
    (["frames/0.png", "clip.mp4"], "out", "clip.mp4 is a film, which is corrected alone"),
    (["-"], "film.mp4", "raw frames on standard input need --raw")])
def test_bad_files(folder, capsys, images, output, message):
    (folder / "empty").mkdir()
    before = (folder / "net.toml").read_bytes()
    assert main(["correct", "net.toml", *images, "-o", output]) == 2
    assert message in capsys.readouterr().err
    assert (folder / "net.toml").read_bytes() == before
    np.testing.assert_array_equal(read_image("frames/0.png"), raws(1)[0])


def stream(monkeypatch, content):
    monkeypatch.setattr(sys, "stdin", io.TextIOWrapper(io.BytesIO(content)))


def test_raw_frames_on_standard_input(folder, lens, monkeypatch, capsysbinary):
    stream(monkeypatch, b"".join(raw.tobytes() for raw in raws(3)) + b"rest")
    assert main(["correct", "net.toml", "-", "--raw", "96x64:RGGB:8", "-o", "-"]) == 0
    out, err = capsysbinary.readouterr()
    assert out == b"".join(correct(lens, raw).picture.tobytes() for raw in raws(3))
    assert b"the last frame is left out, it has 4 of 6144 bytes" in err
    assert b"-: 3 pictures, 96x64 pixels" in err


@pytest.mark.parametrize("options,content,message", [
    ([], b"", "standard input holds no frame"),
    (["--fps", "0"], b"", "--fps is 0, it must be positive"),
    (["--raw", "96x64:BGGR:8"], b"", "the raw frames have the pattern BGGR, the descriptor RGGB"),
    (["--raw", "96x48:RGGB:8"], bytes(96 * 48), "has 96x48 pixels, the descriptor is for 96x64"),
    (["--json", "-"], b"", "standard output holds one of them")])
def test_bad_streams(folder, monkeypatch, capsys, options, content, message):
    stream(monkeypatch, content)
    assert main(["correct", "net.toml", "-", "--raw", "96x64:RGGB:8", "-o", "-", *options]) == 2
    assert message in capsys.readouterr().err


COUNT = 12
TIMES = [512 * k + 100 * (k > 5) for k in range(COUNT)]     # of 15,360 a second: one is late


def scenes():
    """Smooth colour pictures, so that a film loses little of them."""
    v, u = np.indices(SIZE[::-1])
    return [np.stack([128 + 100 * np.sin((u + 5 * k) / 20), 128 + 100 * np.cos(v / 15), 255 - u],
                     axis=-1).astype(np.uint8) for k in range(COUNT)]


@pytest.fixture
def film(folder):
    """``clip.mp4``: pictures at :data:`TIMES`, to be turned by 90 degrees, and a tone."""
    av = pytest.importorskip("av")
    from fractions import Fraction
    with av.open("clip.mp4", "w") as out:
        video, sound = out.add_stream("h264", 30), out.add_stream("aac", 48000)
        video.width, video.height, video.pix_fmt = *SIZE, "yuv420p"
        video.codec_context.time_base = Fraction(1, 15360)
        video.options = {"crf": "1"}
        video.set_display_rotation(90)
        for time, picture in zip(TIMES, scenes()):
            frame = av.VideoFrame.from_ndarray(picture, "rgb24")
            frame.pts, frame.time_base = time, Fraction(1, 15360)
            out.mux(video.encode(frame))
        tone = np.sin(np.arange(1024, dtype=np.float32) / 9)[None]
        for k in range(19):
            samples = av.AudioFrame.from_ndarray(tone, "fltp", "mono")
            samples.sample_rate, samples.pts = 48000, 1024 * k
            out.mux(sound.encode(samples))
        out.mux(video.encode())
        out.mux(sound.encode())
    return av


def read_film(av, path):
    """(times, rotation, pictures, packets of sound) of a film."""
    with av.open(path) as film:
        frames = list(film.decode(video=0))
        film.seek(0)
        sound = [bytes(packet) for packet in film.demux(audio=0) if packet.size]
        base = film.streams.video[0].time_base
    return ([float(frame.pts * base) for frame in frames], frames[0].rotation,
            [frame.to_ndarray(format="rgb24") for frame in frames], sound)


@pytest.mark.parametrize("mode", ["bilinear", "lanczos", "mosaic"])
def test_a_film(film, folder, lens, mode, capsys):
    assert main(["correct", "net.toml", "clip.mp4", "-o", "straight.mp4", "--film", mode, "--json",
                 "report.json"]) == 0
    times, rotation, source, sound = read_film(film, "clip.mp4")
    assert len(source) == COUNT and rotation == 90 and len(sound) > 10
    new_times, new_rotation, pictures, new_sound = read_film(film, "straight.mp4")
    assert (new_times, new_rotation, new_sound) == (times, rotation, sound)
    kernel = {"bilinear": cv2.INTER_LINEAR, "lanczos": cv2.INTER_LANCZOS4}.get(mode)
    blank = correct(lens, raws(1)[0]).blank
    # Away from the edge of the fill, across which the film's code blurs the colours.
    seen, filled = (cv2.erode(part.astype(np.uint8), np.ones((9, 9))) > 0
                    for part in (~blank, blank))
    assert seen.mean() > .4 and filled.any()
    for before, after in zip(source, pictures, strict=True):
        if mode == "mosaic":
            wanted = correct(lens, mosaic(before)).picture
        else:
            wanted = cv2.remap(before, *remap_tables(lens), kernel, borderMode=cv2.BORDER_REPLICATE)
            wanted[blank] = lens.geometry.fill
        wrong, moved = (np.abs(one.astype(int) - wanted) for one in (after, before))
        # A few grey levels are the film's code.
        assert wrong[seen].mean() < 4 < moved[seen].mean()
        assert wrong[filled].mean() < 5         # x264 differs from run to run on a busy machine
    report = json.loads((folder / "report.json").read_text())
    assert report["film"] == mode and report["pictures"] == COUNT
    assert ("not by the hardware's arithmetic" in capsys.readouterr().err) == (mode != "mosaic")


def test_a_film_of_raw_frames(film, folder, lens, monkeypatch):
    stream(monkeypatch, b"".join(mosaic(picture).tobytes() for picture in scenes()))
    assert main(["correct", "net.toml", "-", "--raw", "96x64:RGGB:8", "--fps", "25", "-o",
                 "straight.mkv"]) == 0
    with film.open("straight.mkv") as made:
        times = [float(frame.time) for frame in made.decode(video=0)]
    np.testing.assert_allclose(times, np.arange(COUNT) / 25, atol=.002)


def test_bad_films(film, folder, capsys):
    barrel_descriptor((48, 40), (48, 40)).save("small.toml")
    (folder / "broken.mp4").write_bytes(b"no film" * 100)
    (folder / "kept.mp4").write_bytes(b"kept")
    for arguments, message in [
            (["small.toml", "clip.mp4"], "clip.mp4 has 96x64 pixels, the descriptor is for 48x40"),
            (["net.toml", "broken.mp4"], "cannot read broken.mp4: "),
            (["net.toml", "missing.mp4"], "cannot read missing.mp4: No such file or directory"),
            (["net.toml", "clip.mp4", "--tone", "sRGB"], "--tone need --film mosaic")]:
        assert main(["correct", *arguments, "-o", "kept.mp4"]) == 2
        assert message in capsys.readouterr().err
        assert (folder / "kept.mp4").read_bytes() == b"kept"
    assert main(["correct", "net.toml", "clip.mp4", "-o", "straight.png"]) == 2
    assert "straight.png is none: films are written as one of .mp4" in capsys.readouterr().err

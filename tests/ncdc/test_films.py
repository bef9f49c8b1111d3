"""Films keep their colours, and all else that they say of themselves: FFmpeg's own filter
``remap``, with the same maps, is the truth."""

import json
from dataclasses import replace
from fractions import Fraction

import av
import cv2
import numpy as np
import pytest
from av.sidedata.sidedata import Type

from cameras import barrel_descriptor
from films import (
    COUNT,
    HDR,
    HLG,
    PC,
    SDR_601,
    SDR_709,
    SIZE,
    TAGS,
    TV,
    Film,
    frames_of,
    scene,
    shown,
)
from ncdc.cli import main
from ncdc_model.film import writing_film
from ncdc_model.film.look import planes_of
from ncdc_model.remap_tables import PlaneMaps, remap_tables
from ncdc_spec.interpolation import GRADIENT

MASTERING = "G(13250,34500)B(7500,3000)R(34000,16000)WP(15635,16450)L(10000000,50)"
QUIET = "log-level=none"
X265 = {"x265-params": f"{QUIET}:hdr10=1:master-display={MASTERING}:max-cll=1000,400", "crf": "1"}
TURNED = (0, 65536, 0, -65536, 0, 0, 0, 0, 1 << 30)
MIRRORED = (-65536, 0, 0, 0, 65536, 0, 0, 0, 1 << 30)
DEEP = dict(form="yuv420p10le", codec="libx265")
FILMS = [
    Film("full.mp4", tags=(PC, *SDR_709)), Film("limited.mp4", tags=(TV, *SDR_709)),
    Film("sd.mkv", tags=(TV, *SDR_601)), Film("untagged.mov"),
    Film("motion_jpeg.avi", "mjpeg", "yuvj422p", (PC, 2, 2, 2), {"qmin": "1", "qmax": "1"}),
    Film("hdr10.mp4", tags=(TV, *HDR), options=X265, **DEEP),
    Film("hlg.mkv", tags=(TV, *HLG), options={"x265-params": QUIET, "crf": "1"}, **DEEP),
    Film("prores.mov", "prores_ks", "yuv422p10le", (TV, *SDR_709), {}),
    Film("deep.mkv", "ffv1", "yuv444p12le", (TV, *HDR), {}),
    Film("grey.mkv", "ffv1", "gray", options={}),
    Film("wide_pixels.mp4", aspect=Fraction(16, 11)), Film("turned.mp4", matrix=TURNED),
    Film("mirrored.mov", matrix=MIRRORED), Film("stream.ts", tags=(TV, *SDR_709)),
    Film("bare.y4m", "wrapped_avframe", options={}),
    Film("vp9.webm", "libvpx-vp9", tags=(TV, *SDR_709), options={"crf": "4", "b": "0"}),
    Film("av1.webm", "libsvtav1", "yuv420p10le", (TV, *HDR), {"crf": "5"}),
]


@pytest.fixture(scope="module")
def lens():
    return barrel_descriptor(SIZE, SIZE, strength=.4, interpolation=GRADIENT, fill=(9, 80, 7))


@pytest.fixture
def folder(lens, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("SVT_LOG", "1")
    lens.save("net.toml")
    return tmp_path


def corrected(capsys, name, output, *options):
    """(status, sentences) of ``ncdc correct``, but for those on every film."""
    status = main(["correct", "net.toml", name, "-o", output, "--json", "report.json", *options])
    lines = capsys.readouterr().err.splitlines()
    return status, [line for line in lines if line and "remapped in their" not in line
                    and not line.startswith("correcting:")]


def stated(path):
    """What a film says of its pictures."""
    with av.open(path) as film:
        stream = film.streams.best("video")
        frame = next(film.decode(stream))
        sides = {side.type.name: bytes(side) for side in frame.side_data.keys() if side.type in (
            Type.DISPLAYMATRIX, Type.MASTERING_DISPLAY_METADATA, Type.CONTENT_LIGHT_LEVEL)}
        return {"bits": frame.format.components[0].bits, "sides": sides,
                "aspect": stream.sample_aspect_ratio or 1,
                **{name: getattr(frame, name) for name in TAGS}}


@pytest.mark.parametrize("film", FILMS, ids=lambda film: film.name)
def test_colours_and_tags(folder, lens, film, capsys, request):
    output = f"straight{film.name[film.name.index('.'):]}"
    output += "" if output.endswith(("mp4", "mov", "mkv", "webm", "avi")) else ".mp4"
    assert corrected(capsys, film.write(), output) == (0, [])
    before, after = stated(film.name), stated(output)
    if film.form == "gray":         # full range, as FFmpeg reads it
        assert after.pop("color_range") == PC and before.pop("color_range") == 0
    assert after == before
    if film.matrix or film.options is X265:
        assert len(after["sides"]) == (1 if film.matrix else 2)
    maps = remap_tables(lens)
    blank = maps[0] < 0
    truth = shown(film.name, [np.where(blank, 0, one) for one in maps])
    made = shown(output)
    assert made.shape == truth.shape == (COUNT, *SIZE[::-1], 3)
    # Away from the edge of the fill, across which the film's code blurs the colours.
    seen, filled = (cv2.erode(part.astype(np.uint8), np.ones((9, 9))) > 0
                    for part in (~blank, blank))
    wrong = (made - truth)[:, seen]
    mean, colour = np.abs(wrong).mean(), np.abs(wrong.mean(axis=(0, 1))).max()
    with capsys.disabled():
        if request.config.getoption("capture") == "no":
            print(f"{film.name}: {mean:.2f} levels from FFmpeg's remap, their mean {colour:.2f}")
    assert mean < 2 and colour < 1.5
    if film.form != "gray":
        assert np.abs(made[:, filled].mean(axis=(0, 1)) - lens.geometry.fill).max() < 5


def test_the_samples_of_colour_are_where_decoders_take_them_to_be():
    """Planes that are linear in x and y: brightness at each pixel; colour on the first of two
    columns, between two rows."""
    width, height = 40, 30
    v, u = np.indices((height, width)).astype(np.float32)
    map_x, map_y = 3 + .8 * u + .1 * v, 2 + .7 * v - .02 * u
    blank = np.zeros((height, width), bool)
    blank[:11, 7:] = True           # an odd row, and an odd column
    x, y = 2 * u[:height // 2, :width // 2], 2 * v[:height // 2, :width // 2] + .5
    planes = [(4 * u + v).astype(np.uint16) * 100, (400 * x + 100 * y).astype(np.uint16)]
    whole, part = PlaneMaps(map_x, map_y, blank, cv2.INTER_LINEAR)(planes, (1, 2))
    # OpenCV's remap takes a 32nd of a pixel.
    np.testing.assert_allclose(whole[~blank], (400 * map_x + 100 * map_y)[~blank], atol=10)
    half = blank[::2, ::2] & blank[1::2, ::2]
    y += .5 * blank[::2, ::2]       # beside a row without a source, the other row's counts
    wanted = 400 * (3 + .8 * x + .1 * y) + 100 * (2 + .7 * y - .02 * x)
    np.testing.assert_allclose(part[~half], wanted[~half], atol=20)
    assert (whole[blank] == 1).all() and (part[half] == 2).all() and half[4, 4] and not half[5, 4]


def test_the_colours_of_rgb_pictures_are_where_decoders_take_them_to_be(folder):
    """As of a camera, by the definition of BT.709: half a pixel would be half a level here."""
    picture = np.stack(np.broadcast_arrays(*np.ogrid[:240:60j, 250:10:60j], 128.0), axis=-1)
    picture = np.rint(picture).astype(np.uint8)
    with writing_film("ramp.mp4", (60, 60), 25) as out:
        for _ in range(3):
            out.write(picture)
    assert [stated("ramp.mp4")[name] for name in TAGS] == [TV, 1, 2, 2]
    red, green, blue = (picture[..., k] / 255 for k in range(3))
    bright = .2126 * red + .7152 * green + .0722 * blue
    frame = frames_of("ramp.mp4")[0]
    for plane, wanted in zip(planes_of(frame), (
            16 + 219 * bright, 128 + 224 * (blue - bright) / 1.8556,
            128 + 224 * (red - bright) / 1.5748)):
        if plane.shape != wanted.shape:
            wanted = (wanted[::2, ::2] + wanted[1::2, ::2]) / 2
        assert abs((plane - wanted)[2:-2, 2:-2].mean()) < .3


def tracks(path):
    """(kind, language, seconds after the pictures, payload) of each stream, tags, chapters."""
    with av.open(path) as film:
        streams = [stream for stream in film.streams if stream.type in ("video", "audio", "data")]
        found = {stream: [] for stream in streams}
        for packet in film.demux(streams):
            if packet.size:
                found[packet.stream].append((packet.pts * packet.time_base, bytes(packet)))
        begin = min(found[film.streams.video[0]])[0]
        return ([(stream.type, stream.language, float(packets[0][0] - begin),
                  [one for _, one in packets])
                 for stream, packets in found.items() if stream.type != "video" and packets],
                film.metadata, film.chapters())


def test_late_sound_languages_and_titles(folder, capsys):
    film = Film("two.mp4", sound=("deu", "fra"), late=.12, metadata={
        "title": "A title", "comment": "none", "creation_time": "2020-01-02T03:04:05Z"}).write()
    assert corrected(capsys, film, "straight.mp4") == (0, [])
    assert tracks("straight.mp4") == tracks(film)
    assert [track[:2] for track in tracks(film)[0]] == [("audio", "deu"), ("audio", "fra")]
    assert .09 < tracks(film)[0][0][2] < .13 and tracks(film)[1]["title"] == "A title"
    # AVI has neither languages nor a beginning of its sound.
    status, said = corrected(capsys, film, "straight.avi")
    assert status == 0 and said[0] == (
        "straight.avi: the language deu of a stream of kind audio is left out")
    assert "begins 0.098 s after the first picture, here -0.0" in said[1] and len(said) == 4
    assert corrected(capsys, film, "straight.webm") == (
        0, 2 * ["the sound is left out: .webm holds no aac"])


def test_tags_that_a_container_has_no_place_for(folder, capsys):
    film = Film("made.mkv", metadata={"title": "A title", "lens": "wide"}).write()
    assert corrected(capsys, film, "straight.mp4") == (
        0, ["straight.mp4: tags of the film are left out: lens"])
    assert tracks("straight.mp4")[1]["title"] == "A title"


def test_samples_of_a_sensor_and_chapters(folder, capsys):
    film = Film("sensor.mp4", data=True, chapters=True).write()
    assert corrected(capsys, film, "straight.mp4") == (0, [])
    (made, _, chapters), (wanted, _, old) = tracks("straight.mp4"), tracks(film)
    assert made == wanted and made[0][0] == "data" and len(made[0][3]) == 2
    assert [one["metadata"] for one in chapters] == [one["metadata"] for one in old] == [
        {"title": "part 0"}, {"title": "part 1"}]
    assert corrected(capsys, film, "straight.mkv") == (
        0, ["stream 1 (data, sensor) is left out: .mkv holds none such"])


@pytest.mark.parametrize("film,output,said", [
    (Film("two.mkv", second=True), "straight.mp4",
     ["two.mkv: another video stream (number 1) is left out"]),
    (Film("clear.mov", "prores_ks", "yuva444p10le", (TV, *SDR_709), {"profile": "4444"},
          alpha=.5), "straight.mov", ["clear.mov: its alpha channel is left out"]),
    (Film("rgb.mkv", "ffv1", "bgr0", (PC, 0, 1, 13), {}), "straight.mkv",
     ["straight.mkv: red, green and blue are written as Y'CbCr of BT.709"]),
    (Film("deep.mkv", "ffv1", "yuv444p12le", (TV, *HDR), {}), "straight.avi",
     ["straight.avi: of the 12 bits of a sample 10 are kept"])], ids=lambda one: getattr(
         one, "name", ""))
def test_what_cannot_be_kept_is_a_sentence(folder, capsys, film, output, said):
    assert corrected(capsys, film.write(), output) == (0, said)


def test_hardware_arithmetic_takes_8_bits(folder, capsys):
    film = Film("deep.mkv", "ffv1", "yuv420p10le", (TV, *SDR_709), {}).write()
    status, said = corrected(capsys, film, "straight.mkv", "--film", "mosaic")
    assert status == 0 and said[1:] == [
        "--film mosaic corrects samples of 8 bits, as the hardware does: the 10 bits of deep.mkv "
        "are rounded"]
    assert stated("straight.mkv") == {**stated(film), "bits": 8}
    for made, before in zip(*(planes_of(frames_of(name)[0]) for name in ("straight.mkv", film))):
        rows, columns = (slice(side // 3, 2 * side // 3) for side in made.shape)
        assert abs(made[rows, columns].mean() - before[rows, columns].mean() / 4) < 1


def packets(path):
    """(offset in the file, bytes) of each packet of pictures."""
    content = open(path, "rb").read()
    with av.open(path) as film:
        parts = [bytes(packet) for packet in film.demux(video=0) if packet.size]
    return [(content.index(part), part) for part in parts]


@pytest.mark.parametrize("suffix,codec", [("mkv", "libx264"), ("mp4", "libx264"),
                                          ("mov", "libx265"), ("avi", "mjpeg")])
def test_a_damaged_packet_is_skipped_and_counted(folder, capsys, suffix, codec):
    options = {"bf": "0", "g": "1", "x265-params": f"{QUIET}:keyint=1"}
    film = Film(f"damaged.{suffix}", codec, "yuvj420p" if codec == "mjpeg" else "yuv420p",
                options=options).write()
    offset, part = packets(film)[4]
    content = bytearray(open(film, "rb").read())
    noise = np.random.default_rng(3).integers(0, 256, len(part), np.uint8).tobytes()
    content[offset:offset + len(part)] = noise
    open(film, "wb").write(content)
    status, said = corrected(capsys, film, f"straight.{suffix}")
    assert (status, said) == (0, [
        f"{film} is damaged: packets that gave no picture and are skipped: 1; pictures that are "
        f"kept as the decoder has repaired them: 0"])
    report = json.loads((folder / "report.json").read_text())
    assert (report["pictures"], report["packets_skipped"]) == (COUNT - 1, 1)
    assert len(frames_of(f"straight.{suffix}")) == COUNT - 1


def test_packets_that_a_decoder_drops_without_a_word_are_counted(folder, capsys):
    """H.265: pictures that are predicted from a damaged one."""
    film = Film("damaged.mov", "libx265", options={"x265-params": f"{QUIET}:bframes=0"}).write()
    offset, part = packets(film)[4]
    content = bytearray(open(film, "rb").read())
    content[offset + 4:offset + 6] = b"\xff\xff"        # the header of the unit
    open(film, "wb").write(content)
    assert corrected(capsys, film, "straight.mov")[0] == 0
    report = json.loads((folder / "report.json").read_text())
    assert report["packets_skipped"] == COUNT - report["pictures"] >= 1


@pytest.mark.parametrize("name,codec,container", [
    ("index_first.mp4", "libx264", {"movflags": "faststart"}), ("cut.mkv", "libx264", {}),
    ("cut.avi", "mjpeg", {}), ("cut.ts", "libx264", {}), ("cut.webm", "libvpx-vp9", {}),
    ("fragments.mp4", "libx264", {"movflags": "frag_keyframe+empty_moov"})])
def test_a_film_that_is_cut_off(folder, capsys, name, codec, container):
    film = Film(name, codec, "yuvj420p" if codec == "mjpeg" else "yuv420p", container=container,
                options={"crf": "10", "g": "2", "bf": "0"}).write()
    output = "straight.mkv"
    assert corrected(capsys, film, output) == (0, [])
    content = open(film, "rb").read()
    offset, part = packets(film)[7] if not name.endswith("ts") else (len(content) * 3 // 4, b"abc")
    open(film, "wb").write(content[:offset + len(part) // 2])
    status, said = corrected(capsys, film, output)
    report = json.loads((folder / "report.json").read_text())
    written = report["pictures"]
    assert status == 1 and report["cut_off"] and 5 <= written <= 8
    assert said[-1].startswith(f"{film} is cut off: {written} ")
    assert said[-1].endswith("pictures are written")
    assert len(frames_of(output)) == written


def test_a_film_without_its_index(folder, capsys):
    film = Film("index_last.mp4").write()
    content = open(film, "rb").read()
    open(film, "wb").write(content[:content.index(b"moov") - 100])
    (folder / "kept.mp4").write_bytes(b"kept")
    status, said = corrected(capsys, film, "kept.mp4")
    assert status == 2 and (folder / "kept.mp4").read_bytes() == b"kept"
    assert said[0].startswith(f"ncdc correct: cannot read {film}: ")
    assert said[0].endswith("; it is cut off, and lacks what is needed to play it")


def test_an_interlaced_film_is_rejected(folder, capsys):
    film = Film("fields.mkv", options={"x264-params": "tff=1", "flags": "+ildct+ilme"}).write()
    status, said = corrected(capsys, film, "straight.mkv")
    assert status == 2 and "fields.mkv is interlaced" in said[0] and "-vf bwdif" in said[0]
    assert not (folder / "straight.mkv").exists()
    assert main(["calibrate", "--live", film]) == 2
    assert "fields.mkv is interlaced" in capsys.readouterr().err


def test_a_film_is_known_by_its_content(folder, capsys):
    (folder / Film("clip.mp4").write()).rename("clip.png")
    assert corrected(capsys, "clip.png", "straight.mp4") == (0, [])
    Film("clip.gif", "gif", "rgb8", options={}).write()
    assert corrected(capsys, "clip.gif", "straight.mp4") == (
        0, ["straight.mp4: red, green and blue are written as Y'CbCr of BT.709"])
    cv2.imwrite("photo.png", (scene() >> 8).astype(np.uint8)[:, :, 0])
    (folder / "photo.png").rename("photo.mp4")
    assert corrected(capsys, "photo.mp4", "straight.png")[0] == 0
    (folder / "words.ts").write_bytes(b"no film\n" * 99)
    for name in ("photo.mp4", "words.ts"):
        status, said = corrected(capsys, name, "none.mp4")
        assert status == 2 and f"{name} holds no film, none.mp4 would be one" in said[0]
    assert main(["correct", "net.toml", "missing.ts", "-o", "none.mp4"]) == 2
    assert "cannot read missing.ts: No such file" in capsys.readouterr().err


def test_a_part_of_the_picture_that_the_lens_was_measured_in(folder, lens, capsys):
    """A film of 48x24 pixels that shows the middle 96x48 of 96x64."""
    film = Film("small.mp4", size=(48, 24), window=(0, 8, 96, 48)).write()
    status, said = corrected(capsys, film, "straight.mp4")
    assert status == 2 and said == [
        "ncdc correct: small.mp4 has 48x24 pixels, the descriptor is for 96x64: measure the lens "
        "in the film, ncdc calibrate --live small.mp4, or say which part of the 96x64 it shows, "
        "as --film-crop 96x48"]
    whole = Film("whole.mp4").write()
    assert corrected(capsys, whole, "all.mp4")[0] == 0
    for crop in ("96x48", "full", "96x48+0+8"):
        status, said = corrected(capsys, film, "straight.mp4", "--film-crop", crop)
        assert (status, said) == (0, ["small.mp4: its 48x24 pixels are 96x48 of the descriptor's "
                                      "96x64, from column 0 and row 8, at 0.500 to one"])
        made = shown("straight.mp4")
        wanted = np.array([cv2.resize(one[8:56], (48, 24), interpolation=cv2.INTER_AREA)
                           for one in shown("all.mp4")])
        blank = remap_tables(lens)[1][8:56] < 8.5
        blank |= remap_tables(lens)[1][8:56] > 54.5
        seen = cv2.erode((~blank).astype(np.uint8), np.ones((11, 11)))[::2, ::2] > 0
        assert made.shape == wanted.shape and seen.mean() > .2
        assert np.abs((made - wanted)[:, seen]).mean() < 2.5


@pytest.mark.parametrize("crop,options,message", [
    ("96x64", [], "96x48 has its shape"), ("96x96", [], "not within the 96x64 pixels"),
    ("wide", [], "WIDTHxHEIGHT"), ("96x48+8+0", [], "not within the 96x64 pixels"),
    ("full", ["--film", "mosaic"], "--film mosaic has the descriptor's pixels")])
def test_bad_crops(folder, capsys, crop, options, message):
    film = Film("small.mp4", size=(48, 24)).write()
    status, said = corrected(capsys, film, "straight.mp4", "--film-crop", crop, *options)
    assert status == 2 and message in said[0]


def test_a_crop_takes_a_film(folder, capsys):
    cv2.imwrite("photo.png", np.zeros(SIZE[::-1], np.uint8))
    assert main(["correct", "net.toml", "photo.png", "-o", "out.png", "--film-crop", "full"]) == 2
    assert "--film-crop is full: it takes a film, photo.png is none" in capsys.readouterr().err


def test_a_film_with_other_tags_in_its_middle_is_named(folder, capsys):
    first = Film("first.ts", tags=(TV, *SDR_709))
    joined = open(first.write(), "rb").read() + open(replace(
        first, name="second.ts", tags=(TV, *SDR_601)).write(), "rb").read()
    (folder / "joined.ts").write_bytes(joined)
    status, said = corrected(capsys, "joined.ts", "straight.mkv")
    assert status == 0 and "joined.ts: its colours' tags change at" in said[0]


def test_a_time_code_is_kept_and_data_without_a_name_is_not(folder, capsys):
    """A stream of four letters that FFmpeg does not know would be written without them."""
    film = Film("coded.mov", timecode="01:02:03:04").write()
    assert corrected(capsys, film, "straight.mov") == (0, [])
    for path in (film, "straight.mov"):
        with av.open(path) as opened:
            assert [stream.metadata["timecode"] for stream in opened.streams.data] == [
                "01:02:03:04"]
    film = Film("sensor.mp4", data=True).write()
    content = open(film, "rb").read()
    open(film, "wb").write(content.replace(b"gpmd", b"mebx"))
    assert corrected(capsys, film, "straight.mov") == (
        0, ["stream 1 (data, sensor) is left out: .mov holds none such"])

"""Dumps of bare samples: plain, packed, with a stride, of several frames."""

import numpy as np
import pytest

from ncdc_model.raw_dump import RawDump
from ncdc_spec.errors import InputError


def packed(samples, bits):
    """Bytes of ``samples`` (height, width) as MIPI CSI-2 sends them, by its text: of 4, 2 or 4
    samples the upper eight bits each, then all lower bits, the first sample's lowest."""
    count, low = {10: 4, 12: 2, 14: 4}[bits], bits - 8
    out = bytearray()
    for row in samples.tolist():
        row += [0] * (-len(row) % count)
        for start in range(0, len(row), count):
            group = row[start:start + count]
            out += bytes(sample >> low for sample in group)
            rest = sum((sample & (1 << low) - 1) << (low * k) for k, sample in enumerate(group))
            out += rest.to_bytes(count * low // 8, "little")
    return bytes(out)


def read(path, text):
    said = []
    return RawDump.parse(text).read(path, said.append), said


def frame(bits, shape=(8, 12), seed=1):
    return np.random.default_rng(seed).integers(0, 1 << bits, shape)


def test_a_known_vector_of_each_packing(tmp_path):
    # 0x3FF, 0x001, 0x202, 0x0AB: upper bits FF 00 80 2A, lower pairs 3, 1, 2, 3 from bit 0 up.
    line = bytes([0xFF, 0x00, 0x80, 0x2A, 0b11_10_01_11])
    assert packed(np.array([[0x3FF, 0x001, 0x202, 0x0AB]]), 10) == line
    assert packed(np.array([[0xABC, 0x123]]), 12) == bytes([0xAB, 0x12, 0x3C])
    (tmp_path / "a").write_bytes(line * 2 * 8)
    assert read(tmp_path / "a", "8x8:RGGB:10p")[0].tolist() == [[255, 0, 128, 42] * 2] * 8
    (tmp_path / "a").write_bytes(bytes([0xAB, 0x12, 0x3C]) * 4 * 8)
    assert read(tmp_path / "a", "8x8:RGGB:12p")[0].tolist() == [[0xAB, 0x12] * 4] * 8


@pytest.mark.parametrize("width", [12, 13, 15])
@pytest.mark.parametrize("bits", [10, 12, 14])
def test_packed_samples(tmp_path, bits, width):
    samples = frame(bits, (8, width))
    (tmp_path / "a").write_bytes(packed(samples, bits))
    image, said = read(tmp_path / "a", f"{width}x8:bggr:{bits}p")
    np.testing.assert_array_equal(image, samples >> (bits - 8))
    assert image.dtype == np.uint8 and not said


@pytest.mark.parametrize("form,content", [
    ("8", lambda samples: (samples >> 4).astype(np.uint8).tobytes()),
    ("12", lambda samples: samples.astype("<u2").tobytes()),
    ("12p", lambda samples: packed(samples, 12))])
def test_strides_and_frames(tmp_path, form, content):
    frames = [frame(12, seed=seed) for seed in (1, 2, 3)]
    rows = [[content(row[None]) for row in samples] for samples in frames]
    stride = len(rows[0][0]) + 5
    (tmp_path / "a").write_bytes(b"".join(row.ljust(stride, b"\xee") for one in rows
                                          for row in one))
    image, said = read(tmp_path / "a", f"12x8:RGGB:{form}:stride={stride}")
    np.testing.assert_array_equal(image, frames[0] >> 4)
    assert said == [f"{tmp_path / 'a'}: the first of 3 frames is taken; :frame=2 in --raw takes "
                    "the second"]
    for number, samples in enumerate(frames, 1):
        image, said = read(tmp_path / "a", f"12x8:RGGB:{form}:frame={number}:stride={stride}")
        np.testing.assert_array_equal(image, samples >> 4)
        assert not said
    with pytest.raises(InputError, match="a holds 3 frames, frame 4 is asked for"):
        read(tmp_path / "a", f"12x8:RGGB:{form}:stride={stride}:frame=4")
    (tmp_path / "a").write_bytes((tmp_path / "a").read_bytes()[:-1])
    with pytest.raises(InputError, match=f"8 rows of {stride} bytes need {8 * stride}"):
        read(tmp_path / "a", f"12x8:RGGB:{form}:stride={stride}:frame=1")


def test_two_frames_of_bytes_could_be_one_of_words(tmp_path):
    first, second = (frame(8, seed=seed).astype(np.uint8) for seed in (1, 2))
    (tmp_path / "a").write_bytes(first.tobytes() + second.tobytes())
    with pytest.raises(InputError, match=r"a has 192 bytes, 12x8 samples of 1 byte need 96; that "
                                         r"is one frame of 9 to 16 bits, or two of 8 \(:frame=1"):
        read(tmp_path / "a", "12x8:RGGB:8")
    np.testing.assert_array_equal(read(tmp_path / "a", "12x8:RGGB:8:frame=2")[0], second)


def test_an_npy_file_is_no_dump(tmp_path):
    np.save(tmp_path / "a.npy", frame(12).astype(np.uint16))
    with pytest.raises(InputError, match="it is a NumPy file, which is read without --raw"):
        read(tmp_path / "a.npy", "12x8:RGGB:12")

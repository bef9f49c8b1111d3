"""Checks of a set of registers: each compared value on its limit and next to it."""

import numpy as np

from ncdc_spec.frames import BGR8, BGRX8, MONO8, OUTPUT_FORMATS
from ncdc_spec.geometry import MAX_SIZE, MIN_SIZE, STRIP_UNIT
from ncdc_spec.registers.register_map import BAYER_MONO
from pipelines import run_pipeline

__all__ = ["check_checks"]

_BYTES = {one.code: one.pixel_bytes for one in (MONO8, BGR8, BGRX8)}
_ADDRESSES = "SOURCE_BASE", "TARGET_BASE", "TARGET_OFFSET"


def _right(dut, rng):
    """Registers that have no fault."""
    word, hardware = dut.hardware.data_width // 8, dut.hardware
    width, height = (int(rng.choice([most, MIN_SIZE, rng.integers(MIN_SIZE, most + 1)]))
                     for most in dut.largest)
    across, down = (int(rng.choice([MAX_SIZE, MIN_SIZE, rng.integers(MIN_SIZE, MAX_SIZE + 1)]))
                    for _ in range(2))
    code = int(rng.choice(list(_BYTES)))
    pitch = -(-_BYTES[code] * width // word) * word
    return {"CORRECTED_WIDTH": width, "CORRECTED_HEIGHT": height, "DISTORTED_WIDTH": across,
            "DISTORTED_HEIGHT": down, "OUTPUT_FORMAT": code,
            "BAYER_PHASE": BAYER_MONO if code == MONO8.code else int(rng.integers(8)),
            "SOURCE_PITCH": -(-across // word) * word + word * int(rng.integers(2)),
            "STRIP_WIDTH": STRIP_UNIT * int(rng.integers(MAX_SIZE // STRIP_UNIT + 1)),
            "CACHE_SPLIT": int(rng.integers(hardware.cache.max_split + 1)),
            "VIEWS": int(rng.integers(1, hardware.views + 1)),
            "TARGET_PITCH": int(rng.choice([0, pitch, pitch + word])),
            **{name: word * int(rng.integers((1 << 32) // word)) for name in _ADDRESSES}}


def _row(values):
    """Bytes of a row; a format that there is not counts as the largest."""
    return _BYTES.get(values["OUTPUT_FORMAT"], BGRX8.pixel_bytes) * values["CORRECTED_WIDTH"]


def _near(dut, name, values, rng):
    """Another value of a register: near a limit, or with one bit changed."""
    word = dut.hardware.data_width // 8
    row = _row(values)
    limits = {"CORRECTED_WIDTH": (MIN_SIZE, dut.largest[0]),
              "CORRECTED_HEIGHT": (MIN_SIZE, dut.largest[1]),
              "DISTORTED_WIDTH": (MIN_SIZE, MAX_SIZE, values["SOURCE_PITCH"]),
              "DISTORTED_HEIGHT": (MIN_SIZE, MAX_SIZE),
              "SOURCE_PITCH": (values["DISTORTED_WIDTH"], values["DISTORTED_WIDTH"] // word * word),
              "TARGET_PITCH": (row, row // word * word), "VIEWS": (0, dut.hardware.views),
              "CACHE_SPLIT": (dut.hardware.cache.max_split,)}.get(name, ())
    bits = len(getattr(dut.active, name))
    near = [limit + d for limit in limits for d in (-1, 0, 1)]
    near += [values[name] ^ 1 << int(bit) for bit in rng.integers(bits, size=2)]
    return int(rng.choice(near)) % (1 << bits)


def _faults(dut, values):
    """The three faults, by the rules of the register map."""
    v, word = values, dut.hardware.data_width // 8
    return {
        "alignment": any(v[name] % word for name in (*_ADDRESSES, "SOURCE_PITCH", "TARGET_PITCH")),
        "size": not (MIN_SIZE <= v["CORRECTED_WIDTH"] <= dut.largest[0]
                     and MIN_SIZE <= v["CORRECTED_HEIGHT"] <= dut.largest[1]
                     and MIN_SIZE <= v["DISTORTED_WIDTH"] <= min(MAX_SIZE, v["SOURCE_PITCH"])
                     and MIN_SIZE <= v["DISTORTED_HEIGHT"] <= MAX_SIZE
                     and v["STRIP_WIDTH"] % STRIP_UNIT == 0
                     and v["CACHE_SPLIT"] <= dut.hardware.cache.max_split
                     and 1 <= v["VIEWS"] <= dut.hardware.views
                     and (v["TARGET_PITCH"] == 0 or v["TARGET_PITCH"] >= _row(v))),
        "format": v["OUTPUT_FORMAT"] not in {one.code for one in OUTPUT_FORMATS.values()}
                  or v["OUTPUT_FORMAT"] == MONO8.code and not v["BAYER_PHASE"] & BAYER_MONO}


def check_checks(dut, count=3000):
    """The faults of ``count`` sets of which no value, one or two are near a limit.

    ``dut``: a :class:`ncdc_hdl.registers.checks.Checks` of hardware with a cache, lists of views,
    and an interpolation that knows grey sensors.
    """
    rng, cases = np.random.default_rng(8), []
    for k in range(count):
        values = _right(dut, rng)
        for _ in range(k % 3 or k % 2):
            name = str(rng.choice(list(values)))
            values[name] = _near(dut, name, values, rng)
        cases.append(values)

    def drive(ctx, values):
        for name, value in values.items():
            ctx.set(getattr(dut.active, name), value)

    faults = dut.faults
    found = run_pipeline(dut, cases, drive, lambda: (faults.alignment, faults.size, faults.format))
    expected = [tuple(_faults(dut, values).values()) for values in cases]
    assert found == expected
    assert all(count // 30 < sum(one) < count // 2 for one in zip(*expected))

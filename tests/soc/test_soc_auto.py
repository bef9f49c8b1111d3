"""Automatic exposure and white balance of the whole system in simulation, by Debian's Aravis."""

from dataclasses import replace

import cv2
import numpy as np
import pytest

from cameras import barrel_descriptor
from ncdc_host.device.auto_control import level_of
from ncdc_model.golden.colour import ColourSums
from ncdc_model.images import mosaic
from ncdc_sim.system.soc import HARDWARE, SocModel, SocRun
from ncdc_spec.protocols.auto_control import BALANCE_BAND, BAND, TARGET
from ncdc_spec.white_balance import UNITY, grey_world
from peers import need
from soc_clients import OPEN, SIZE, matches, peer

# Compiling the model takes more than a minute.
pytestmark = [pytest.mark.regress, pytest.mark.many_clocks]

_SETTLE = OPEN + """
def until_off(stream, name):
    for count in range(60):
        if device.get(name) == "Off":
            return count
        stream.next(300)
    raise SystemExit(f"{name} is {device.get(name)}")
device.set("ExposureTime", arguments[0])
counts, ratios = [], []
with device.stream() as stream:
    for name in ("ExposureAuto", "BalanceWhiteAuto"):
        device.set(name, "Once")
        counts.append(until_off(stream, name))
    for colour in ("Red", "Green", "Blue"):
        device.set("BalanceRatioSelector", colour)
        ratios.append(device.get("BalanceRatio"))
    for _ in range(16):                 # those under way, or waiting here, have other gains
        take(stream)
print(json.dumps([counts, device.get("ExposureTime"), device.get("LineTime"), ratios]))
"""


def test_a_dark_tinted_scene(tmp_path):
    """Its pictures end as the golden model's with the exposure and the gains that it says."""
    need("riscv64-unknown-elf-gcc", "unshare", "ip", "aravis")
    noise = np.random.default_rng(1).integers(0, 256, (*SIZE[::-1], 3), dtype=np.uint8)
    scene = cv2.GaussianBlur(noise, (0, 0), 1.0) * (0.6, 1.0, 0.8)
    descriptor = barrel_descriptor(corrected=SIZE, distorted=SIZE)
    model = SocModel(descriptor, mosaic(scene.astype(np.uint8), descriptor.geometry.bayer),
                     hardware=replace(HARDWARE, colour=True))
    with SocRun(model) as run:
        counts, exposure, line_ns, ratios = peer(run, _SETTLE, tmp_path, 30.0)
    assert max(counts) < 40 and exposure > 60
    assert abs(level_of(model.raw_at(exposure)) - TARGET) <= BAND
    gains = tuple(round(ratio * UNITY) for ratio in ratios)
    golden = model.golden(exposure, gains)
    best = grey_world(ColourSums.of(golden).colours, gains)
    assert gains != (UNITY,) * 3
    assert all(abs(a - b) * BALANCE_BAND <= b for a, b in zip(gains, best)), (gains, best)
    assert matches(tmp_path, 16, [golden.picture])[-1] == 0
    means = golden.picture[~golden.blank].mean(axis=0)
    assert means.max() < 1.02 * means.min()

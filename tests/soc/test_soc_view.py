"""A view of the whole system in simulation, moved by Aravis: every pixel is the golden model's."""

from dataclasses import replace

import cv2
import numpy as np
import pytest

from devices import view_lens
from ncdc_model.correction import correct
from ncdc_sim.system.soc import HARDWARE, SocModel, SocRun
from ncdc_spec.view_matrix import Angles, PlaneCamera, camera_values, frame_of_values
from peers import need
from soc_clients import OPEN, SIZE, matches, peer

# Compiling the model takes more than a minute.
pytestmark = [pytest.mark.regress, pytest.mark.many_clocks]

_MOVE = OPEN + """
from ncdc_spec.descriptor import Descriptor
with device.stream() as stream:
    take(stream)
    for name, value in arguments[0].items():
        device.set(name, value)
    for _ in range(16):                 # those under way, or waiting here, have the view before
        take(stream)
    device.load_lens(Descriptor.load(arguments[1]))
    for _ in range(16):
        take(stream)
print(json.dumps([taken, device.get("ViewFocal")]))
"""


def of_registers(lens):
    """The lens with its picture's camera as the registers hold it."""
    return replace(lens, provenance={"frame": frame_of_values(camera_values(lens))})


def test_the_view_moves_and_a_lens_brings_its_camera(tmp_path):
    need("riscv64-unknown-elf-gcc", "unshare", "ip", "aravis")
    noise = np.random.default_rng(1).integers(0, 256, SIZE[::-1], dtype=np.uint8)
    lens, other = of_registers(view_lens()), of_registers(view_lens(seed=2, focal=60.3))
    other.save(tmp_path / "other.toml")
    model = SocModel(lens, cv2.GaussianBlur(noise, (0, 0), 1.0),
                     hardware=replace(HARDWARE, view=True))
    raw = model.raw(model.setup)
    old, new = (PlaneCamera.of(one) for one in (lens, other))
    moved = Angles(pan=12, zoom=1.5)
    goldens = [correct(one, raw, view=view).picture for one, view in (
        (lens, old.looking(Angles())), (lens, old.looking(Angles(pan=12))),
        (lens, old.looking(moved)),
        (other, old.looking(moved)),    # the view follows the lens by a frame
        (other, new.looking(moved)))]
    with SocRun(model) as run:
        taken, focal = peer(run, _MOVE, tmp_path, {"Pan": 12.0, "Zoom": 1.5},
                            str(tmp_path / "other.toml"))
        run.end()
    found = matches(tmp_path, len(taken), goldens)
    assert None not in found and found == sorted(found) and {0, 2, 4} <= set(found)
    assert focal == pytest.approx(60.3)

"""A board's monitor in simulation: pictures of ``docs/reference/ulx3s.md``, ``boards.md``.

    python -m ncdc_bench.figures.board_screen ulx3s net.toml photo.png docs/figures/ulx3s-screen.jpg

``photo.png``: a colour picture as the camera sees it. Takes some ten minutes.
"""

import sys

import cv2
import numpy as np

from ncdc.cli.hardware import planned
from ncdc_boards.camera_board.design import design_of, hardware_for, sensor_for
from ncdc_boards.catalogue import board
from ncdc_hdl.video.modes import mode_for
from ncdc_model.correction import correct
from ncdc_model.planner.plan import Fixed
from ncdc_sim.board.run import simulate_board
from ncdc_sim.sensor.photo import moving_photo
from ncdc_sim.sensor.reference import raw_frames
from ncdc_spec.descriptor import Descriptor
from ncdc_spec.sensors.field import FULL
from ncdc_spec.sensors.level import levelled

__all__ = ["last_screen"]

_EXPOSURE_US = 100
_FRAMES = 6


def last_screen(name, path, photo, run_us):
    """The last frame that the monitor of a board shows, (height, width, 3), red first.

    Prints for each frame of the screen which frame of the sensor it shows whole. "black" is
    printed before the first, "none" if it is no frame of the golden model's. ``photo``: (height,
    width, 3).
    """
    on, descriptor = board(name), Descriptor.load(path)
    g = descriptor.geometry
    sensor = sensor_for("mt9p031", g, exposure_us=_EXPOSURE_US, field=FULL)
    setup, crop = sensor
    light = moving_photo(descriptor, setup, crop, photo, _FRAMES, (12, 0))
    hardware, _ = planned(hardware_for(on), Fixed(None, None, None), descriptor)
    design = design_of(on, [(path, descriptor)], sensor, mode_for(*g.corrected), hardware=hardware,
                       time_scale=1000, waits=False, i2c_hz=400_000)
    run = simulate_board(design, "mt9p031", light, run_us=run_us, optimise="-O2")
    raw = levelled(crop.raw(raw_frames(setup, light), g.distorted), setup.sensor.black)
    golden = [correct(descriptor, np.ascontiguousarray(one),
                      strip=design.system.hardware.strip).picture for one in raw]
    for number, frame in enumerate(run.screen.frames):
        same = [k for k, picture in enumerate(golden) if np.array_equal(frame, picture)]
        print(number, same[0] if same else "none" if frame.any() else "black")
    print({name: run.results[name] for name in ("violations", "refreshes", "underruns", "shown")})
    return run.screen.frames[-1]


if __name__ == "__main__":
    seen = last_screen(*sys.argv[1:3], cv2.imread(sys.argv[3])[:, :, ::-1].copy(), 150_000)
    cv2.imwrite(sys.argv[4], seen[:, :, ::-1], [cv2.IMWRITE_JPEG_QUALITY, 90])

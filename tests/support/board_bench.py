"""A board's design in simulation, what its sensor sees, and what its screen has to show."""

import numpy as np

from cameras import barrel_descriptor
from ncdc_boards.camera_board.design import SENSOR_CLOCK_HZ, design_of, sensor_for
from ncdc_boards.camera_board.pattern import PatternSensor, pattern_samples, pattern_sensor
from ncdc_boards.catalogue import board
from ncdc_hdl.video.modes import VideoMode
from ncdc_model.correction import correct
from ncdc_model.example.card import card_codes
from ncdc_model.raw_lens import raw_lens
from ncdc_sim.board.run import simulate_board
from ncdc_sim.sensor.reference import raw_frames
from ncdc_sim.sensor.verilog import Light
from ncdc_spec.interpolation import FAST
from ncdc_spec.sensors.level import levelled

__all__ = ["HEIGHT", "SMALL", "WIDTH", "Bench", "PatternBench"]

WIDTH, HEIGHT = 64, 24
SMALL = VideoMode((72, 8, 8, 40), (28, 2, 2, 4), False, (141, 280))


class Bench:
    """A design for two lenses, or without a screen (``mode`` None) for one, the light on its
    sensor, and the golden pictures of that; ``field``, ``asked``: as of ``sensor_for``."""

    def __init__(self, name, mode, size, sensor="mt9p031", interpolation=FAST, **more):
        self.mode, self.size, self.name = mode, size, sensor
        # Bits of a colour that the board shows.
        self.colour_mask = 0xF0 if name == "de0-cv" else 0xFF
        lenses = [barrel_descriptor(size, size, hidden_neurons=2, strength=s,
                                    interpolation=interpolation) for s in (.4, .2)]
        self.lenses = [*lenses, raw_lens(lenses[0])]
        more = self._camera(lenses[0], **more)
        named = [("a", lenses[0]), ("b", lenses[1])]
        self.design = design_of(board(name), named if mode else named[:1], self.sensor, mode,
                                **{"time_scale": 1000, "waits": False, "i2c_hz": 400_000} | more)

    def _camera(self, lens, *, frames=6, field=None, asked=None, **more):
        """The sensor, the light on it, and the raw frames; what is left of the arguments."""
        self.sensor = setup, crop = sensor_for(self.name, lens.geometry, exposure_us=100,
                                               field=field, **(asked or {}))
        asked = setup.settings
        read = frames, asked.skip * asked.height, asked.skip * asked.width
        noise = np.random.default_rng(1).integers(0, 4096, read, dtype=np.uint16)
        self.light = Light(noise, asked.left, asked.top)
        self.raw = levelled(crop.raw(raw_frames(setup, self.light), self.size),
                            setup.sensor.black)
        return more

    def run(self, run_us, **more):
        return simulate_board(self.design, self.light and self.name, self.light, run_us=run_us,
                              **more)

    def golden(self, lens):
        """Pictures of all raw frames."""
        strip = self.design.system.hardware.strip
        return [correct(self.lenses[lens], raw, strip=strip).picture & self.colour_mask
                for raw in self.raw]

    def inside(self, frame):
        """The picture in a screen's frame, after a check that all around it is black."""
        (width, height), (wide, high) = self.size, self.mode.size
        left, top = (wide - width) // 2, (high - height) // 2
        inner = frame[top:top + height, left:left + width]
        assert frame.shape == (high, wide, 3)
        assert int(frame.sum()) == int(inner.sum())
        return inner

    def shown(self, run, lens=0):
        """Number of the raw frame that each frame of the screen shows whole, None if black.

        A frame that is neither fails.
        """
        golden, numbers = self.golden(lens), []
        for frame in run.screen.frames:
            inner = self.inside(frame)
            same = [k for k, picture in enumerate(golden) if np.array_equal(inner, picture)]
            assert same or not inner.any(), "a frame of the screen is no frame of the sensor"
            numbers.append(same[0] if same else None)
        return numbers


class PatternBench(Bench):
    """A design with a test pattern instead of a sensor; ``rate``: its frames per second."""

    def _camera(self, lens, *, rate, **more):
        codes = card_codes(lens)
        self.sensor = pattern_sensor(lens.geometry, SENSOR_CLOCK_HZ, rate)
        self.light, self.raw = None, levelled(pattern_samples(codes))[None]
        return more | {"pattern": PatternSensor(codes, self.sensor[0].timing)}

"""The camera system with a parallel sensor: capture with a grid stage, stores, I2C, registers.

The corrector in it is judged by the design ``core``, the other parts by ``camera``.
"""

import random
from functools import cache

import numpy as np

from cameras import barrel_descriptor
from ncdc_bench.mutation.designs import Design, PlayedBench
from ncdc_bench.system.readers import simulate_readers
from ncdc_hdl.export.verilog.system_cover import SYSTEM
from ncdc_hdl.system import System
from ncdc_model.correction import correct
from ncdc_sim.sensor.verilog import Fault, Light
from ncdc_sim.system.camera import simulate_camera
from ncdc_sim.system.live import Clocks
from ncdc_sim.system.running import running
from ncdc_spec.hardware import Hardware
from ncdc_spec.registers.system_map import EVENTS, LOCKED
from ncdc_spec.sensors.catalogue import sensor_named, setup
from ncdc_spec.sensors.framing import Crop
from ncdc_spec.sensors.sensor import Settings

__all__ = ["DESIGN"]

_SIZE = 48, 20              # of raw and corrected frames
_ROW = 112                  # samples of the longest row of the grid stage
_FRAMES = 5                 # different ones that the sensor sees
_QUARTER = 6                # clocks of a quarter of a bit of I2C
_QUICK = Clocks(extclk_period=4010)     # the sensor's blanking takes less of a run
_BUFFER = 0x1000            # bytes from buffer to buffer, of which a frame has no more than 0xF00
_FRESH = 0xA5               # of memory that was not written
_LOCKED = 1 << 8 + [name for name, _ in EVENTS].index("REFUSED")
_SENSOR = sensor_named("mt9p031")
# What the sensor sends, what capture makes of it, clocks, gains of the samples, early start.
_WAYS = {
    "window": ((64, 24), Crop(11, 2), Clocks(extclk_period=5500), (300, 256, 411), False),
    "grid": ((64, 24), Crop(6, 1, 2), Clocks(extclk_period=3990), (256, 256, 256), True),
    "binning": ((104, 48), Crop(1, 0, 3, 1), Clocks(extclk_period=3010), (256, 200, 999), True),
}


def make():
    """The system, anew."""
    return System(barrel_descriptor(_SIZE, _SIZE, hidden_neurons=2, strength=.4),
                  Hardware(data_width=64), grid=_ROW)


@cache
def system():
    """The system, made once, for its registers."""
    return make()


@cache
def scene(size):
    """Configuration of the sensor that sends frames of a size, and light on it."""
    width, height = size
    asked = setup(_SENSOR, Settings(width=width, height=height, exposure_us=20,
                                    clock_hz=_SENSOR.pixel_clock_hz))
    noise = np.random.default_rng(1).integers(0, 4096, (_FRAMES, height, width), np.uint16)
    return asked, Light(noise)


_GOLDEN = {}        # pictures by the bytes of the raw frame: the same for each mutant


def golden(raw):
    """The golden model's picture of a raw frame."""
    key = raw.tobytes()
    if key not in _GOLDEN:
        _GOLDEN[key] = correct(system().descriptor, raw, strip=system().hardware.strip).picture
    return _GOLDEN[key]


def options(verilog, transcripts, clock_limit):
    """Options of a run, of each bench."""
    return {"verilog": verilog, "transcripts": transcripts, "clock_limit": clock_limit,
            "quarter": _QUARTER}


def buffers():
    """Registers of buffers that begin between those after a reset, and of the bytes of a raw frame.
    """
    stores = system().stores
    bases = {f"RAW{k}_BASE": _BUFFER * k + 0x200 for k in range(stores.raw)}
    bases |= {f"CORRECTED{k}_BASE": _BUFFER * (stores.raw + k) - 0x600
              for k in range(stores.corrected)}
    return bases | {"RAW_BYTES": _SIZE[0] * _SIZE[1]}


def frames(name):
    """The bench of whole frames of a way, both stores."""
    size, corner, clocks, gains, follow = _WAYS[name]

    def run(verilog, transcripts):
        with running(system(), *scene(size), corner=corner, clocks=clocks, gains=gains,
                     registers={"RUN_FOLLOW": int(follow)} | buffers(), memory="hostile",
                     **options(verilog, transcripts, 400_000)) as camera:
            host, live, seen = camera.host, camera.host.live, []
            host.camera.listen("CORRECTED_FRAME")
            while len(seen) < 3:
                assert live.wait_irq(8 * camera.frame_clocks)
                assert "CORRECTED_FRAME" in host.camera.events()
                picture, held = host.claim(), host.get("READER0")
                raw = host.claim(False, reader=1)
                np.testing.assert_array_equal(host.picture(picture),
                                              golden(camera.sent(picture.number)))
                np.testing.assert_array_equal(host.raw(raw), camera.sent(raw.number))
                assert host.get("CORRECTED_NUMBER") - picture.number in (0, 1)
                assert 0 < live.now - picture.time < 4 * camera.frame_clocks
                assert 0 < host.get("TIME_LOW") - live.now + 40 < 40
                seen.append(picture)
                assert host.get("READER0") == held
                # One more raw frame is held, so that more buffers are in use.
                other = host.claim(False)
                np.testing.assert_array_equal(host.raw(other), camera.sent(other.number))
            numbers = [one.number for one in seen]
            assert numbers[0] <= 3 and numbers == sorted(set(numbers))
            for one, other in zip(seen, seen[1:]):
                due = (other.number - one.number) * camera.frame_clocks
                assert abs(other.time - one.time - due) < 12
            assert not any(host.get(counter) for counter in (
                "LINE_FAULTS", "FRAMES_CUT", "OVERFLOWS", "FRAMES_MISSED", "CLOCK_STOPS",
                "RAW_ENDED_BAD", "RAW_TAKEN", "CORRECTED_ENDED_BAD", "CORRECTED_TAKEN"))
            assert host.get("RAW_BEGUN") - host.get("CORRECTED_BEGUN") in (0, 1)
            assert host.get("CAMERA_STATUS") & 3 == 3
            stop(camera)
            check_outside(host)
            bench = live.end()
        assert not any(value for name, value in bench.items() if name.endswith("_errors"))
    return run


def halt(camera):
    """Switch the camera off; it is inactive after its last frame."""
    host, live = camera.host, camera.host.live
    host.camera.stop()
    for _ in range(40):
        if host.get("CAMERA_STATUS") & 3 == 0:
            return
        live.wait(camera.frame_clocks // 8)
    raise AssertionError("the camera does not stop")


def stop(camera):
    """Switch the camera off: its last frame is right, and no other begins."""
    host, live = camera.host, camera.host.live
    halt(camera)
    begun = host.get("RAW_BEGUN"), host.get("CORRECTED_BEGUN")
    picture = host.claim()
    np.testing.assert_array_equal(host.picture(picture), golden(camera.sent(picture.number)))
    live.wait(camera.frame_clocks)
    assert (host.get("RAW_BEGUN"), host.get("CORRECTED_BEGUN")) == begun
    assert host.get("CAMERA_STATUS") & 3 == 0


def check_outside(host):
    """No byte outside the frames was written."""
    size, stores = host.live.memory_bytes, system().stores
    content = np.frombuffer(host.live.memory(0, size), np.uint8)
    outside = np.ones(size, bool)
    for store, count, used in (("RAW", stores.raw, _SIZE[1] * host.get("RAW_PITCH")),
                               ("CORRECTED", stores.corrected, 4 * _SIZE[0] * _SIZE[1])):
        for k in range(count):
            base = host.get(f"{store}{k}_BASE")
            outside[base:base + used] = False
    assert outside.any() and (content[outside] == _FRESH).all()


def readers(limit):
    """The bench of readers that claim at any time, with a time limit or without one."""
    size, corner, clocks, gains, _ = _WAYS["window"]

    def run(verilog, transcripts):
        result = simulate_readers(system(), *scene(size), count=12, seed=7, limit=limit,
                                  corner=corner, gains=gains, clocks=clocks,
                                  **options(verilog, transcripts, 700_000))
        assert (result.torn, result.bad) == (0, 0)
        assert result.raw > 1 and result.corrected > 0
        assert (result.lost > 0) == (limit > 0) and result.taken >= result.lost
    return run


_FAULTS = (
    ("short_line", {"frame": 1, "row": 7}, "LINE_FAULTS"),
    ("long_line", {"frame": 1, "row": 7}, "LINE_FAULTS"),
    ("glitch", {"frame": 1, "row": 7}, "LINE_FAULTS"),
    ("cut_frame", {"frame": 1, "row": 15}, "FRAMES_CUT"),
    ("clock_stop", {"frame": 1, "row": 9, "clocks": 20_000}, "CLOCK_STOPS"))


def faults(verilog, transcripts):
    """Faults of the sensor: each is counted, its frame is bad, and the others are right."""
    for k, (kind, how, counter) in enumerate(_FAULTS):
        run = simulate_camera(system(), *scene(_SIZE), count=2, follow=bool(k % 2),
                              fault=Fault(kind, **how), clocks=_QUICK,
                              **options(verilog, transcripts, 400_000))
        others = [name for name in ("LINE_FAULTS", "FRAMES_CUT", "CLOCK_STOPS")
                  if name != counter and kind not in ("glitch", "clock_stop")]
        assert run.counters[counter] > 0 and not any(run.counters[name] for name in others), kind
        assert run.counters["RAW_ENDED_BAD"] > 0 == run.counters["OVERFLOWS"]
        assert run.counters["CORRECTED_ENDED_BAD"] == (
            run.counters["RAW_ENDED_BAD"] if k % 2 else 0)
        assert [frame.different for frame in run.frames] == [0, 0]
        assert run.frames[0].number == 1 < run.frames[1].number - 1


def stalls(verilog, transcripts):
    """A memory that takes nothing for some frames: they are lost and counted."""
    run = simulate_camera(system(), *scene(_SIZE), count=3,
                          disturb=lambda host: host.live.stall(30_000), clocks=_QUICK,
                          **options(verilog, transcripts, 500_000))
    assert run.counters["OVERFLOWS"] > 0 and run.counters["RAW_ENDED_BAD"] > 0
    assert [frame.different for frame in run.frames] == [0, 0, 0]


def bus(verilog, transcripts):
    """Registers of the sensor over I2C; one that does not answer, and one that holds SDA."""
    rng = random.Random(3)
    run_options = options(verilog, transcripts, 400_000) | {"clocks": _QUICK}
    with running(system(), *scene(_SIZE), **run_options) as camera:
        host, report = camera.host, scene(_SIZE)[0].report()
        for _ in range(12):
            register, value = rng.choice((0x35, 0x2B, 0x2C)), rng.randrange(1 << 7)
            host.camera.write_sensor(report, register, value)
            assert host.camera.read_sensor(report, register) == value
        report |= {"i2c_address": report["i2c_address"] ^ 1}
        try:
            host.camera.read_sensor(report, 0)
        except host.errors as error:
            assert "no acknowledge" in str(error)
        else:
            raise AssertionError("a sensor that is not there answers")
        assert host.camera.i2c_errors == ["NACK"] * 3
        # A command before the last one is over is rejected.
        host.camera.events()
        host.write("I2C_COMMAND", 0x100)
        host.write("I2C_COMMAND", 0x1000)
        assert "REFUSED" in host.camera.events()
    for kind, flag in (("nack", "NACK"), ("stuck_sda", "LOST")):
        run = simulate_camera(system(), *scene(_SIZE), count=1, fault=Fault(kind, start=9),
                              **run_options)
        assert flag in run.i2c_errors and run.frames[0].different == 0


def registers(verilog, transcripts):
    """Each register keeps its bits, or none; those that are in use are not written."""
    rng = random.Random(5)
    with running(system(), *scene(_SIZE), **options(verilog, transcripts, 300_000)) as camera:
        host, live = camera.host, camera.host.live
        halt(camera)
        # The corrector's registers are before those of the camera.
        [fill] = [one for one in system().corrector.registers.table if one.name == "FILL"]
        for word in (0x5A96C3, 0xA5693C):
            live.write(fill.address, word)
            assert live.read(fill.address) == word
        stored = [one for one in system().table if one.access == "rw"
                  and one.name not in ("CAMERA_ENABLE", "RUN")]
        values = {}
        for _ in range(2):
            for one in rng.sample(stored, len(stored)):
                live.write(one.address, word := rng.getrandbits(32))
                values[one.name] = word & (1 << one.shape.width) - 1 & ~low_bits(one.name)
            for one in stored:
                assert host.get(one.name) == values[one.name], one.name
        # What is locked while the camera is enabled keeps its value.
        host.write("CAMERA_STATUS", 0xFFFFFFFF)
        host.write("CAMERA_IRQ_ENABLE", 0)
        host.write("CAMERA_ENABLE", 1)
        for one in stored:
            locked = one.name in LOCKED or one.name.endswith("_BASE")
            if one.name == "CAMERA_IRQ_ENABLE":
                continue
            live.write(one.address, word := rng.getrandbits(32))
            new = word & (1 << one.shape.width) - 1 & ~low_bits(one.name)
            assert host.get(one.name) == (values[one.name] if locked else new), one.name
            assert bool(host.get("CAMERA_STATUS") & _LOCKED) == locked, one.name
            assert not live.wait_irq(0)
            host.write("CAMERA_IRQ_ENABLE", _LOCKED >> 8)
            assert live.wait_irq(2) == locked
            host.write("CAMERA_STATUS", _LOCKED)
            assert not live.wait_irq(0)
            host.write("CAMERA_IRQ_ENABLE", 0)


def low_bits(name):
    """Bits of a register that are not stored: addresses of whole words."""
    aligned = name.endswith("_BASE") or name in ("RAW_PITCH", "RAW_BYTES", "CORRECTED_BYTES")
    return system().hardware.data_width // 8 - 1 if aligned else 0


def resets(verilog, transcripts):
    """Resets in the midst of frames, of the memory as well or not: the next frame is right."""
    size, corner, clocks, gains, _ = _WAYS["window"]
    with running(system(), *scene(size), corner=corner, gains=gains, clocks=clocks,
                 memory="hostile", **options(verilog, transcripts, 400_000)) as camera:
        host, live = camera.host, camera.host.live
        written = {name: host.get(name) for name in (
            "SENT_WIDTH", "SENT_HEIGHT", "WINDOW_LEFT", "WINDOW_TOP", "BLACK_LEVEL", "CLOCK_LIMIT",
            "CAPTURE_GAINS")}
        for k in range(4):
            live.wait(int((1.1 + k / 4) * camera.frame_clocks))
            live.reset(1 + k % 3, memory=k % 2 == 0)
            assert host.get("RAW_BEGUN") == 0 == host.get("CAMERA_STATUS") >> 8
            host.camera.put(**written)
            host.camera.listen("CORRECTED_FRAME")
            host.camera.start()
            assert live.wait_irq(6 * camera.frame_clocks)
            picture = host.picture(host.claim())
            assert any(np.array_equal(picture, golden(raw)) for raw in camera.raw)


_RUNS = {"registers": registers, **{f"frames, {name}": frames(name) for name in _WAYS},
         "stalls": stalls, "I2C": bus,
         "readers with a limit": readers(14_000), "faults": faults, "resets": resets}

DESIGN = Design("system", SYSTEM, make, tuple(PlayedBench(*item) for item in _RUNS.items()),
                leaves=("corrector", "capture", "raw", "corrected", "i2c", "run_control", "page",
                        "writes", "reader0", "reader1"))

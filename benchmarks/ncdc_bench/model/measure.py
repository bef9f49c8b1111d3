"""Processor time of the models for a frame, next to OpenCV's flow of the same quality."""

import socket
import threading
import time
from contextlib import contextmanager
from dataclasses import replace

import cv2
import numpy as np

from ncdc_bench.throughput.lenses import Lens, trained
from ncdc_host.device.camera import Frame, picture_of
from ncdc_host.device.light import MovingScene
from ncdc_host.device.registers import Settings, View
from ncdc_host.device.sensor import Exposure, expose
from ncdc_host.device.stream import Receiver, Stream
from ncdc_model.correction import COMPILED, MODELS, Correction
from ncdc_model.example import BAYER, example_camera, scene_light
from ncdc_model.images import demosaic, mosaic
from ncdc_model.remap_tables import remap_tables
from ncdc_spec.descriptor import Descriptor
from ncdc_spec.geometry import Geometry, ValidRows
from ncdc_spec.interpolation import DEFAULT, INTERPOLATIONS
from ncdc_spec.pixel_formats import BGR8

__all__ = ["SIZES", "device_row", "lens_of", "model_rows"]

SIZES = (640, 480), (1280, 1024), (1920, 1080)
_TRAINED = Lens(105, SIZES[0])
_FRAMES = 9             # the fastest of them counts: others share the machine
_DEVICE = SIZES[1]      # of the emulated device
_PACKET = 1500          # bytes with headers, as every network carries


def lens_of(size, interpolation):
    """The descriptor of a wide-angle lens: one network, its coordinates scaled to the ``size``."""
    base = trained(_TRAINED).network
    scale = np.divide(size, _TRAINED.size)
    network = replace(base, output_weights=base.output_weights * scale[:, None],
                      output_biases=(base.output_biases + .5) * scale - .5)
    geometry = Geometry(*size, *size, interpolation=interpolation)
    v, u = np.indices(size[::-1])
    inside = geometry.window_inside(*network(*geometry.normalise(u, v)))
    return Descriptor.quantise(network, geometry, ValidRows.of_mask(inside))


def model_rows(sizes=SIZES, progress=lambda name: None):
    """Rows of both models for each interpolation and size.

    Yields
    ------
    dict
        ``size``, ``interpolation``, ``model``; ``milliseconds`` of processor time for a frame, and
        ``map_milliseconds`` for the map of its lens; ``opencv_milliseconds`` of OpenCV's
        demosaicing (VNG) and bilinear remapping by the same map, on one thread;
        ``bits_different`` of the picture, from the reference's.
    """
    scene = np.float32(scene_light(example_camera()))
    for size in sizes:
        raw = mosaic(np.clip(cv2.resize(scene, size) + .5, 0, 255).astype(np.uint8), BAYER)
        opencv = None
        for interpolation in INTERPOLATIONS.values():
            descriptor = lens_of(size, interpolation)
            opencv = opencv or _opencv_milliseconds(raw, descriptor)
            pictures = {}
            for model in reversed(MODELS):
                progress(f"{size[0]}x{size[1]} {interpolation.name} {model}")
                count = _FRAMES if model == COMPILED else 1
                map_milliseconds = _milliseconds(lambda: Correction(descriptor, model).blank, count)
                correction = Correction(descriptor, model)
                pictures[model] = correction(raw).picture
                milliseconds = _milliseconds(lambda: correction(raw), count)
                different = np.bitwise_count(pictures[model] ^ next(iter(pictures.values())))
                yield {"size": "x".join(map(str, size)), "interpolation": interpolation.name,
                       "model": model, "milliseconds": milliseconds,
                       "map_milliseconds": map_milliseconds, "opencv_milliseconds": opencv,
                       "bits_different": int(different.sum(dtype=np.int64))}


def device_row(interpolation=DEFAULT):
    """Processor time of the emulated device for a corrected picture that it has not made before.

    Returns
    -------
    dict
        ``size``, ``interpolation``; ``milliseconds`` of light, noise, correction and packing;
        ``sending_milliseconds`` of its packets, of ``packet_bytes`` each, over the loopback
        interface; ``frames_per_second`` of one core with both.
    """
    descriptor = lens_of(_DEVICE, interpolation)
    scene, correction = MovingScene(descriptor), Correction(descriptor)
    settings = Settings(View(BGR8, 0, 0, *_DEVICE), 0, 1, 8, "Off", 1)
    light, seeds = scene.raw(0), iter(range(_FRAMES + 1))

    def frame():
        raw = expose(light, Exposure(1, 1, "Off", 1.0), descriptor.geometry.bayer, next(seeds))
        return picture_of(raw, settings, correction)
    data = frame().data
    milliseconds, sending = _milliseconds(frame, _FRAMES), _sending_milliseconds(data)
    return {"size": "x".join(map(str, _DEVICE)), "interpolation": interpolation.name,
            "milliseconds": milliseconds, "sending_milliseconds": sending,
            "packet_bytes": _PACKET, "frames_per_second": 1000 / (milliseconds + sending)}


def _sending_milliseconds(data):
    """Processor time of the stream channel for a picture of the bytes ``data``, (h, w, 3)."""
    height, width = data.shape[:2]
    frame = Frame(1, 0, BGR8, (width, height), (0, 0), memoryview(data).cast("B"), None, 0, None)
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as receiver:
        receiver.bind(("127.0.0.1", 0))
        stream = Stream(None, "127.0.0.1")
        to = Receiver(receiver.getsockname(), _PACKET, 0, False)
        try:
            return _milliseconds(lambda: stream.send_frame(frame, to, threading.Event()), _FRAMES)
        finally:
            stream.close()


def _opencv_milliseconds(raw, descriptor):
    tables = remap_tables(descriptor)
    with _one_thread():
        return _milliseconds(
            lambda: cv2.remap(demosaic(raw, descriptor.geometry.bayer, "vng"), *tables,
                              cv2.INTER_LINEAR, borderMode=cv2.BORDER_CONSTANT), _FRAMES)


@contextmanager
def _one_thread():
    """OpenCV uses one thread in the block."""
    threads = cv2.getNumThreads()
    cv2.setNumThreads(1)
    try:
        yield
    finally:
        cv2.setNumThreads(threads)


def _milliseconds(work, count):
    """Processor time of the fastest of ``count`` calls."""
    times = []
    for _ in range(count):
        begin = time.process_time()
        work()
        times.append(time.process_time() - begin)
    return 1000 * min(times)

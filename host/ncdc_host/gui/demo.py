"""Two emulated devices for a first look, in a process of their own: ``ncdc client gui --demo``.

    python -m ncdc_host.gui.demo

One shows the built-in scene in motion, the other one the page of dots of the built-in example, so
that it can be calibrated. Both have a network of few starts as lens 0 and 1, which is trained here.
Ends with its standard input. Prints a line for each step, then the URLs of the devices.
"""

import sys
import tempfile
from pathlib import Path

from ncdc_host.device.emulated import Announcer, DeviceOptions, EmulatedDevice, lens_corrections
from ncdc_model.example import BAYER, example_camera, target_photo
from ncdc_model.training.choices import TrainingChoices
from ncdc_model.training.pipeline import train_camera
from ncdc_model.training.source import load_source
from ncdc_spec.errors import InputError

__all__ = ["ADDRESSES", "main"]

ADDRESSES = "127.0.0.2", "127.0.0.3"
_FPS = 20.0
_LENSES = 8, 5          # hidden neurons
_NODES = 8              # pixels, of both
_STARTS = 4             # of the training, instead of 64: seconds, and a little less exact


def main():
    """Serve until standard input ends."""
    try:
        devices = _devices()
    except InputError as error:
        print(f"error {error}", flush=True)
        return 2
    announcer = Announcer(devices)
    print("ready", *(f"gige://{address}" for address in ADDRESSES), flush=True)
    sys.stdin.read()
    for one in (announcer, *devices):
        one.close()
    return 0


def _devices():
    camera = example_camera()
    print("step training two lenses", flush=True)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "camera.toml"
        camera.save(path)
        source = load_source(path, bayer=BAYER)
    choices = TrainingChoices(options={"starts": _STARTS}, nodes=_NODES)
    lenses = [train_camera(source, neurons, choices).descriptor for neurons in _LENSES]
    print("step photographing a page of dots", flush=True)
    corrections, devices = lens_corrections(lenses), []
    for k, (address, image) in enumerate(zip(ADDRESSES, (None, target_photo(camera)))):
        options = DeviceOptions(address, ("SCENE", "DOTS")[k], fps=_FPS)
        devices.append(EmulatedDevice(corrections, options, image))
    return devices


if __name__ == "__main__":
    sys.exit(main())

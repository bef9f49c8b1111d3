"""A process that chooses the pictures of a calibration from frames that the window sends.

    python -m ncdc_host.gui.live_job FOLDER --target auto

A frame on standard input is a line of JSON, {"shape": [h, w] or [h, w, 3], "seconds": s}, and the
bytes of its pixels. The answer to each is a line of JSON: {"state": report, "points": positions,
"outline": positions, "picture": path or null}; see :class:`LiveState`. The last one may be
{"error": sentence}.
"""

import argparse
import json
import math
import os
import sys
from pathlib import Path

import numpy as np

from ncdc_model.calibration.live.calibrator import LiveCalibrator
from ncdc_model.images import write_image
from ncdc_spec.errors import InputError

__all__ = ["main"]


def main(arguments=None, frames=None):
    """Run it on the stream ``frames``, by default standard input; returns the exit status."""
    parser = argparse.ArgumentParser(prog="live_job")
    parser.add_argument("folder", type=Path)
    parser.add_argument("--target", default="auto")
    args = parser.parse_args(arguments)
    if arguments is None and hasattr(os, "nice"):
        os.nice(5)          # the window and its pictures come first
    try:
        # What overflows becomes not-a-number, which the checks of the calibration name.
        with np.errstate(all="ignore"):
            _run(args, frames or sys.stdin.buffer)
    except InputError as error:
        print(json.dumps({"error": str(error)}), flush=True)
        return 2
    return 0


def _run(args, frames):
    calibrator = LiveCalibrator(args.target)
    while head := frames.readline():
        about = json.loads(head)
        content = frames.read(math.prod(about["shape"]))
        image = np.frombuffer(content, np.uint8).reshape(about["shape"])
        state, path = calibrator.look(image, about["seconds"]), None
        if state.seen == "taken":
            path = str(args.folder / f"{state.pictures:02d}.png")
            write_image(path, image)
        print(json.dumps({"state": state.report(), "points": state.points.round(1).tolist(),
                          "outline": state.wish.outline if state.wish else [], "picture": path}),
              flush=True)


if __name__ == "__main__":
    sys.exit(main())

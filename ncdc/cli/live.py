"""``ncdc calibrate --live``: pictures of the target, chosen from a running camera."""

import json
import sys
from contextlib import contextmanager
from pathlib import Path

from ncdc.terminal import say
from ncdc_host.client.errors import DeviceError
from ncdc_model.calibration.live.calibrator import MAX_PICTURES, LiveCalibrator
from ncdc_model.images import write_image
from ncdc_spec.errors import InputError
from ncdc_spec.files import read_bytes

__all__ = ["add_live", "compared", "pictures_of_live"]

_SEEN = {"nothing": "no target is seen", "moving": "the target moves",
         "blurred": "the target is blurred", "known": "a picture of this pose is there already",
         "wrong": "no lens explains this picture with the others", "waiting": "hold it still"}


def add_live(parser):
    """Declare the options."""
    group = parser.add_argument_group(
        "a running camera", "pictures are taken by themselves when the target stands still, until "
        "enough of the frame is covered; Ctrl-C ends it sooner")
    group.add_argument("--live", metavar="SOURCE",
                       help="camera:0 (of this PC), a film, or the URL of a device as "
                            "gige://192.168.1.20; the pictures go into a folder next to the points "
                            "file, as points.photos")
    group.add_argument("--pictures", type=int, default=MAX_PICTURES, metavar="N",
                       help=f"at most (default: {MAX_PICTURES})")
    group.add_argument("--states", metavar="FILE",
                       help="write the state after each frame as a line of JSON; - for stdout")
    parser.add_argument("--previous", metavar="FILE",
                        help="earlier calibration of this camera (descriptor, points or camera "
                             "file), from which the difference is measured")


def pictures_of_live(args):
    """Names of the pictures, written into a folder, and a report.

    Raises
    ------
    InputError
        If an option or the source is bad, the folder holds files already, or no picture was taken.
    """
    from ncdc_host.sources import frames_of  # takes a tenth of a second
    if args.photos:
        raise InputError(f"--live {args.live} takes its own pictures, {args.photos[0]} is one more")
    if not 1 <= args.pictures <= MAX_PICTURES:
        raise InputError(f"--pictures is {args.pictures}, the limits are 1 and {MAX_PICTURES}")
    if args.raw is not None or args.bits is not None:
        raise InputError(f"--{'raw' if args.bits is None else 'bits'} says how files are read, "
                         f"--live {args.live} reads none")
    if args.states == args.json == "-":
        raise InputError("--states - and --json - are given, standard output holds one of them")
    output = Path(args.output)
    folder = output.with_name(f"{output.stem}.photos")
    if folder.exists() and (not folder.is_dir() or any(folder.iterdir())):
        raise InputError(f"{folder} holds the pictures of an earlier run, choose another -o")
    if args.previous is not None:
        read_bytes(args.previous)       # an error comes before the work
    calibrator, names = LiveCalibrator(args.target, args.pictures), []
    with _states(args.states) as write, frames_of(args.live) as frames:
        state = _watched(calibrator, frames, write, folder, names)
    if not names:
        raise InputError(f"{args.live} shows no target that is still and sharp: no picture was "
                         f"taken")
    report = state.report()
    missing = [] if state.done else [_missing(state)]
    return names, {key: report[key] for key in ("covered", "coverage", "uncertainty_px")}, missing


def _watched(calibrator, frames, write, folder, names):
    """The last :class:`LiveState`; the names of its pictures are added to ``names``."""
    state, shown, start = None, "", None
    try:
        for number, (image, seconds) in enumerate(frames):
            start = seconds if start is None else start
            state = calibrator.look(image, seconds)
            if state.seen == "taken":
                names.append(str(folder / f"{state.pictures:02d}.png"))
                write_image(names[-1], image)
            write({"frame": number, "seconds": round(seconds - start, 3), **state.report()})
            if state.seen == "taken" or state.seen != shown:
                shown = state.seen
                say(f"{seconds - start:6.1f} s: {_text(state)}")
            if state.done:
                break
    except KeyboardInterrupt:
        say("ended")
    except (InputError, DeviceError) as error:
        if not names:
            raise
        say(str(error))         # the pictures are there
    if state is None:
        raise InputError("the source has no frame")
    return state


def _text(state):
    if state.seen != "taken":
        return _SEEN[state.seen]
    wish = "" if state.done or state.wish is None else (
        f"; wanted next: {state.wish.text}, which takes {100 * state.wish.gain:.0f} % off")
    return (f"picture {state.pictures}: {100 * state.covered:.0f} % of the frame covered, the map "
            f"is uncertain by {state.uncertainty_px:.3f} px{wish}")


def _missing(state):
    wish = "" if state.wish is None else (
        f"; a picture with the target at the {state.wish.text}, would reduce its uncertainty of "
        f"{state.uncertainty_px:.3f} px by {100 * state.wish.gain:.0f} %")
    one = state.pictures == 1
    return (f"the calibration is not complete: its {state.pictures} picture{'' if one else 's'} "
            f"cover{'s' if one else ''} {100 * state.covered:.0f} % of the frame{wish}")


@contextmanager
def _states(path):
    """Yield the function that writes a state as a line of JSON."""
    if path is None:
        yield lambda state: None
        return
    if path == "-":
        yield lambda state: print(json.dumps(state), file=sys.stdout, flush=True)
        return
    try:
        file = open(path, "w")
    except OSError as error:
        raise InputError(f"cannot write {path}: {error.strerror}") from error
    with file:
        yield lambda state: print(json.dumps(state), file=file, flush=True)


def compared(frame, previous):
    """Report entry, and a line of text, on the difference of an :class:`IdealFrame`'s lens from an
    earlier calibration; both empty without one."""
    if previous is None or frame is None:
        return {}, ""
    from ncdc_model.compare import difference_from  # takes a third of a second
    found = difference_from(frame.camera, previous)
    return {"difference_px": found}, (
        f"{previous} differs by {found['rms']:.3f} px rms, at most {found['max']:.2f} px at "
        f"({found['x']:.0f}, {found['y']:.0f}), apart from the view")

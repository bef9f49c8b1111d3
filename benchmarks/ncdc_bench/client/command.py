"""``ncdc bench client``: third-party clients and ours with emulated devices."""

import tempfile
from contextlib import ExitStack

from ncdc.cli.common import add_json, report_failures, write_report
from ncdc.terminal import Steps
from ncdc.text_table import text_table
from ncdc_bench.client.measure import (
    Case,
    Served,
    case_row,
    discovery_rows,
    killed_row,
    monitor_row,
)
from ncdc_model.calibration.camera_file import training_grid
from ncdc_model.lens import Camera
from ncdc_model.training.pipeline import train_camera
from ncdc_model.training.source import Source
from ncdc_spec.geometry import Geometry

__all__ = ["EXAMPLE", "HELP", "add_arguments", "complaints", "late", "run", "rows_of",
           "small_and_large", "table"]

HELP = ("viva-genicam, Aravis and the TCP client with emulated devices, each in a network of "
        "its own")
EXAMPLE = "ncdc bench client --quick --json -"
_NEURONS = 4
_DELAY_NS = 50_000
_CONTROL_SECONDS = 3.5          # until control is free: the heartbeat's 3 s and a bit


def add_arguments(parser):
    """Declare the command's arguments on an argparse parser."""
    parser.add_argument("--quick", action="store_true",
                        help="few frames, small pictures: half a minute")
    add_json(parser)


def run(args):
    """Measure and report; 1 if a row is not as it has to be."""
    rows = rows_of(args.quick, Steps("client"))
    if not write_report({"rows": rows}, args.json):
        print(table(rows))
    return report_failures("bench client", complaints(rows) + late(rows))


def small_and_large(quick=False):
    """Descriptors of two cameras: 640x480, and 1280x1024 unless ``quick``."""
    small = _trained(640, 480)
    return small, small if quick else _trained(1280, 1024)


def _trained(width, height):
    camera = Camera.from_dict({
        "width": width, "height": height, "f_distorted": 0.52 * width, "k": [.03, .01],
        "centre": [0.503 * width, 0.491 * height], "p": [.001, -.0006]})
    geometry = Geometry(*camera.frame.size, width, height)
    source = Source(training_grid(camera.back_map, geometry), geometry, back_map=camera.back_map,
                    provenance={"source": "bench client"})
    return train_camera(source, _NEURONS).descriptor


def rows_of(quick, step):
    """All rows; ``step(text)`` is called with the name of each measurement."""
    step("training two cameras")
    small, large = small_and_large(quick)
    few, some, many = (3, 3, 20) if quick else (50, 20, 300)
    rows = []
    with _served(small, count=3) as served:
        step("discovery")
        rows += discovery_rows(served, 3)
        for scheme in ("gige", "aravis", "tcp"):
            step(f"{scheme}: every feature, 3 devices at once")
            rows.append(case_row(served, Case(scheme, 3, few, every_feature=True,
                                              settings=_corrected(scheme, 15))))
    for loss in (0.01, 0.05):
        with _served(large, loss=loss) as served:
            for scheme in ("gige", "aravis"):
                step(f"{scheme}: {100 * loss:g} % of the packets lost")
                rows.append(case_row(served, Case(scheme, 1, some, loss,
                                                  settings=_corrected(scheme, 4))))
    with _served(small) as served:
        step("one controller, monitors")
        rows.append(monitor_row(served, some, 1 if quick else 4, _corrected("gige", 10)))
        step("controller killed")
        rows.append(killed_row(served))
    with _served(large, mtu=9000) as served:
        for scheme in ("gige", "aravis", "tcp"):
            step(f"{scheme}: raw frames, jumbo packets")
            rows.append(case_row(served, Case(
                scheme, 1, many, packet_size=9000,
                settings={"CorrectionEnable": 0, "AcquisitionFrameRate": 40})))
    step("done")
    return rows


def _corrected(scheme, rate):
    """Settings for corrected pictures; the packets of a frame are spread over its time.

    A receiver that waits for a processor loses what its socket cannot hold: 90 packets.
    """
    settings = {"CorrectionEnable": 1, "AcquisitionFrameRate": rate}
    return settings if scheme == "tcp" else {**settings, "GevSCPD": _DELAY_NS}


class _served:
    """:class:`Served` with a folder of its own."""

    def __init__(self, descriptor, **options):
        self._stack, self._descriptor, self._options = ExitStack(), descriptor, options

    def __enter__(self):
        folder = self._stack.enter_context(tempfile.TemporaryDirectory())
        return self._stack.enter_context(Served(folder, self._descriptor, **self._options))

    def __exit__(self, *error):
        return self._stack.__exit__(*error)


def complaints(rows):
    """Errors in the rows that do not depend on the machine's speed, a sentence each."""
    found = []
    for row in rows:
        name = f"{row['peer']}, {row['transport']}"
        if row.get("found", row["devices"]) < row["devices"]:
            found.append(f"{name}: {row['found']} of {row['devices']} devices found")
        if row.get("incomplete"):
            found.append(f"{name}, loss {row['loss']}: {row['incomplete']} frames incomplete")
        if row.get("wrong_pixels"):
            found.append(f"{name}, loss {row['loss']}: {row['wrong_pixels']} pixels are wrong")
        if row.get("features_read_back", 0) < row.get("features", 0):
            found.append(f"{name}: {row['features_read_back']} of {row['features']} features read "
                         "back")
        if row.get("writes_rejected", 0) < row.get("monitors", 0):
            found.append(f"{name}: a monitor could write")
    return found


def late(rows):
    """Exceeded times, a sentence each; they are meaningful on an idle machine only."""
    return [f"{row['peer']}, {row['transport']}: control is free after "
            f"{row['seconds_until_free']:.1f} s, {_CONTROL_SECONDS} is the limit"
            for row in rows if row.get("seconds_until_free", 0) > _CONTROL_SECONDS]


_COLUMNS = (("peer", ""), ("transport", ""),
            ("devices", "d"), ("found", "d"), ("frames", "d"), ("incomplete", "d"),
            ("wrong_pixels", "d"), ("features", "d"), ("features_read_back", "d"),
            ("resent", "d"), ("frames_per_second", ".1f"), ("loss", ".2f"),
            ("device_cpu_seconds", ".1f"), ("seconds_until_free", ".2f"))


def table(rows):
    """The rows as text."""
    return text_table([
        (name.replace("_", " "), lambda row, name=name, form=form: (
            format(row[name], form) if name in row else None)) for name, form in _COLUMNS],
        rows, left=2)

"""Live calibration by the window: from a film and from a device."""

import io
import json
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from cameras import barrel_descriptor
from guis import SECONDS, announced, tab_on, url_of
from live_camera import HAND_PICKED, SIZE, Hand, write_film
from ncdc_host.client import open_device
from ncdc_host.gui.calibration_dialog import CalibrationDialog
from ncdc_host.gui.live_dialog import LiveDialog
from ncdc_host.gui.live_job import main as job
from ncdc_host.gui.live_source import LiveSource
from ncdc_host.gui.source_reader import SourceReader
from ncdc_model.calibration.detect import detect_points
from ncdc_model.calibration.frame import ideal_frame
from ncdc_model.compare import difference_from
from ncdc_model.images import mosaic, read_image

LONG = 8 * SECONDS


@pytest.fixture(scope="module")
def photo():
    return Hand().photo(HAND_PICKED[0]).image


def answers(capsys):
    return [json.loads(line) for line in capsys.readouterr().out.splitlines()]


def test_the_job_takes_a_picture_of_frames(photo, tmp_path, capsys):
    raw = mosaic(photo)
    frames = b"".join(json.dumps({"shape": raw.shape, "seconds": k / 4}).encode() + b"\n"
                      + raw.tobytes() for k in range(4))
    assert job([str(tmp_path), "--target=chessboard:9x6"], io.BytesIO(frames)) == 0
    found = answers(capsys)
    assert [one["state"]["seen"] for one in found] == ["moving", "waiting", "taken", "known"]
    assert [one["picture"] for one in found] == [None, None, str(tmp_path / "01.png"), None]
    np.testing.assert_array_equal(read_image(tmp_path / "01.png"), raw)
    assert len(found[0]["points"]) == 54 and found[0]["outline"] == []
    assert len(found[2]["outline"]) == 4


def test_the_job_reports_an_error_and_its_status(tmp_path, capsys):
    assert job([str(tmp_path), "--target=board"], io.BytesIO(b"")) == 2
    assert "target is 'board'" in answers(capsys)[-1]["error"]


def test_a_source_that_is_none(qtbot):
    reader = SourceReader("nothing.txt")
    with qtbot.waitSignal(reader.ended, timeout=SECONDS) as ended:
        reader.start()
    assert "nothing.txt is no running source" in ended.args[0]


def test_a_dialog_without_frames_can_be_closed(qtbot):
    dialog = LiveDialog("camera:0")
    qtbot.addWidget(dialog)
    dialog.begin()
    dialog.trouble("The device rejects it.")
    assert dialog.state.text() == "The device rejects it."
    assert dialog.live.waits and not dialog.go_on.isEnabled()
    dialog.source_ended("camera:0 sends no frame any more")
    assert dialog.state.text() == "camera:0 sends no frame any more" and not dialog.live.running
    dialog.reject()


@pytest.mark.longer
def test_a_film(qtbot, tmp_path):
    pytest.importorskip("av")
    write_film(tmp_path / "clip.mp4", HAND_PICKED[:2])
    source = LiveSource(str(tmp_path / "clip.mp4"), None)
    live = source.dialog
    qtbot.addWidget(live)
    with qtbot.waitSignal(source.reader.ended, timeout=LONG):
        pass
    assert len(live.live.pictures) == 2 and "The film has ended" in live.state.text()
    assert live.covered.value() > 50 and "by 2 pictures" in live.uncertainty.text()
    drawn = live.view.grab().toImage()
    live.view.show_frame(live.view.image)
    assert drawn != live.view.grab().toImage()          # points, coverage and outline are painted
    live.go_on.click()
    dialog = source.dialog
    qtbot.addWidget(dialog)
    assert isinstance(dialog, CalibrationDialog) and len(dialog.job.photos) == 2
    assert all(read_image(path).shape == (*SIZE[::-1], 3) for path in dialog.job.photos)
    assert "clip.mp4 has no corrector" in dialog.file_only.text()
    compared_with_an_earlier_lens(qtbot, dialog, tmp_path / "earlier.toml")
    dialog.reject()


def compared_with_an_earlier_lens(qtbot, dialog, path):
    """The calibration of the pictures of ``dialog``, compared with a lens that is not the same."""
    lens = ideal_frame(detect_points([(path.name, read_image(path)) for path in map(
        Path, dialog.job.photos)], "chessboard:9x6")).camera
    first, *others = lens.radial.k
    replace(lens, radial=replace(lens.radial, k=(first + .02, *others))).save(path)
    expected = difference_from(lens, path)
    assert expected["rms"] > .2
    dialog.compare_with(str(path))
    dialog.target.setCurrentText("chessboard:9x6")
    dialog.neurons.setValue(4)
    dialog.run()
    qtbot.waitUntil(lambda: not dialog.job.running and dialog.start.isEnabled(), timeout=LONG)
    found = re.search(r"earlier.toml differs by ([\d.]+) px rms, ([\d.]+) px at most",
                      dialog.state.text())
    assert found, dialog.state.text()
    assert list(map(float, found.groups())) == pytest.approx(
        [expected["rms"], expected["max"]], rel=.02)


@pytest.mark.longer
def test_a_device(qtbot, photo):
    rough = barrel_descriptor(SIZE, SIZE, hidden_neurons=3)
    raw = mosaic(photo)
    with announced(descriptors=[rough], image=raw, fps=4.0) as [one]:
        with open_device(url_of(one, "tcp")) as other:
            other.set("ReverseX", True)         # pictures are those of the sensor all the same
        with tab_on(qtbot, url_of(one, "gige")) as tab:
            tab.loader.calibrate_live()
            live = tab.loader.dialog
            qtbot.waitUntil(lambda: len(live.live.pictures) == 1, timeout=LONG)
            np.testing.assert_array_equal(read_image(live.live.pictures[0]), raw)
            live.go_on.click()
            qtbot.waitUntil(lambda: isinstance(tab.loader.dialog, CalibrationDialog), timeout=LONG)
            dialog = tab.loader.dialog
            assert dialog.job.photos == live.live.pictures and dialog._limits is not None
            dialog.reject()
            # The device sends again what it sent before.
            qtbot.waitUntil(lambda: not tab.shown.frame.pixel_format.raw, timeout=LONG)
        with open_device(url_of(one, "tcp")) as other:
            assert other.get("ReverseX") and other.get("CorrectionEnable")

"""Lenses by the window: chosen, loaded from files good and bad, calibrated from the picture."""

from types import SimpleNamespace

import numpy as np
import pytest
from PySide6.QtGui import QImage

from cameras import barrel_descriptor
from devices import SIZE, small_lens
from guis import SECONDS, announced, pixels_of, tab_on, url_of
from ncdc_host.client import open_device
from ncdc_host.client.frame import Frame
from ncdc_host.gui.calibration import Calibration
from ncdc_host.gui.calibration_dialog import CalibrationDialog
from ncdc_host.gui.calibration_job import main as calibrate
from ncdc_host.gui.shown import Shown
from ncdc_model.calibration.detect import detect_points
from ncdc_model.correction import Correction
from ncdc_model.evaluate import evaluate_frame
from ncdc_model.example import BAYER, example_camera, noise_picture, target_photo, true_map
from ncdc_model.golden.corrector import correct
from ncdc_spec.descriptor import Descriptor
from ncdc_spec.pixel_formats import bayer_format

RAW = noise_picture(*SIZE)


def corrected_by(lens):
    return correct(lens, RAW).picture


def shows(tab, picture):
    return np.array_equal(tab.shown.frame.pixels, picture)


def test_another_lens_while_pictures_run(qtbot):
    lenses = [small_lens(), small_lens(seed=2)]
    with announced(descriptors=lenses) as [one], tab_on(qtbot, url_of(one, "gige")) as tab:
        assert tab.lenses.list.count() == 2 and shows(tab, corrected_by(lenses[0]))
        receiver = tab.session._receiver
        tab.lenses.list.setCurrentRow(1)
        qtbot.waitUntil(lambda: shows(tab, corrected_by(lenses[1])), timeout=SECONDS)
        assert tab.session._receiver is receiver        # the stream went on


def test_a_lens_file_replaces_the_chosen_lens(qtbot, tmp_path):
    other, path = small_lens(seed=9), tmp_path / "other.toml"
    other.save(path)
    with announced() as [one], tab_on(qtbot, url_of(one, "gige")) as tab:
        with qtbot.waitSignal(tab.session.lens_loaded, timeout=SECONDS):
            tab.loader.load(path)
        qtbot.waitUntil(lambda: shows(tab, corrected_by(other)), timeout=SECONDS)
        assert tab.lenses.list.item(0).text() == "Lens 0: other.toml"


def bad_files(folder):
    """(file, what the window says of it)."""
    (folder / "text.toml").write_text("this is = no descriptor [")
    (folder / "picture.toml").write_bytes(bytes(range(256)))
    small_lens(fill=(9, 9, 9)).save(folder / "fill.toml")
    barrel_descriptor(SIZE, SIZE, hidden_neurons=6).save(folder / "larger.toml")
    return [(folder / "text.toml", "text.toml"), (folder / "picture.toml", "picture.toml"),
            (folder / "none.toml", "none.toml"), (folder / "fill.toml", "FILL"),
            (folder / "larger.toml", "6 hidden neurons")]


def test_bad_lens_files_are_reported_and_change_nothing(qtbot, tmp_path):
    with announced() as [one], tab_on(qtbot, url_of(one, "gige")) as tab:
        for path, sentence in bad_files(tmp_path):
            tab.messages.clear()
            with qtbot.waitSignal(tab.session.rejected, timeout=SECONDS):
                tab.loader.load(path)
            assert sentence in tab.messages.text and "\n" not in tab.messages.text
        old = tab.shown
        qtbot.waitUntil(lambda: tab.shown is not old, timeout=SECONDS)
        assert shows(tab, corrected_by(small_lens()))
        assert tab.lenses.list.item(0).text() == "Lens 0"


def test_table_one_takes_no_lens_and_says_so(qtbot, tmp_path):
    small_lens(seed=9).save(tmp_path / "other.toml")
    with announced() as [one], tab_on(qtbot, url_of(one, "tcp")) as tab:
        with qtbot.waitSignal(tab.session.rejected, timeout=SECONDS):
            tab.loader.load(tmp_path / "other.toml")
        assert "only GVCP reaches" in tab.messages.text
        tab.loader.calibrate()
        qtbot.waitUntil(lambda: tab.loader.dialog is not None, timeout=SECONDS)
        dialog = tab.loader.dialog
        assert dialog._limits is None and "only GVCP reaches" in dialog.file_only.text()
        dialog.reject()


@pytest.fixture(scope="module")
def dots():
    """The raw frame of a page of dots through the example camera, and the camera."""
    camera = example_camera()
    return target_photo(camera), camera


@pytest.mark.longer
def test_calibrate_from_this_picture(qtbot, dots, tmp_path):
    raw, camera = dots
    size = raw.shape[1], raw.shape[0]
    rough = barrel_descriptor(size, size, hidden_neurons=3, bayer=BAYER, fill=(1, 2, 3))
    with announced(descriptors=[rough], image=raw, fps=2.0) as [one]:
        with open_device(url_of(one, "tcp")) as other:
            other.set("ReverseX", True)         # the lens is that of the frame as it is
            with tab_on(qtbot, url_of(one, "gige")) as tab:
                tab.loader.calibrate()
                qtbot.waitUntil(lambda: tab.loader.dialog is not None, timeout=SECONDS)
                dialog, shares = tab.loader.dialog, []
                assert dialog.neurons.maximum() == 3 and dialog.neurons.value() == 3
                assert np.array_equal(dialog._shown.frame.pixels, raw)
                dialog.job.progress.connect(lambda share, mse: shares.append(share))
                with qtbot.waitSignal(dialog.job.done, timeout=8 * SECONDS):
                    dialog.run()
                assert "373 points" in dialog.state.text()
                # Nothing is overwritten before the user says so.
                assert dialog.number.currentText() == "Lens 0 (active)"
                assert shows(tab, Correction(rough)(raw).picture[:, ::-1])
                assert dialog.load.isEnabled()
                with qtbot.waitSignal(tab.session.lens_loaded, timeout=SECONDS):
                    dialog.load.click()
                assert "lens 0 of the device now" in dialog.state.text()
                assert shares == sorted(shares) and len(shares) > 3
                dialog.save_lens(tmp_path / "net.toml")
                lens = Descriptor.load(tmp_path / "net.toml")
                assert lens.geometry == rough.geometry
                golden = Correction(lens)(raw).picture[:, ::-1]
                qtbot.waitUntil(lambda: shows(tab, golden), timeout=SECONDS)
                dialog.reject()
    # Three neurons are few; the lens of a mirrored frame errs by tens of pixels.
    back_map = true_map(camera, detect_points([("dots", raw)]).photos[0],
                        lens.provenance["homography"])
    assert evaluate_frame(lens, back_map)["map_error_fixed_px"]["mean"] < 3


@pytest.mark.longer
def test_a_picture_without_a_target(qtbot):
    with announced(fps=10.0) as [one], tab_on(qtbot, url_of(one, "gige")) as tab:
        tab.loader.calibrate()
        qtbot.waitUntil(lambda: tab.loader.dialog is not None, timeout=SECONDS)
        dialog = tab.loader.dialog
        with qtbot.waitSignal(dialog.job.failed, timeout=4 * SECONDS):
            dialog.run()
        assert "no photo shows the target" in dialog.state.text()
        assert dialog.start.isEnabled() and not dialog.keep.isEnabled()
        dialog.target.setCurrentText("chessbored:9x6")
        with qtbot.waitSignal(dialog.job.failed, timeout=4 * SECONDS):
            dialog.run()
        assert "target is 'chessbored:9x6'" in dialog.state.text()
        dialog.run()
        dialog.reject()                                 # in the middle of it
        assert not dialog.job.running
        old = tab.shown
        qtbot.waitUntil(lambda: tab.shown is not old, timeout=SECONDS)


def test_a_failed_detection_shows_no_points_of_an_earlier_one(qtbot, tmp_path):
    shown = Shown.of(Frame.of_bytes(RAW.tobytes(), SIZE, bayer_format("RGGB"), 1, 0))
    dialog = CalibrationDialog(shown, None, ["Lens 0"], 0)
    qtbot.addWidget(dialog)
    frame = pixels_of(dialog.picture.pixmap().toImage())
    overlay = tmp_path / "points.png"
    assert QImage(64, 48, QImage.Format.Format_RGB32).save(str(overlay))
    dialog.job.points_found.emit(99, "dots", str(overlay))
    assert not np.array_equal(pixels_of(dialog.picture.pixmap().toImage()), frame)
    dialog.run()
    dialog.job.failed.emit("no photo shows the target")
    assert np.array_equal(pixels_of(dialog.picture.pixmap().toImage()), frame)
    assert not dialog.load.isEnabled() and not dialog.keep.isEnabled()


def test_the_picture_leaves_space_for_a_long_result(qtbot):
    shown = Shown.of(Frame.of_bytes(RAW.tobytes(), SIZE, bayer_format("RGGB"), 1, 0))
    dialog = CalibrationDialog(shown, None, ["Lens 0"], 0)
    qtbot.addWidget(dialog)
    dialog.show()
    before = dialog.picture.height()
    report = {"warnings": ["the page may be bent or of two sheets, or the lens is uneven " * 6],
              "mean_px": 0.1, "max_px": 0.5, "valid_percent": 99}
    dialog.job.done.emit("net.toml", report)
    qtbot.waitUntil(lambda: dialog.picture.height() < before, timeout=SECONDS)
    seen, space = dialog.picture.pixmap().deviceIndependentSize(), dialog.picture.size()
    assert seen.width() <= space.width() and seen.height() <= space.height()
    state = dialog.state
    assert state.height() >= state.heightForWidth(state.width())


def test_another_lens_than_the_active_one_can_be_replaced(qtbot):
    shown = Shown.of(Frame.of_bytes(RAW.tobytes(), SIZE, bayer_format("RGGB"), 1, 0))
    limits = SimpleNamespace(neurons=8)
    dialog = CalibrationDialog(shown, limits, ["Lens 0: a.toml", "Lens 1"], 0)
    qtbot.addWidget(dialog)
    wanted = []
    dialog.lens_wanted.connect(lambda path, number: wanted.append((path, number)))
    report = {"warnings": [], "mean_px": 0.1, "max_px": 0.5, "valid_percent": 99}
    dialog.job.done.emit("net.toml", report)
    assert wanted == []
    dialog.number.setCurrentIndex(1)
    dialog.load.click()
    assert wanted == [("net.toml", 1)] and not dialog.load.isEnabled()
    dialog.trouble("The device has gone.")
    assert dialog.load.isEnabled() and "not loaded: The device" in dialog.state.text()


@pytest.mark.longer
def test_a_job_that_breaks_is_reported(qtbot):
    job = Calibration()
    with qtbot.waitSignal(job.failed, timeout=4 * SECONDS) as failed:
        job.start("auto", 8, "RGGB")                    # without a photo
    assert "photo.raw.png" in failed.args[0]
    with qtbot.waitSignal(job.failed, timeout=4 * SECONDS) as failed:
        job.start("auto", "many", "RGGB")
    assert "ended unexpectedly" in failed.args[0]


def test_the_job_reports_an_error_and_its_status(tmp_path, capsys):
    assert calibrate([str(tmp_path / "none.png"), str(tmp_path)]) == 2
    assert '"error"' in capsys.readouterr().out.splitlines()[-1]

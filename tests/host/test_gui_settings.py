"""Every setting of the window changes the device, and is read back over the other transport."""

import pytest
from PySide6.QtCore import QPoint, QPointF, Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QAbstractSpinBox, QComboBox, QSlider

from devices import small_lens
from guis import SECONDS, announced, other_transport, tab_on, url_of
from ncdc_host.client import open_device
from ncdc_host.client.device import FeatureInfo
from ncdc_host.gui.number_editor import NumberEditor
from ncdc_host.gui.settings_panel import SettingsPanel


def type_in(editor, text):
    """Type a number as a user does, and leave the box by Enter."""
    editor.box.setFocus()
    editor.box.selectAll()
    QTest.keyClicks(editor.box, text)
    QTest.keyClick(editor.box, Qt.Key.Key_Return)


def choose(box, data):
    """Choose an entry of a combo box as a user does."""
    index = box.findData(data)
    assert index >= 0
    box.setCurrentIndex(index)
    box.activated.emit(index)


def steps(tab):
    """(feature, what the user does, value that the device then has)."""
    panel = tab.settings
    line_us = tab.infos["LineTime"].value / 1000
    return [
        ("ExposureTime", lambda: type_in(panel.shutter, "321"), 321 * line_us),
        ("ExposureTime", lambda: type_in(panel.exposure, "2"), round(2000 / line_us) * line_us),
        ("Gain", lambda: type_in(panel.gain, "2.625"), 2.625),
        ("AcquisitionFrameRate", lambda: type_in(panel.speed, "50"), 50),
        ("TestPattern", lambda: choose(panel.pattern, "HorizontalBars"), "HorizontalBars"),
        ("PixelFormat", lambda: choose(panel.format, "Mono8"), "Mono8"),
        ("Width", lambda: type_in(panel.window["Width"], "40"), 40),
        ("Height", lambda: type_in(panel.window["Height"], "24"), 24),
        ("OffsetX", lambda: type_in(panel.window["OffsetX"], "10"), 10),
        ("OffsetY", lambda: type_in(panel.window["OffsetY"], "8"), 8),
        ("Width", lambda: choose(panel.size, "Half"), 32),
        ("OffsetX", lambda: None, 16), ("OffsetY", lambda: None, 12),
        ("Width", lambda: choose(panel.size, "Whole picture"), 64),
        ("ReverseX", lambda: panel.mirror["ReverseX"].click(), True),
        ("ReverseY", lambda: panel.mirror["ReverseY"].click(), True),
        ("LensSelector", lambda: tab.lenses.list.setCurrentRow(1), 1),
        ("CorrectionEnable", lambda: tab.bar.modes["before"].click(), False),
        ("CorrectionEnable", lambda: tab.bar.modes["after"].click(), True)]


@pytest.mark.parametrize("scheme", ["gige", "tcp"])
def test_every_setting_is_read_back_over_the_other_transport(qtbot, scheme):
    other_scheme, monitor = other_transport(scheme)
    with announced(descriptors=[small_lens(), small_lens(seed=2)]) as [one]:
        with tab_on(qtbot, url_of(one, scheme)) as tab, \
                open_device(url_of(one, other_scheme), monitor) as other:
            for name, act, value in steps(tab):
                act()
                qtbot.waitUntil(lambda: other.get(name) == pytest.approx(value)
                                if isinstance(value, float) else other.get(name) == value,
                                timeout=SECONDS)
                # What the window shows is what the device has.
                qtbot.waitUntil(lambda: tab.infos[name].value == other.get(name), timeout=SECONDS)
            assert tab.messages.text == ""
            before = tab.shown.frame.time_ns
            qtbot.waitUntil(lambda: tab.shown.frame.time_ns > before, timeout=SECONDS)


def test_automatic_features_are_chosen_and_lock_the_editors(qtbot):
    with announced() as [one], tab_on(qtbot, url_of(one, "gige")) as tab, \
            open_device(url_of(one, "gige"), monitor=True) as other:
        panel = tab.settings
        for name, editors in (("ExposureAuto", (panel.shutter, panel.exposure)),
                              ("GainAuto", (panel.gain,)), ("BalanceWhiteAuto", ())):
            for mode in ("Continuous", "Off"):
                choose(panel.auto[name], mode)
                qtbot.waitUntil(lambda: other.get(name) == mode, timeout=SECONDS)
                qtbot.waitUntil(lambda: all(e.isEnabled() == (mode == "Off") for e in editors),
                                timeout=SECONDS)
        # Once ends by itself, and the window shows it.
        choose(panel.auto["ExposureAuto"], "Once")
        qtbot.waitUntil(lambda: tab.infos["ExposureAuto"].value == "Off"
                        and panel.auto["ExposureAuto"].currentData() == "Off"
                        and panel.shutter.isEnabled(), timeout=SECONDS)


def test_features_that_a_device_lacks_are_hidden(qtbot):
    with announced() as [one], tab_on(qtbot, url_of(one, "tcp")) as tab:
        assert all(box.isHidden() for box in tab.settings.auto.values())


def test_what_another_user_changes_is_shown(qtbot):
    with announced() as [one], tab_on(qtbot, url_of(one, "gige")) as tab, \
            open_device(url_of(one, "tcp")) as other:
        other.set("Gain", 3.5)
        other.set("TestPattern", "ColorBar")
        qtbot.waitUntil(lambda: tab.settings.gain.value == 3.5, timeout=SECONDS)
        assert tab.settings.pattern.currentData() == "ColorBar"


def test_correction_switched_off_by_another_user_is_shown(qtbot):
    with announced() as [one], tab_on(qtbot, url_of(one, "tcp")) as tab, \
            open_device(url_of(one, "tcp")) as other:
        assert tab.mode == "after"
        other.set("CorrectionEnable", False)
        qtbot.waitUntil(lambda: tab.mode == "before", timeout=SECONDS)
        assert tab.bar.modes["before"].isChecked()
        assert tab.settings.format.currentData().startswith("Bayer")


def test_a_rejected_value_is_reported_and_taken_back(qtbot):
    with announced() as [one], tab_on(qtbot, url_of(one, "gige")), \
            tab_on(qtbot, url_of(one, "tcp")) as tab:
        # Another user streams over GVSP: sizes are locked.
        type_in(tab.settings.window["Width"], "40")
        qtbot.waitUntil(lambda: "locked while pictures stream" in tab.messages.text,
                        timeout=SECONDS)
        qtbot.waitUntil(lambda: tab.settings.window["Width"].value == 64, timeout=SECONDS)


def float_info(name, value, low, high):
    return FeatureInfo(name, "float", value, True, low, high)


def test_older_values_do_not_overwrite_newer_ones(qtbot):
    panel = SettingsPanel()
    qtbot.addWidget(panel)
    panel.show_features({"Gain": float_info("Gain", 1.0, 1, 7.875)})
    panel.wait_for("Gain", 7)
    panel.gain.box.setValue(2.0)
    panel.show_features({"Gain": float_info("Gain", 1.0, 1, 7.875)})
    assert panel.gain.value == 2.0
    panel.written("Gain", 6)            # of an earlier change
    assert panel.gain.value == 2.0
    panel.show_features({"Gain": float_info("Gain", 1.5, 1, 7.875)})
    panel.written("Gain", 7)
    assert panel.gain.value == 1.5


def test_showing_a_value_is_no_edit(qtbot):
    for slider in ("", "linear", "log"):
        editor = NumberEditor("x", 3, "ms", slider)
        qtbot.addWidget(editor)
        edits = []
        editor.edited.connect(edits.append)
        editor.show_value(5, 1, 10, 1)
        editor.show_value(50, 1, 100, 1)
        assert edits == [] and editor.value == 50
        if slider:
            editor.slider.setValue(0)
            editor.slider.setValue(1000)
            assert edits == [1, 100]


def test_the_wheel_passes_over_what_was_not_clicked(qtbot):
    """A wheel of the system, which gives the focus to widgets that want it."""
    panel, edits = SettingsPanel(), []
    qtbot.addWidget(panel)
    auto = FeatureInfo("ExposureAuto", "enumeration", "Once", True,
                       choices=("Off", "Once", "Continuous"))
    panel.show_features({"ExposureAuto": auto, "Gain": float_info("Gain", 2, 1, 8),
                         "Pan": float_info("Pan", 5, 1, 10)})
    panel.changed.connect(lambda *change: edits.append(change))
    with qtbot.waitActive(panel):
        panel.show()
    panel.focusWidget().clearFocus()        # what a window of this panel alone begins with

    def turn(widget):
        centre = QPointF(widget.rect().center())
        QTest.wheelEvent(panel.windowHandle(), widget.mapTo(panel, centre), QPoint(0, -120))

    box = panel.auto["ExposureAuto"]
    widgets = [one for kind in (QComboBox, QAbstractSpinBox, QSlider)
               for one in panel.findChildren(kind) if one.isVisible()]
    assert box in widgets and panel.gain.slider in widgets and panel.looks["Pan"].box in widgets
    for widget in widgets:
        turn(widget)
        assert edits == [] and not widget.hasFocus()
    box.setFocus(Qt.FocusReason.MouseFocusReason)
    turn(box)
    assert edits == [("ExposureAuto", "Continuous")]


def test_a_shutter_longer_than_the_slider_is_shown_in_full(qtbot):
    panel = SettingsPanel()
    qtbot.addWidget(panel)
    line = FeatureInfo("LineTime", "integer", 16000, False)
    panel.show_features({"LineTime": line,
                         "ExposureTime": float_info("ExposureTime", 3e6, 16, 1.6e7)})
    assert panel.exposure.value == 3000 and panel.shutter.value == 187500


def test_the_exposure_box_keeps_every_digit(qtbot):
    panel = SettingsPanel()
    qtbot.addWidget(panel)
    box, seen = panel.exposure.box, []
    panel.exposure.edited.connect(seen.append)
    panel.exposure.show_value(0.009688, 0.000001, 10_000, 0.009688)
    assert box.value() == 0.009688 and box.text() == "0.009688 ms" and seen == []
    type_in(panel.exposure, "1.234567")
    assert seen == [1.234567]
    panel.exposure.show_value(2, 0.000001, 10_000, 0.01)
    assert box.text() == "2.000 ms"


@pytest.mark.parametrize("decimals,high,typed,sent", [
    (6, 10_000, "20000", 10_000), (6, 10_000, "12345.678901", 10_000),
    (6, 10_000, "0.000001", 0.5), (0, 100, "500", 100), (0, 100, "0", 1)])
def test_a_number_beyond_its_limit_becomes_the_limit(qtbot, decimals, high, typed, sent):
    """None of its digits is dropped for it: 20000 would become 2000."""
    editor, seen = NumberEditor("x", decimals, "ms", "log" if decimals else ""), []
    qtbot.addWidget(editor)
    editor.edited.connect(seen.append)
    editor.show_value(5, .5 if decimals else 1, high, 1)
    type_in(editor, typed)
    assert seen == [sent] and editor.value == sent


def test_no_exposure_is_sent_that_the_device_cannot_have(qtbot):
    """Whole lines within the limits, although the limits are none; longer than the slider too."""
    panel, sent = SettingsPanel(), []
    qtbot.addWidget(panel)
    panel.changed.connect(lambda name, value: sent.append((name, value)))
    panel.show_features({"LineTime": FeatureInfo("LineTime", "integer", 16000, False),
                         "ExposureTime": float_info("ExposureTime", 3200, 40, 3.00001e6)})
    for typed, lines in (("0.04", 3), ("99999", 187_500), ("2000", 125_000)):
        type_in(panel.exposure, typed)
        assert sent.pop() == ("ExposureTime", lines * 16.0)
    assert "From 0.040" in panel.exposure.toolTip() and "ms" in panel.exposure.toolTip()
    type_in(panel.shutter, "1")
    assert sent.pop() == ("ExposureTime", 48.0)

"""How a device gets another lens: from a file, or from a calibration."""

from pathlib import Path

from PySide6.QtCore import QObject, Qt

from ncdc_host.gui.calibration_dialog import CalibrationDialog
from ncdc_host.gui.file_names import name_to_open
from ncdc_host.gui.live_dialog import LiveDialog

__all__ = ["LensLoader"]


class LensLoader(QObject):
    """Loads lenses into the device of a :class:`DeviceTab`.

    Attributes
    ----------
    dialog : CalibrationDialog, LiveDialog or None
        The one that is open.
    """

    def __init__(self, tab):
        super().__init__(tab)
        self.tab, self.session, self.lenses, self.dialog = tab, tab.session, tab.lenses, None
        self._live = None           # whose pictures are calibrated next
        self.lenses.load.clicked.connect(self.ask)
        self.lenses.calibrate.clicked.connect(self.calibrate)
        self.session.lens_loaded.connect(self._loaded)

    def ask(self):
        """Ask for a lens file, and load it into the lens that is chosen."""
        number = self.lenses.active
        path = name_to_open(self.tab, "Load lens file", "Lens files (*.toml);;All files (*)")
        if path:
            self.load(path, number)

    def load(self, path, number=None, name=""):
        """Load a lens file into lens ``number``, or into the one that is chosen."""
        number = self.lenses.active if number is None else number
        self.session.load_lens(path, name or Path(path).name, number)

    def _loaded(self, number, name):
        self.lenses.name_lens(number, name)
        self.tab.said.emit(f"Lens {number} is {name} now")
        if isinstance(self.dialog, CalibrationDialog):
            self.dialog.lens_loaded(number)

    def calibrate(self):
        """Take a raw frame, and open the dialog that makes a lens of it."""
        self.session.take_still("calibrate", mirrored=False)

    def calibrate_live(self):
        """Take the pictures of a calibration from the stream, then open the same dialog on them."""
        self.close_dialog()
        live = self.dialog = LiveDialog(self.tab.name, self.tab)
        live.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self.tab.pictured.connect(self._look)
        live.complete.connect(self._pictures_taken)
        live.finished.connect(self._live_closed)
        self.session.stream_sensor(True)
        live.open()
        live.begin()

    def _look(self, shown):
        frame = shown.frame
        if frame.pixel_format.raw and self.dialog.live.waits:
            self.dialog.show_frame(frame.pixels, frame.time_ns / 1e9, frame.picture())

    def _live_closed(self):
        self.tab.pictured.disconnect(self._look)
        self.session.stream_sensor(False)
        self._dialog_closed()

    def _pictures_taken(self):
        self._live = self.dialog.live
        self._live.setParent(self)      # the dialog closes
        self.calibrate()

    def open_dialog(self, still):
        """Open the dialog on the frame that was taken."""
        self.close_dialog()
        dialog = self.dialog = CalibrationDialog(still.shown, still.limits, self.lenses.texts(),
                                                 self.lenses.active, still.reason, self.tab)
        dialog.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        dialog.photo_wanted.connect(self.session.save)
        self.session.saved.connect(dialog.photo_written)
        dialog.lens_wanted.connect(lambda path, number: self.load(path, number, "calibrated here"))
        dialog.finished.connect(self._dialog_closed)
        if self._live is not None:
            dialog.use_pictures(self._live)
            self._live = None
        dialog.open()

    def close_dialog(self):
        """Close the dialog, if there is one."""
        if self.dialog is not None:
            self.dialog.close()

    def _dialog_closed(self):
        self.dialog = None

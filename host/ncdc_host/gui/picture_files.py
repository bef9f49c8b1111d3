"""Pictures of a device as files, and on the clipboard."""

from PySide6.QtCore import QObject
from PySide6.QtGui import QGuiApplication

from ncdc_host.gui.file_names import name_to_save

__all__ = ["PictureFiles"]


class PictureFiles(QObject):
    """Saves and copies what a :class:`DeviceTab` shows."""

    def __init__(self, tab):
        super().__init__(tab)
        self.tab, self.session = tab, tab.session
        self._raw_path = None
        tab.bar.save.clicked.connect(self.ask_picture)
        self.session.saved.connect(lambda path: tab.said.emit(f"Saved {path}"))

    def ask_picture(self):
        """Ask for a name, and save the picture that is shown."""
        if self.tab.shown is None:
            return
        shown = self.tab.shown
        path = name_to_save(self.tab, "Save picture", f"picture-{shown.frame.number:06d}.png",
                            "Pictures (*.png *.bmp *.tif)")
        if path:
            self.save_picture(path, shown)

    def save_picture(self, path, shown=None):
        """Save the colours that are shown; of a raw frame, demosaiced."""
        self.session.save(path, (shown or self.tab.shown).frame.picture())

    def ask_raw(self):
        """Ask for a name, and save a raw frame."""
        number = self.tab.shown.frame.number if self.tab.shown else 0
        path = name_to_save(self.tab, "Save raw frame", f"frame-{number:06d}.raw.png",
                            "Raw frames, one channel (*.png)")
        if path:
            self.save_raw(path)

    def save_raw(self, path):
        """Take a raw frame, as ``ncdc correct`` wants it, and save it."""
        self._raw_path = path
        self.session.take_still("save", mirrored=False)

    def raw_taken(self, still):
        """Save the frame that was taken."""
        self.session.save(self._raw_path, still.shown.frame.pixels)

    def copy(self):
        """Put what is seen on the clipboard."""
        QGuiApplication.clipboard().setPixmap(self.tab.view.grab())
        self.tab.said.emit("The picture is on the clipboard")

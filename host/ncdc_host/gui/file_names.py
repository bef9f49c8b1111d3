"""Asks for names of files; the folder of the last one is where the next one is looked for."""

from pathlib import Path

from PySide6.QtCore import QSettings
from PySide6.QtWidgets import QFileDialog

__all__ = ["name_to_open", "name_to_save"]


def name_to_open(parent, title, kinds):
    """Path of a file that exists, or ""."""
    return _kept(QFileDialog.getOpenFileName(parent, title, _folder(), kinds))


def name_to_save(parent, title, name, kinds):
    """Path of a file to be written, ``name`` being proposed, or ""."""
    return _kept(QFileDialog.getSaveFileName(parent, title, str(Path(_folder()) / name), kinds))


def _folder():
    return QSettings().value("folder", str(Path.home()))


def _kept(answer):
    path, _ = answer
    if path:
        QSettings().setValue("folder", str(Path(path).parent))
    return path

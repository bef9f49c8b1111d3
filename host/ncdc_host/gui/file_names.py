"""Asks for names of files; the folder of the last one is where the next one is looked for."""

from pathlib import Path

from PySide6.QtCore import QSettings
from PySide6.QtWidgets import QFileDialog

__all__ = ["name_to_open", "name_to_save"]


def name_to_open(parent, title, kinds):
    """Path of a file that exists, or ""."""
    return _remembered(QFileDialog.getOpenFileName(parent, title, _folder(), kinds))


def name_to_save(parent, title, name, kinds):
    """Path of a file to be written, ``name`` being proposed, or ""."""
    path = str(Path(_folder()) / name)
    return _remembered(QFileDialog.getSaveFileName(parent, title, path, kinds))


def _folder():
    return QSettings().value("folder", str(Path.home()))


def _remembered(answer):
    """The path of Qt's answer; its folder is remembered."""
    path, _ = answer
    if path:
        QSettings().setValue("folder", str(Path(path).parent))
    return path

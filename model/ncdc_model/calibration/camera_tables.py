"""Camera files of other projects as plain dictionaries."""

import cv2
import numpy as np
import yaml

from ncdc_model.errors import InputError
from ncdc_model.files import read_bytes

__all__ = ["file_storage", "read_table"]


def read_table(path):
    """Content of a YAML, XML or JSON file: dict of numbers, strings, lists and dicts.

    OpenCV's FileStorage (a first line %YAML, or XML) is read by OpenCV, its matrices as
    arrays; any other YAML, ROS's among it, by PyYAML.

    Raises
    ------
    InputError
        If the file cannot be read or is neither.
    """
    content = read_bytes(path)
    try:
        text = content.decode("utf-8-sig")
        if text.startswith(("%YAML", "<?xml")):
            table = file_storage(text)
        else:
            table = yaml.safe_load(text)
    except (UnicodeDecodeError, yaml.YAMLError, cv2.error, SystemError, ValueError,
            RecursionError) as error:
        if isinstance(error, RecursionError):
            raise InputError("it is no camera file: it is nested too deep") from error
        reason = str(error.__cause__ or error).strip().splitlines()[-1].strip()
        raise InputError(f"it is no camera file: {reason}") from error
    if not isinstance(table, dict):
        raise InputError("it is no camera file: it holds no names and values")
    return table


def file_storage(text):
    """Content of OpenCV's FileStorage in ``text``: dict, its matrices as arrays.

    Raises
    ------
    cv2.error, SystemError
        If OpenCV cannot read it.
    """
    storage = cv2.FileStorage(text, cv2.FILE_STORAGE_READ | cv2.FILE_STORAGE_MEMORY)
    try:
        return _plain(storage.root())
    finally:
        storage.release()


def _plain(node):
    if node.isMap():
        if {"rows", "cols", "data"} <= set(node.keys()):
            return np.atleast_2d(node.mat())
        return {name: _plain(node.getNode(name)) for name in node.keys()}
    if node.isSeq():
        return [_plain(node.at(k)) for k in range(node.size())]
    if node.isString():
        return node.string()
    return None if node.isNone() or node.empty() else node.real()

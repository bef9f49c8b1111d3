"""Reads YAML, JSON and OpenCV's FileStorage as plain dictionaries."""

import json
import re

import cv2
import numpy as np
import yaml

from ncdc_spec.errors import InputError

__all__ = ["file_storage", "is_json", "table_of"]

# What takes some 10 seconds of CPU time: characters of YAML, PyYAML's aliases, of which each may
# double the table, and values of OpenCV's FileStorage outside of its matrices.
_LARGEST_YAML = 1 << 20
_MOST_ALIASES = 16
_MOST_VALUES = 20_000


def table_of(text):
    """Content of YAML, XML or JSON ``text``: dict of numbers, strings, lists and dicts.

    OpenCV's FileStorage (a first line %YAML, or XML) is read by OpenCV, its matrices as
    arrays; JSON by Python, and any other YAML, ROS's among it, by PyYAML. A YAML file of several
    documents, as ``rostopic echo`` prints them, is read if they differ in their header only. Tables
    in a list are named by their places, from 0.

    Raises
    ------
    InputError
        If it is none of these, holds a name twice, or documents that differ.
    """
    try:
        if text.startswith(("%YAML", "<?xml")):
            table = _opencv(text)
        elif is_json(text):
            table = _json(text)
        else:
            table = _yaml(text)
    except RecursionError as error:
        raise InputError("it is no camera file: it is nested too deep") from error
    except yaml.YAMLError as error:
        raise InputError(f"it is no camera file: {_in_words(error)}") from error
    except (cv2.error, SystemError) as error:
        raise InputError(f"it is no camera file: {_of_opencv(error)}") from error
    except ValueError as error:
        if isinstance(error, InputError):
            raise
        raise InputError(f"it is no camera file: {error}") from error
    if isinstance(table, list) and table and all(isinstance(part, dict) for part in table):
        table = {str(place): part for place, part in enumerate(table)}
    if not isinstance(table, dict):
        raise InputError("it is no camera file: it holds no names and values")
    return table


def is_json(text):
    """Whether ``text`` begins as a table or a list of tables in JSON."""
    return re.match(r"\s*(\[\s*)?\{", text) is not None


class _Loader(yaml.SafeLoader):
    """PyYAML's safe loader, which rejects a name that a mapping holds twice, and many aliases."""
    aliases = 0

    def compose_node(self, parent, index):
        self.aliases += self.check_event(yaml.AliasEvent)
        if self.aliases > _MOST_ALIASES:
            raise InputError(f"it holds more than {_MOST_ALIASES} aliases of YAML")
        return super().compose_node(parent, index)

    def construct_mapping(self, node, deep=False):
        seen = set()
        for key, _ in getattr(node, "value", ()):
            if isinstance(key, yaml.ScalarNode):
                if key.value in seen and key.value != "<<":
                    mark = key.start_mark
                    raise InputError(f"the name {key.value} stands in it twice, again in line "
                                     f"{mark.line + 1}, column {mark.column + 1}")
                seen.add(key.value)
        return super().construct_mapping(node, deep)


# Matrices of OpenCV in a file without its first line, %YAML.
_Loader.add_constructor("tag:yaml.org,2002:opencv-matrix",
                        lambda loader, node: loader.construct_mapping(node, deep=True))


def _yaml(text):
    if len(text) > _LARGEST_YAML:
        raise InputError(f"it is no camera file: it holds {len(text)} characters of YAML or other "
                         f"text, the limit is {_LARGEST_YAML}")
    documents = [part for part in yaml.load_all(text, _Loader) if part is not None]
    if len(documents) > 1:
        plain = [{name: value for name, value in part.items() if name != "header"}
                 if isinstance(part, dict) else part for part in documents]
        if any(part != plain[0] for part in plain):
            raise InputError(f"it holds {len(documents)} YAML documents that differ (split by "
                             f"lines of ---), one camera is needed")
    return documents[0] if documents else None


def _json(text):
    def unique(pairs):
        table = dict(pairs)
        if len(table) < len(pairs):
            names = [name for name, _ in pairs]
            twice = next(name for name in names if names.count(name) > 1)
            raise InputError(f"the name {twice} stands in it twice")
        return table
    try:
        table = json.loads(text, object_pairs_hook=unique)
    except json.JSONDecodeError as error:
        try:
            # Braces without quotes around the names are YAML.
            return _yaml(text)
        except yaml.YAMLError:
            raise InputError(f"it is no camera file: line {error.lineno}, column {error.colno}: "
                             f"{error.msg}") from error
    return file_storage(text) if '"opencv-matrix"' in text else table


def _opencv(text):
    # An end mark, which OpenCV takes for a name.
    try:
        return file_storage(re.sub(r"\n(---|\.\.\.)\s*\Z", "\n", text))
    except (cv2.error, SystemError):
        if not text.startswith("%YAML"):
            raise
        # YAML that OpenCV does not understand, or an error whose column PyYAML reports. The first
        # line becomes an empty one.
        return _yaml(text[text.index("\n"):]) if "\n" in text else {}


def _in_words(error):
    """Line, column and problem of PyYAML's ``error``."""
    mark = getattr(error, "problem_mark", None) or getattr(error, "context_mark", None)
    if mark is None:
        return " ".join(str(error).split())
    text = f"line {mark.line + 1}, column {mark.column + 1}: {error.problem or error.context}"
    start = getattr(error, "context_mark", None)
    if error.problem and error.context and start is not None:
        text += f" ({error.context} of line {start.line + 1}, column {start.column + 1})"
    return " ".join(text.replace("'<stream end>'", "the end of the file").split())


def _of_opencv(error):
    """Line and problem of OpenCV's ``error``."""
    reason = " ".join(str(error.__cause__ or error).split())
    found = re.search(r"'?\((\d+)\): (.*?)'?$", reason)
    return f"line {found[1]}: {found[2]}" if found else reason.rpartition(": ")[2]


def file_storage(text):
    """Content of OpenCV's FileStorage in ``text``: dict, its matrices as arrays.

    Raises
    ------
    cv2.error, SystemError
        If OpenCV cannot read it.
    InputError
        If it holds a name twice, or too many values.
    """
    # OpenCV takes true for 1; as text it is no number.
    text = re.sub(r"(?<=[\[,:\s])(true|false)(?=\s*[\],}\n])", r'"\1"', text, flags=re.I)
    storage = cv2.FileStorage(text, cv2.FILE_STORAGE_READ | cv2.FILE_STORAGE_MEMORY)
    try:
        return _plain(storage.root(), [_MOST_VALUES])
    finally:
        storage.release()


def _check_matrix(node):
    """Whether a matrix holds values. One with more than its size is rejected: OpenCV would write
    past its end."""
    kind, data = node.getNode("dt"), node.getNode("data")
    channels = re.fullmatch(r"(\d*)[ucwsifdhUIBb]", kind.string() if kind.isString() else "")
    sides = [node.getNode(name) for name in ("rows", "cols")]
    if channels is None or not all(side.isInt() for side in sides):
        raise InputError("a matrix lacks its type, or a whole number of rows and columns")
    rows, columns = (int(side.real()) for side in sides)
    count = data.size() if data.isSeq() else int(not data.empty())
    if not rows * columns:
        return False
    if count != rows * columns * int(channels[1] or 1) or min(rows, columns) < 0:
        raise InputError(f"a matrix of {rows} rows and {columns} columns has {count} values")
    return True


def _plain(node, room):
    """Content of ``node``; ``room`` is the list of the number of values that may yet come."""
    room[0] -= 1 if node.isMap() else node.size()
    if room[0] < 0:
        raise InputError(f"it holds more than {_MOST_VALUES} values outside of its matrices")
    if node.isMap():
        names = node.keys()
        if {"rows", "cols", "data"} <= set(names):
            return np.atleast_2d(node.mat()) if _check_matrix(node) else np.zeros((0, 0))
        if len(set(names)) < len(names):
            twice = next(name for name in names if names.count(name) > 1)
            raise InputError(f"the name {twice} stands in it twice")
        return {name: _plain(node.getNode(name), room) for name in names}
    if node.isSeq():
        return [_plain(node.at(k), room) for k in range(node.size())]
    if node.isString():
        return node.string()
    return None if node.isNone() or node.empty() else node.real()

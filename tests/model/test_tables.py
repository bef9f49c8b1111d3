"""Tables of YAML, JSON and FileStorage: what is wrong is said by line, column and in words."""

import json

import cv2
import numpy as np
import pytest

from ncdc_model.calibration.files.lens import numbers
from ncdc_model.calibration.files.tables import table_of
from ncdc_spec.errors import InputError


@pytest.mark.parametrize("text,message", [
    ("a: [1, 2\n", r"line 2, column 1: expected ',' or '\]', but got the end of the file "
                   r"\(while parsing a flow sequence of line 1, column 4\)"),
    ("a: 1\n\tb: 2\n", r"line 2, column 1: found character '\\t' that cannot start any token"),
    ("a: 1\n b: : 2\n", "line 2, column 3: mapping values are not allowed here"),
    ("a: @x\n", "line 1, column 4: found character '@' that cannot start any token"),
    ("a: \"x\n", "line 2, column 1: found unexpected end of stream"),
    ("%YAML:1.0\n---\na: [1, 2\n", r"line 4, column 1: expected ',' or '\]'"),
    ("%YAML:1.0\n---\na: {b: 1\n", "line 4, column 1: expected ',' or '}'"),
    ("<?xml version='1.0'?>\n<opencv_storage><a>1</a><b></opencv_storage>",
     "line 2: Mismatched closing tag"),
    ('{"a": 1,\n "b": [}', "line 2, column 8: Expecting value"),
    ('{"a": [1, 2]', "line 1, column 13: Expecting ',' delimiter"),
    ("a: 1\nb: 2\na: 3\n", "the name a stands in it twice, again in line 3, column 1"),
    ("c:\n  a: 1\n  a: 3\n", "the name a stands in it twice, again in line 3, column 3"),
    ("%YAML:1.0\n---\na: 1\na: 2\n", "the name a stands in it twice"),
    ('{"a": 1, "b": {"c": 1, "c": 2}}', "the name c stands in it twice"),
    ("%YAML:1.0\n---\nK: !!opencv-matrix\n   rows: 3\n   cols: 1\n   dt: d\n"
     "   data: [ 1., 2., 3., 4. ]\n",
     "a matrix of 3 rows and 1 columns has 4 values"),
    ("%YAML:1.0\n---\nK: !!opencv-matrix\n   rows: x\n   cols: 1\n   dt: d\n   data: [1.]\n",
     "lacks its type, or a whole number of rows"),
    ("a: 1\n---\na: 2\n---\na: 1\n", "holds 3 YAML documents that differ"),
    ("", "holds no names and values"), ("---\n", "holds no names and values"),
    ("- 1\n- 2\n", "holds no names and values"),
])
def test_mistakes_are_named(text, message):
    with pytest.raises(InputError, match=message) as caught:
        table_of(text)
    assert "\n" not in str(caught.value) and not str(caught.value).endswith("^")


@pytest.mark.parametrize("text", [
    "a: 1\nb: [2, 3]\n---\n", "---\na: 1\nb: [2, 3]\n...\n", "{a: 1, b: [2, 3]}\n",
    "header: {seq: 1}\na: 1\nb: [2, 3]\n---\nheader: {seq: 2}\na: 1\nb: [2, 3]\n---\n",
    "%YAML:1.0\n---\na: 1\nb: [2, 3]\n---\n", "%YAML 1.0\n---\na: 1\nb: [2, 3]\n...\n",
    json.dumps({"a": 1, "b": [2, 3]}),
    "<?xml version='1.0'?><opencv_storage><a>1</a><b>2 3</b></opencv_storage>"])
def test_end_marks_and_documents_alike_are_one_table(text):
    table = table_of(text)
    assert table["a"] == 1 and table["b"] == [2, 3]


@pytest.mark.parametrize("text", [
    "%YAML:1.0\n---\nK: !!opencv-matrix\n   rows: 1\n   cols: 2\n   dt: d\n   data: [1., 2.]\n",
    "K: !!opencv-matrix\n   rows: 1\n   cols: 2\n   dt: d\n   data: [1., 2.]\n",
    "%YAML 1.2\n---\nK: {rows: 1, cols: 2, data: [1.0,\n 2.0]}\nname: 'it''s'\n"])
def test_matrices_of_opencv_with_and_without_its_first_line(text):
    assert numbers(table_of(text)["K"], "K").tolist() == [1, 2]


@pytest.mark.parametrize("end", ["yml", "xml", "json"])
def test_what_opencv_writes_is_what_is_read(tmp_path, end):
    arrays = {"a": np.eye(3), "b": np.full((9, 8), 1.5, np.float32), "c": np.zeros((0, 0)),
              "d": np.arange(128, dtype=np.int16).reshape(8, 8, 2), "e": np.ones((1, 5))}
    storage = cv2.FileStorage(str(tmp_path / f"x.{end}"), cv2.FILE_STORAGE_WRITE)
    for name, array in arrays.items():
        storage.write(name, array)
    storage.release()
    table = table_of((tmp_path / f"x.{end}").read_text())
    for name, array in arrays.items():
        np.testing.assert_array_equal(table[name], array)

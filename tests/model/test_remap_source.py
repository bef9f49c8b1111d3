"""Maps from elsewhere: tables for OpenCV's ``remap`` become the exact map of a training."""

import cv2
import numpy as np
import OpenEXR
import pytest
import tifffile

from ncdc_model.calibration.camera_file import training_grid
from ncdc_model.calibration.remap_file import read_remap
from ncdc_model.calibration.remap_source import load_remap
from ncdc_model.training.source import load_source
from ncdc_spec.errors import InputError
from stereo import stereo_maps

SIZE = WIDTH, HEIGHT = 160, 128
X, Y = stereo_maps(*SIZE)[0]
V, U = np.indices((HEIGHT, WIDTH)).astype(np.float32)


def file_storage(path, **arrays):
    storage = cv2.FileStorage(str(path), cv2.FILE_STORAGE_WRITE)
    for name, array in arrays.items():
        storage.write(name, array)
    storage.release()
    return [path]


def two_pictures(folder, suffix):
    paths = [folder / f"{name}{suffix}" for name in "xy"]
    for path, table in zip(paths, (X, Y)):
        if suffix == ".exr":
            OpenEXR.File({"type": OpenEXR.scanlineimage}, {"Y": table}).write(str(path))
        elif suffix == ".npy":
            np.save(path, table)
        else:
            assert cv2.imwrite(str(path), table)
    return paths


def numpy_file(folder, **arrays):
    np.savez(folder / "map.npz", **arrays)
    return [folder / "map.npz"]


FIXED = dict(zip(("map1", "map2"), cv2.convertMaps(X, Y, cv2.CV_16SC2)))
FILES = {
    "npz": lambda folder: numpy_file(folder, map_x=X, map_y=Y),
    "double": lambda folder: numpy_file(folder, mapx=X.astype(float), mapy=Y.astype(float)),
    "two channels": lambda folder: numpy_file(folder, map1=np.dstack([X, Y]), map2=np.empty(0)),
    **{suffix: lambda folder, suffix=suffix: two_pictures(folder, suffix)
       for suffix in (".npy", ".tif", ".tiff", ".exr")},
    **{suffix: lambda folder, suffix=suffix: file_storage(folder / f"map{suffix}", MAPX=X, MAPY=Y)
       for suffix in (".yml", ".xml", ".json")},
    "two yml": lambda folder: [*file_storage(folder / "1.yml", map=X),
                               *file_storage(folder / "2.yml", map=Y)]}


@pytest.mark.parametrize("make", FILES.values(), ids=list(FILES))
def test_every_container_gives_the_same_map(tmp_path, make):
    paths = make(tmp_path)
    read = load_source(paths if len(paths) > 1 else paths[0], sensor=SIZE)
    x, y = read.back_map(U, V)
    known = np.isfinite(x)
    assert known.mean() > .99
    np.testing.assert_array_equal(x[known], X[known])
    np.testing.assert_array_equal(y[known], Y[known])
    assert read.geometry.corrected == read.geometry.distorted == SIZE


@pytest.mark.parametrize("suffix", [".npz", ".yml"])
def test_fixed_point_maps_are_read_to_a_64th_of_a_pixel(tmp_path, suffix):
    paths = numpy_file(tmp_path, **FIXED) if suffix == ".npz" else \
        file_storage(tmp_path / "map.yml", **FIXED)
    read = load_remap(paths, SIZE)
    assert read.model == "fixed-point remap tables" and not read.warnings
    for table, truth in ((read.x, X), (read.y, Y)):
        error = np.abs(table - truth)[np.isfinite(table)]
        assert .01 < error.max() <= 1 / 64 + 1e-5


def test_sensor_of_the_file_and_of_the_call(tmp_path):
    paths = numpy_file(tmp_path, map_x=X, map_y=Y, sensor=(200, 150))
    assert load_remap(paths).geometry.distorted == (200, 150)
    stored = file_storage(tmp_path / "map.yml", map_x=X, map_y=Y,
                          sensor=np.array([200, 150], np.int32))
    assert load_remap(stored, (200, 150)).geometry.distorted == (200, 150)
    with pytest.raises(InputError, match="the sensor has 160x128 pixels, the map of .*map.npz is "
                                         "for 200x150"):
        load_remap(paths, SIZE)


def test_one_of_several_maps_is_chosen_by_its_name(tmp_path):
    right = stereo_maps(*SIZE)[1]
    names = {"map11": X, "map12": Y, "map21": right[0], "map22": right[1]}
    by_number = numpy_file(tmp_path, **names)
    by_name = file_storage(tmp_path / "s.yml", stereoMapL_x=X, stereoMapL_y=Y, K1=np.eye(3),
                           K2=np.eye(3), stereoMapR_x=right[0], stereoMapR_y=right[1])
    for paths, left, other in ((by_number, "map11", "map21"), (by_name, "MapL", "stereoMapR_x")):
        for camera, truth in ((left, (X, Y)), (other, right)):
            read = load_remap(paths, SIZE, camera)
            on = np.isfinite(read.x)
            np.testing.assert_array_equal(read.x[on], truth[0][on])
            np.testing.assert_array_equal(read.y[on], truth[1][on])
    with pytest.raises(InputError, match="holds the maps map11 and map21, --camera must name one"):
        load_remap(by_number, SIZE)
    for camera, many in (("middle", "no"), ("map", 2)):
        with pytest.raises(InputError, match=f"camera {camera} is asked for, .* holds {many} such"):
            load_remap(by_number, SIZE, camera)


@pytest.mark.parametrize("mark", [-1, 0, -16, 65535, 1e30])
def test_marked_pixels_are_not_trained_on(tmp_path, mark):
    blank = np.hypot(U - 90, V - 60) > 70
    x, y = (np.where(blank, np.float32(mark), table) for table in (X, Y))
    source = load_source(numpy_file(tmp_path, map_x=x, map_y=y)[0], sensor=SIZE)
    u, v, a, b = source.pairs
    assert len(u) > 1000 and not source.facts["warnings"]
    row, column = np.round(v).astype(int), np.round(u).astype(int)
    assert not blank[row, column].any()
    # Half a pixel from the tables' own values at most, whose steps are shorter than 1.5 pixels.
    assert np.hypot(a - X[row, column], b - Y[row, column]).max() < 1.1
    x, _ = source.back_map(U, V)
    np.testing.assert_array_equal(np.isnan(x) | blank, np.isnan(x))
    assert np.isfinite(x[~blank]).mean() > .99


def test_between_pixels_the_map_is_linear_and_a_missing_neighbour_does_not_reach_a_pixel(tmp_path):
    x = X.copy()
    x[:, 100:] = -1
    read = load_remap(numpy_file(tmp_path, map_x=x, map_y=Y), SIZE)
    a, b = read.back_map([40.25, 99.0, 99.5, 40.0], [30.5, 30.0, 30.0, HEIGHT - 1])
    assert a[0] == pytest.approx(np.mean([.75 * x[r, 40] + .25 * x[r, 41] for r in (30, 31)]))
    assert b[0] == pytest.approx(np.mean([.75 * Y[r, 40] + .25 * Y[r, 41] for r in (30, 31)]))
    assert a[1] == x[30, 99] and np.isnan(a[2]) and a[3] == x[-1, 40]


def test_a_map_that_goes_on_beyond_the_sensor_is_reported(tmp_path):
    x, y = stereo_maps(*SIZE, alpha=1)[0]
    read = load_remap(numpy_file(tmp_path, map_x=x, map_y=y), SIZE)
    assert "of the map's pixels have a source beyond a sensor of 160x128; is that its size?" in \
        " ".join(read.warnings)
    inside = read.geometry.window_inside(x, y)
    assert .5 < inside.mean() < .8 and np.isfinite(read.x).sum() <= inside.sum()


def test_a_map_folded_in_its_corners_is_used_without_them(tmp_path):
    # Brown's model folds back beyond a radius: it gives corners a source in the sensor again.
    matrix = np.array([[95.0, 0, 80], [0, 95, 64], [0, 0, 1]])
    small = np.array([[.75 * 95, 0, 80], [0, .75 * 95, 64], [0, 0, 1]])
    x, y = cv2.initUndistortRectifyMap(matrix, np.array([[-.28, 0, 0, 0]]), None,
                                       small, SIZE, cv2.CV_32FC1)
    read = load_remap(numpy_file(tmp_path, map_x=x, map_y=y), SIZE)
    assert any("pixels have a source in the sensor and are left blank, because the map folds back"
               in sentence for sentence in read.warnings)
    u, v, a, b = training_grid(read.back_map, read.geometry)
    radius = np.hypot(u - 80, v - 64) / (.75 * 95)
    assert radius.max() < (1 / (3 * .28))**.5 + .05


def noisy(sigma):
    rng = np.random.default_rng(3)
    return [table + rng.normal(0, sigma, table.shape).astype(np.float32) for table in (X, Y)]


def test_a_rough_map_is_reported(tmp_path):
    x, y = noisy(.1)
    warning, = load_remap(numpy_file(tmp_path, map_x=x, map_y=y), SIZE).warnings
    assert "the map scatters by 0.1" in warning


def with_value(column, row, value):
    table = X.copy()
    table[row, column] = value
    return table


FOLDED = U + 60 * np.sin(U / 12), V
TORN = np.where(U < 70, X, X + 30)
CONSTANT = np.full_like(X, 5)
CARELESS = {
    "not finite": ((with_value(7, 3, np.nan), Y), "map_x has 1 values that are not finite, the "
                                                  "first in column 7, row 3; -1 is the mark"),
    "infinite": ((with_value(7, 3, np.inf), Y), "map_x has 1 values that are not finite"),
    "sizes": ((X, Y[:-8]), "map_x is 160x128, map_y is 160x120, both must have the size"),
    "offsets": ((X - U, Y - V), "the tables hold offsets from the corrected pixel, source pixels 0 "
                                "to 159 and 0 to 127 are needed"),
    "shifted offsets": ((X - U + 20, Y - V + 15), "the tables hold offsets from the corrected"),
    "swapped": ((Y, X), "the tables hold x and y swapped"),
    "mirrored": ((X[:, ::-1], Y[:, ::-1]), "the map is mirrored"),
    "normalised": ((2 * X / 159 - 1, 2 * Y / 127 - 1), "the tables hold coordinates of -1 to 1"),
    "shares": ((X / 159, Y / 127), "the tables hold coordinates of 0 to 1"),
    "constant": ((X, CONSTANT), "map_y is 5 everywhere"),
    "constant but for marks": ((np.where(V < 9, -1, CONSTANT), Y), "x is 5 at every pixel whose "
                                                                   "source lies in the sensor"),
    "outside": ((X + 155, Y), r"only [\d.]+ % of the map's pixels have a source in a sensor of "
                              r"160x128, the middle has none; the tables reach from"),
    "of a larger sensor": ((2 * X, 2 * Y), r"only 2\d\.\d % of the map's pixels have a source in a "
                                           r"sensor of 160x128, the middle has none"),
    "folded": (FOLDED, "the map is folded: of"),
    "noise": (noisy(.8), "the map is not smooth: from pixel to pixel it scatters by 0.8"),
    "torn": ((TORN, Y), r"the map is torn: between the corrected pixels \(69, \d+\) and \(70, \d+"
                        r"\) the source jumps by 3"),
    "whole": ((X.round(), Y.round()), "the tables hold whole pixels: they are rounded"),
    "half": ((X.astype(np.float16).astype(np.float32), Y.astype(np.float16).astype(np.float32)),
             "the tables have been through 16-bit floats, whose steps at 15.* are 0.125 px"),
    "16-bit": ((X.astype(np.float16), Y.astype(np.float16)), "map_x holds float16 values"),
    "8-bit": ((X.astype(np.uint8), Y.astype(np.uint8)), "map_x holds uint8 values, which cannot "
                                                        "resolve a hundredth of a pixel: float32"),
    "complex": ((X + 1j * Y, Y), "map_x holds complex64 values"),
    "colour": ((np.dstack([X] * 3), Y), "map_x is 128x160x3, a map has two arrays of one channel"),
    "small": ((X[:4], Y[:4]), "map_x 4x160, map_y 4x160: a map has two arrays, named as map_x and "
                              "map_y are, or two files, and 8x8 pixels at least"),
    "one": ((X, np.empty(0)), "holds map_x 128x160, map_y 0: a map has two arrays")}


@pytest.mark.parametrize("tables,message", CARELESS.values(), ids=list(CARELESS))
def test_careless_maps_are_rejected_by_what_they_are(tmp_path, tables, message):
    paths = numpy_file(tmp_path, map_x=tables[0], map_y=tables[1])
    with pytest.raises(InputError, match=message):
        load_remap(paths, SIZE)


@pytest.mark.parametrize("arrays,message", [
    ({"map1": FIXED["map1"]}, "map1 holds whole pixels, the second table, of their fractions, is "
                              "missing"),
    (FIXED | {"map2": FIXED["map2"].astype(np.float32)}, "map2 holds float32 values, uint16 is"),
    (FIXED | {"map2": FIXED["map2"] + np.uint16(2000)}, r"the limits of OpenCV's fractions are 0 "
                                                        r"and 1023"),
    ({"map_x": X, "map_y": Y, "sensor": (160, 128, 3)}, r"sensor is \[160, 128, 3\], width and"),
    ({"map_x": X, "map_y": Y}, r"the size of the sensor is not known; --sensor-size WxH gives it"),
    ({"map_x": X, "map_y": Y, "sensor": (5000, 128)}, "distorted_width is 5000, the limits are 8"),
    ({"map_x": X, "map_y": np.array([None, {}])}, "holds no map that can be read: Object arrays"),
])
def test_files_of_wrong_content_are_named(tmp_path, arrays, message):
    with pytest.raises(InputError, match=message):
        load_remap(numpy_file(tmp_path, **arrays))


def test_files_that_are_none(tmp_path):
    for name, content in (("a.npz", b""), ("a.npz", b"PK\x03\x04 and more"),
                          ("a.npy", b"\x93NUMPY"), ("a.tif", b"II*\0junk"),
                          ("a.exr", b"v/1\1junk"), ("a.tif", b"")):
        path = tmp_path / name
        path.write_bytes(content)
        with pytest.raises(InputError, match=f"{name}.* holds no "):
            load_source(path, sensor=SIZE)
    with pytest.raises(InputError, match="cannot read .*absent.npz"):
        load_source(tmp_path / "absent.npz")


def test_a_tiff_is_not_turned_and_has_one_page(tmp_path):
    paths = two_pictures(tmp_path, ".tif")
    for path, table in zip(paths, (X, Y)):
        tifffile.imwrite(path, table, extratags=[(274, "H", 1, 3, True)])
    np.testing.assert_array_equal(read_remap(paths).x, X)
    tifffile.imwrite(paths[0], np.stack([X, Y]))
    with pytest.raises(InputError, match="x.tif: it has 2 pages, one is needed"):
        read_remap(paths)


def test_more_careless_calls(tmp_path):
    first, second = two_pictures(tmp_path, ".tif")
    for paths, options, message in (
            ((first,), {}, "x.tif 128x160: a map has two arrays, named"),
            ((first, first), {}, "x.tif is given twice, a map has two tables"),
            ((first, second, first), {}, "3 files are given, one is needed, or the two of a map"),
            ((first, second), {"camera": "left"}, "camera left is asked for, .* hold one map"),
            ((first, second), {"size": (80, 64)}, "the map of .*x.tif has its own"),
            ((first, second), {"zoom": "fill"}, "the map of .*x.tif has its own"),
            ((*numpy_file(tmp_path, map_x=X, map_y=Y), second), {}, "map.npz holds 2 tables")):
        with pytest.raises(InputError, match=message):
            load_source(paths, **{"sensor": SIZE} | options)


def test_a_shift_by_whole_pixels_and_a_great_magnification_are_maps(tmp_path):
    for x, y in ((U + 12, V + 3), (60 + U / 8, 40 + V / 8), (30 + U / 6, 30 + V / 6),
                 (130 - V, U / 2 + 20)):
        read = load_remap(numpy_file(tmp_path, map_x=x, map_y=y), (300, 200))
        assert np.isfinite(read.x).all() and not read.warnings

"""Files of other software that are recognised by their content but not supported."""

import re

from ncdc_spec.errors import InputError

__all__ = ["reject_known_bytes", "reject_known_table", "reject_known_text"]

# Kind of file, and a pattern of its text. The first that fits counts.
_TEXTS = (
    ("a lensfun profile", r"<lensdatabase|<!DOCTYPE lensdatabase"),
    ("an Adobe lens profile (.lcp)", r"<x:xmpmeta|stCamera:"),
    ("an Agisoft Metashape or PhotoScan XML",
     r"<calibration>\s*<projection>|<document[^>]*version[\s\S]*<chunk|<calibration[ >]"
     r"[\s\S]*<projection>frame"),
    ("a CAHVOR model", r"(?m)^Model = CAHV"),
    ("a Hugin project", r"(?m)^p f\d+ w\d+ h\d+"),
    ("a Bundler file", r"^# Bundle file"),
    ("a Pix4D camera file", r"(?m)^[ \t]*(Pix4D camera calibration file|FOCAL \d|IMWIDTH \d)"),
    ("a COLMAP images.txt", r"# Image list with two lines of data per image"),
    ("a COLMAP points3D.txt", r"# 3D point list with one line of data per point"),
    ("a points file of ncdc export --style discorpy", r"^photo,direction,line,y,x"),
    ("a descriptor of ncdc train", r"^# NCDC descriptor|(?m:^corrected_width = )"),
    ("an Anipose or Pose2Sim calibration", r"(?m)^distortions\s*="),
    ("a results file of Kalibr, whose camchain.yaml is read", r"(?m)^Calibration results\s*$"),
    ("a ZED settings file", r"(?m)^\[(LEFT|RIGHT)_CAM_\w+\]"),
    ("a picture in PostScript or PDF", r"^%(PDF|!PS)"),
    ("a PTLens profile", r"(?i)^\s*\[ptlens\]|^\s*begin_(cmr|len)\b|(?m:^a\s*=[-+.\d\s]+^b\s*="
     r"[-+.\d\s]+^c\s*=)"),
    ("an HTML page", r"(?i)^\s*<!doctype html|^\s*<html"),
)
# Kind of file, and names in its table: all of one of the tuples.
_TABLES = (
    ("a Gyroflow lens profile", (("calib_dimension",), ("fisheye_params",))),
    ("a Kalibr imu file", (("accelerometer_noise_density",), ("gyroscope_noise_density",),
                           ("imu0",))),
    ("a Kalibr target file", (("target_type",),)),
    ("a basalt calibration", (("value0",),)),
    ("an OpenMVG sfm_data", (("sfm_data_version",), ("root_path", "views"))),
    ("a Meshroom SfM file", (("intrinsics", "views"),)),
    ("a calib.io calibration", (("Calibration",),)),
    ("an Azure Kinect calibration", (("CalibrationInformation",),)),
    ("an ORB-SLAM settings file",
     (("Camera.fx",), ("Camera1.fx",), ("Camera.type",))),
    ("a Zivid intrinsics file",
     (("CameraIntrinsics",), ("CameraMatrix", "Distortion"))),
    ("a Blender file", (("blender_version",), ("sensor_width", "lens"))),
    ("a VINS settings file, which names its camera file as cam0_calib",
     (("cam0_calib",), ("imu_topic", "image_topic"))),
    ("a report of ncdc", (("map_error_float_px",), ("hidden_neurons",))),
)
# What to do instead.
_MAP = "; where its program writes a map, as for cv2.remap, the map is read"
_OPENCV = "; write its focal lengths, centre, coefficients and size as an OpenCV file"
_WAYS = {"a lensfun profile": _MAP, "an Adobe lens profile (.lcp)": _MAP, "a PTLens profile": _MAP,
         "a Hugin project": _MAP, "a Gyroflow lens profile": _OPENCV,
         "an ORB-SLAM settings file": _OPENCV, "a Zivid intrinsics file": _OPENCV}
_BYTES = (("an SQLite database, of COLMAP or a ROS 2 bag", b"SQLite format 3"),
          ("a ROS bag", b"#ROSBAG"), ("a ROS 2 bag (MCAP)", b"\x89MCAP"),
          *(("a pickle of Python", bytes([0x80, version])) for version in range(2, 6)),
          ("a ZIP archive", b"PK\x03\x04"), ("a gzip archive", b"\x1f\x8b"))


def reject_known_bytes(content):
    """Raise :class:`InputError` that names the kind of a known binary file."""
    for what, start in _BYTES:
        if content.startswith(start):
            raise InputError(f"it is {what}, which is not supported{_WAYS.get(what, '')}")


def reject_known_text(text):
    """Raise :class:`InputError` that names the kind of a known text file."""
    head = text[:1 << 16]
    for what, pattern in _TEXTS:
        if re.search(pattern, head):
            raise InputError(f"it is {what}, which is not supported{_WAYS.get(what, '')}")
    if head.lstrip().startswith("<") and "<opencv_storage" not in head:
        root = re.search(r"<([A-Za-z][\w:.-]*)", head)
        raise InputError(f"it is no camera file: its XML has the root "
                         f"{root[1] if root else 'none'}, OpenCV's opencv_storage is needed")


def reject_known_table(table):
    """Raise :class:`InputError` that names the kind of a known file of names and values."""
    for what, kinds in _TABLES:
        if any(all(name in table for name in names) for names in kinds):
            raise InputError(f"it is {what}, which is not supported{_WAYS.get(what, '')}")
    if str(table.get("sensor_type", "camera")).lower() != "camera":
        raise InputError(f"it is the file of a sensor of type {table['sensor_type']}, which is not "
                         f"supported")

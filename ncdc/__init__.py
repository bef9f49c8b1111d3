"""NCDC's command line, benches and reports."""

import os

# What is wrong is one sentence of ours. OpenCV reads this when it is loaded, so it comes first.
os.environ.setdefault("OPENCV_LOG_LEVEL", "SILENT")

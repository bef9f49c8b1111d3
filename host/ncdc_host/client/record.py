"""Frames into files."""

from pathlib import Path

from ncdc_model.images import write_image
from ncdc_spec.files import check_outputs, write_text

__all__ = ["record"]


def record(stream, count, folder, timeout=5.0, progress=lambda done, total: None):
    """Write the next ``count`` frames of a ``stream`` to ``folder``; returns their paths.

    Each is ``frame-NNNNNN.png``, by the frame's number and without loss; a raw frame has one
    channel, as ``ncdc correct`` takes it. ``frames.csv`` has a row each: file, number, device time
    in nanoseconds, format.

    Raises
    ------
    DeviceError
        If a frame does not come within ``timeout`` seconds; those before it stay.
    InputError
        If the folder cannot be written.
    """
    folder = Path(folder)
    check_outputs([folder / "frames.csv"], [])
    rows, paths = ["file,number,time_ns,format"], []
    for done in range(count):
        frame = stream.next(timeout)
        path = folder / f"frame-{frame.number:06d}.png"
        write_image(path, frame.pixels)
        paths.append(path)
        rows.append(f"{path.name},{frame.number},{frame.time_ns},{frame.pixel_format.name}")
        write_text(folder / "frames.csv", "\n".join(rows) + "\n")
        progress(done + 1, count)
    return paths

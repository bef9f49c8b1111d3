"""Writes films: pictures of a look, encoded into a container."""

import os
from contextlib import contextmanager
from pathlib import Path

import av
import numpy as np

from ncdc_model.film.look import Look, planes_of
from ncdc_model.images import FILMS, is_film_name
from ncdc_spec.errors import InputError
from ncdc_spec.files import replace_file

__all__ = ["FilmWriter", "writing_film"]

# Nothing is lost that is seen, and a core encodes 1920x1080 of 8 bits in real time.
_QUALITY = {"libx264": {"crf": "18", "preset": "veryfast"},
            "libx265": {"crf": "18", "preset": "superfast", "x265-params": "log-level=none"},
            "libvpx-vp9": {"crf": "24", "b": "0", "deadline": "realtime", "cpu-used": "8"},
            "libsvtav1": {"crf": "24", "preset": "8"}}
# Encoders of 8 bits, and of more: those that players of the container expect.
_ENCODERS = {".webm": ("libvpx-vp9", "libsvtav1"), ".avi": ("libx264", "libx264")}
_COMMON = "libx264", "libx265"


class FilmWriter:
    """Encodes pictures into a container that is open.

    Attributes
    ----------
    path : Path
        That is written in the end.
    container : av.container.OutputContainer
    bits, form : int, str
        Bits and pixel format of the samples that are written.
    """

    def __init__(self, path, container, size, rate, look):
        self.path, self.container, self._look, self._last = path, container, look, None
        suffix = path.suffix.lower()
        name = _ENCODERS.get(suffix, _COMMON)[look.bits > 8]
        os.environ.setdefault("SVT_LOG", "1")       # else this encoder prints what it is set to
        known = {one.name for one in av.codec.Codec(name, "w").video_formats}
        self.bits, self.form = _form(known, look, size)
        self._stream = container.add_stream(name, rate)
        context = look.tagged(self._stream.codec_context)
        context.width, context.height = size
        context.pix_fmt, context.sample_aspect_ratio = self.form, look.aspect
        context.options = _QUALITY[name] | ({"bf": "0"} if suffix == ".avi" else {})
        for option, value in look.hdr_options(name).items():
            words = filter(None, (context.options.get(option), value))
            context.options = context.options | {option: ":".join(words)}
        if name == "libx265" and suffix != ".mkv":
            context.codec_tag = "hvc1"      # that players of Apple know
        if look.matrix:
            self._stream.set_display_matrix(look.matrix)

    def samples_of(self, colour):
        """Samples of a ``colour`` (red, green, blue), uint8, in the planes of the film."""
        frame = self._look.frame_of(np.full((2, 2, 3), colour, np.uint8), self.form)
        return tuple(int(plane[0, 0]) for plane in planes_of(frame))

    def set_time_base(self, time_base):
        """Times of pictures have the unit ``time_base``; by default the rate's."""
        self._stream.codec_context.time_base = time_base

    def set_metadata(self, metadata):
        """Tags of the stream, such as its language."""
        self._stream.metadata.update(metadata)

    def write(self, picture, like=None):
        """Encode an RGB ``picture``, uint8, with the time of the frame ``like``."""
        self._encode(self._look.frame_of(picture, self.form), like)

    def write_planes(self, planes, like=None):
        """Encode ``planes``, as of :func:`planes_of` of a frame in the format :attr:`form`."""
        height, width = planes[0].shape
        frame = self._look.tagged(av.VideoFrame(width, height, self.form))
        for target, plane in zip(planes_of(frame), planes, strict=True):
            target[:] = plane
        self._encode(frame, like)

    def _encode(self, frame, like):
        if like is not None:
            base = like.time_base
            frame.time_base = base
            if like.pts is None:        # as in a bare stream of a codec
                frame.pts = None
            else:
                # A damaged film may step back, where an encoder would fail.
                frame.pts = like.pts if self._last is None else max(like.pts, self._last + 1)
                self._last = frame.pts
        self.container.mux(self._stream.encode(frame))

    def end(self):
        """Encode what the encoder holds back."""
        self.container.mux(self._stream.encode())


def _form(known, look, size):
    """(bits, name) of the pixel format among ``known`` that loses least of a ``look``."""
    # Two columns or rows share their colour, which needs even sides.
    chroma = look.chroma
    if chroma == "422" and size[0] % 2 or chroma == "420" and (size[0] % 2 or size[1] % 2):
        chroma = "444"
    depths = sorted((8, 10, 12), key=lambda bits: (bits < look.bits, abs(bits - look.bits)))
    for bits in depths:
        for part in (chroma, "444", "420"):
            name = f"yuv{part}p" + (f"{bits}le" if bits > 8 else "")
            if name in known:
                return bits, name
    raise AssertionError("an encoder without a format of pictures")


@contextmanager
def writing_film(path, size, rate, look=None):
    """Yield the :class:`FilmWriter` of the film ``path``, which is replaced when the block ends
    without error.

    Parameters
    ----------
    path : path
    size : (int, int)
    rate : Fraction or int
        Frames per second.
    look : Look, optional
        Of its pictures; by default 8 bits, with the colours of BT.709.

    Raises
    ------
    InputError
        If the suffix is none of :data:`FILMS`, or the file cannot be written.
    """
    if not is_film_name(path):
        raise InputError(f"{path}: films are written as one of {', '.join(FILMS)}")
    with replace_file(path) as temporary:
        try:
            with av.open(str(temporary), "w") as container:
                writer = FilmWriter(Path(path), container, size, rate, look or Look())
                yield writer
                writer.end()
        except av.FFmpegError as error:
            raise InputError(f"cannot write {path}: {error.strerror}") from error

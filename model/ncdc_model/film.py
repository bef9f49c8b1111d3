"""Films: each picture of one is changed, and the rest of it stays as it was.

PyAV brings FFmpeg's libraries. Pictures keep their times, so that a changing rate stays; packets of
sound are copied. Players turn a film by its stream's matrix, which stays too.
"""

from contextlib import contextmanager
from pathlib import Path

import av
import numpy as np

from ncdc_model.images import FILMS, is_film
from ncdc_spec.errors import InputError
from ncdc_spec.files import replace_file

__all__ = ["change_film", "pictures_of", "writing_film"]

# Nothing is lost that is seen, and a core encodes 1920x1080 in real time.
_QUALITY = {"libx264": {"crf": "18", "preset": "veryfast"},
            "libvpx-vp9": {"crf": "24", "b": "0", "deadline": "realtime", "cpu-used": "8"}}
_COLOUR_TAGS = "color_range", "colorspace", "color_primaries", "color_trc"


@contextmanager
def _opened(path):
    """The film ``path`` and its video stream."""
    try:
        with av.open(str(path)) as film:
            if not film.streams.video:
                raise InputError(f"{path} holds no pictures")
            film.streams.video[0].thread_type = "AUTO"      # several pictures are decoded at once
            yield film, film.streams.video[0]
    except (av.FFmpegError, OSError) as error:
        raise InputError(f"cannot read {path}: {error.strerror}") from error


def change_film(source, target, size, change, warn, progress=lambda fraction: None):
    """Write the film ``target``: each picture of the film ``source`` by ``change``.

    Parameters
    ----------
    source, target : path
        ``target`` is replaced whole or not at all.
    size : (int, int)
        Width and height of the changed pictures.
    change : callable
        Gives a picture, uint8 RGB (height, width, 3), for one of the source's size and the seconds
        since the film began.
    warn : callable
        Called with a sentence on what is left out.
    progress : callable
        Called with the fraction done, if the film says how long it is.

    Returns
    -------
    int
        Number of pictures.

    Raises
    ------
    InputError
        If the source cannot be read, or the target cannot be written.
    """
    count, turned, began = 0, _turned(source), None
    with _opened(source) as (film, pictures):
        total = _count(film, pictures)
        with writing_film(target, size, pictures.average_rate, pictures.time_base) as out:
            copied = _copied(film, out, warn)
            out.turn(turned)        # before the first packet, with which the header is written
            for packet in film.demux([pictures, *copied]):
                if packet.stream is not pictures:
                    if packet.dts is not None:
                        packet.stream = copied[packet.stream]
                        out.container.mux(packet)
                    continue
                for frame in packet.decode():
                    picture, time = frame.to_ndarray(format="rgb24"), float(frame.time or 0.0)
                    began = time if began is None else began    # of some files not at 0
                    out.write(change(picture, time - began), like=frame)
                    count += 1
                    if total:
                        progress(min(count / total, 1))
    progress(1)
    return count


def pictures_of(path, pause=0.0):
    """Yield the pictures of the film ``path``, uint8 RGB (height, width, 3), with their times.

    Parameters
    ----------
    path : path
    pause : float
        Pictures that follow another one sooner, in seconds, are left out.

    Yields
    ------
    (ndarray, float)
        Picture, and seconds since the film began.

    Raises
    ------
    InputError
        If the film cannot be read.
    """
    last = -np.inf
    with _opened(path) as (film, pictures):
        for frame in film.decode(pictures):
            seconds = float(frame.time or 0.0)
            if seconds - last >= pause - 1e-6:
                last = seconds
                yield frame.to_ndarray(format="rgb24"), seconds


def _turned(path):
    """Degrees, counter-clockwise, by which players turn the pictures of a film."""
    with _opened(path) as (film, pictures):
        for frame in film.decode(pictures):
            return frame.rotation
    raise InputError(f"{path} holds no pictures")


def _count(film, pictures):
    """Number of pictures as the film says it, or 0."""
    if pictures.frames or not film.duration or not pictures.average_rate:
        return pictures.frames
    return int(film.duration / av.time_base * pictures.average_rate)


def _copied(film, out, warn):
    """The stream of ``out`` for each stream of sound of ``film`` that can be copied."""
    copied = {}
    for stream in film.streams.audio:
        try:
            copied[stream] = out.container.add_stream_from_template(stream)
        except (av.FFmpegError, ValueError):
            warn(f"the sound is left out: {out.path.suffix} holds no {stream.codec.name}")
    return copied


class _Writer:
    """Encodes pictures into a container that is open."""

    def __init__(self, path, container, size, rate, time_base):
        self.path, self.container = path, container
        self._stream = container.add_stream(container.default_video_codec, rate)
        context = self._stream.codec_context
        context.width, context.height = size
        # Two columns and rows share their colour, which needs even sides.
        context.pix_fmt = "yuv444p" if size[0] % 2 or size[1] % 2 else "yuv420p"
        context.options = _QUALITY.get(context.codec.name, {})
        if time_base is not None:
            context.time_base = time_base

    def turn(self, degrees):
        """Players are to turn the pictures by ``degrees``, counter-clockwise."""
        if degrees:
            self._stream.set_display_rotation(degrees)

    def write(self, picture, like=None):
        """Encode an RGB ``picture``, with the time and the colour space of the frame ``like``."""
        frame = av.VideoFrame.from_ndarray(np.ascontiguousarray(picture), "rgb24")
        if like is not None:
            frame.pts, frame.time_base = like.pts, like.time_base
            frame = frame.reformat(format=self._stream.codec_context.pix_fmt,
                                   dst_colorspace=like.colorspace,
                                   dst_color_range=like.color_range)
            for name in _COLOUR_TAGS:
                setattr(frame, name, getattr(like, name))
        self.container.mux(self._stream.encode(frame))

    def end(self):
        """Encode what the encoder holds back."""
        self.container.mux(self._stream.encode())


@contextmanager
def writing_film(path, size, rate, time_base=None):
    """Yield a writer of the film ``path``, which is replaced when the block ends without error.

    Parameters
    ----------
    path : path
    size : (int, int)
    rate : Fraction or int
        Frames per second.
    time_base : Fraction, optional
        Unit of the times of its pictures; by default they have the rate's.

    Raises
    ------
    InputError
        If the suffix is none of :data:`FILMS`, or the file cannot be written.
    """
    if not is_film(path):
        raise InputError(f"{path}: films are written as one of {', '.join(FILMS)}")
    with replace_file(path) as temporary:
        try:
            with av.open(str(temporary), "w") as container:
                writer = _Writer(Path(path), container, size, rate, time_base)
                yield writer
                writer.end()
        except av.FFmpegError as error:
            raise InputError(f"cannot write {path}: {error.strerror}") from error

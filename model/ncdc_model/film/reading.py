"""Reads films: their pictures, the packets of other streams, and what is damaged."""

from contextlib import contextmanager
from fractions import Fraction
from pathlib import Path

import av
import numpy as np
from av.stream import Disposition

from ncdc_model.film.ending import WholeBoxes, ends_early
from ncdc_model.film.look import rgb_of
from ncdc_spec.errors import InputError

__all__ = ["FilmReader", "frame_shape", "opened", "pictures_of"]

_AT_ONCE = 100                  # errors without a packet in between, after which a film has ended

_HIDING = "vp8", "vp9", "mpeg4"     # of which a packet may hold no picture that is shown


@contextmanager
def opened(path):
    """Yield the :class:`FilmReader` of the film ``path``.

    Raises
    ------
    InputError
        If it cannot be read, or holds no pictures.
    """
    try:
        with _opened(path) as film:
            pictures = film.streams.best("video")
            if pictures is None or pictures.disposition & Disposition.attached_pic:
                raise InputError(f"{path} holds no pictures")
            if pictures.codec_context is None:
                raise InputError(f"{path}: nothing here decodes its pictures")
            pictures.thread_type = "AUTO"       # several pictures are decoded at once
            yield FilmReader(path, film, pictures)
    except (av.FFmpegError, OSError) as error:
        cut = "; it is cut off, and lacks what is needed to play it" * _cut(path)
        raise InputError(f"cannot read {path}: {error.strerror}{cut}") from error


def _opened(path):
    """The container ``path``; of fragments that are cut off, those that are whole."""
    try:
        return av.open(str(path), metadata_errors="replace")
    except av.FFmpegError:
        if not _cut(path):
            raise
        return av.open(WholeBoxes(path), metadata_errors="replace")


def _cut(path):
    return Path(path).is_file() and ends_early(path)


class FilmReader:
    """A film that is open.

    Attributes
    ----------
    film, pictures : av.container.InputContainer, av.video.stream.VideoStream
    skipped : int
        Damaged packets of pictures that gave none.
    repaired : int
        Pictures that the decoder has completed from others, since a part was damaged.
    """

    def __init__(self, path, film, pictures):
        self.path, self.film, self.pictures = path, film, pictures
        self.repaired = self._errors = self._packets = self._decoded = 0
        self._partial = False

    def packets(self, others=()):
        """Yield the packets of the pictures and of ``others``; the film ends where it is lost."""
        failures = 0
        while failures < _AT_ONCE:
            try:
                for packet in self.film.demux([self.pictures, *others]):
                    failures = 0
                    if packet.stream is self.pictures and packet.size:
                        self._count(packet)
                    yield packet
                return
            except (av.FFmpegError, OSError):
                failures += 1
        self._partial = True

    def _count(self, packet):
        self._packets += not packet.is_discard
        self._partial = packet.is_corrupt

    def frames(self, packet):
        """Pictures that ``packet`` of theirs gives; none if it is damaged.

        Raises
        ------
        InputError
            If one is interlaced.
        """
        try:
            frames = packet.decode()
        except av.FFmpegError:
            self._errors += 1
            return []
        if any(frame.interlaced_frame and not frame.is_corrupt for frame in frames):
            raise InputError(f"{self.path} is interlaced, each of its pictures is two of half the "
                             f"rows: split them first, as by ffmpeg -i {self.path} -vf bwdif "
                             f"split.mkv")
        self._decoded += len(frames)
        self.repaired += sum(frame.is_corrupt for frame in frames)
        return frames

    @property
    def skipped(self):
        """See the class; to be asked at the end, since decoders hold pictures back."""
        if self.pictures.codec_context.name in _HIDING:
            return self._errors
        # Some decoders drop what is damaged and report no error.
        return max(self._errors, self._packets - self._decoded)

    @property
    def expected(self):
        """Number of pictures that the film states, or 0."""
        stream, film = self.pictures, self.film
        if stream.frames or not film.duration or not stream.average_rate:
            return stream.frames
        return int(film.duration / av.time_base * stream.average_rate)

    @property
    def cut_off(self):
        """Whether the film ends before the end that it states; to be asked at its end."""
        return self._partial or ends_early(self.path)


def frame_shape(path):
    """(width, height) of the pictures of the film ``path``, and the width of its pixels over their
    height.

    Raises
    ------
    InputError
        If the film cannot be read.
    """
    with opened(path) as reader:
        context = reader.pictures.codec_context
        return (context.width, context.height), reader.pictures.sample_aspect_ratio or Fraction(1)


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
    with opened(path) as reader:
        for packet in reader.packets():
            for frame in reader.frames(packet):
                seconds = float(frame.time or 0.0)
                if seconds - last >= pause - 1e-6:
                    last = seconds
                    yield rgb_of(frame), seconds

"""Changes each picture of a film, and keeps the rest of it."""

import io
from dataclasses import dataclass, replace
from fractions import Fraction

import av

from ncdc_model.film.kept import (
    DATA,
    Facts,
    copied_metadata,
    is_cover,
    left_out,
    other_streams,
    stream_facts,
)
from ncdc_model.film.look import planes_of, rgb_of, tags_of, transparent
from ncdc_model.film.reading import opened
from ncdc_model.film.writing import writing_film
from ncdc_spec.errors import InputError

__all__ = ["Changed", "change_film"]


@dataclass(frozen=True)
class Changed:
    """What :func:`change_film` has made.

    Parameters
    ----------
    pictures : int
        That were written.
    expected : int
        That the source states, or 0.
    skipped, repaired : int
        As of :class:`~ncdc_model.film.reading.FilmReader`.
    cut_off : bool
        Whether the source ends before the end that it states.
    source_bits, bits : int
        Of a sample, in the source and in the film that was written.
    """
    pictures: int
    expected: int
    skipped: int
    repaired: int
    cut_off: bool
    source_bits: int
    bits: int


def change_film(source, target, size, change, warn, progress=lambda fraction: None):
    """Write the film ``target``: each picture of the film ``source`` by ``change``.

    Parameters
    ----------
    source, target : path
        ``target`` is replaced whole or not at all.
    size : (int, int)
        Width and height of the changed pictures.
    change : callable
        With the attribute ``rgb`` true: gives a picture, uint8 RGB (height, width, 3), for one of
        the source's size and the seconds since the film began. Else it gives planes of samples,
        brightness and two of colour, for those of a picture, the seconds, and a function that
        gives the sample in each plane of a colour (red, green, blue). The planes of colour may have
        half the columns, or half the columns and rows; samples have the film's bits.
    warn : callable
        Called with a sentence on what is left out.
    progress : callable
        Called with the fraction done, if the film says how long it is.

    Returns
    -------
    Changed

    Raises
    ------
    InputError
        If the source cannot be read, is interlaced, or the target cannot be written.
    """
    before = Facts.of(source)
    look = replace(before.look, bits=8) if change.rgb else before.look
    with opened(source) as reader:
        pictures, rate = reader.pictures, reader.pictures.average_rate or Fraction(25)
        with writing_film(target, size, rate, look) as out:
            out.set_time_base(pictures.time_base if before.timed else 1 / rate)
            work = _Work(reader, out, look, before.begin, warn)
            work.all(change, progress)
        progress(1)
        kept = replace(before, look=look)
        for sentence in left_out(kept, Facts.of(target), work.streams):
            warn(f"{target}: {sentence}")
        return Changed(work.count, reader.expected, reader.skipped, reader.repaired,
                       reader.cut_off, before.look.bits, out.bits)


class _Work:
    """Changes the pictures of one film."""

    def __init__(self, reader, out, look, begin, warn):
        self._reader, self._out, self._look, self._warn = reader, out, look, warn
        self.count, self.streams, self._copied, self._said = 0, [], {}, set()
        self._lost, self._begin = 0, begin
        film = reader.film
        out.container.metadata.update(copied_metadata(film.metadata))
        if date := film.metadata.get("creation_time"):
            out.container.metadata["creation_time"] = date
        out.container.set_chapters(film.chapters())
        out.set_metadata(copied_metadata(reader.pictures.metadata))
        for stream in other_streams(reader):
            self._copy(stream)

    def _copy(self, stream):
        """Have the packets of a ``stream`` copied, if the container takes them."""
        if stream.type == "video":
            self._warn(f"{self._reader.path}: " + (
                "its cover picture is left out" if is_cover(stream) else
                f"another video stream (number {stream.index}) is left out"))
            return
        if not _taken(self._out.container.format.name, stream):
            suffix, name = self._out.path.suffix, stream.metadata.get("handler_name", "")
            self._warn(f"the sound is left out: {suffix} holds no {stream.name}"
                       if stream.type == "audio" else
                       f"stream {stream.index} ({stream.type}{name and ', '}{name}) is left out: "
                       f"{suffix} holds none such")
            return
        copy = self._out.container.add_stream_from_template(stream)
        copy.metadata.update({**copied_metadata(stream.metadata), **{
            key: value for key, value in stream.metadata.items() if key == "handler_name"}})
        copy.disposition = stream.disposition
        self._copied[stream] = copy
        self.streams.append(stream_facts(stream, self._begin))

    def all(self, change, progress):
        """Change all pictures and copy the packets between them."""
        reader, expected = self._reader, self._reader.expected
        for packet in reader.packets([one for one in self._copied if one.type != "attachment"]):
            if packet.stream is not reader.pictures:
                self._mux(packet)
                continue
            for frame in reader.frames(packet):
                self._check(frame)
                self._change(change, frame, float(frame.time or 0) - self._begin)
                self.count += 1
                if expected:
                    progress(min(self.count / expected, 1))
        if self._lost:
            self._warn(f"{reader.path}: {self._lost} packets of other streams are left out, their "
                       f"times step back")

    def _change(self, change, frame, seconds):
        """Write one changed ``frame``."""
        out, look = self._out, self._look
        if change.rgb:
            out.write(change(_rgb(self._reader.path, frame), seconds), like=frame)
            return
        planes = planes_of(look.sampled(frame, out.form))
        out.write_planes(change(planes, seconds, out.samples_of), like=frame)

    def _check(self, frame):
        """Name what is left out of a ``frame``, the first time."""
        if self._look.alpha and "alpha" not in self._said and transparent(frame):
            self._warn(f"{self._reader.path}: its alpha channel is left out")
            self._said.add("alpha")
        for side in frame.side_data.keys():
            if side.type in DATA and side.type not in self._said:
                self._warn(f"{self._reader.path}: {DATA[side.type]} of its pictures is left out")
                self._said.add(side.type)
        if "tags" not in self._said and tags_of(frame) != self._look.tags:
            self._warn(f"{self._reader.path}: its colours' tags change at {frame.time or 0:.3f} s, "
                       f"the first ones stay")
            self._said.add("tags")

    def _mux(self, packet):
        """Copy a ``packet`` of another stream; an empty one is the sign of its end."""
        if packet.dts is None:
            if not packet.size:
                return
            packet.dts = packet.pts
        packet.stream = self._copied[packet.stream]
        try:
            self._out.container.mux(packet)
        except (av.error.InvalidDataError, av.error.ArgumentError, ValueError):
            self._lost += 1


def _rgb(path, frame):
    """The RGB picture of a ``frame``, uint8."""
    try:
        return rgb_of(frame)
    except av.FFmpegError as error:
        raise InputError(f"{path} has colours of matrix {frame.colorspace} of H.273, which are not "
                         f"converted to red, green and blue: --film bilinear needs none") from error


def _taken(form, stream):
    """Whether a container of the format ``form`` takes the packets of a ``stream``.

    Data that FFmpeg has no name for it would write without the four letters that say what it is.
    """
    if stream.type == "data" and stream.name is None:
        return False
    try:
        with av.open(io.BytesIO(), "w", format=form) as trial:
            trial.add_stream_from_template(stream)
            trial.start_encoding()
    except (av.FFmpegError, ValueError):
        return False
    return True

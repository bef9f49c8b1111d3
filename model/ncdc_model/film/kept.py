"""What a film keeps of another one, found by reading both."""

from dataclasses import dataclass

from av.sidedata.sidedata import Type
from av.stream import Discard, Disposition

from ncdc_model.film.look import COLOUR_TAGS, Look
from ncdc_model.film.reading import opened
from ncdc_spec.errors import InputError

__all__ = ["DATA", "Facts", "copied_metadata", "is_cover", "left_out", "other_streams",
           "stream_facts"]

# Written by the program that made a file, about that file.
_OF_THE_FILE = ("encoder", "major_brand", "minor_version", "compatible_brands", "vendor_id",
                "handler_name", "duration", "creation_time", "software")
_HEARD = 0.03           # seconds of sound before or after its picture that is not noticed
_NAMES = {"color_range": "range", "colorspace": "matrix", "color_primaries": "primaries",
          "color_trc": "transfer"}


# Data of single pictures that no encoder here writes.
DATA = {Type.DYNAMIC_HDR_PLUS: "the dynamic HDR10+ data", Type.DOVI_METADATA: "Dolby Vision data",
        Type.DOVI_RPU_BUFFER: "Dolby Vision data", Type.DYNAMIC_HDR_VIVID: "the HDR Vivid data",
        Type.A53_CC: "the closed captions", Type.ICC_PROFILE: "the ICC profile",
        Type.STEREO3D: "the arrangement for two eyes", Type.SPHERICAL: "the spherical projection",
        Type.S12M_TIMECODE: "the time code",
        Type.AMBIENT_VIEWING_ENVIRONMENT: "the ambient light"}


def copied_metadata(metadata):
    """Those of ``metadata`` that are about the film and not about its file; keys in lower case."""
    return {key.lower(): value for key, value in metadata.items()
            if key.lower() not in _OF_THE_FILE and not key.startswith("_STATISTICS")
            and key.partition("-")[0] not in ("BPS", "NUMBER_OF_FRAMES", "NUMBER_OF_BYTES")}


def other_streams(reader):
    """Streams besides the pictures, but for the text of chapters and the time code: they are read
    as chapters and as a tag of the pictures, and the container makes streams of them again."""
    return [stream for stream in reader.film.streams if stream is not reader.pictures
            and not (stream.type == "data" and (
                # Sony's samples have time codes too, one a picture.
                stream.discard == Discard.all
                or "timecode" in stream.metadata and stream.frames <= 1))]


@dataclass(frozen=True)
class Facts:
    """What a film says of itself.

    Parameters
    ----------
    look : Look
    begin : float
        Seconds at which its first picture is shown.
    timed : bool
        Whether its pictures have times.
    metadata : dict
    chapters : list
    streams : list of (str, str, float)
        Kind of each stream besides the pictures that is no video, its language, and the seconds
        from the first picture to its beginning.
    """
    look: Look
    begin: float
    timed: bool
    metadata: dict
    chapters: list
    streams: list

    @classmethod
    def of(cls, path):
        """The facts of the film ``path``.

        Raises
        ------
        InputError
            If it cannot be read, or none of its pictures can be decoded.
        """
        with opened(path) as reader:
            frame = next((frame for packet in reader.packets()
                          for frame in reader.frames(packet)), None)
            if frame is None:
                raise InputError(f"{path} holds no picture that can be decoded")
            film, begin = reader.film, float(frame.time or 0)
            return cls(Look.of(frame, reader.pictures.sample_aspect_ratio),
                       begin, frame.pts is not None,
                       copied_metadata(film.metadata) | _of_pictures(reader.pictures.metadata),
                       film.chapters(),
                       [stream_facts(stream, begin) for stream in other_streams(reader)
                        if stream.type != "video"])


def _of_pictures(metadata):
    """The time code and the language among the tags of the pictures."""
    found = {key.lower(): value for key, value in metadata.items()}
    if found.get("language") == "und":      # what some containers say of none
        del found["language"]
    return {f"{key} of the pictures": found[key] for key in ("timecode", "language")
            if key in found}


def left_out(before, after, copied):
    """Sentences on what ``after``, the :class:`Facts` of a film, has lost of those ``before``.

    ``copied``: streams, as of :class:`Facts`, that were to be copied.
    """
    old, new = before.look, after.look
    if old.rgb:
        yield "red, green and blue are written as Y'CbCr of BT.709"
    if new.bits < old.bits:
        yield f"of the {old.bits} bits of a sample {new.bits} are kept"
    if new.chroma < old.chroma:
        yield f"of the colours, stored as 4:{old.chroma[1]}:{old.chroma[2]}, " \
              f"4:{new.chroma[1]}:{new.chroma[2]} are kept"
    lost = [_NAMES[name] for name in COLOUR_TAGS if new.tags[name] != old.tags[name]
            and {new.tags[name], old.tags[name]} != {0, 1}]     # of a range: unstated is limited
    if lost:
        yield f"the colours' {', '.join(lost)}: the file does not state them any more"
    for name, text in (("aspect", "the shape of the pixels"), ("matrix", "the rotation"),
                       ("mastering", "the mastering display of HDR"),
                       ("light", "the light level of HDR")):
        if getattr(old, name) != getattr(new, name):
            yield f"{text} is left out"
    lost = [key for key, value in before.metadata.items() if after.metadata.get(key) != value]
    if lost:
        yield f"tags of the film are left out: {', '.join(sorted(lost))}"
    if len(after.chapters) < len(before.chapters):
        yield f"{len(before.chapters)} chapters are left out"
    for kind, language, _ in copied[len(after.streams):]:
        yield f"a stream of kind {kind}, language {language}, is left out"
    for (kind, language, begin), (_, now, later) in zip(copied, after.streams):
        if language != now:
            yield f"the language {language} of a stream of kind {kind} is left out"
        if abs(begin - later) > _HEARD:
            yield f"a stream of kind {kind} begins {begin:.3f} s after the first picture, here " \
                  f"{later:.3f} s"


def stream_facts(stream, begin):
    """What :class:`Facts` says of a ``stream`` of a film whose first picture is at ``begin``."""
    start = float((stream.start_time or 0) * (stream.time_base or 0))
    return stream.type, stream.language or "und", start - begin


def is_cover(stream):
    """Whether a stream of video is one picture, such as the cover of a disc."""
    return bool(stream.disposition & Disposition.attached_pic)

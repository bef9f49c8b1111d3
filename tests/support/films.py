"""Films of known pictures and tags, and what FFmpeg's own filter ``remap`` makes of them."""

from dataclasses import dataclass, field
from fractions import Fraction

import av
import cv2
import numpy as np
from av.filter import Graph

__all__ = ["COUNT", "HDR", "HLG", "PC", "SDR_601", "SDR_709", "SIZE", "TAGS", "TV", "Film",
            "frames_of", "scene", "shown"]

SIZE = 96, 64
COUNT = 10
BASE = Fraction(1, 12800)       # of 25 pictures a second
TAGS = "color_range", "colorspace", "color_primaries", "color_trc"
SDR_709, SDR_601, HDR, HLG = (1, 1, 1), (6, 6, 6), (9, 9, 16), (9, 9, 18)
TV, PC = 1, 2


def scene(k=0):
    """A picture without edges, whose colours move by a level from pixel to pixel, 16-bit RGB."""
    v, u = np.indices(SIZE[::-1])
    colours = np.stack([10 + u, 240 - u - k, 120 + v / 2 + u / 4], axis=-1)
    return (257 * colours).astype(np.uint16)


@dataclass(frozen=True)
class Film:
    """How a film is written: codec, pixel format, tags."""
    name: str
    codec: str = "libx264"
    form: str = "yuv420p"
    tags: tuple = (0, 2, 2, 2)
    options: dict = field(default_factory=lambda: {"crf": "1"})
    aspect: Fraction = Fraction(1)
    matrix: tuple = ()
    metadata: dict = field(default_factory=dict)
    sound: tuple = ()           # languages
    late: float = 0.0           # seconds at which the sound begins
    data: bool = False          # samples of a sensor, as action cameras write them
    chapters: bool = False
    timecode: str = ""
    second: bool = False        # another video stream
    alpha: float = 1.0
    size: tuple = SIZE
    window: tuple = (0, 0, *SIZE)       # of the scene: left, top, width, height
    container: dict = field(default_factory=dict)   # options

    def write(self):
        """Write the film into the working folder."""
        with av.open(self.name, "w", options=self.container) as out:
            video = self._video(out)
            if self.timecode:
                video.metadata["timecode"] = self.timecode
            others = [self._sound(out, language) for language in self.sound]
            extra = self._video(out) if self.second else None
            data = out.add_data_stream("bin_data") if self.data else None
            if data:
                data.time_base = Fraction(1, 1000)
                data.metadata["handler_name"] = "sensor"
            out.metadata.update(self.metadata)
            if self.chapters:
                out.set_chapters([{"id": k, "start": 200 * k, "end": 200 * k + 200,
                                   "time_base": Fraction(1, 1000),
                                   "metadata": {"title": f"part {k}"}} for k in range(2)])
            for k in range(COUNT):
                frame = self.frame(k)
                out.mux(video.encode(frame))
                if extra:
                    out.mux(extra.encode(self.frame(k)))
                if data and k % 5 == 0:
                    packet = av.Packet(b"DEVC" + bytes([k] * 20))
                    packet.stream, packet.time_base = data, Fraction(1, 1000)
                    packet.pts = packet.dts = 40 * k
                    packet.duration = 200
                    out.mux(packet)
            for stream, samples in others:
                for frame in samples:
                    out.mux(stream.encode(frame))
                out.mux(stream.encode())
            for stream in (video, extra):
                if stream:
                    out.mux(stream.encode())
        return self.name

    def frame(self, k):
        """Picture number ``k`` in the film's samples."""
        left, top, width, height = self.window
        colours = scene(k)[top:top + height, left:left + width]
        if self.size != (width, height):
            colours = cv2.resize(colours, self.size, interpolation=cv2.INTER_AREA)
        clear = np.full((*colours.shape[:2], 1), round(65535 * self.alpha), np.uint16)
        picture = av.VideoFrame.from_ndarray(np.dstack([colours, clear]), "rgba64le")
        matrix = {1: 1, 6: 5, 9: 9}.get(self.tags[1], 5)
        frame = picture.reformat(format=self.form, dst_colorspace=matrix,
                                 dst_color_range=self.tags[0] or TV)
        for name, value in zip(TAGS, self.tags):
            setattr(frame, name, value)
        frame.pts, frame.time_base = 512 * k, BASE
        return frame

    def _video(self, out):
        video = out.add_stream(self.codec, 25)
        context = video.codec_context
        context.width, context.height = self.size
        context.pix_fmt, context.time_base = self.form, BASE
        context.sample_aspect_ratio, context.options = self.aspect, dict(self.options)
        for name, value in zip(TAGS, self.tags):
            setattr(context, name, value)
        if self.matrix:
            video.set_display_matrix(self.matrix)
        return video

    def _sound(self, out, language):
        stream = out.add_stream("aac" if self.name.endswith(("mp4", "mov")) else "pcm_s16le", 48000)
        stream.metadata["language"] = language
        tone, frames = np.sin(np.arange(1024, dtype=np.float32) / 9)[None], []
        for k in range(15):
            form = stream.codec_context.format.name
            samples = tone if form == "fltp" else (20000 * tone).astype(np.int16)
            frames.append(av.AudioFrame.from_ndarray(samples, form, "mono"))
            frames[-1].sample_rate, frames[-1].pts = 48000, round(48000 * self.late) + 1024 * k
        return stream, frames


def frames_of(path):
    """Decoded pictures of a film."""
    with av.open(path) as film:
        return list(film.decode(film.streams.best("video")))


def shown(path, maps=()):
    """RGB pictures of the film ``path`` as FFmpeg converts them, float (n, height, width, 3) of
    0 to 255; before, its filter ``remap`` takes the nearest pixels of ``maps`` (x, y)."""
    frames = frames_of(path)
    graph = Graph()
    # The matrix and the range are named, else the graph converts them to none.
    source = graph.add("buffer", (
        "video_size={0.width}x{0.height}:pix_fmt={0.format.name}:time_base={0.time_base}:"
        "colorspace={0.colorspace}:range={0.color_range}").format(frames[0]))
    sources = [(source, frames)]
    last = source
    if maps:
        last = graph.add("remap")
        source.link_to(last, 0, 0)
        for k, table in enumerate(maps):
            height, width = table.shape
            frame = av.VideoFrame.from_ndarray(np.rint(table).astype(np.uint16), "gray16le")
            frame.pts, frame.time_base = 0, frames[0].time_base
            buffer = graph.add_buffer(width=width, height=height, format="gray16le",
                                      time_base=frame.time_base)
            buffer.link_to(last, 0, k + 1)
            sources.insert(0, (buffer, [frame]))
    form, sink = graph.add("format", "rgb48le"), graph.add("buffersink")
    last.link_to(form)
    form.link_to(sink)
    graph.configure()
    for buffer, given in sources:
        for frame in given:
            buffer.push(frame)
        buffer.push(None)
    return np.array([frame.to_ndarray() for frame in _pulled(sink)]) / 257


def _pulled(sink):
    while True:
        try:
            yield sink.pull()
        except (av.error.EOFError, av.error.BlockingIOError):
            return

"""Format of a file by its first bytes, and known formats that are not supported."""

from enum import Enum

from ncdc_spec.errors import InputError

__all__ = ["HEAD", "Kind", "film_by", "film_of", "kind_of", "packet_of"]

HEAD = 1024             # bytes that show the format of a file


class Kind(Enum):
    """Formats with their own reader or check; the value is the name in messages."""
    PNG = "PNG"
    JPEG = "JPEG"
    JPEG_2000 = "JPEG 2000"
    AVIF = "AVIF"
    GIF = "GIF"
    WEBP = "WebP"
    BMP = "BMP"
    PNM = "PNM"
    TIFF = "TIFF"
    CAMERA_RAW = "camera RAW"
    NUMPY = "NumPy"
    OTHER = "image"


_READ = (
    (b"\x89PNG\r\n\x1a\n", Kind.PNG), (b"\xff\xd8\xff", Kind.JPEG),
    (b"\xff\x4f\xff\x51", Kind.JPEG_2000), (b"\0\0\0\x0cjP  \r\n", Kind.JPEG_2000),
    (b"GIF8", Kind.GIF), (b"BM", Kind.BMP), (b"\x93NUMPY", Kind.NUMPY),
    *((b"P%d" % digit, Kind.PNM) for digit in range(1, 8)),
    # Canon, Olympus, Panasonic and Phase One have their own signatures on a file like a TIFF.
    (b"II*\0\x10\0\0\0CR", Kind.CAMERA_RAW), (b"IIRO", Kind.CAMERA_RAW),
    (b"IIRS", Kind.CAMERA_RAW), (b"MMOR", Kind.CAMERA_RAW), (b"IIU\0", Kind.CAMERA_RAW),
    (b"IIII", Kind.CAMERA_RAW), (b"MMMM", Kind.CAMERA_RAW),
    (b"FUJIFILMCCD-RAW", Kind.CAMERA_RAW), (b"II\x1a\0\0\0HEAPCCDR", Kind.CAMERA_RAW),
    (b"\0MRM", Kind.CAMERA_RAW), (b"FOVb", Kind.CAMERA_RAW), (b"ARRI", Kind.CAMERA_RAW),
    (b"II*\0", Kind.TIFF), (b"MM\0*", Kind.TIFF), (b"II+\0", Kind.TIFF), (b"MM\0+", Kind.TIFF),
)

_PICTURE = "save the photo as PNG or TIFF"
_FRAME = ("a photo is needed: extract a frame as PNG, as by ffmpeg -ss 1 -i VIDEO -frames:v 1 "
          "frame.png; ncdc calibrate --live VIDEO measures the lens in the video itself")
_FILMS = (
    (0, b"\x1aE\xdf\xa3", "Matroska or WebM"), (0, b"\0\0\1\xba", "MPEG"),
    (0, b"\0\0\1\xb3", "MPEG"), (0, b"\0\0\0\1", "H.264 or H.265 stream"),
    (0, b"FLV\1", "Flash"), (0, b"OggS", "Ogg"), (0, b"YUV4MPEG2", "YUV4MPEG2"),
    (0, b"0&\xb2u\x8ef\xcf\x11", "Windows Media"), (0, b"DKIF", "IVF"),
    (0, b".RMF", "RealMedia"), (0, b"\x06\x0e+4\2\5\1\1", "MXF"),
    (0, b"nut/multimedia container", "NUT"), (8, b"AVI ", "AVI"),
    *((4, kind, "QuickTime") for kind in (b"moov", b"mdat", b"wide", b"free")))
# Where the packets of a transport stream begin, and how long they are.
_TRANSPORT = (0, 188), (4, 192), (0, 204)
_HEIC = "save the photo as PNG or TIFF, as by heif-convert PHOTO photo.png (libheif-examples)"
_NOT_READ = (
    (b"\xff\x0a", "a JPEG XL file", _PICTURE), (b"\0\0\0\x0cJXL ", "a JPEG XL file", _PICTURE),
    (b"%PDF", "a PDF document", _PICTURE), (b"%!PS", "a PostScript document", _PICTURE),
    (b"8BPS", "a Photoshop file", _PICTURE), (b"gimp xcf", "a GIMP file", _PICTURE),
    (b"v/1\x01", "an OpenEXR file of floating-point samples", _PICTURE),
    (b"#?RADIANCE", "a Radiance file of floating-point samples", _PICTURE),
    (b"PF\n", "a PFM file of floating-point samples", _PICTURE),
    (b"Pf\n", "a PFM file of floating-point samples", _PICTURE),
    (b"SIMPLE  =", "a FITS file", _PICTURE), (b"\x89HDF", "an HDF5 file", _PICTURE),
    (b"PK\3\4", "a zip archive, as .npz is", "unpack it, or save one array as .npy"),
    (b"\x1f\x8b", "a gzip archive", "unpack it"), (b"7z\xbc\xaf", "a 7-Zip archive", "unpack it"),
)
_HEIF = (b"heic", b"heix", b"heim", b"heis", b"hevc", b"hevx", b"mif1", b"msf1")


def film_of(head):
    """Name of the film's format that a file has with the first bytes ``head``, or None."""
    if head[4:8] == b"ftyp":
        pictures = head[8:12] in (b"crx ", b"avif", b"avis", *_HEIF)
        return None if pictures else "MP4 or QuickTime"
    for offset, signature, name in _FILMS:
        if head[offset:].startswith(signature):
            return name
    return "MPEG transport stream" if packet_of(head) else None


def packet_of(head):
    """Bytes of a packet of the transport stream that a file with the first bytes ``head`` is, or
    None."""
    return next((step for start, step in _TRANSPORT if len(head) > start + 2 * step and all(
        head[start + k * step] == ord("G") for k in range(3))), None)


def film_by(head, animated=False):
    """Whether a file with the first bytes ``head`` is a film; None if they do not say.

    A GIF is a film if ``animated``, else a picture.
    """
    if animated and head.startswith(b"GIF8"):
        return True
    if film_of(head):
        return True
    pictures = (*(one for one, _ in _READ), *(one[0] for one in _NOT_READ), b"RIFF")
    return False if head.startswith(pictures) or head[4:8] == b"ftyp" else None


def kind_of(content, path):
    """The :class:`Kind` of the file ``path`` with this ``content``, never by its suffix.

    Raises
    ------
    InputError
        If the file is empty or of a known format that is not read; the message names it.
    """
    if not len(content):
        raise InputError(f"{path} holds no image that can be decoded: it is empty")
    head = bytes(content[:HEAD])
    if film := film_of(head):
        raise InputError(f"{path} is a video ({film}), which is not supported; {_FRAME}")
    if head[4:8] == b"ftyp":
        return _boxes(head, path)
    if head[:4] == b"RIFF":
        return Kind.WEBP if head[8:12] == b"WEBP" else Kind.OTHER
    for signature, name, advice in _NOT_READ:
        if head.startswith(signature):
            raise InputError(f"{path} is {name}, which is not supported; {advice}")
    if head.lstrip(b"\xef\xbb\xbf \r\n\t")[:5].lower() in (b"<?xml", b"<svg ", b"<html", b"<!doc"):
        raise InputError(f"{path} is a text in XML or HTML, a picture is needed")
    return next((kind for signature, kind in _READ if head.startswith(signature)), Kind.OTHER)


def _boxes(head, path):
    """Kind of a file of the ISO base media format by its major brand."""
    brand = head[8:12]
    if brand == b"crx ":
        return Kind.CAMERA_RAW
    if brand in (b"avif", b"avis"):
        return Kind.AVIF
    if brand in _HEIF:
        # The codecs' brands are after a general one.
        if b"avif" in head[16:int.from_bytes(head[:4])]:
            return Kind.AVIF
        raise InputError(f"{path} is a HEIF photo (HEIC), which is not supported; {_HEIC}")
    raise AssertionError(brand)         # the others are films

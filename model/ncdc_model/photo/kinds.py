"""Format of a file by its first bytes, and known formats that are not supported."""

from enum import Enum

from ncdc_spec.errors import InputError

__all__ = ["Kind", "kind_of"]


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
          "frame.png")
_HEIC = "save the photo as PNG or TIFF, as by heif-convert PHOTO photo.png (libheif-examples)"
_NOT_READ = (
    (b"\x1aE\xdf\xa3", "a video (Matroska or WebM)", _FRAME),
    (b"\0\0\1\xba", "a video (MPEG)", _FRAME), (b"\0\0\1\xb3", "a video (MPEG)", _FRAME),
    (b"\0\0\0\1", "a video (H.264 or H.265 stream)", _FRAME), (b"FLV", "a video (Flash)", _FRAME),
    (b"OggS", "a video (Ogg)", _FRAME), (b"YUV4MPEG2", "a video (YUV4MPEG2)", _FRAME),
    (b"0&\xb2u\x8ef\xcf\x11", "a video (Windows Media)", _FRAME),
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


def kind_of(content, path):
    """The :class:`Kind` of the file ``path`` with this ``content``, never by its suffix.

    Raises
    ------
    InputError
        If the file is empty or of a known format that is not read; the message names it.
    """
    if not len(content):
        raise InputError(f"{path} holds no image that can be decoded: it is empty")
    head = bytes(content[:64])
    if head[4:8] == b"ftyp":
        return _boxes(head, path)
    if head[:4] == b"RIFF":
        if head[8:12] == b"AVI ":
            raise InputError(f"{path} is a video (AVI), {_FRAME}")
        return Kind.WEBP if head[8:12] == b"WEBP" else Kind.OTHER
    for signature, name, advice in _NOT_READ:
        if head.startswith(signature):
            raise InputError(f"{path} is {name}, which is not supported; {advice}")
    if head[4:8] in (b"moov", b"mdat", b"wide", b"free"):
        raise InputError(f"{path} is a video (QuickTime), which is not supported; {_FRAME}")
    if content[:1] == b"G" and content[188:189] == b"G" and content[376:377] == b"G":
        raise InputError(f"{path} is a video (MPEG transport stream), which is not supported; "
                         f"{_FRAME}")
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
    raise InputError(f"{path} is a video (MP4 or QuickTime), which is not supported; {_FRAME}")

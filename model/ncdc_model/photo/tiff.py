"""Reads one page of a TIFF file by tifffile as stored: no rotation, scaling or colour mixing."""

from io import BytesIO

import numpy as np
from tifffile import PHOTOMETRIC, TiffFile

from ncdc_model.photo.camera_raw import UnknownRaw, read_camera_raw
from ncdc_model.photo.photo import Photo
from ncdc_model.samples import eight_bits
from ncdc_spec.errors import InputError
from ncdc_spec.needs import pip_line

__all__ = ["read_tiff"]

_PIXELS = 178_000_000                   # the limit of other formats
_REDUCED, _MASK = 1, 4                  # bits of NewSubfileType
_JPEG = 6, 7                            # compressions
_CHANNELS = {PHOTOMETRIC.MINISWHITE: 1, PHOTOMETRIC.MINISBLACK: 1, PHOTOMETRIC.RGB: 3,
             PHOTOMETRIC.PALETTE: 1, PHOTOMETRIC.YCBCR: 3, PHOTOMETRIC.CFA: 1}
_MAKE, _DNG, _CFA_PATTERN, _CFA_SIZE, _WHITE = 271, 50706, 33422, 33421, 50717
# LinearizationTable, BlackLevel, ActiveArea: the samples are not linear in light.
_ALTERED = {50712, 50714, 50829}


def read_tiff(path, content, bits, warn):
    """The :class:`Photo` in ``content`` of the TIFF file ``path``.

    It is the first page that is no preview. LibRaw reads a file with a raw frame, as a DNG, NEF or
    ARW; if LibRaw does not support it, its page of filtered samples is used.

    Raises
    ------
    InputError
        If the file is damaged, of a variant that is not supported, or ``bits`` does not suit it.
    """
    try:
        with TiffFile(BytesIO(content)) as tiff:
            pages = [page for top in tiff.pages for page in (top, *(top.pages or ()))]
            if not pages:
                raise InputError(f"{path} holds no image that can be decoded: it is a TIFF file "
                                 f"without a page, or cut short")
            frames = [page for page in pages
                      if page.photometric in (PHOTOMETRIC.CFA, PHOTOMETRIC.LINEAR_RAW)
                      or _CFA_PATTERN in page.tags]
            if frames or _DNG in pages[0].tags:
                return _raw(path, content, pages[0], frames, bits, warn)
            return _page(path, _first(path, pages, warn), bits, warn, len(content))
    except (InputError, ModuleNotFoundError):
        raise
    except Exception as error:      # tifffile and its codecs raise many kinds for damaged files
        reason = str(error).strip().splitlines()[:1] or [type(error).__name__]
        if "imagecodecs" in reason[0]:
            raise InputError(f"{path} is compressed, and imagecodecs is not installed: "
                             f"{pip_line('calibrate')}") from error
        raise InputError(f"{path} holds no image that can be decoded: it is a TIFF file that is "
                         f"damaged or of a variant that is not supported ({reason[0]})") from error


def _first(path, pages, warn):
    """The first of ``pages`` that is neither a preview nor a mask."""
    whole = [page for page in pages if not page.subfiletype & (_REDUCED | _MASK)]
    if not whole:
        raise InputError(f"{path} holds only previews (NewSubfileType {pages[0].subfiletype}), "
                         f"no picture of full size")
    if len(whole) > 1:
        warn(f"{path}: the first of {len(whole)} pages is taken")
    elif whole[0] is not pages[0]:
        warn(f"{path} begins with a preview: its page of {whole[0].imagewidth}x"
             f"{whole[0].imagelength} pixels is taken")
    return whole[0]


def _raw(path, content, first, frames, bits, warn):
    """Photo of a file with a raw frame: by LibRaw, else of the page of filtered samples.

    LibRaw guesses the filter of a file that is no DNG and names neither maker nor filter.
    """
    cfa = next((page for page in frames if page.photometric == PHOTOMETRIC.CFA
                or _CFA_PATTERN in page.tags and page.samplesperpixel == 1), None)
    dng = _DNG in first.tags
    if dng or not cfa or _MAKE in first.tags and _CFA_PATTERN in cfa.tags:
        try:
            return read_camera_raw(path, content, bits, warn)
        except UnknownRaw:
            if not cfa or _ALTERED.intersection(cfa.tags.keys()):
                raise
    elif altered := _ALTERED.intersection(cfa.tags.keys()):
        raise InputError(f"{path} is a TIFF with a raw frame and the tag "
                         f"{cfa.tags[min(altered)].name}, which is supported in DNG only")
    white = cfa.tags.valueof(_WHITE)
    white = white[0] if isinstance(white, tuple) else white
    if white is None and dng:
        white = (1 << cfa.bitspersample) - 1
    photo = _page(path, cfa, bits, warn, len(content), white)
    warn(f"{path} is a {'DNG' if dng else 'TIFF'} with a raw frame: its page of {cfa.imagewidth}x"
         f"{cfa.imagelength} samples is taken, filter pattern {photo.bayer or 'not declared'}")
    return photo


def _page(path, page, bits, warn, length, white=None):
    """Photo of one page; ``white`` is the largest sample that another tag declares."""
    kind, width = page.photometric, page.bitspersample
    if (channels := _CHANNELS.get(kind)) is None or (kind == PHOTOMETRIC.YCBCR
                                                     and page.compression not in _JPEG):
        name = getattr(kind, "name", kind)
        raise InputError(f"{path} is a TIFF of the colour space {name}, which is not supported; "
                         f"save it as grey or RGB")
    if page.sampleformat not in (1, 4) or not isinstance(width, int) or not 1 <= width <= 16:
        raise InputError(f"{path} holds {page.dtype or width} samples, unsigned integers of 1 to "
                         f"16 bits are needed")
    _check_whole(path, page, length)
    extra = page.samplesperpixel - channels
    if extra < 0 or extra > 1:
        raise InputError(f"{path} is a TIFF of the colour space {kind.name} with "
                         f"{page.samplesperpixel} channels, {channels} are needed, or one more for "
                         f"transparency")
    samples = page.asarray()
    if page.axes == "SYX":
        samples = np.moveaxis(samples, 0, 2)
    size = page.imagelength, page.imagewidth
    if samples.shape not in (size, (*size, page.samplesperpixel)):
        raise InputError(f"{path} is a TIFF with the axes {page.axes} of {samples.shape}, one flat "
                         f"picture is needed")
    samples = samples.astype(np.uint8) if samples.dtype == bool else samples
    if samples.ndim == 3:
        samples = samples[:, :, 0] if channels == 1 else samples[:, :, :3]
    samples = np.ascontiguousarray(samples)
    full = (1 << width) - 1
    declared = white or (None if width == 16 else full)
    if kind == PHOTOMETRIC.MINISWHITE:
        warn(f"{path} is a TIFF in which 0 is white (MinIsWhite): inverted")
        image = 255 - eight_bits(samples, declared or (None if bits else full), bits, path, warn)
    elif kind == PHOTOMETRIC.PALETTE:
        image = _coloured(page, samples)
    else:
        image = eight_bits(samples, declared, bits, path, warn)
    return Photo(image, _pattern(path, page), page.compression in _JPEG and width == 8)


def _check_whole(path, page, length):
    """Raise :class:`InputError` if a strip or tile is missing, or the page is too large."""
    if page.imagewidth * page.imagelength > _PIXELS:
        raise InputError(f"{path} has {page.imagewidth}x{page.imagelength} pixels, {_PIXELS} in "
                         f"all are the limit")
    parts = list(zip(page.dataoffsets, page.databytecounts))
    if not parts or any(not size or start + size > length for start, size in parts):
        raise InputError(f"{path} holds no image that can be decoded: it is a TIFF file that is "
                         f"cut short")


def _coloured(page, samples):
    """uint8 colours, or greys if all are grey, of indices into the page's palette."""
    palette = page.colormap
    palette = (palette >> 8 if palette.max() > 255 else palette).astype(np.uint8)
    if np.array_equal(palette[0], palette[1]) and np.array_equal(palette[1], palette[2]):
        return palette[0][samples]
    return np.ascontiguousarray(palette.T)[samples]


def _pattern(path, page):
    """Letters of the page's filter pattern, or None if it has no tag for it."""
    pattern = page.tags.valueof(_CFA_PATTERN)
    if pattern is None:
        return None
    letters = "".join("RGB"[k] if k < 3 else "?" for k in bytes(pattern))
    size = page.tags.valueof(_CFA_SIZE)
    if tuple(size or (2, 2)) != (2, 2) or sorted(letters) != sorted("RGGB"):
        raise InputError(f"{path} has the filter pattern {letters} of {size}, a Bayer pattern of "
                         f"2x2 is needed")
    return letters

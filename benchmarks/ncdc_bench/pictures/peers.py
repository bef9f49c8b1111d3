"""Demosaicing by others: OpenCV's three ways, and two of the package colour-demosaicing."""

import warnings

import numpy as np

from ncdc_model.images import demosaic

__all__ = ["PEERS", "PEER_PACKAGE", "decoded"]

PEER_PACKAGE = "colour-demosaicing"
_OPENCV = {f"opencv {name}": name for name in ("bilinear", "edge-aware", "vng")}
# Malvar, He and Cutler (2004), and Menon, Andriani and Calvagno (2007) with refining.
_PACKAGED = {"malvar": "demosaicing_CFA_Bayer_Malvar2004",
             "menon": "demosaicing_CFA_Bayer_Menon2007"}
PEERS = (*_OPENCV, *_PACKAGED)


def decoded(peer, raw, bayer):
    """Colours of a raw frame by one of :data:`PEERS`.

    Parameters
    ----------
    peer : str
    raw : ndarray of uint8, shape (height, width)
    bayer : str
        Colour filter, as ``RGGB``.

    Returns
    -------
    ndarray of uint8, shape (height, width, 3), or None
        None if the package is not installed.
    """
    if peer in _OPENCV:
        return demosaic(raw, bayer, _OPENCV[peer])
    try:
        with warnings.catch_warnings():     # it imports SciPy by a name that SciPy deprecates
            warnings.simplefilter("ignore")
            import colour_demosaicing  # takes a second
    except ModuleNotFoundError as error:
        if error.name != "colour_demosaicing":
            raise
        return None
    colours = getattr(colour_demosaicing, _PACKAGED[peer])(raw.astype(np.float64), bayer)
    return np.clip(np.floor(colours + .5), 0, 255).astype(np.uint8)

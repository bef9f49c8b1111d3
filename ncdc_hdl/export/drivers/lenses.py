"""Lenses that one corrector can load at run time, and their values for its host."""

import re
from dataclasses import dataclass
from pathlib import Path

from ncdc_model.evaluate import check_curvature
from ncdc_model.planner.plan import best_split
from ncdc_spec.eeprom import kind_bytes
from ncdc_spec.errors import InputError, reading
from ncdc_spec.frames import check_format, output_format
from ncdc_spec.hardware import check_lanes
from ncdc_spec.registers.host_values import host_values, network_values, table_words
from ncdc_spec.registers.register_map import COLOUR_SETTINGS, RAW_GAINS

__all__ = ["Lens", "check_lens", "lens_name", "lenses_of"]

# Registers that the host sets: addresses of frames, the bank of valid rows, early start,
# colour.
_HOST = ("SOURCE_BASE", "SOURCE_LIMIT", "TARGET_BASE", "TARGET_LIMIT", "VALID_BANK", "FOLLOW",
         "CREST", *COLOUR_SETTINGS, *RAW_GAINS)


@dataclass(frozen=True)
class Lens:
    """Values of a descriptor for the host.

    Parameters
    ----------
    digest : str
    kind : bytes
        What no register can change, see :func:`ncdc_spec.eeprom.kind_bytes`.
    neurons, width, height : int
        Hidden neurons, those of the corrector; corrected image.
    interpolation : str
    source_bytes, target_bytes : int
        Bytes read of a raw frame; bytes of a corrected frame.
    values : dict
        Value of every shadow register that concerns the lens, by name.
    valid_rows : tuple of int
        Words of the table of valid rows, from row 0 on.
    """
    digest: str
    kind: bytes
    neurons: int
    width: int
    height: int
    interpolation: str
    source_bytes: int
    target_bytes: int
    values: dict
    valid_rows: tuple

    @classmethod
    def of(cls, corrector, descriptor):
        """The lens of ``descriptor`` on ``corrector``, with the split of the cache that suits it.

        A split for an unrotated lens takes several times the clocks with a rotated one.
        """
        neurons = corrector.descriptor.hidden_neurons
        values = host_values(descriptor, corrector.hardware, neurons=neurons)
        if corrector.hardware.cached and descriptor.digest != corrector.descriptor.digest:
            values["CACHE_SPLIT"] = best_split(descriptor, corrector.hardware)
        return cls(descriptor.digest, kind_bytes(descriptor), neurons,
                   *descriptor.geometry.corrected,
                   descriptor.geometry.interpolation.name,
                   values["SOURCE_LIMIT"] - values["SOURCE_BASE"],
                   values["TARGET_LIMIT"] - values["TARGET_BASE"],
                   {name: value for name, value in values.items() if name not in _HOST},
                   tuple(word for _, word in table_words(descriptor.valid)))


def lens_name(path):
    """Name of the lens of the descriptor at ``path``: the file's name, as an identifier."""
    return re.sub(r"\W", "_", Path(path).stem, flags=re.ASCII)


def check_lens(corrector, path, descriptor):
    """Reject a ``descriptor`` that ``corrector`` cannot load at run time.

    Raises
    ------
    InputError
        If there are more neurons, if formats, tan-sigmoid, interpolation or nodes differ, the
        nodes' error exceeds the limit, the table of valid rows is too small, the width is no
        multiple of the pixels per clock, or the corrector's format would lose the lens's colours.
    """
    made_for = corrector.descriptor
    with reading(path):
        network_values(descriptor, made_for.hidden_neurons)     # rejects more neurons
    for what, value, needed in (
            ("tan-sigmoid", descriptor.variant, made_for.variant),
            ("interpolation", descriptor.geometry.interpolation.name,
             made_for.geometry.interpolation.name),
            ("pixels from node to node", descriptor.nodes, made_for.nodes),
            *((f"format {name}", q, getattr(made_for.formats, name))
              for name, q in vars(descriptor.formats).items())):
        if value != needed:
            raise InputError(f"{path}: {what} {value} does not fit a corrector made for {needed}")
    columns, rows = corrector.table.largest
    if descriptor.geometry.corrected_height > rows:
        raise InputError(f"{path}: the corrected image has {descriptor.geometry.corrected_height} "
                         f"rows, the corrector's table of valid rows holds {rows}")
    width = descriptor.geometry.corrected_width
    if width > columns:
        raise InputError(f"{path}: the corrected image has {width} columns, the corrector's table "
                         f"of valid rows counts to {columns}")
    with reading(path):
        check_lanes(width, corrector.hardware.lanes)
        check_format(output_format(corrector.hardware.format), descriptor.geometry)
        check_curvature(descriptor)


def lenses_of(corrector, named):
    """:class:`Lens` by name of each (path, descriptor) in ``named``, for ``corrector``.

    Raises
    ------
    InputError
        If two names are equal, or a descriptor does not fit.
    """
    lenses, paths = {}, {}
    for path, descriptor in named:
        name = lens_name(path)
        if name in lenses:
            raise InputError(f"the lenses {paths[name]} and {path} both have the name {name}")
        check_lens(corrector, path, descriptor)
        lenses[name], paths[name] = Lens.of(corrector, descriptor), path
    return lenses

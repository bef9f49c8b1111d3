"""What a host writes to the registers to correct frames of a camera."""

from ncdc_spec.colour import COLOURS, Colour
from ncdc_spec.errors import InputError
from ncdc_spec.frames import (
    BGRX8,
    FrameAddresses,
    check_format,
    output_format,
    source_bytes,
    target_bytes,
)
from ncdc_spec.hardware import Hardware
from ncdc_spec.interpolation import check_crest
from ncdc_spec.registers.register_map import BAYER_MONO, RAW_GAINS, TABLE, network_registers
from ncdc_spec.view import View, view_values
from ncdc_spec.view_list import ONE_VIEW
from ncdc_spec.view_matrix import camera_values
from ncdc_spec.view_rows import rows_values

__all__ = ["address_values", "colour_values", "host_values", "network_values", "table_words"]

# Array of the descriptor that holds the parameters of a layer's part.
_ARRAYS = {("hidden", "weights"): "hidden_weights", ("hidden", "bias"): "hidden_biases",
           ("output", "weights"): "output_weights", ("output", "bias"): "output_biases",
           ("output", "skip"): "skip_weights"}


def network_values(descriptor, neurons=None):
    """Register values, by name, of the network of ``descriptor`` in hardware of ``neurons`` hidden
    neurons, by default its own number.

    Neurons that the network lacks have the weights and the bias 0.

    Raises
    ------
    InputError
        If the network has more neurons than the hardware.
    """
    own = descriptor.hidden_neurons
    if neurons is not None and own > neurons:
        raise InputError(f"the lens has {own} hidden neurons, the hardware has {neurons}")
    values = {}
    for register in network_registers(neurons or own, descriptor.formats):
        layer, neuron, part, *weight = register.parameter
        array = getattr(descriptor, _ARRAYS[layer, part])
        # Those of the output layer: its weight of a hidden neuron is numbered last.
        hidden = neuron if layer == "hidden" else weight[0] if part == "weights" else 0
        values[register.name] = int(array[(neuron, *weight)]) if hidden < own else 0
    return values


def address_values(geometry, data_width, addresses, form=BGRX8):
    """Register values, by name, of the ``addresses`` that the frames of ``geometry`` just fill, the
    corrected one in the :class:`OutputFormat` ``form``."""
    return {"SOURCE_BASE": addresses.source,
            "SOURCE_LIMIT": addresses.source + source_bytes(geometry, addresses.pitch),
            "TARGET_BASE": addresses.target,
            "TARGET_LIMIT": addresses.target + target_bytes(geometry, data_width, form)}


def colour_values(colour):
    """Register values, by name, of the gains after interpolation and the tone curve of ``colour``.
    """
    return {**{f"GAIN_{name.upper()}": gain for name, gain in zip(COLOURS, colour.gains)},
            **{f"TONE{k}": node for k, node in enumerate(colour.tone)}}


def host_values(descriptor, hardware=Hardware(), addresses=None, follow=False, colour=Colour(),
                neurons=None, view=None):
    """Register values, by name, that a host writes to correct frames of ``descriptor``'s camera.

    Parameters
    ----------
    descriptor : Descriptor
    hardware : Hardware
        Its data width, split, strips, format and colour count; others are those of the corrector.
    addresses : FrameAddresses, optional
        Those after reset if absent.
    follow : bool
        Whether the corrector begins before the raw frame is complete.
    colour : Colour
        Crest; gains before and after interpolation and tone curve, where the hardware has
        registers for them.
    neurons : int, optional
        As for :func:`network_values`.
    view : View, optional
        Where the hardware has one; the trained picture itself if absent.

    Raises
    ------
    InputError
        If the format would lose the camera's colours, the interpolation has no crest, the
        network has more neurons than the hardware, or there is a view and the descriptor states a
        camera of its picture that cannot be.
    """
    g, form = descriptor.geometry, output_format(hardware.format)
    check_format(form, g)
    check_crest(colour.crest, g.interpolation)
    view = view or View.identity(g.corrected)
    picture = view.geometry(g)
    addresses = addresses or FrameAddresses.after_reset(picture, hardware.data_width)
    origin_x, step_x, origin_y, step_y = g.scan()
    red, green, blue = g.fill
    return {
        **network_values(descriptor, neurons),
        "VALID_BANK": 0,
        **address_values(picture, hardware.data_width, addresses, form),
        "SOURCE_PITCH": addresses.pitch,
        "OUTPUT_FORMAT": form.code,
        "CORRECTED_WIDTH": view.size[0], "CORRECTED_HEIGHT": view.size[1],
        "DISTORTED_WIDTH": g.distorted_width, "DISTORTED_HEIGHT": g.distorted_height,
        "SCAN_ORIGIN_X": origin_x, "SCAN_STEP_X": step_x,
        "SCAN_ORIGIN_Y": origin_y, "SCAN_STEP_Y": step_y,
        "BAYER_PHASE": BAYER_MONO if g.mono else g.phase[0] | g.phase[1] << 1,
        "FILL": red << 16 | green << 8 | blue,
        "CACHE_SPLIT": hardware.split_for(g), "STRIP_WIDTH": hardware.strip, "FOLLOW": int(follow),
        "CREST": colour.crest,
        **(colour_values(colour) if hardware.colour else {}),
        **(dict(zip(RAW_GAINS, colour.raw_gains)) if hardware.raw_balance else {}),
        **(view_values(view, g.corrected_height) | camera_values(descriptor)
           if hardware.view else {}),
        **(ONE_VIEW if hardware.views else {}),
        **(rows_values(view.rows) if hardware.view_rows else {}),
    }


def table_words(valid):
    """(word address, value) of every entry of the table of valid rows."""
    return [(TABLE + 2 * row + k, spans[2 * k] | spans[2 * k + 1] << 16)
            for row, spans in enumerate(valid.spans.tolist()) for k in range(2)]

"""Clocks between events of a corrector for a picture that may be larger than hardware takes."""

from dataclasses import replace

from ncdc_hdl.corrector import Corrector
from ncdc_model.planner.scaled import hardware_takes

__all__ = ["planned_timing"]


def planned_timing(trained, descriptor, hardware):
    """:class:`CorrectorTiming` of a corrector for ``descriptor``, which is ``trained`` or the same
    lens in another size.

    Of a size without hardware it is that of the trained picture with as many tan-sigmoids: the
    latencies depend on nothing else that the size changes.

    Raises
    ------
    InputError
        As of :meth:`ncdc_spec.hardware.Hardware.made_for`.
    """
    if hardware_takes(descriptor.geometry):
        return Corrector(descriptor, hardware).timing
    return Corrector(trained, replace(hardware, share=hardware.made_for(descriptor).share)).timing

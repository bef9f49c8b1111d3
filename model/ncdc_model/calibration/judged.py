"""A calibration as a whole: straightness, the ideal frame, and warnings."""

from ncdc_model.calibration.frame import ideal_frame
from ncdc_model.calibration.measure import measure_smooth
from ncdc_model.calibration.quality import warnings_of
from ncdc_spec.errors import InputError

__all__ = ["judged"]


def judged(points):
    """Straightness with a smooth lens, the frame it was measured in, and warnings.

    Without a lens that explains the points the first is empty, the second None, and the
    warning says why.
    """
    try:
        try:
            frame = ideal_frame(points)
        except InputError:
            # A lens of 180 degrees fits no flat picture; its middle does.
            frame = ideal_frame(points, zoom=1.0)
    except InputError as error:
        return {}, None, [str(error)]
    measured = measure_smooth(frame)
    return measured, frame, warnings_of(points, frame, measured)

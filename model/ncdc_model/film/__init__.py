"""Films: each picture of one is changed, and the rest of it stays as it was.

PyAV brings FFmpeg's libraries. Pictures keep their samples' bits, their colours' tags and their
times; sound, subtitles and data are copied. :mod:`ncdc_model.film.kept` names what is lost.
"""

from ncdc_model.film.changing import change_film
from ncdc_model.film.reading import frame_shape, pictures_of
from ncdc_model.film.writing import writing_film

__all__ = ["change_film", "frame_shape", "pictures_of", "writing_film"]

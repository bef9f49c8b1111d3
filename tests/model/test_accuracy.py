"""What a trained camera's integers cost, over whole frames of the built-in example."""

import numpy as np
import pytest

from ncdc_model.evaluate import evaluate_frame
from ncdc_model.example import BAYER, example_camera, noise_picture
from ncdc_model.golden.corrector import correct
from ncdc_model.reference import correct_real, grey_level_difference
from ncdc_model.training.choices import TrainingChoices
from ncdc_model.training.pipeline import train_camera
from ncdc_model.training.source import load_source
from ncdc_spec.interpolation import FAST, GRADIENT

regress = pytest.mark.regress


@pytest.fixture(scope="module")
def camera(tmp_path_factory):
    path = tmp_path_factory.mktemp("camera") / "camera.toml"
    example_camera().save(path)
    return path


# How well the network is trained is not asked: few starts miss the map by less than a pixel too.
FEW_STARTS = {"starts": 6, "rounds": 0}


@pytest.mark.longer
@pytest.mark.parametrize("neurons,needs,options", [
    (4, GRADIENT, FEW_STARTS), (12, GRADIENT, FEW_STARTS), (4, FAST, FEW_STARTS),
    *(pytest.param(n, needs, {}, marks=regress) for needs in (GRADIENT, FAST)
      for n in range(4, 13))])
def test_integers_add_little_to_the_map_and_blanking_is_exact(camera, neurons, needs, options):
    source = load_source(camera, bayer=BAYER, interpolation=needs)
    d = train_camera(source, neurons, TrainingChoices(options=options)).descriptor
    errors = evaluate_frame(d, source.back_map)
    # The paper's own fixed point multiplied its MSE by four.
    assert errors["fixed_minus_float_max_px"] <= 0.0022
    assert errors["map_error_fixed_px"]["mse"] <= 1.01 * errors["map_error_float_px"]["mse"] + 1e-5
    raw = noise_picture(*d.geometry.distorted)
    result = correct(d, raw)
    assert grey_level_difference(result.picture, correct_real(d, raw)) <= 1
    v, u = np.indices(d.geometry.corrected[::-1])
    has_source = d.geometry.window_inside(*source.back_map(u, v))
    if neurons >= 6:
        # Errors below a pixel: the window is moved in at the edge, what is blank is the truth.
        assert errors["map_error_fixed_px"]["max"] < 1
        np.testing.assert_array_equal(result.blank, ~has_source)
    assert result.blank[~has_source].all(), "shown from the network's extrapolation"

"""``ncdc bench grid``: what an uneven Bayer grid costs, and what evening it gives back."""

import json

import numpy as np
import pytest

from cameras import barrel_descriptor
from ncdc.cli import main
from ncdc_bench.grid.light import MARGIN, Light, camera_of, photo_light, scene_light
from ncdc_bench.grid.measure import GRIDS, SAMPLINGS, measure, samples
from ncdc_model.example import example_camera
from ncdc_model.example import scene_light as example_light
from ncdc_model.images import write_image
from ncdc_spec.errors import InputError
from ncdc_spec.interpolation import INTERPOLATIONS

SIZE = 96, 64


def light_of(field, reduction, size=SIZE):
    """:class:`Light` whose grey is ``field(x, y)`` at each active pixel."""
    y, x = np.indices([length * reduction + 2 * MARGIN for length in size[::-1]]) - MARGIN
    return Light("field", reduction, np.repeat(field(x, y)[..., None], 3, 2).astype(np.float32))


@pytest.mark.parametrize("sampling", SAMPLINGS)
def test_samples_are_those_of_their_positions(sampling):
    """On a ramp a mean is the value in the middle of its pixels."""
    s, members = SAMPLINGS[sampling]
    light = light_of(lambda x, y: 40 + x / 4 + y / 8, s)
    index = np.arange(SIZE[0])
    middle = np.mean(members)
    for even, x in ((True, s * index), (False, 2 * s * (index // 2) + index % 2)):
        y = x[:SIZE[1], None]
        value = 40 + (x + middle) / 4 + (y + middle) / 8
        assert np.abs(samples(light, members, even, "RGGB")
                      - (value * 16 + 168)).max() <= .5


@pytest.mark.parametrize("sampling", SAMPLINGS)
def test_figures_of_detail_that_the_grid_can_hold(sampling):
    """Waves of 16 and 20 samples: evening gives back at least half of the loss."""
    s, _ = SAMPLINGS[sampling]
    light = light_of(lambda x, y: 120 + 80 * np.sin(x / s * .39) * np.cos(y / s * .31), s)
    rows = measure(barrel_descriptor(SIZE, SIZE, strength=.1), light, sampling, "RGGB")
    assert [row["grid"] for row in rows] == [*GRIDS] * len(INTERPOLATIONS)
    for even, uneven, evened in (rows[k:k + 3] for k in range(0, len(rows), 3)):
        assert even["gain_db"] == even["gain_mean_db"] == 0
        assert uneven["gain_db"] < -1 and evened["gain_db"] > uneven["gain_db"] / 2
        assert uneven["gain_mean_db"] < -1 and evened["gain_mean_db"] > uneven["gain_mean_db"] / 2
        assert evened["gain_db"] == evened["psnr_db"] - even["psnr_db"]


def test_light_of_the_built_in_scene_is_the_scene():
    """Averaged over the pixels of the small frame it is what that frame's camera sees."""
    camera = camera_of(example_camera(), SIZE)
    light = scene_light(camera, 4, 0)
    assert light.size == SIZE and light.values.shape == (64 * 4 + 32, 96 * 4 + 32, 3)
    # Active pixel 0 lies in the middle of sample 0: the mean lies half a pixel before it.
    inside = light.values[MARGIN - 2:-MARGIN - 2, MARGIN - 2:-MARGIN - 2]
    inside = inside.reshape(64, 4, 96, 4, 3).mean(axis=(1, 3))
    seen = example_light(camera)
    assert np.corrcoef(inside.ravel(), seen.ravel())[0, 1] > .94


def test_a_lens_of_another_size_is_the_same_lens():
    camera = example_camera()
    half = camera_of(camera, (320, 240))
    for a, b in ((0, 0), (.5, -.3), (-.7, .6)):
        whole, small = camera.distort(a, b), half.distort(a, b)
        assert np.allclose(np.subtract(small, (160, 120)), np.subtract(whole, (320, 240)) / 2,
                           atol=.05)


def test_a_photo_is_taken_pixel_by_pixel():
    photo = np.random.default_rng(1).integers(0, 256, (330, 429)).astype(np.uint8)
    light = photo_light("noise", photo, 4, 0)
    assert light.size == (98, 74)
    assert np.array_equal(light.values[..., 1], photo[:328, :424])
    assert photo_light("noise", photo, 4, 2).values.std() < light.values.std() / 4


@pytest.mark.longer
def test_what_is_too_small_or_out_of_range(tmp_path, capsys):
    small = np.zeros((223, 400), np.uint8)
    with pytest.raises(InputError, match="it has 400x223|small has 400x223 pixels: reduced by 4"):
        photo_light("small", small, 4, 1)
    write_image(tmp_path / "a.png", small)
    assert main(["bench", "grid", str(tmp_path / "a.png"), "--blur", "-1"]) == 2
    assert "blur is -1.0, it must be 0 to 16" in capsys.readouterr().err


@pytest.mark.regress
def test_command(tmp_path, capsys):
    photo = np.random.default_rng(1).integers(0, 256, (288, 352, 3)).astype(np.uint8)
    write_image(tmp_path / "a.png", photo)
    assert not main(["bench", "grid", str(tmp_path / "a.png"), "--json", str(tmp_path / "b.json")])
    report = json.loads((tmp_path / "b.json").read_text())
    assert report["blur_px"] == 1 and len(report["rows"]) == 2 * 4 * len(INTERPOLATIONS) * 3
    assert not main(["bench", "grid", str(tmp_path / "a.png")])
    printed = capsys.readouterr().out.splitlines()
    assert sum(line.startswith("mean of all") for line in printed) == 8

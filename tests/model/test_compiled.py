"""The compiled model has the reference's bits; and what happens where it cannot be had."""

import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest

from cameras import barrel_descriptor
from ncdc_model import correction
from ncdc_model.compiled import library
from ncdc_model.correction import (
    COMPILED,
    REFERENCE,
    Correction,
    coloured,
    correct,
    correction_of,
    default_model,
    frame_coordinates,
)
from ncdc_model.golden import colour as golden_colour
from ncdc_model.golden import corrector as golden
from ncdc_model.golden import network
from ncdc_spec.colour import Colour
from ncdc_spec.errors import InputError
from ncdc_spec.fixed import Q
from ncdc_spec.formats import MAX_NEURONS, Formats
from ncdc_spec.geometry import BAYERS, MONO, ValidRows
from ncdc_spec.interpolation import DIRECTIONAL, FAST, GRADIENT, INTERPOLATIONS
from ncdc_spec.nodes import NODES, nodes_fit
from ncdc_spec.tansig import FRACTION_BITS, VARIANTS


def random_formats(rng):
    """Formats in which inputs, weights, the tan-sigmoid and coordinates have random widths."""
    return Formats(input=Q(1, int(rng.integers(12, 24))),
                   hidden_weight=Q(4, int(rng.integers(12, 21))),
                   hidden_bias=Q(5, int(rng.integers(12, 28))),
                   tansig=Q(1, 1 + int(rng.choice(FRACTION_BITS))),
                   coordinate=Q(14, int(rng.integers(1, 15))))


def random_descriptor(rng):
    """A descriptor of random size, sensor, interpolation, formats, tan-sigmoid and nodes.

    Its network is a rough lens, or one without any sense, whose sums saturate.

    Raises
    ------
    InputError
        If what was drawn does not go together.
    """
    interpolation = rng.choice(list(INTERPOLATIONS.values()))
    sizes = [tuple(int(side) for side in rng.integers(8, 80, 2)) for _ in range(2)]
    bayer = rng.choice([each for each in BAYERS if each != MONO or interpolation != FAST])
    lens = barrel_descriptor(*sizes, hidden_neurons=int(rng.integers(1, 9)),
                             seed=int(rng.integers(1 << 30)), strength=rng.uniform(-.2, 1.5),
                             bayer=str(bayer), interpolation=interpolation,
                             fill=tuple(rng.integers(0, 256, 3).tolist()))
    values = lens.network
    if rng.random() < .5:
        values = replace(values, skip_weights=rng.uniform(-30, 30, (2, 2)))
    if rng.random() < .3:
        shape, scale = values.output_weights.shape, rng.choice([80, 2000])
        values = replace(values, hidden_weights=rng.uniform(-7, 7, shape[::-1]),
                         hidden_biases=rng.uniform(-15, 15, shape[1]),
                         output_weights=rng.uniform(-scale, scale, shape))
    valid = lens.valid
    if rng.random() < .3:
        valid = ValidRows.of_mask(rng.random(sizes[0][::-1]) < .8)
    nodes = int(rng.choice([each for each in NODES if nodes_fit(each, sizes[0][0])]))
    return type(lens).quantise(values, lens.geometry, valid, random_formats(rng), nodes=nodes,
                               variant=str(rng.choice(list(VARIANTS))))


def drawn(rng):
    """A :func:`random_descriptor`: the first one that can be had."""
    while True:
        try:
            return random_descriptor(rng)
        except InputError:
            pass


def random_frame(rng, geometry):
    """A raw frame: noise, noise of two values, or one value."""
    highest, lowest = int(rng.choice([255, 255, 1])), int(rng.choice([0, 0, 255]))
    values = rng.integers(0, highest + 1, geometry.distorted[::-1])
    return np.maximum(values, lowest).astype(np.uint8)


def bits_different(rng):
    """Bits in which the models differ, of a random descriptor and frame."""
    descriptor = drawn(rng)
    geometry = descriptor.geometry
    crest = int(rng.integers(3)) if geometry.interpolation == DIRECTIONAL else 0
    strip = int(rng.choice([0, 32]))
    raw = random_frame(rng, geometry)
    colour = Colour(tuple(rng.integers(0, 1024, 3).tolist()),
                    tuple(rng.integers(0, 257, 17).tolist()), crest)
    mine = correct(descriptor, raw, strip=strip, crest=crest, model=COMPILED)
    reference = golden.correct(descriptor, raw, strip=strip, crest=crest)
    pairs = [(frame_coordinates(descriptor), np.stack(network.frame_coordinates(descriptor))),
             (mine.picture, reference.picture), (mine.blank, reference.blank),
             (coloured(mine, colour, COMPILED), golden_colour.coloured(reference, colour)),
             (np.int64(mine.fetches), np.int64(reference.fetches))]
    return sum(int(np.bitwise_count(a.astype(np.int64) ^ b.astype(np.int64)).sum())
               for a, b in pairs)


@pytest.mark.parametrize("seed", range(4))
def test_random_descriptors_and_frames(seed):
    rng = np.random.default_rng(seed)
    assert sum(bits_different(rng) for _ in range(10)) == 0


@pytest.mark.longer
def test_500_random_descriptors_and_frames():
    rng = np.random.default_rng(500)
    assert sum(bits_different(rng) for _ in range(500)) == 0


def lens_of_nets(nets, weights, variant="mmhbc", bits=20):
    """A descriptor whose hidden neurons have these nets at every pixel, raw in Q5.19.

    Its coordinates show the last bit of each tan-sigmoid.
    """
    lens = barrel_descriptor((8, 8), (8, 8), hidden_neurons=len(nets))
    values = replace(lens.network, hidden_weights=np.zeros((len(nets), 2)),
                     hidden_biases=np.asarray(nets) / 2**19, output_weights=weights)
    formats = replace(Formats().with_tansig_bits(bits), coordinate=Q(14, 18))
    return type(lens).quantise(values, lens.geometry, lens.valid, formats, variant=variant)


@pytest.mark.parametrize("variant", VARIANTS)
@pytest.mark.parametrize("bits", FRACTION_BITS)
def test_the_tan_sigmoid_around_whole_numbers_and_everywhere(variant, bits):
    whole, rng = np.arange(-16, 16) << 19, np.random.default_rng(4)
    nets = np.concatenate([whole, whole + 1, whole - 1, [2**23 - 1],
                           rng.integers(-2**23, 2**23, 255)])
    for few in np.array_split(np.maximum(nets, -2**23), len(nets) // MAX_NEURONS + 1):
        lens = lens_of_nets(few, rng.uniform(-200, 200, (2, len(few))), variant, bits)
        np.testing.assert_array_equal(frame_coordinates(lens), network.frame_coordinates(lens))


def test_coordinates_saturate():
    lens = lens_of_nets([2**23 - 1] * 8, np.array([[2000.], [-2000.]]).repeat(8, axis=1))
    x, y = frame_coordinates(lens)
    assert (x == lens.formats.coordinate.hi).all() and (y == lens.formats.coordinate.lo).all()


def test_corners_are_those_of_both_models():
    descriptor = barrel_descriptor((90, 40), (64, 52), strength=.6, interpolation=GRADIENT)
    mine, reference = (Correction(descriptor, model) for model in (COMPILED, REFERENCE))
    assert not mine.blank.all() and mine.blank.any()
    np.testing.assert_array_equal(mine.blank, reference.blank)
    for ours, theirs in zip(mine.corners(), reference.corners(), strict=True):
        np.testing.assert_array_equal(ours, theirs)
        assert ours.dtype == theirs.dtype


def test_the_map_of_a_lens_is_computed_once(monkeypatch):
    made = []
    monkeypatch.setattr(correction, "CompiledCorrector",
                        lambda descriptor, *sources: made.append(descriptor))
    correction._cached.cache_clear()
    lens, same, other = (barrel_descriptor(seed=seed) for seed in (41, 41, 42))
    assert correction_of(lens, COMPILED) is correction_of(same, COMPILED)
    assert correction_of(other, COMPILED) is not correction_of(lens, COMPILED)
    assert made == [lens, other]
    correction._cached.cache_clear()


def test_a_frame_that_does_not_fit_is_rejected():
    one = Correction(barrel_descriptor(), COMPILED)
    with pytest.raises(InputError, match="has 40x48 pixels, the descriptor is for 48x40"):
        one(np.zeros((48, 40), np.uint8))
    with pytest.raises(InputError, match="one 8-bit channel is needed"):
        one(np.zeros((40, 48), np.uint16))
    with pytest.raises(InputError, match="a crest needs directional"):
        one(np.zeros((40, 48), np.uint8), crest=1)


def test_a_frame_may_be_part_of_a_larger_array():
    lens = barrel_descriptor(interpolation=DIRECTIONAL)
    whole = np.random.default_rng(2).integers(0, 256, (80, 96), np.uint8)
    for part in (whole[::2, ::2], whole[:40, :48][::-1, ::-1], np.asfortranarray(whole[:40, :48])):
        np.testing.assert_array_equal(correct(lens, part, model=COMPILED).picture,
                                      golden.correct(lens, part).picture)


@pytest.fixture
def unloaded(monkeypatch):
    """The library, not loaded yet, and forgotten afterwards."""
    library._loaded.cache_clear()
    monkeypatch.delenv("NCDC_MODEL", raising=False)
    yield
    library._loaded.cache_clear()


def test_without_a_compiler_the_reference_is_used(unloaded, monkeypatch):
    monkeypatch.setenv("PATH", "")
    monkeypatch.delenv("CC", raising=False)
    said = []
    assert default_model(said.append) == REFERENCE
    assert said == ["the reference model is used, which takes a hundred times as long: no C "
                    "compiler is installed: apt install gcc"]
    with pytest.raises(InputError, match="no C compiler is installed: apt install gcc"):
        Correction(barrel_descriptor(), COMPILED)


def test_a_compiler_that_fails_is_named(unloaded, monkeypatch, tmp_path):
    monkeypatch.setenv("NCDC_CACHE", str(tmp_path))
    compiler = tmp_path / "cc"
    compiler.write_text("#!/bin/sh\necho cc: no such option >&2\nexit 1\n")
    compiler.chmod(0o755)
    monkeypatch.setenv("CC", str(compiler))
    with pytest.raises(InputError, match="cc cannot compile the model: cc: no such option"):
        library.library()


@pytest.mark.parametrize("damage", [
    lambda content: b"garbage", lambda content: bytes(len(content)), lambda content: b"",
    lambda content: content[:len(content) // 2], None],
    ids=["other", "zeros", "empty", "half", "none"])
def test_a_damaged_library_is_compiled_again(monkeypatch, tmp_path, damage):
    """As after a power cut. The compiler is a copy of what the real one has made."""
    made = library.library()._name
    compiler = tmp_path / "cc"
    compiler.write_text(f"""#!/bin/sh
case "$*" in *-dM*) exit;; esac
while [ "$1" != -o ]; do shift; done
echo compiled >> {tmp_path}/log
cp {made} "$2"
""")
    compiler.chmod(0o755)
    monkeypatch.setenv("NCDC_CACHE", str(tmp_path / "cache"))
    monkeypatch.setenv("CC", str(compiler))
    library._load()
    file, = (tmp_path / "cache").glob("model-*/model.so")
    content = file.read_bytes()
    # As another file: the library is mapped into this process.
    file.unlink()
    if damage:
        file.write_bytes(damage(content))
    loaded = library._load()
    assert loaded._name == str(file) and file.read_bytes() == content
    library._load()
    assert (tmp_path / "log").read_text() == 2 * "compiled\n"


def test_a_folder_of_builds_that_cannot_be_written(unloaded, monkeypatch, tmp_path):
    file = tmp_path / "file"
    file.touch()
    monkeypatch.setenv("NCDC_CACHE", str(file / "cache"))
    assert default_model() == REFERENCE


def test_the_model_of_the_environment(monkeypatch):
    monkeypatch.setenv("NCDC_MODEL", REFERENCE)
    assert Correction(barrel_descriptor()).model == REFERENCE
    monkeypatch.setenv("NCDC_MODEL", "quick")
    with pytest.raises(InputError, match="NCDC_MODEL is 'quick', one of compiled, reference"):
        Correction(barrel_descriptor())


def test_the_reference_does_not_import_the_compiled_model():
    code = ("import sys, ncdc_model.golden.corrector, ncdc_model.golden.colour\n"
            "assert not [name for name in sys.modules if 'compiled' in name]")
    subprocess.run([sys.executable, "-c", code], check=True)

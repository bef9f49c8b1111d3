"""The TMDS encoder, and that what checks it finds a wrong bit."""

import numpy as np
import pytest
from amaranth import DomainRenamer

from ncdc_hdl.video.tmds import CONTROL, TmdsEncoder
from units.tmds import check_tmds, decoded, encoded, specified


def encoder():
    """An encoder in the domain of all benches."""
    return DomainRenamer({"pixel": "sync"})(TmdsEncoder())


@pytest.mark.parametrize("seed", [1, 2])
def test_every_word_is_the_specifications(seed):
    check_tmds(encoder(), seed)


def test_a_receiver_can_live_on_it():
    """Few bits of a picture's words change, and about as many are ones as zeros.

    A control word changes more often than any of them.
    """
    items = [(1, int(byte)) for byte in np.random.default_rng(3).integers(0, 256, 2000)]
    words = encoded(encoder(), items)
    changes = [sum(a != b for a, b in zip(word, word[1:9])) for word in words]
    assert max(changes) <= 5
    sums = np.cumsum([2 * sum(word) - 10 for word in words])
    assert abs(sums).max() <= 10
    tokens = [[token >> k & 1 for k in range(10)] for token in CONTROL]
    assert min(sum(a != b for a, b in zip(token, token[1:])) for token in tokens) >= 7


def test_a_wrong_bit_is_found():
    assert all(decoded([*word[:k], 1 - word[k], *word[k + 1:]]) != value
               for value in range(256) for word in [specified(value, 0)[0]] for k in range(10))

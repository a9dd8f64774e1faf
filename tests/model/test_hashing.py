"""One number for everything a chunk is made from."""

from dataclasses import dataclass

import numpy as np
import pytest

from usdfoot.model.hashing import content_hash


@dataclass(frozen=True)
class Pair:
    first: object
    second: object


def test_equal_values_have_equal_hashes():
    def value():
        return Pair({"b": 2, "a": (1, 2.5, None)}, np.arange(6.0).reshape(2, 3))

    assert content_hash(value(), "x") == content_hash(value(), "x")


@pytest.mark.parametrize(
    ("one", "other"),
    [
        (("ab", "c"), ("a", "bc")),
        ((1, (2,)), ((1, 2), ())),
        (1, 1.0),
        ("1", 1),
        (None, "None"),
        (np.zeros(2), np.zeros((2, 1))),
        (np.zeros(2), np.zeros(2, dtype=np.float32)),
        (Pair(1, 2), Pair(2, 1)),
        (Pair(1, 2), (1, 2)),
        ({"a": 1}, {"a": 2}),
    ],
)
def test_different_values_have_different_hashes(one, other):
    assert content_hash(one) != content_hash(other)


def test_an_object_without_a_value_is_refused():
    with pytest.raises(TypeError, match="object"):
        content_hash(object())

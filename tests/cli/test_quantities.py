"""Arguments that are read, and those that are refused with what would be right."""

import argparse

import pytest

from usdfoot.cli import quantities


@pytest.mark.parametrize(
    ("quantity", "text", "value"),
    [
        ("number", "-1e3", -1000.0),
        ("above_zero", "1e-9", 1e-9),
        ("root_weight", "0", 0.0),
        ("root_weight", "1", 1.0),
        ("distance", "0", 0.0),
        ("duration", "0", 0.0),
        ("span", "0.5", 0.5),
        ("rate", "29.97", 29.97),
        ("count", "1", 1),
        ("several", "2", 2),
        ("seed", "0", 0),
        ("frame_range", "-5:-5", (-5, -5)),
        ("warp_range", "0.5:2", (0.5, 2.0)),
        ("area", "-1,-2,3,4.5", (-1.0, -2.0, 3.0, 4.5)),
    ],
)
def test_the_quantity_is_read(quantity, text, value):
    assert getattr(quantities, quantity)(text) == value


@pytest.mark.parametrize(
    ("quantity", "texts"),
    [
        ("number", ("x", "nan", "inf", "-inf", "")),
        ("above_zero", ("0", "-1", "nan", "inf")),
        ("root_weight", ("-0.1", "1.1", "nan")),
        ("distance", ("-1", "inf", "nan")),
        ("duration", ("-1", "inf", "nan")),
        ("span", ("0", "inf", "nan")),
        ("rate", ("0", "inf", "nan")),
        ("count", ("0", "1.5", "-1")),
        ("several", ("1", "two")),
        ("seed", ("-1", "1.5", "x")),
        ("frame_range", ("5:4", "1", "1:2:3", "a:b")),
        ("warp_range", ("2:1", "1.5:2", "0:1", "1", "a:b")),
        ("area", ("1,2,3", "3,0,1,1", "0,0,inf,1", "a,b,c,d")),
    ],
)
def test_what_is_none_is_refused_with_its_text(quantity, texts):
    for text in texts:
        with pytest.raises(argparse.ArgumentTypeError, match="is no"):
            getattr(quantities, quantity)(text)

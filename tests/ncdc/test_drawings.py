"""Drawings of the documentation: every text in its box."""

import pytest

from drawings import misplaced
from ncdc_bench.figures.box_drawing import boxes_figure
from ncdc_bench.figures.guide_diagrams import DRAWINGS
from ncdc_bench.figures.packet_diagrams import packets_figure
from ncdc_bench.figures.sdram_clock_diagram import draw_sdram_clock


@pytest.mark.parametrize("name", DRAWINGS)
def test_no_text_lies_over_a_box_or_another_text(name):
    assert misplaced(boxes_figure(*DRAWINGS[name])) == []


def test_every_name_fits_its_field():
    assert misplaced(packets_figure()) == []


def test_the_drawing_of_clocks_is_written(tmp_path):
    draw_sdram_clock(tmp_path / "clock.png")
    assert (tmp_path / "clock.png").stat().st_size > 10_000


def test_texts_over_boxes_and_texts_are_found():
    boxes = (0, 0, 2, 2, "a"), (4, 0, 2, 2, "b" * 60)
    assert ("b" * 60, "box") in misplaced(boxes_figure(boxes, ()))
    close = (2, 4, 1.0, "one", "two"), (2, 4, .9, "three", "four")
    assert ("three", "two") in misplaced(boxes_figure(boxes[:1] + ((4, 0, 2, 2, "b"),), close)) \
        or ("three", "one") in misplaced(boxes_figure(boxes[:1], close))

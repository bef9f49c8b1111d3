"""Drawings of the documentation: every text in its box."""

import pytest

from drawings import misplaced
from ncdc_bench.figures import axi_diagram, board_diagrams, guide_diagrams
from ncdc_bench.figures.box_drawing import boxes_figure
from ncdc_bench.figures.packet_diagrams import packets_figure

BOXES = {name: (boxes, arrows, note, guide_diagrams.size_of(name),
                guide_diagrams.VERTICAL.get(name, ()))
         for name, (boxes, arrows, note) in guide_diagrams.DRAWINGS.items()}
BOXES |= {"axi.png": axi_diagram.DRAWING, "board.png": board_diagrams.DRAWING}


@pytest.mark.parametrize("name", BOXES)
def test_no_text_lies_over_a_box_or_another_text(name):
    assert misplaced(boxes_figure(*BOXES[name])) == []


def test_every_name_fits_its_field():
    assert misplaced(packets_figure()) == []


def test_drawings_of_boards_are_written(tmp_path):
    board_diagrams.draw_all(tmp_path)
    assert {path.name for path in tmp_path.iterdir()} == {"board.png", "board-sdram-clock.png"}


def test_texts_over_boxes_and_texts_are_found():
    boxes = (0, 0, 2, 2, "a"), (4, 0, 2, 2, "b" * 60)
    assert ("b" * 60, "box") in misplaced(boxes_figure(boxes, ()))
    close = (2, 4, 1.0, "one", "two"), (2, 4, .9, "three", "four")
    assert ("three", "two") in misplaced(boxes_figure(boxes[:1] + ((4, 0, 2, 2, "b"),), close)) \
        or ("three", "one") in misplaced(boxes_figure(boxes[:1], close))

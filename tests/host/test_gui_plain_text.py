"""What a device says is shown as text: HTML in it is neither drawn nor followed."""

import ast
from pathlib import Path

import pytest
from PySide6.QtCore import Qt
from PySide6.QtGui import QTextDocument
from PySide6.QtWidgets import QLabel

import ncdc_host.gui
from ncdc_host.client import Found
from ncdc_host.gui.device_tab import DeviceTab, Session
from ncdc_host.gui.devices_panel import DevicesPanel

EVIL = '<h1>EVIL</h1><img src="/dev/zero">'
ROOM = Path(ncdc_host.gui.__file__).parent
# Labels whose text is written in the window's own source: a title, the welcome, an icon.
RICH = {"devices_panel.py": 1, "main_window.py": 1, "message_bar.py": 1}


def drawn(tip):
    """The text that Qt draws of a tool tip, and the files that it reads for it."""
    files = []

    class Document(QTextDocument):
        def loadResource(self, kind, name):
            files.append(name.toString())

    document = Document()
    document.setHtml(tip)
    document.size()
    return document.toPlainText(), files


def test_names_of_devices_are_text(qtbot):
    assert drawn(EVIL)[1]           # Qt would read it
    panel = DevicesPanel()
    qtbot.addWidget(panel)
    panel.show_found([Found("gige://127.0.0.9", "127.0.0.9", "", EVIL, "<b>model</b>", "<u>1")])
    text, files = drawn(panel.list.item(0).toolTip())
    assert text.split("\n") == [EVIL, "<b>model</b>", "<u>1", "gige://127.0.0.9"] and not files


def test_messages_are_text(qtbot, monkeypatch):
    monkeypatch.setattr(Session, "start", lambda self: None)
    tab = DeviceTab("gige://127.0.0.9")
    qtbot.addWidget(tab)
    tab._failed("held", EVIL)
    assert drawn(tab.messages.toolTip()) == (EVIL, [])
    tab._failed("other", EVIL)
    [label] = [one for one in tab.messages.findChildren(QLabel) if one.text()]
    assert label.text() == EVIL + "." and label.textFormat() == Qt.TextFormat.PlainText


@pytest.mark.parametrize("path", sorted(ROOM.glob("*.py")), ids=lambda path: path.name)
def test_no_other_text_is_guessed_to_be_html(path):
    """Labels and tool tips go through plain_text.py, unless their text is a literal."""
    labels, tips = 0, []
    for node in ast.walk(ast.parse(path.read_text())):
        if not isinstance(node, ast.Call):
            continue
        if isinstance(node.func, ast.Name):
            labels += node.func.id == "QLabel"
        elif isinstance(node.func, ast.Attribute) and node.func.attr.endswith("ToolTip"):
            tip = node.args[-1]
            tips.append(isinstance(tip, ast.Constant) or isinstance(tip, ast.Call)
                        and tip.func.id == "plain_tip")
    assert labels == RICH.get(path.name, 0) and all(tips)

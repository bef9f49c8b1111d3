"""``ncdc sensor show``: the table, JSON, and a C array that compiles and holds the same writes."""

import json
import re
import shutil
import subprocess

import pytest

from ncdc.cli import main
from ncdc_spec.sensors.catalogue import SENSORS, sensor_named, setup
from ncdc_spec.sensors.sensor import Settings

ASKED = ["--width", "640", "--height", "480", "--exposure-us", "5000", "--gain-db", "6"]
PLAN = Settings(width=640, height=480, exposure_us=5000.0, gain_db=6.0)


@pytest.mark.parametrize("name", [sensor.name for sensor in SENSORS])
def test_table_json_and_c_say_the_same(name, tmp_path, capsys):
    pairs = setup(sensor_named(name), PLAN).pairs
    c, report = tmp_path / "setup.c", tmp_path / "setup.json"
    assert main(["sensor", "show", name, *ASKED, "--c", str(c), "--json", str(report)]) == 0
    said = capsys.readouterr().out
    table = re.findall(r"^0x([0-9A-F]+) +0x([0-9A-F]+) ", said, re.MULTILINE)
    assert [(int(a, 16), int(b, 16)) for a, b in table] == pairs
    assert [(w["register"], w["value"]) for w in json.loads(report.read_text())["writes"]] == pairs
    assert _by_a_program(c, name, tmp_path) == pairs


def _by_a_program(path, name, folder):
    """The pairs that a C program finds in the array."""
    source = folder / "main.c"
    source.write_text(f'''#include <stdio.h>
#include "{path.name}"
int main(void) {{
    for (unsigned k = 0; k < sizeof {name}_setup / sizeof *{name}_setup; k++)
        printf("%u %u\\n", {name}_setup[k].address, {name}_setup[k].value);
    return 0;
}}
''')
    program = folder / "program"
    compiler = shutil.which("cc") or shutil.which("gcc")
    subprocess.run([compiler, "-Wall", "-Werror", "-o", program, source], check=True, cwd=folder)
    text = subprocess.run([program], check=True, capture_output=True, text=True).stdout
    return [tuple(map(int, line.split())) for line in text.splitlines()]


@pytest.mark.parametrize("arguments,sentence", [
    (["ov2640"], "the sensor is 'ov2640', known are mt9p031, mt9d111, ov5640, imx219, "
     "ov5647"),
    (["mt9p031", "--width", "641"], "width is 641"),
    (["mt9p031", "--c", "."], "."),
])
def test_bad_input(arguments, sentence, capsys):
    assert main(["sensor", "show", *arguments]) == 2
    output = capsys.readouterr()
    assert sentence in output.err and output.err.count("\n") == 1 and not output.out

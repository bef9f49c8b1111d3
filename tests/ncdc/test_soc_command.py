"""``ncdc soc``: bad input is one sentence that names value and limit."""

import pytest

from cameras import barrel_descriptor
from ncdc.cli import main


@pytest.mark.parametrize("options, sentence", [
    (["--loss", "1001"], "the loss is 1001, the limits are 0 and 1000"),
    (["--exposure-us", "0"], "the exposure is 0 us, the limits are 1 and 1e+06"),
    ([], "cannot read"),
])
def test_bad_input(tmp_path, capsys, options, sentence):
    barrel_descriptor().save(tmp_path / "net.toml")
    with pytest.raises(SystemExit) as end:
        raise SystemExit(main(["soc", "run", "--sim", str(tmp_path / "net.toml"), "--photo",
                               str(tmp_path / "none.png"), *options]))
    said = capsys.readouterr().err
    assert end.value.code == 2 and sentence in said and said.count("\n") == 1

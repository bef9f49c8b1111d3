"""Outputs that are no regular files, and inputs that never end."""

import os
import stat
import threading

import pytest

from ncdc_spec.errors import InputError
from ncdc_spec.files import check_outputs, read_bytes, replace_file, write_stream, write_text


@pytest.fixture
def pipe(tmp_path):
    path = tmp_path / "pipe"
    os.mkfifo(path)
    return path


def test_a_device_is_written_into_and_stays_one():
    write_stream("/dev/null", "text")
    assert stat.S_ISCHR(os.stat("/dev/null").st_mode)
    with pytest.raises(InputError, match="cannot write /dev/full: No space left on device"):
        write_stream("/dev/full", "text")


def test_a_pipe_is_written_into_if_a_process_reads_it(pipe):
    with pytest.raises(InputError, match="pipe: it has no reader"):
        write_stream(pipe, "text")
    read = []
    reader = threading.Thread(target=lambda: read.append(pipe.read_text()))
    reader.start()
    while not read:
        try:
            write_stream(pipe, "text")
            break
        except InputError:      # the reader has not opened it yet
            pass
    reader.join()
    assert read == ["text"] and stat.S_ISFIFO(os.stat(pipe).st_mode)


def test_files_do_not_replace_devices_and_pipes(pipe):
    for path in ("/dev/null", pipe):
        with pytest.raises(InputError, match="it is no regular file"):
            write_text(path, "text")
        with pytest.raises(InputError, match="it is no regular file"):
            check_outputs([path], [])
        check_outputs([], [], [path])
    assert stat.S_ISFIFO(os.stat(pipe).st_mode)


@pytest.mark.parametrize("write", [write_text, write_stream])
def test_a_link_stays_a_link(tmp_path, write):
    (tmp_path / "there").mkdir()
    target, link = tmp_path / "there" / "file", tmp_path / "link"
    link.symlink_to(target)
    for text in ("first", "second"):
        write(link, text)
        assert link.is_symlink() and target.read_text() == text
    assert [path.name for path in target.parent.iterdir()] == ["file"]


def test_a_link_to_an_input_is_rejected(tmp_path):
    source, link = tmp_path / "source", tmp_path / "link"
    source.write_text("input")
    link.symlink_to(source)
    for streams in ((), (link,)):
        with pytest.raises(InputError, match="would replace the input"):
            check_outputs(() if streams else (link,), [source], streams)


def test_an_error_leaves_the_file_of_a_link(tmp_path):
    (tmp_path / "file").write_text("old")
    (tmp_path / "link").symlink_to("file")
    with pytest.raises(RuntimeError), replace_file(tmp_path / "link") as temporary:
        temporary.write_text("new")
        raise RuntimeError
    assert (tmp_path / "file").read_text() == "old"
    assert sorted(path.name for path in tmp_path.iterdir()) == ["file", "link"]


def test_devices_are_not_read():
    with pytest.raises(InputError, match="cannot read /dev/zero: it is a device"):
        read_bytes("/dev/zero")

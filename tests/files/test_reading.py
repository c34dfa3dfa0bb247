import os
import socket
import threading
from pathlib import Path

import pytest
from tolman.files.messages import FileError
from tolman.files.reading import open_regular, read_bytes, read_text


class ShelfError(ValueError):
    pass


def test_a_regular_file_is_read_up_to_its_limit(tmp_path: Path) -> None:
    path = tmp_path / "a"
    path.write_bytes(b"12345")
    assert read_bytes(path, 5) == b"12345"
    with pytest.raises(FileError, match=r"a: larger than the limit of 4 bytes$"):
        read_bytes(path, 4)


def test_a_link_to_a_regular_file_is_followed(tmp_path: Path) -> None:
    (tmp_path / "a").write_bytes(b"12345")
    (tmp_path / "b").symlink_to("a")
    assert read_bytes(tmp_path / "b", 10) == b"12345"


def test_pipes_devices_folders_and_sockets_are_refused_at_once(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")
    with socket.socket(socket.AF_UNIX) as listener:
        listener.bind(str(tmp_path / "socket"))
        for name, kind in (("pipe", "a pipe"), ("socket", "a socket"), (".", "a folder")):
            with pytest.raises(FileError, match=f"{kind}, not a file"):
                read_bytes(tmp_path / name, 10)
    with pytest.raises(FileError, match="/dev/zero: a device, not a file"):
        read_bytes("/dev/zero", 10)


def test_a_file_that_says_it_is_empty_is_read_no_further_than_the_limit() -> None:
    assert os.stat("/proc/kallsyms").st_size == 0
    with pytest.raises(FileError, match="larger than the limit of 100 bytes"):
        read_bytes("/proc/kallsyms", 100)


def _read_for_ever(path: Path) -> None:
    while True:
        read_bytes(path, 100_000)


def test_a_file_that_grows_while_it_is_read_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "a"
    path.write_bytes(b"")
    stop = threading.Event()

    def grow() -> None:
        with path.open("ab") as file:
            while not stop.is_set():
                file.write(b"x" * 4096)
                file.flush()

    writer = threading.Thread(target=grow)
    writer.start()
    try:
        with pytest.raises(FileError, match="larger than the limit"):
            _read_for_ever(path)
    finally:
        stop.set()
        writer.join()


@pytest.mark.parametrize("name", ["a\0b", "a\ud800b"])
def test_names_that_no_file_can_have_are_one_line(tmp_path: Path, name: str) -> None:
    with pytest.raises(FileError, match="no file can have this name") as caught:
        read_bytes(tmp_path / name, 10)
    assert str(caught.value).isprintable()


def test_a_missing_or_a_locked_file_is_one_line(tmp_path: Path) -> None:
    with pytest.raises(FileError, match=r"x\\x1b: there is no such file"):
        read_bytes(tmp_path / "x\x1b", 10)
    with pytest.raises(FileError, match="cannot be read: File name too long"):
        read_bytes(tmp_path / ("x" * 300), 10)


def test_the_reader_chooses_the_kind_of_error(tmp_path: Path) -> None:
    with pytest.raises(ShelfError, match="no such file"):
        read_text(tmp_path / "x", 10, ShelfError)


def test_text_is_utf_8_with_plain_line_ends(tmp_path: Path) -> None:
    path = tmp_path / "a"
    path.write_bytes(b"\xef\xbb\xbfone\r\ntwo\rthree\n")
    assert read_text(path, 100) == "one\ntwo\nthree\n"
    path.write_bytes(b"ab\xff")
    with pytest.raises(FileError, match=r"not a text file \(byte 2 is not UTF-8\)"):
        read_text(path, 100)


def test_no_descriptor_is_left_open(tmp_path: Path) -> None:
    before = len(os.listdir("/proc/self/fd"))
    with pytest.raises(FileError):
        open_regular(tmp_path)
    (tmp_path / "a").write_bytes(b"12345")
    with pytest.raises(FileError):
        read_bytes(tmp_path / "a", 2)
    assert len(os.listdir("/proc/self/fd")) == before

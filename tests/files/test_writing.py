import os
import stat
from pathlib import Path

import pytest
from tolman.files.messages import FileError
from tolman.files.writing import (
    TargetExistsError,
    WriteError,
    atomic_file,
    atomic_path,
    check_target,
    open_growing,
    write_bytes,
    write_text,
)


def test_a_file_is_written_whole(tmp_path: Path) -> None:
    write_text(tmp_path / "a", "é")
    assert (tmp_path / "a").read_bytes() == b"\xc3\xa9"
    assert os.listdir(tmp_path) == ["a"]


def test_an_existing_file_is_replaced_only_if_asked(tmp_path: Path) -> None:
    write_bytes(tmp_path / "a", b"1")
    with pytest.raises(TargetExistsError, match="a exists; --force replaces it"):
        write_bytes(tmp_path / "a", b"2")
    assert (tmp_path / "a").read_bytes() == b"1"
    (tmp_path / "a").chmod(0o640)
    write_bytes(tmp_path / "a", b"3", replace=True)
    assert (tmp_path / "a").read_bytes() == b"3"
    assert stat.S_IMODE((tmp_path / "a").stat().st_mode) == 0o640


def test_one_that_appears_meanwhile_is_not_replaced(tmp_path: Path) -> None:
    with pytest.raises(TargetExistsError), atomic_file(tmp_path / "a"):
        (tmp_path / "a").write_bytes(b"1")
    assert (tmp_path / "a").read_bytes() == b"1"
    assert os.listdir(tmp_path) == ["a"]


def test_pipes_devices_and_folders_are_refused_with_force_too(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "link").symlink_to("pipe")
    (tmp_path / "folder").mkdir()
    for name in ("pipe", "link", "folder"):
        for write in (write_bytes, lambda path, data, replace: open_growing(path, replace=replace)):
            with pytest.raises(FileError, match=r"name a (regular )?file"):
                write(tmp_path / name, b"x", replace=True)
    with pytest.raises(FileError, match="device"):
        check_target(Path("/dev/null"), replace=True)
    assert stat.S_ISFIFO((tmp_path / "pipe").stat().st_mode)
    assert sorted(os.listdir(tmp_path)) == ["folder", "link", "pipe"]


def test_a_pipe_that_takes_the_targets_place_stays(tmp_path: Path) -> None:
    with pytest.raises(FileError, match="pipe"), atomic_file(tmp_path / "a", replace=True):
        os.mkfifo(tmp_path / "a")
    assert os.listdir(tmp_path) == ["a"]


def test_a_link_stays_and_the_file_at_its_end_is_replaced(tmp_path: Path) -> None:
    (tmp_path / "folder").mkdir()
    (tmp_path / "folder" / "a").write_bytes(b"1")
    (tmp_path / "link").symlink_to("folder/a")
    with pytest.raises(TargetExistsError):
        write_bytes(tmp_path / "link", b"2")
    write_bytes(tmp_path / "link", b"2", replace=True)
    assert (tmp_path / "link").is_symlink()
    assert (tmp_path / "folder" / "a").read_bytes() == b"2"
    assert os.listdir(tmp_path / "folder") == ["a"]


def test_links_to_nothing_and_in_circles_are_refused(tmp_path: Path) -> None:
    (tmp_path / "nowhere").symlink_to("missing")
    (tmp_path / "circle").symlink_to("circle")
    for name in ("nowhere", "circle"):
        with pytest.raises(FileError, match=name):
            write_bytes(tmp_path / name, b"2", replace=True)
    assert sorted(os.listdir(tmp_path)) == ["circle", "nowhere"]


def test_a_planted_file_beside_the_target_is_not_touched(tmp_path: Path) -> None:
    (tmp_path / "victim").write_bytes(b"1")
    (tmp_path / "a.part").symlink_to("victim")
    write_bytes(tmp_path / "a", b"2")
    assert (tmp_path / "victim").read_bytes() == b"1"


def test_the_missing_folder_is_named(tmp_path: Path) -> None:
    with pytest.raises(FileError, match=r"no folder .*nowhere; make it first"):
        write_bytes(tmp_path / "nowhere" / "a", b"1")
    (tmp_path / "file").write_bytes(b"")
    with pytest.raises(FileError, match="no folder"):
        write_bytes(tmp_path / "file" / "a", b"1")


@pytest.mark.parametrize("name", ["a\0b", "a\ud800b", "x" * 300])
def test_names_that_no_file_can_have_are_one_line(tmp_path: Path, name: str) -> None:
    with pytest.raises(FileError) as caught:
        write_bytes(tmp_path / name, b"1")
    assert str(caught.value).isprintable()


def test_nothing_is_left_when_writing_fails(tmp_path: Path) -> None:
    (tmp_path / "a").write_bytes(b"1")
    with pytest.raises(ZeroDivisionError), atomic_file(tmp_path / "a", replace=True) as file:
        file.write(b"%d" % (1 // 0))
    assert os.listdir(tmp_path) == ["a"]
    assert (tmp_path / "a").read_bytes() == b"1"


def test_a_full_disk_is_one_line_and_a_failed_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(_: int) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(WriteError, match="a: cannot be written: No space left on device"):
        write_bytes(tmp_path / "a", b"1")
    assert os.listdir(tmp_path) == []


def test_a_library_can_write_by_name(tmp_path: Path) -> None:
    with atomic_path(tmp_path / "a") as part:
        assert part.parent == tmp_path
        assert part.read_bytes() == b""
        part.write_bytes(b"1")
    assert (tmp_path / "a").read_bytes() == b"1"
    assert os.listdir(tmp_path) == ["a"]


def test_a_growing_file_is_of_use_from_the_start(tmp_path: Path) -> None:
    path = tmp_path / "a"
    with open_growing(path) as file:
        file.write(b"1")
        file.flush()
        assert path.read_bytes() == b"1"
    with pytest.raises(TargetExistsError):
        open_growing(path)
    with open_growing(path, append=True) as file:
        file.write(b"2")
    assert path.read_bytes() == b"12"
    with open_growing(path, replace=True) as file:
        file.write(b"3")
    assert path.read_bytes() == b"3"

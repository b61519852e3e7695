"""Where output cannot go: one sentence or silence, and nothing half-written."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from lmic.errors import LmicError
from lmic.files import make_folder, write_whole

LMIC = Path(sys.executable).with_name("lmic")
full = pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs a device that is full")


def shell(line: str, folder: Path) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        ["bash", "-o", "pipefail", "-c", line.replace("lmic ", f"{LMIC} ")],
        capture_output=True,
        text=True,
        cwd=folder,
        check=False,
        timeout=120,
        env={**os.environ, "PYTHONIOENCODING": "utf-8"},
    )


@pytest.mark.parametrize("command", ["lmic list", "lmic list --json", "lmic latex wu2007.theorem1"])
def test_a_reader_that_leaves_hears_nothing_more(command: str, tmp_path: Path) -> None:
    done = shell(f"{command} | head -1", tmp_path)
    assert len(done.stdout.splitlines()) == 1
    assert done.stderr == ""


@full
@pytest.mark.parametrize("command", ["lmic list", "lmic list --json", "lmic latex wu2007.theorem1"])
def test_a_full_disk_behind_the_output(command: str, tmp_path: Path) -> None:
    done = shell(f"{command} > /dev/full", tmp_path)
    assert done.returncode == 1
    (said,) = done.stderr.splitlines()
    assert "No space left on device" in said


@full
def test_a_full_device_as_file(tmp_path: Path) -> None:
    done = shell("lmic latex wu2007.theorem1 -o /dev/full", tmp_path)
    assert done.returncode == 1
    (said,) = done.stderr.splitlines()
    assert said == "LmicError: /dev/full cannot be written: no space left on device; choose another place"
    assert Path("/dev/full").is_char_device()


def test_standard_output_as_file(tmp_path: Path) -> None:
    done = shell("lmic latex standard.stability_discrete -o /dev/stdout | cat", tmp_path)
    assert done.returncode == 0
    assert done.stdout == shell("lmic latex standard.stability_discrete", tmp_path).stdout


def test_a_link_is_followed(tmp_path: Path) -> None:
    (tmp_path / "real").write_text("old")
    (tmp_path / "link").symlink_to("real")
    write_whole(tmp_path / "link", "new")
    assert (tmp_path / "link").is_symlink()
    assert (tmp_path / "real").read_text() == "new"


@pytest.mark.parametrize("name", ["a\0b", "x" * 300, "no/where", "."])
def test_names_that_cannot_be(name: str, tmp_path: Path) -> None:
    with pytest.raises(LmicError, match=r"cannot be written: .*; ") as caught:
        write_whole(tmp_path / name, "text")
    assert "\n" not in str(caught.value)
    assert not list(tmp_path.iterdir())


def test_folders_that_cannot_be(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    for name in ("file", "file/below", "a\0b", "x" * 300):
        with pytest.raises(LmicError, match=r"folder .* cannot be written: .*; choose another"):
            make_folder(tmp_path / name)


@pytest.mark.parametrize("command", ["gallery -o file", "reproduce wu2007 -o file", "reproduce wu2007 --certify file"])
def test_a_file_in_place_of_a_folder(command: str, tmp_path: Path) -> None:
    (tmp_path / "file").write_text("kept")
    done = shell(f"lmic {command}", tmp_path)
    assert done.returncode == 1
    (said,) = done.stderr.splitlines()
    assert "the folder file cannot be written" in said
    assert (tmp_path / "file").read_text() == "kept"


def test_little_memory_is_one_sentence(tmp_path: Path) -> None:
    program = (
        "import resource, lmic.cli, lmic.library, lmic.pipeline, lmic.reporting, lmic.plants.random\n"
        "lmic.library.theorem('standard.bounded_real_discrete')\n"
        "resource.setrlimit(resource.RLIMIT_AS, (1 << 30, 1 << 30))\n"
        "lmic.cli.main(['show', 'standard.bounded_real_discrete', '--size', 'n=20000'])\n"
    )
    environment = {**os.environ, "OPENBLAS_NUM_THREADS": "1"}  # each of its threads takes some, on many cores all
    done = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=False, timeout=120, env=environment
    )
    assert done.returncode == 1
    (said,) = done.stderr.splitlines()
    assert "memory" in said or "Memory" in said

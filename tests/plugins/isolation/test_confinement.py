"""What a plugin tries in its subprocess, where the system has Landlock and seccomp."""

from __future__ import annotations

import json
import os
import platform
import subprocess
import sys
from pathlib import Path

import pytest

TRY = """
import json, os, resource, signal, socket, subprocess, sys, threading
from tolman.plugins.isolation.confinement import confine, folders_of_python
folder, parent = sys.argv[1], os.getppid()
held = confine([*folders_of_python(), folder])
def tried(call):
    try:
        call()
    except OSError as fault:
        return "refused"
    return "done"
thread = threading.Thread(target=lambda: None)
print(json.dumps({"held": held, **{name: tried(call) for name, call in {
    "read own": lambda: open(folder + "/own").read(),
    "thread": lambda: (thread.start(), thread.join()),
    "read others": lambda: open("/etc/passwd").read(),
    "list": lambda: os.listdir("/"),
    "environment": lambda: open(f"/proc/{parent}/environ").read(),
    "write": lambda: open(folder + "/own", "a"),
    "create": lambda: open(folder + "/new", "w"),
    "remove": lambda: os.remove(folder + "/own"),
    "rename": lambda: os.rename(folder + "/own", folder + "/new"),
    "chmod": lambda: os.chmod(folder + "/own", 0o777),
    "times": lambda: os.utime(folder + "/own"),
    "link": lambda: os.symlink("own", folder + "/link"),
    "tcp": lambda: socket.create_connection(("127.0.0.1", 9), 0.2),
    "udp": lambda: socket.socket(socket.AF_INET, socket.SOCK_DGRAM),
    "unix": lambda: socket.socketpair(),
    "fork": lambda: os.fork() or os._exit(0),
    "run": lambda: subprocess.run(["/bin/true"]),
    "kill": lambda: os.kill(parent, 0),
    "limit": lambda: resource.prlimit(parent, resource.RLIMIT_NOFILE, (9, 9)),
    "session": lambda: os.setsid(),
}.items()}}))
"""
ALLOWED = {"read own", "thread"}


def test_nothing_is_left_but_reading_its_own_folder(tmp_path: Path) -> None:
    (tmp_path / "own").write_text("x")
    done = subprocess.run(
        [sys.executable, "-c", TRY, str(tmp_path)], capture_output=True, text=True, check=True, timeout=60
    )
    ended = json.loads(done.stdout)
    held = ended.pop("held")
    if held != ["files", "system"]:
        pytest.skip(f"this system holds only {held}: {platform.platform()}")
    assert {name for name, how in ended.items() if how == "done"} == ALLOWED
    assert [path.name for path in tmp_path.iterdir()] == ["own"]
    assert os.path.getsize(tmp_path / "own") == 1

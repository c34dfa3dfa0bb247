"""Takes from a process what an isolated plugin does not need: files, network, other processes (Linux).

Landlock allows reading beneath some folders and nothing else of files; a seccomp filter refuses sockets,
new processes, signals to others and the system calls by which either could be got around. Both need no
privileges and hold until the process ends. Where the system has them not, `confine` says so.

Sources: landlock(7); Documentation/userspace-api/seccomp_filter.rst; numbers of asm/unistd.h.
"""

from __future__ import annotations

import contextlib
import ctypes
import os
import platform
import resource
import signal
import struct
import sys
from collections.abc import Iterable, Iterator
from pathlib import Path

_PDEATHSIG, _NO_NEW_PRIVS, _SECCOMP, _FILTER = 1, 38, 22, 2
_CREATE_RULESET, _ADD_RULE, _RESTRICT_SELF = 444, 445, 446
_READ_FILE, _READ_FOLDER = 1 << 2, 1 << 3
_RIGHTS = {1: (1 << 13) - 1, 2: (1 << 14) - 1, 3: (1 << 15) - 1, 4: (1 << 15) - 1}
"""All rights to files that a version of Landlock knows; from 5 on also that of devices' ioctl."""
_ARCHITECTURES = {"x86_64": (0, 0xC000003E), "aarch64": (1, 0xC00000B7)}
"""Place of an architecture's numbers below, and what the kernel calls it."""
_REFUSED = {
    # sockets, processes and signals
    "socket": (41, 198),
    "socketpair": (53, 199),
    "fork": (57, None),
    "vfork": (58, None),
    "execve": (59, 221),
    "execveat": (322, 281),
    "kill": (62, 129),
    "tkill": (200, 130),
    "rt_sigqueueinfo": (129, 138),
    "rt_tgsigqueueinfo": (297, 240),
    "pidfd_open": (434, 434),
    "pidfd_getfd": (438, 438),
    "pidfd_send_signal": (424, 424),
    "setsid": (112, 157),
    "setpgid": (109, 154),
    # other processes' memory and turns
    "ptrace": (101, 117),
    "process_vm_readv": (310, 270),
    "process_vm_writev": (311, 271),
    "process_madvise": (440, 440),
    "kcmp": (312, 272),
    "setpriority": (141, 140),
    "sched_setscheduler": (144, 119),
    "sched_setaffinity": (203, 122),
    "sched_setattr": (314, 274),
    # ways around this filter, or into the kernel
    "io_uring_setup": (425, 425),
    "bpf": (321, 280),
    "userfaultfd": (323, 282),
    "perf_event_open": (298, 241),
    "unshare": (272, 97),
    "setns": (308, 268),
    "mount": (165, 40),
    "shmget": (29, 194),
    "msgget": (68, 186),
    # what Landlock leaves open of files
    "chmod": (90, None),
    "fchmod": (91, 52),
    "fchmodat": (268, 53),
    "fchmodat2": (452, 452),
    "chown": (92, None),
    "fchown": (93, 55),
    "lchown": (94, None),
    "fchownat": (260, 54),
    "utime": (132, None),
    "utimes": (235, None),
    "futimesat": (261, None),
    "utimensat": (280, 88),
    "setxattr": (188, 5),
    "lsetxattr": (189, 6),
    "fsetxattr": (190, 7),
    "removexattr": (197, 14),
}
"""System calls by name: their numbers on each architecture, None where it has none."""
_OF_ITSELF = {"tgkill": (234, 131), "prlimit64": (302, 261)}
"""Allowed where the first argument names this process (or is 0)."""
_CLONE = (56, 220)
_CLONE3, _CLONE_THREAD = 435, 0x10000
_LOAD, _EQUAL, _AT_LEAST, _ANY_BIT, _RETURN = 0x20, 0x15, 0x35, 0x45, 0x06
_ALLOW, _REFUSE, _UNKNOWN_CALL = 0x7FFF0000, 0x00050001, 0x00050026


def die_with_parent(parent: int) -> None:
    """Has this process killed when the one that started it ends (Linux). parent: its number."""
    if sys.platform == "linux":
        _libc().prctl(_PDEATHSIG, signal.SIGKILL, 0, 0, 0)
        if os.getppid() != parent:
            os._exit(1)


def limit_resources(memory: int) -> None:
    """No core files, no bytes written to files, and `memory` more bytes of address space than now (Linux)."""
    for kind in (resource.RLIMIT_CORE, resource.RLIMIT_FSIZE):
        resource.setrlimit(kind, (0, 0))
    with contextlib.suppress(OSError, ValueError):  # elsewhere than on Linux a leak is not noticed here
        pages = int(Path("/proc/self/statm").read_text().split()[0])
        limit = pages * resource.getpagesize() + memory
        resource.setrlimit(resource.RLIMIT_AS, (limit, limit))


@contextlib.contextmanager
def limited_cpu(seconds: int) -> Iterator[None]:
    """Has the system end this process if what is inside takes more processor time."""
    used = resource.getrusage(resource.RUSAGE_SELF)
    before = resource.getrlimit(resource.RLIMIT_CPU)
    limit = int(used.ru_utime + used.ru_stime) + 1 + seconds
    resource.setrlimit(resource.RLIMIT_CPU, (limit, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_CPU, before)


def confine(readable: Iterable[str | Path]) -> list[str]:
    """Confines this process, for ever. readable: files and folders that it may still read.

    Returns what it holds of: "files" (reads only these, writes none), "system" (no network, no processes, no
    signals to others); neither where the system has no such thing.
    """
    if sys.platform != "linux" or _libc().prctl(_NO_NEW_PRIVS, 1, 0, 0, 0) != 0:
        return []
    held = []
    if _landlock(readable):
        held.append("files")
    if _seccomp(platform.machine()):
        held.append("system")
    return held


def folders_of_python() -> list[str]:
    """What Python and installed packages are read from."""
    own = Path(__file__).resolve().parents[2]
    known = [*sys.path, sys.prefix, sys.base_prefix, own, "/usr", "/lib", "/lib64", "/etc/localtime"]
    return [str(each) for each in known if str(each)] + ["/dev/null", "/dev/urandom"]


def _libc() -> ctypes.CDLL:
    return ctypes.CDLL(None, use_errno=True)


def _landlock(readable: Iterable[str | Path]) -> bool:
    libc = _libc()
    version = libc.syscall(_CREATE_RULESET, None, ctypes.c_size_t(0), 1)
    if version < 1:
        return False
    rights = _RIGHTS.get(version, (1 << 16) - 1)
    network, scopes = (3 if version >= 4 else 0), (3 if version >= 6 else 0)
    body = struct.pack("=QQQ", rights, network, scopes)[: 8 if version < 4 else 16 if version < 6 else 24]
    ruleset = libc.syscall(_CREATE_RULESET, body, ctypes.c_size_t(len(body)), 0)
    if ruleset < 0:
        return False
    try:
        for path in readable:
            _allow_reading(libc, ruleset, path)
        return bool(libc.syscall(_RESTRICT_SELF, ruleset, 0) == 0)
    finally:
        os.close(ruleset)


def _allow_reading(libc: ctypes.CDLL, ruleset: int, path: str | Path) -> None:
    try:
        opened = os.open(path, os.O_PATH | os.O_CLOEXEC)
    except OSError:
        return  # not there
    try:
        rights = _READ_FILE | (_READ_FOLDER if Path(path).is_dir() else 0)
        rule = struct.pack("=Qi", rights, opened)
        libc.syscall(_ADD_RULE, ruleset, 1, rule, 0)
    finally:
        os.close(opened)


def _seccomp(machine: str) -> bool:
    if machine not in _ARCHITECTURES or struct.calcsize("P") != 8:
        return False
    program = b"".join(struct.pack("=HBBI", *line) for line in _program(machine))

    class Program(ctypes.Structure):
        _fields_ = (("length", ctypes.c_ushort), ("lines", ctypes.c_char_p))

    return bool(
        _libc().prctl(_SECCOMP, _FILTER, ctypes.byref(Program(len(program) // 8, program)), 0, 0) == 0
    )


def _program(machine: str) -> list[tuple[int, int, int, int]]:
    """The filter as lines of classic BPF: operation, skipped if it holds, skipped if not, operand."""
    number, architecture, first = 0, 4, 16  # offsets in struct seccomp_data
    place, audited = _ARCHITECTURES[machine]
    lines = [(_LOAD, 0, 0, architecture), (_EQUAL, 1, 0, audited), (_RETURN, 0, 0, _REFUSE)]
    lines += [(_LOAD, 0, 0, number)]
    if machine == "x86_64":  # the numbers of x32, by which the list could be got around
        lines += [(_AT_LEAST, 0, 1, 0x40000000), (_RETURN, 0, 0, _REFUSE)]
    for call in (numbers[place] for numbers in _REFUSED.values()):
        if call is not None:
            lines += [(_EQUAL, 0, 1, call), (_RETURN, 0, 0, _REFUSE)]
    lines += [(_EQUAL, 0, 1, _CLONE3), (_RETURN, 0, 0, _UNKNOWN_CALL)]  # the C library then uses clone
    lines += [(_EQUAL, 0, 4, _CLONE[place]), (_LOAD, 0, 0, first)]
    lines += [(_ANY_BIT, 0, 1, _CLONE_THREAD), (_RETURN, 0, 0, _ALLOW), (_RETURN, 0, 0, _REFUSE)]
    for numbers in _OF_ITSELF.values():
        lines += [(_EQUAL, 0, 5, numbers[place]), (_LOAD, 0, 0, first), (_EQUAL, 1, 0, 0)]
        lines += [(_EQUAL, 0, 1, os.getpid()), (_RETURN, 0, 0, _ALLOW), (_RETURN, 0, 0, _REFUSE)]
    return [*lines, (_RETURN, 0, 0, _ALLOW)]

"""Faults of plugins, as sources: each deed at each place where a plugin's code runs, and single tricks."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

SOURCE = '''"""Evil."""
import atexit, ctypes, os, signal, socket, subprocess, sys, threading, time
from enum import Enum
from tolman.agent import Behavior, Context, Proposal, Transition
from tolman.agent.events import CornerReached, Event, LoopClosed, Lost, PluginEvent
from tolman.world.robot import WheelCommand

class LoudError(Exception):
    def __str__(self):
        raise ValueError("no text")

class EndlessError(Exception):
    def __str__(self):
        while True: pass

class OwnBaseError(BaseException):
    pass

def loop():
    while True: pass

def recurse():
    return recurse()

def swallow():
    end = time.monotonic() + 1.2 * INTERRUPTED
    while time.monotonic() < end:
        try:
            while time.monotonic() < end: pass
        except BaseException:
            pass

def leave(call):
    threading.Thread(target=call).start()

def shout():
    while True:
        print("shout")
        time.sleep(0.01)

INTERRUPTED = 1.0
{head}

class Evil(Behavior):
    """Evil."""
    name = "evil"
    priority = 45
    class States(Enum):
        """One."""
        ON = "on"
    initial = States.ON
    {body}
    def __init__(self, config=None, **settings):
        {make}
        super().__init__(config, **settings)
    def on_reset(self):
        self.ticks = 0
        {reset}
    def on_start(self, context):
        context.subscribe(Lost, self.hear)
        {start}
    def hear(self, event):
        {hear}
    def on_stop(self, context):
        {stop}
    def on(self, percept, context):
        self.ticks += 1
        context.publish(Lost(time=context.time, reason="evil"))
        {tick}
        return Proposal(WheelCommand(300.0, 300.0), 1.0, "x")
{tail}
'''
PLACES = ("head", "make", "reset", "start", "hear", "stop", "tick")
"""Where a plugin's code runs: import, constructor, ..."""
DEEDS = {
    "raise": "raise RuntimeError('on purpose')",
    "raise-base": "raise OwnBaseError('base')",
    "interrupt": "raise KeyboardInterrupt",
    "generator-exit": "raise GeneratorExit",
    "exit": "sys.exit(0)",
    "loop": "loop()",
    "sleep": "time.sleep(3000)",
    "recursion": "recurse()",
    "no-text": "raise LoudError",
    "endless-text": "raise EndlessError",
    "escapes": "raise ValueError('a\\x1b[2J\\nb' * 10000)",
    "swallow": "swallow()",
    "thread": "leave(lambda: time.sleep(3000))",
    "shouting-thread": "leave(shout)",
    "at-exit": "atexit.register(loop)",
    "noise": "print('noise'); os.write(1, b'more')",
}
TRICKS = {
    "priority-text": {"body": "priority = 'high'"},
    "priority-nan": {"body": "priority = float('nan')"},
    "priority-later": {"reset": "self.priority = 'high'; self.name = 7"},
    "name-escapes": {"body": "name = 'e\\x1b[2Jvil'"},
    "name-list": {"body": "name = ['evil']"},
    "name-of-a-builtin": {"body": "name = 'wander'"},
    "states-changed": {"tick": "self.__class__.States = None"},
    "finished-raises": {"body": "finished = property(lambda self: 1 / 0, lambda self, value: None)"},
    "finished-loops": {"body": "finished = property(lambda self: loop(), lambda self, value: None)"},
    "state-raises": {"body": "state = property(lambda self: 1 / 0)", "tick": "raise ValueError('x')"},
    "reason-is-none": {"tick": "self.finish(True, None, None)"},
    "result-holds-itself": {"tick": "r = []; r += [r, r, r]; self.finish(True, 'x', r)"},
    "event-holds-itself": {
        "tick": "d = {}; d['a'] = d['b'] = d; context.publish(PluginEvent(time=0.0, name='x', data=d))"
    },
    "event-holds-itself-later": {
        "tick": "d = {}; context.publish(PluginEvent(time=0.0, name='x', data=d)); d['a'] = d['b'] = d"
    },
    "event-of-no-class": {"tick": "context.publish('lost')"},
    "event-flood": {"tick": "[context.publish(Lost(time=0.0, reason='x')) for _ in range(10**6)]"},
    "event-out-of-sorts": {
        "tick": "publish = context.publish\n        "
        "publish(CornerReached(time='x', side=3, kind=9, path_length='x', heading=0, turn=0))"
    },
    "event-of-a-mapper": {"tick": "context.publish(LoopClosed(time=0.0, node=99, met=99))"},
    "subscriptions": {"tick": "[context.subscribe(Event, self.hear) for _ in range(10**6)]"},
    "nan": {"tick": "return Proposal(WheelCommand(float('nan'), 0.0), 1.0, 'x')"},
    "wild": {"tick": "return Proposal(WheelCommand(1e300, 1e300), 1.0, 'x')"},
    "activation-text": {"tick": "return Proposal(WheelCommand(1.0, 1.0), 'much', 'x')"},
    "reason-a-list": {"tick": "return Proposal(WheelCommand(1.0, 1.0), 1.0, [1])"},
    "command-text": {"tick": "return Proposal(WheelCommand('fast', None), 1.0, 'x')"},
    "no-proposal": {"tick": "return 'ahead'"},
    "no-behavior": {"tail": "Evil = None"},
    "syntax": {"head": "def f(:"},
}
"""Parts of the source by place."""
_WRITABLE = """
def writable(number):
    try:
        return os.write(number, b"") == 0
    except OSError:
        return False
"""
_GARBAGE = "[os.write(each, b'\\xff' * 1000) for each in range(3, 20) if writable(each)]"
ALONE = {
    "os-exit-import": {"head": "os._exit(0)"},
    "os-exit-make": {"make": "os._exit(0)"},
    "os-exit-tick": {"tick": "os._exit(0)"},
    "segfault": {"tick": "ctypes.string_at(0)"},
    "leak": {"tick": "self.kept = bytearray(1 << 34)"},
    "leak-import": {"head": "kept = bytearray(1 << 34)"},
    "maps-patched": {
        "head": "import tolman.maps.hybrid_map as m, tolman.maps.storage.map_file as f\n"
        "m.HybridMap.save = lambda *a, **k: open(a[1], 'w').close()\nf.MapFile = None"
    },
    "parent-killed": {"tick": "os.kill(os.getppid(), signal.SIGKILL)"},
    "parent-limited": {"tick": "import resource; resource.prlimit(os.getppid(), resource.RLIMIT_AS, (0, 0))"},
    "file-written": {"head": "open(__file__ + '.written', 'w').write('x')"},
    "file-removed": {"head": "os.remove(__file__)"},
    "network": {"tick": "socket.create_connection(('127.0.0.1', 9), 0.2)"},
    "grandchild": {"start": "subprocess.Popen(['sleep', '3117'], start_new_session=True)"},
    "fork": {"start": "os.fork() or time.sleep(3117)"},
    "garbage": {"head": _WRITABLE, "tick": _GARBAGE},
    "garbage-import": {"head": _WRITABLE + _GARBAGE},
}
"""What only an isolated plugin is kept from."""


@dataclass(frozen=True, slots=True)
class Misdeed:
    """One fault: its name, the plugin's source, whether it is held in the agent's process too."""

    name: str
    source: str
    here: bool


def misdeeds() -> Iterator[Misdeed]:
    """All of them."""
    for deed, code in DEEDS.items():
        for place in PLACES:
            yield Misdeed(f"{deed}-{place}", _source({place: code}), True)
    for name, parts in TRICKS.items():
        yield Misdeed(name, _source(parts), True)
    for name, parts in ALONE.items():
        yield Misdeed(name, _source(parts), False)


def _source(parts: dict[str, str]) -> str:
    source = SOURCE
    for place in ("head", "body", "make", "reset", "start", "hear", "stop", "tick", "tail"):
        nothing = "" if place in ("head", "tail", "body") else "pass"
        source = source.replace("{" + place + "}", parts.get(place, nothing))
    return source

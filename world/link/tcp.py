"""A robot's packets over TCP: one thread reads all the time, so that what is taken is the newest."""

from __future__ import annotations

import contextlib
import re
import select
import socket
import threading
import time
from functools import partial

from ..robot import CONTROL_PERIOD
from .channel import Heard, LinkError
from .packets import Command, PacketError, ReplyReader

PORT = 1000
"""Where a real e-puck2 listens."""
CONNECTING, GIVING_UP = 5.0, 30.0
"""Seconds for one try to connect, and without a packet until the link is given up."""
DEAD_MAN = 0.3
"""Seconds without a command from its driver after which the wheels are told to stop."""
LISTENED = 0.4
"""Seconds in which a robot that streams sends a second packet."""


def parse_address(url: str) -> tuple[str, int]:
    """Host and port of `tcp://HOST[:PORT]`. Raises: LinkError."""
    match = re.fullmatch(r"tcp://(\[[0-9a-fA-F:]+\]|[^:/\s]+)(?::(\d{1,5}))?/?", url)
    port = int(match[2] or PORT) if match else 0
    if match is None or not 0 < port < 65536:
        raise LinkError(f"{url!r} is no robot's address: write tcp://HOST:PORT, as in tcp://192.168.1.7:1000")
    return match[1].strip("[]"), port


class TcpChannel:
    """A connection that is made again when it breaks. Commands go out at once, or are lost with it."""

    def __init__(self, url: str, giving_up: float = GIVING_UP) -> None:
        """Connects, and finds out whether the robot streams or answers each command once.

        Raises: LinkError when nothing listens there or nothing answers.
        """
        self.name, self.in_step, self.reconnections = url, False, 0
        self._address, self._giving_up = parse_address(url), giving_up
        self._heard, self._began, self._last = Heard(), time.monotonic(), Command()
        self._sent_at, self._alive = time.monotonic(), True
        self._news = threading.Condition()
        self._failure = ""
        try:
            self._socket = self._connected()
        except OSError as error:
            reason = error.strerror or str(error)
            raise LinkError(
                f"{url}: {reason}; is the robot on, its selector at 15, and this its network?"
            ) from None
        self._thread = threading.Thread(target=self._read, name="tolman-link", daemon=True)
        self._thread.start()
        try:
            self._find_out()
        except BaseException:
            self.close()
            raise

    @property
    def heard(self) -> Heard:
        """The newest packets."""
        return self._heard

    def now(self) -> float:
        """Seconds since it was made; in step, 32 ms for each packet of sensors."""
        return self._heard.number * CONTROL_PERIOD if self.in_step else time.monotonic() - self._began

    def send(self, command: Command) -> None:
        """Sends it, and again without what acts once whenever the link has to be made again."""
        with self._news:
            self._last, self._sent_at = command, time.monotonic()
            self._transmit(command)

    def wait(self, until: float, seen: Heard) -> None:
        """Waits for the next packet, or until then. Raises: LinkError for a link that is given up."""
        with self._news:
            patience = self._giving_up if self.in_step else max(0.0, until - self.now())
            self._news.wait_for(lambda: self._heard is not seen or bool(self._failure), patience)
            if self._heard is seen and self.in_step and not self._failure:
                self._failure = f"no answer for {self._giving_up:g} s"
            if self._failure:
                raise LinkError(f"{self.name}: {self._failure}; the link is given up")

    def close(self) -> None:
        """Ends the thread and closes the connection."""
        self._alive = False
        with contextlib.suppress(OSError):
            self._socket.shutdown(socket.SHUT_RDWR)
        self._thread.join(timeout=2.0)
        self._socket.close()

    # --- inside ------------------------------------------------------------------------------------------

    def _connected(self) -> socket.socket:
        made = socket.create_connection(self._address, timeout=CONNECTING)
        made.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        made.setblocking(False)
        return made

    def _find_out(self) -> None:
        """Whether one command is answered by one packet, tried twice, or by a stream."""
        answers = []
        for _ in range(2):
            before = self._heard.number
            self.send(Command())
            with self._news:
                self._news.wait_for(partial(self._came, before + 1), self._giving_up)
                self._news.wait_for(partial(self._came, before + 2), LISTENED)
            answers.append(self._heard.number - before)
            if answers[-1] == 0:
                raise LinkError(f"{self.name}: connected, but no sensors came within {self._giving_up:g} s")
        self.in_step = answers == [1, 1]

    def _came(self, number: int) -> bool:
        return self._heard.number >= number or bool(self._failure)

    def _transmit(self, command: Command) -> None:
        """A command is 21 bytes: it fits the socket's buffer whole, or the link is as good as broken."""
        with contextlib.suppress(OSError):
            self._socket.send(command.pack())

    def _read(self) -> None:
        """The thread: reads until the channel is closed, connects again, stops wheels that nobody drives."""
        reader, heard_at = ReplyReader(), time.monotonic()
        while self._alive:
            try:
                ready = select.select([self._socket], [], [], 0.05)[0]
                data = self._socket.recv(1 << 16) if ready else None
                if data == b"":
                    raise ConnectionResetError
                if data:
                    heard_at = time.monotonic()
                    self._take(list(reader.feed(data)))
            except BlockingIOError:
                continue
            except (OSError, ValueError, PacketError):
                reader = ReplyReader()
                if not self._again(heard_at):
                    return
            if not self.in_step:
                self._mind_the_driver()
                if time.monotonic() - heard_at > self._giving_up:
                    self._fail(f"no packet for {self._giving_up:g} s")

    def _take(self, found: list[tuple[int, bytes]]) -> None:
        with self._news:
            heard = self._heard
            for kind, payload in found:
                heard = heard.with_packet(kind, payload, time.monotonic() - self._began)
            if heard is not self._heard:
                self._heard = heard
                self._news.notify_all()

    def _mind_the_driver(self) -> None:
        """Tells the wheels to stop when the driver has not said anything for a while."""
        with self._news:
            last = self._last
            if (last.left or last.right) and time.monotonic() - self._sent_at > DEAD_MAN:
                self._last = Command(request=last.request)
                self._transmit(self._last)

    def _again(self, heard_at: float) -> bool:
        """Connects again, more and more slowly; whether that went well before it is given up."""
        pause = 0.1
        while self._alive:
            self._socket.close()
            if time.monotonic() - heard_at > self._giving_up:
                self._fail("the connection broke and cannot be made again")
                return False
            with contextlib.suppress(OSError):
                self._socket = self._connected()
                self.reconnections += 1
                self._transmit(Command(request=self._last.request))
                return True
            time.sleep(pause)
            pause = min(2.0, 2 * pause)
        return False

    def _fail(self, reason: str) -> None:
        with self._news:
            self._failure = self._failure or reason
            self._news.notify_all()

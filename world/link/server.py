"""The simulated e-puck2's socket: one client at a time, one thread, whatever bytes come."""

from __future__ import annotations

import contextlib
import selectors
import socket
import time
from collections.abc import Callable

from ..errors import WorldError
from ..robot import CONTROL_PERIOD
from . import packets
from .device import Device
from .model import LINKS, Link, Timings
from .packets import Command, CommandReader

READ_SIZE, SEND_SIZE = 4096, 6144
"""Bytes read at once, and of the socket's buffer for sending: the robot's own is 5744."""
WAITING = 64 * packets.COMMAND_SIZE
"""Bytes of commands that may wait before no more are read."""
REST_OF_SET = 0.005
"""Seconds after which, in step with the client, the rest of a set is sent though no command asks for it."""
SILENCE = 30.0
"""Seconds in which a client must send its first command, or make room for another."""
MOST_BEHIND = 1.0
"""Seconds that a slow simulation may lag behind the clock before it gives up catching up."""


class Client:
    """One connection: commands that came, bytes that wait to be sent. gone: whether the other end is."""

    def __init__(self, connection: socket.socket) -> None:
        """Takes the socket over."""
        self.socket = connection
        self.reader = CommandReader()
        self.out = bytearray()
        self.gone = False
        self.spoke = False
        self.since = time.monotonic()
        connection.setblocking(False)
        with contextlib.suppress(OSError):
            connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            connection.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, SEND_SIZE)

    def read(self) -> None:
        """Takes in what has come, unless too much waits already."""
        if len(self.reader) >= WAITING:
            return
        try:
            data = self.socket.recv(READ_SIZE)
        except (BlockingIOError, InterruptedError):
            return
        except OSError:
            data = b""
        self.gone = self.gone or not data
        self.reader.feed(data)

    def put(self, kind: int, payload: bytes) -> None:
        """Sends a packet, as far as that goes now."""
        self.out.append(kind)
        self.out += payload
        self.write()

    def write(self) -> None:
        """Sends what waits, as far as that goes now: a packet is never cut off for another."""
        try:
            sent = self.socket.send(self.out) if self.out else 0
        except (BlockingIOError, InterruptedError):
            return
        except OSError:
            self.gone = True
            return
        del self.out[:sent]

    def newest(self) -> Command | None:
        """The last whole command that came since, or None."""
        newest = None
        while (command := self.reader.next()) is not None:
            newest = command
        return newest


class Server:
    """Serves a device until it is told that it is over.

    In real time it streams as the robot does. In step (`fast`) each command lets 32 ms pass and releases the
    next packet of what it asks for, so that a client goes as fast as it can, and twice alike.
    """

    def __init__(
        self,
        device: Device,
        host: str = "127.0.0.1",
        port: int = 0,
        *,
        fast: bool = False,
        stops: bool = True,
        timings: Timings = LINKS["ideal"],
        seed: int = 0,
    ) -> None:
        """Listens. port: 0 takes any. stops: whether the wheels stop with the connection: the robot's do not.

        Raises: WorldError when it cannot listen there.
        """
        self.device, self.stops = device, stops
        self.served, self.commands = 0, 0
        self._link = Link(device, timings, seed)
        self._fast, self._set = fast, _Set()
        self._client: Client | None = None
        try:
            self._listener = socket.create_server((host, port), backlog=16)
        except (OSError, OverflowError) as error:
            reason = getattr(error, "strerror", None) or str(error)
            raise WorldError(f"cannot listen at {host}:{port}: {reason}; try another --port") from None
        self._listener.setblocking(False)
        self.host, self.port = self._listener.getsockname()[:2]

    def serve(self, over: Callable[[], bool] = lambda: False) -> None:
        """Serves one client after the other until `over()`, which is asked after each step of its loop."""
        began = time.monotonic() - self._link.time
        try:
            while not over():
                self._exchange(self._patience(began))
                if self._fast:
                    self._in_step()
                else:
                    began = self._in_real_time(began)
                self._look_after_client()
        finally:
            self.close()

    @property
    def connected(self) -> bool:
        """Whether a client is being served."""
        return self._client is not None

    def close(self) -> None:
        """Stops the wheels and closes all sockets."""
        self.device.stop()
        self._drop()
        self._listener.close()

    # --- sockets -----------------------------------------------------------------------------------------

    def _patience(self, began: float) -> float:
        """How long (s) it may sleep unless something comes."""
        client = self._client
        if not self._fast:
            return max(0.0, began + self._link.time + CONTROL_PERIOD - time.monotonic())
        if client is None or client.out:
            return 0.1
        return 0.0 if client.reader.waits() else REST_OF_SET if self._set.due else 0.1

    def _exchange(self, patience: float) -> None:
        """Waits until something can be read, written or accepted, and does it."""
        client = self._client
        with selectors.DefaultSelector() as selector:
            if client is None:
                selector.register(self._listener, selectors.EVENT_READ)
            else:
                events = selectors.EVENT_WRITE if client.out else 0
                events |= selectors.EVENT_READ if len(client.reader) < WAITING else 0
                if events:
                    selector.register(client.socket, events)
            ready = selector.select(patience)
        if client is None:
            if ready:
                self._accept()
            return
        for _, events in ready:
            if events & selectors.EVENT_READ:
                client.read()
            if events & selectors.EVENT_WRITE:
                client.write()

    def _accept(self) -> None:
        with contextlib.suppress(OSError):
            self._client = Client(self._listener.accept()[0])
            self.served += 1

    def _look_after_client(self) -> None:
        client = self._client
        if client is None:
            return
        if client.gone or (not client.spoke and time.monotonic() - client.since > SILENCE):
            self._drop()

    def _drop(self) -> None:
        client, self._client = self._client, None
        if client is None:
            return
        client.socket.close()
        self._link.hang_up()
        self._set = _Set()
        if self.stops:
            self.device.stop()

    # --- time --------------------------------------------------------------------------------------------

    def _in_real_time(self, began: float) -> float:
        """Lets the time pass that has passed; returns the wall clock's time at which the world's was 0."""
        behind = time.monotonic() - began - self._link.time
        if behind > MOST_BEHIND:
            began += behind
        if behind < CONTROL_PERIOD:
            return began
        client = self._client
        command = client.newest() if client is not None else None
        if client is not None and command is not None:
            client.spoke = True
            self.commands += 1
            self._link.send(command)
        self._link.tick()
        arrived = self._link.arrived()
        if client is not None and not client.out:  # else it reads too slowly: it gets the next ones
            for kind, payload in arrived:
                client.put(kind, payload)
        return began

    def _in_step(self) -> None:
        """Answers the next command, when all before it is sent."""
        client = self._client
        if client is None or client.out:
            return
        command = client.reader.next()
        if command is None:
            if self._set.due and time.monotonic() - self._set.at >= REST_OF_SET:
                self._answer(client)
            return
        client.spoke = True
        self.commands += 1
        self.device.obey(command)
        if not self._set.due or self._set.request != command.request:
            self.device.tick()
            self._set = _Set(command.request)
        self._answer(client)

    def _answer(self, client: Client) -> None:
        """Sends the next packet of the set, if any is left."""
        self._set.at = time.monotonic()
        kind = self._set.due.pop(0) if self._set.due else None
        if kind == packets.IMAGE_ID:
            client.put(kind, self.device.image())
        elif kind == packets.SENSORS_ID:
            client.put(kind, self.device.sensors().pack())
        elif kind is not None:
            client.put(kind, b"")


class _Set:
    """The packets that one cycle of the robot gives for a request. due: their ids, those not sent yet."""

    def __init__(self, request: int | None = None) -> None:
        self.request, self.at = request, 0.0
        kinds = ((packets.IMAGES, packets.IMAGE_ID), (packets.SENSORS, packets.SENSORS_ID))
        self.due = [kind for bit, kind in kinds if (request or 0) & bit]
        if request == 0:
            self.due = [packets.EMPTY_ID]

"""Serves a page on this machine alone, read only; and what happens, to whoever looks."""

from __future__ import annotations

import errno
import threading
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from types import TracebackType
from typing import Self

from ..errors import UsageError

HOST = "127.0.0.1"
_KEEP_ALIVE = 10.0
"""Seconds without news after which a line is sent, so that a viewer who has gone is noticed."""


class Feed:
    """What was told so far, from the beginning on: every viewer gets all of it, in order.

    viewers: how many are reading now.
    """

    def __init__(self) -> None:
        """Nothing is told yet."""
        self._told: list[bytes] = []
        self._news = threading.Condition()
        self._ended = False
        self.viewers = 0

    def tell(self, kind: str, data: str) -> None:
        """Adds an event of the page's `EventSource`. data: without line breaks."""
        with self._news:
            self._told.append(f"event: {kind}\ndata: {data}\n\n".encode())
            self._news.notify_all()

    def end(self) -> None:
        """Nothing more will be told."""
        self.tell("end", "")
        with self._news:
            self._ended = True
            self._news.notify_all()

    def drained(self, seconds: float) -> bool:
        """Waits until all viewers have got everything; False if they have not within so many seconds."""
        with self._news:
            return self._news.wait_for(lambda: self.viewers == 0, seconds)

    def enter(self) -> None:
        """One viewer more."""
        with self._news:
            self.viewers += 1

    def leave(self) -> None:
        """One viewer less."""
        with self._news:
            self.viewers -= 1
            self._news.notify_all()

    def after(self, index: int) -> list[bytes] | None:
        """What was told from `index` on, waiting for it; [] where nothing comes for long, None at the end."""
        with self._news:
            self._news.wait_for(lambda: len(self._told) > index or self._ended, _KEEP_ALIVE)
            news = self._told[index:]
            return None if not news and self._ended else news


class PageServer:
    """A page at `address`, from `start` to `close`; a context manager."""

    def __init__(self, page: str, port: int = 0, feed: Feed | None = None) -> None:
        """port: 0 takes any that is free. Raises: UsageError for one that cannot be had."""
        self._page, self._feed = page.encode(), feed
        if not 0 <= port < 1 << 16:
            raise UsageError(f"port {port}: there are those from 0 to 65535")
        try:
            self._server = ThreadingHTTPServer((HOST, port), self._handler())
        except OSError as fault:
            taken = fault.errno == errno.EADDRINUSE
            why = "it is taken; name another, or none for any that is free" if taken else fault.strerror
            raise UsageError(f"port {port}: {why}") from None
        self._server.daemon_threads = True
        self._thread = threading.Thread(target=self._server.serve_forever, args=(0.1,), daemon=True)

    @property
    def port(self) -> int:
        """Where it listens."""
        return int(self._server.server_address[1])

    @property
    def address(self) -> str:
        """What to type into a browser."""
        return f"http://{HOST}:{self.port}/"

    def __enter__(self) -> Self:
        """Begins to serve."""
        self._thread.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Serves no more."""
        self._server.shutdown()
        self._server.server_close()

    def _handler(self) -> type[BaseHTTPRequestHandler]:
        page, feed, server = self._page, self._feed, self

        class Handler(BaseHTTPRequestHandler):
            """Answers GET and HEAD of the page, and GET of the feed; to names of this machine alone."""

            protocol_version = "HTTP/1.1"

            def do_HEAD(self) -> None:
                self._answer(body=False)

            def do_GET(self) -> None:
                self._answer(body=True)

            def _answer(self, body: bool) -> None:
                path = self.path.partition("?")[0]
                if self.headers.get("Host") not in {f"{name}:{server.port}" for name in (HOST, "localhost")}:
                    self.send_error(HTTPStatus.FORBIDDEN, "this page is for this machine alone")
                elif path == "/":
                    self._send_page(body)
                elif path == "/events" and feed is not None and body:
                    self._send_feed(feed)
                else:
                    self.send_error(HTTPStatus.NOT_FOUND)

            def _head(self, kind: str) -> None:
                self.send_response(HTTPStatus.OK)
                self.send_header("Content-Type", kind)
                self.send_header("Cache-Control", "no-store")
                self.send_header("X-Content-Type-Options", "nosniff")

            def _send_page(self, body: bool) -> None:
                self._head("text/html; charset=utf-8")
                self.send_header("Content-Length", str(len(page)))
                self.end_headers()
                if body:
                    self.wfile.write(page)

            def _send_feed(self, feed: Feed) -> None:
                self._head("text/event-stream")
                self.send_header("Connection", "close")
                self.end_headers()
                self.close_connection = True
                feed.enter()
                try:
                    index = 0
                    while (news := feed.after(index)) is not None:
                        self.wfile.write(b"".join(news) or b": still here\n\n")
                        self.wfile.flush()
                        index += len(news)
                except OSError:
                    pass  # the viewer has gone
                finally:
                    feed.leave()

            def log_message(self, format: str, *args: object) -> None:
                """Says nothing: stderr is for the run."""

        return Handler

from __future__ import annotations

import http.client
import threading

import pytest
from tolman.scripts.errors import UsageError
from tolman.scripts.report.server import Feed, PageServer


def ask(server: PageServer, method: str, path: str, host: str | None = None) -> http.client.HTTPResponse:
    connection = http.client.HTTPConnection("127.0.0.1", server.port, timeout=10)
    connection.request(method, path, headers={} if host is None else {"Host": host})
    return connection.getresponse()


def test_the_page_is_served_and_nothing_else() -> None:
    with PageServer("<p>hello</p>") as server:
        answer = ask(server, "GET", "/?x")
        assert (answer.status, answer.read()) == (200, b"<p>hello</p>")
        assert ask(server, "HEAD", "/").status == 200
        assert ask(server, "GET", "/etc/passwd").status == 404
        assert ask(server, "GET", "/events").status == 404
        assert ask(server, "POST", "/").status == 501


def test_it_listens_on_this_machine_alone_and_answers_to_its_names_alone() -> None:
    with PageServer("") as server:
        assert server.address.startswith("http://127.0.0.1:")
        assert ask(server, "GET", "/", f"localhost:{server.port}").status == 200
        assert ask(server, "GET", "/", f"evil.example:{server.port}").status == 403


def test_a_port_that_is_taken_is_one_line() -> None:
    with PageServer("") as server, pytest.raises(UsageError, match=f"port {server.port}: it is taken"):
        PageServer("", server.port)


def test_a_port_that_there_is_not_is_one_line() -> None:
    with pytest.raises(UsageError, match="port 70000: there are those from 0 to 65535"):
        PageServer("", 70_000)


def test_who_comes_late_gets_everything_from_the_beginning() -> None:
    feed = Feed()
    feed.tell("begin", "a")
    with PageServer("", feed=feed) as server:
        answer = ask(server, "GET", "/events")
        assert answer.getheader("Content-Type") == "text/event-stream"
        feed.tell("ticks", "b")
        threading.Timer(0.1, feed.end).start()
        told = answer.read().decode()
    assert told == "event: begin\ndata: a\n\nevent: ticks\ndata: b\n\nevent: end\ndata: \n\n"
    assert feed.drained(5.0)

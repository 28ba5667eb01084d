# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The web server: own files only, own host names only, and browsers that leave."""

from __future__ import annotations

import asyncio
import json
import re
import socket
import subprocess
import sys

import pytest
import tornado.httpclient
import tornado.websocket

from aerial_gnss_ros.core.values.errors import InputError
from aerial_gnss_ros.view.server import LOCAL, STATIC, Answer, Socket, application, is_local, listen


class Hello(Answer):
    def get(self):
        self.write("hello")


class Echo(Socket):
    def initialize(self, seen):
        self.seen = seen

    def opened(self):
        self.seen.append("opened")
        self.send({"kind": "hello"})

    def received(self, fields):
        self.send(fields)

    def closed(self):
        self.seen.append("closed")


@pytest.fixture
def pages(tmp_path):
    (tmp_path / "page.html").write_text("<p>page</p>")
    (tmp_path.parent / "secret.txt").write_text("secret")
    return tmp_path


def served(folder, task):
    """Run an asynchronous task beside a server; return what the task returns and what was seen."""
    seen = []

    async def whole():
        app = application(
            "page.html", [("/hello", Hello, {}), ("/socket", Echo, {"seen": seen})], folder
        )
        server, url = listen(app, LOCAL, 0)
        try:
            return await task(url, seen)
        finally:
            server.stop()
            await server.close_all_connections()

    return asyncio.run(whole()), seen


async def get(url, **headers):
    client = tornado.httpclient.AsyncHTTPClient(force_instance=True)
    return await client.fetch(url, raise_error=False, headers=headers, follow_redirects=False)


def test_the_page_and_its_files_are_served_and_nothing_beside_them(pages):
    async def task(url, _seen):
        return [
            await get(url + path)
            for path in (
                "", "static/page.html", "hello", "static/..%2Fsecret.txt", "secret.txt",
                "static/page.html%00",
            )
        ]  # fmt: skip

    (page, file, hello, *outside), _ = served(pages, task)
    assert (page.body, file.body, hello.body) == (b"<p>page</p>", b"<p>page</p>", b"hello")
    assert [answer.code for answer in outside] == [403, 404, 404]


def test_pages_may_load_nothing_from_elsewhere(pages):
    async def task(url, _seen):
        return [await get(url), await get(url + "hello")]

    for answer in served(pages, task)[0]:
        policy = answer.headers["Content-Security-Policy"]
        assert policy.startswith("default-src 'self';")
        assert "http" not in policy


def test_our_pages_name_no_address_elsewhere_and_vendored_files_have_their_licence():
    own = [path for path in STATIC.iterdir() if path.suffix in (".html", ".js", ".css")]
    assert len(own) > 4
    for path in own:
        text = path.read_text(encoding="utf-8").replace("http://www.w3.org/2000/svg", "")
        assert not re.search(r"https?://|[\"'(]//", text), path.name
    for folder in (STATIC / "vendor").iterdir():
        assert "Redistribution" in (folder / "LICENSE").read_text(encoding="utf-8")


@pytest.mark.parametrize(
    ("host", "code"),
    [("127.0.0.1:80", 200), ("localhost", 200), ("[::1]:8060", 200), ("evil.example", 403)],
)
def test_requests_for_the_name_of_another_computer_are_refused(pages, host, code):
    async def task(url, _seen):
        return await get(url + "hello", Host=host)

    assert served(pages, task)[0].code == code


def test_a_browser_gets_messages_and_may_leave_at_any_time(pages):
    async def task(url, seen):
        address = url.replace("http", "ws") + "socket"
        first = await tornado.websocket.websocket_connect(address)
        hello = await first.read_message()
        await first.write_message("no JSON")
        await first.write_message("[" * 100_000)
        await first.write_message(json.dumps({"kind": "asked"}))
        answer = await first.read_message()
        first.close()
        leaving = await tornado.websocket.websocket_connect(address)
        leaving.protocol.stream.close()  # without a word
        for _ in range(4500):
            if seen.count("closed") == 2:
                break
            await asyncio.sleep(0.02)
        return json.loads(hello), json.loads(answer)

    (hello, answer), seen = served(pages, task)
    assert (hello, answer) == ({"kind": "hello"}, {"kind": "asked"})
    assert sorted(seen) == ["closed", "closed", "opened", "opened"]


def test_a_page_of_another_site_may_not_connect(pages):
    async def task(url, _seen):
        request = tornado.httpclient.HTTPRequest(
            url.replace("http", "ws") + "socket", headers={"Origin": "http://evil.example"}
        )
        with pytest.raises(tornado.httpclient.HTTPClientError, match="403"):
            await tornado.websocket.websocket_connect(request)

    assert served(pages, task)[1] == []


def test_a_port_in_use_is_said_with_the_remedy(pages):
    with socket.socket() as taken:
        taken.bind((LOCAL, 0))
        taken.listen()
        port = taken.getsockname()[1]
        with pytest.raises(InputError, match=rf"port {port} of 127.0.0.1 is in use.*--port"):
            listen(application("page.html", [], pages), LOCAL, port)


def test_an_address_of_another_computer_is_refused(pages):
    with pytest.raises(InputError, match=r"192\.0\.2\.1 is no address of this computer"):
        listen(application("page.html", [], pages), "192.0.2.1", 0)


@pytest.mark.parametrize(
    ("bind", "local"),
    [("127.0.0.1", True), ("::1", True), ("0.0.0.0", False), ("boat", False)],  # noqa: S104
)
def test_what_others_can_reach(bind, local):
    assert is_local(bind) == local


PROGRAM = """
import os, signal
from aerial_gnss_ros.view.server import application, run
run(application("view.html", []), "127.0.0.1", 0, lambda url: os.kill(os.getpid(), {signal}))
print("ended")
"""


@pytest.mark.parametrize("number", [2, 15])
def test_a_signal_ends_the_server_quietly(number):
    done = subprocess.run(
        [sys.executable, "-c", PROGRAM.replace("{signal}", str(number))],
        capture_output=True, text=True, timeout=300, check=False,
    )  # fmt: skip
    assert (done.returncode, done.stdout, done.stderr) == (0, "ended\n", "")

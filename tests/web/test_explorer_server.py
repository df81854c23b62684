"""The command without a browser: where it listens, how it ends."""

from __future__ import annotations

import json
import os
import signal
import socket
import subprocess
import sys
import urllib.request
from urllib.parse import urlsplit

import pytest


@pytest.fixture
def server(tmp_path):
    plain = {name: value for name, value in os.environ.items() if not name.startswith(("PYTEST", "NICEGUI"))}
    beam = tmp_path / "beam.toml"
    subprocess.run([sys.executable, "-m", "squama", "new", str(beam)], check=True, capture_output=True)
    command = [
        sys.executable,
        "-m",
        "squama",
        "explore",
        str(beam),
        "--no-browser",
        "--json",
        "--set",
        "friction.mu=0.4",
    ]
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
    with subprocess.Popen(command, env=plain, **pipes) as process:
        yield process
        process.kill()


def test_it_listens_on_this_machine_only_and_ends_quietly(server) -> None:
    told = "".join(server.stdout.readline() for _ in range(4))
    address = urlsplit(json.loads(told)["address"])
    assert address.hostname == "127.0.0.1"
    # a client that keeps cookies, as a browser does
    client = urllib.request.build_opener(urllib.request.HTTPCookieProcessor())
    page = client.open(address.geturl()).read().decode()
    assert "squama explorer" in page
    assert "0.4" in page, "the value of --set"
    # the port is not open on the machine's other addresses (every address of 127.0.0.0/8 is this machine)
    with socket.socket() as other:
        assert other.connect_ex(("127.0.0.2", address.port)) != 0
    server.send_signal(signal.SIGINT)
    said, complained = server.communicate(timeout=60)
    assert server.returncode in (0, 130)
    assert "Traceback" not in said + complained

"""A studio served in a process of its own, and Debian's Chromium to look at it."""

from __future__ import annotations

import json
import os
import shutil
import socket
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from studio_tabs import PATIENCE_S


@pytest.fixture(scope="session")
def browser() -> Iterator[Any]:
    """Headless Chromium without network; skips where it is not installed."""
    playwright = pytest.importorskip("playwright.sync_api", reason="pip install playwright")
    chromium = shutil.which("chromium")
    if chromium is None:
        pytest.skip("needs Debian's package chromium")
    with playwright.sync_playwright() as driver:
        flags = ["--no-sandbox", "--disable-gpu", "--disable-background-networking"]
        shown = driver.chromium.launch(executable_path=chromium, args=flags)
        yield shown
        shown.close()


@pytest.fixture
def new_tab(browser: Any) -> Iterator[Callable[..., Any]]:
    """Opens tabs, each with a memory of its own, that wait long, must not fail, and must not
    ask any other machine."""
    contexts: list[Any] = []
    asked: list[str] = []
    faults: list[str] = []

    def open_one(**options: Any) -> Any:
        context = browser.new_context(**{"viewport": {"width": 1280, "height": 900}, **options})
        contexts.append(context)
        context.set_default_timeout(1000 * PATIENCE_S)
        context.on("request", lambda request: asked.append(request.url))
        context.on("weberror", lambda error: faults.append(str(error.error)))
        return context.new_page()

    yield open_one
    for context in contexts:
        context.close()
    assert not faults
    local = ("http://127.0.0.1:", "ws://127.0.0.1:", "data:", "blob:")
    assert [url for url in asked if not url.startswith(local)] == []


def free_port() -> int:
    with socket.socket() as s:
        s.bind(("127.0.0.1", 0))
        return int(s.getsockname()[1])


def start_studio(*arguments: str, port: int | None = None) -> tuple[subprocess.Popen[bytes], str]:
    """Starts the studio and waits until it answers; returns the process and its address."""
    pytest.importorskip("nicegui", reason="pip install 'demospec[studio]'")
    # nicegui behaves otherwise where it sees pytest's variable: the studio must not see it.
    environment = {k: v for k, v in os.environ.items() if not k.startswith("PYTEST")}
    for _ in range(5):
        process = subprocess.Popen(
            [sys.executable, "-m", "demospec", "studio", *arguments, "--json", "--no-browser",
             "--port", str(free_port() if port is None else port)],
            env=environment,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
        )  # fmt: skip
        assert process.stdout is not None
        lines: list[bytes] = []
        with process.stdout as said:
            # One document, whose last line is its brace; nothing where the process ends.
            while lines[-1:] != [b"}\n"] and (line := said.readline()):
                lines.append(line)
        if lines:
            return process, json.loads(b"".join(lines))["address"].split("/teach")[0]
        process.wait(PATIENCE_S)  # somebody else took the port meanwhile
    raise RuntimeError("the studio did not start")


@pytest.fixture(scope="session")
def serve_studio() -> Callable[..., tuple[subprocess.Popen[bytes], str]]:
    """`start_studio`, for test modules that serve a studio of their own."""
    return start_studio


@pytest.fixture(scope="session")
def small_set(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Three scenes with pictures and demonstrations of three types."""
    from demospec.demonstrations import simulate_set, write_set

    data, truth = simulate_set(train_scenes=2, test_scenes=1, demonstrations=3, seed=1)
    folder = tmp_path_factory.mktemp("studio") / "set"
    return write_set(data, folder, documents={"truth.json": truth})


@pytest.fixture(scope="session")
def studio(small_set: Path) -> Iterator[str]:
    process, address = start_studio(str(small_set))
    yield address
    process.terminate()
    process.wait(60)

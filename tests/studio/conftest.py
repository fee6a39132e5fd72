"""A studio served in a process of its own, and Debian's Chromium to look at it."""

from __future__ import annotations

import os
import shutil
import socket
import subprocess
import sys
import time
import urllib.error
import urllib.request
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest


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


def free_port() -> int:
    with socket.socket() as s:
        s.bind(("127.0.0.1", 0))
        return int(s.getsockname()[1])


def start_studio(*arguments: str) -> tuple[subprocess.Popen[bytes], str]:
    """Starts the studio and waits until it answers; returns the process and its address."""
    pytest.importorskip("nicegui", reason="pip install 'demospec[studio]'")
    port = free_port()
    # nicegui behaves otherwise where it sees pytest's variable: the studio must not see it.
    environment = {k: v for k, v in os.environ.items() if not k.startswith("PYTEST")}
    process = subprocess.Popen(
        [sys.executable, "-m", "demospec", "studio", *arguments,
         "--port", str(port), "--no-browser"],
        env=environment,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )  # fmt: skip
    address = f"http://127.0.0.1:{port}"
    for _ in range(300):
        try:
            with urllib.request.urlopen(address + "/studio-static/studio.css", timeout=1):
                return process, address
        except urllib.error.HTTPError:  # it answers, and wants the token
            return process, address
        except (urllib.error.URLError, OSError):
            if process.poll() is not None:
                raise RuntimeError("the studio did not start") from None
            time.sleep(0.1)
    process.kill()
    raise RuntimeError("the studio did not answer")


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
    process.wait(10)

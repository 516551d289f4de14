"""A running Chromium for tests of pages."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import pytest


@contextmanager
def launched(target: str) -> Iterator[Any]:
    """Yield a headless Chromium; skip the test without one. `target`: of the Makefile, which installs playwright."""
    playwright = pytest.importorskip("playwright.sync_api", reason=f"playwright is not installed: {target}")
    chromium = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
    if not chromium:
        pytest.skip("chromium is not installed")
    with playwright.sync_playwright() as running:
        browser = running.chromium.launch(executable_path=chromium, args=["--no-sandbox"])
        yield browser
        browser.close()

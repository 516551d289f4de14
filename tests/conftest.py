"""What all tests share: golden numbers, measured recordings, figures without a screen, repeatable draws."""

from __future__ import annotations

import os
from pathlib import Path

import hypothesis
import pytest

# Before anything imports matplotlib; commands that a test starts inherit it.
os.environ["MPLBACKEND"] = "Agg"

# Derandomized: a commit passes or fails the same way everywhere. No deadline and no health check of speed:
# a busy machine is not a fault. (pytest --hypothesis-profile=default draws anew.)
hypothesis.settings.register_profile(
    "tirefmu",
    deadline=None,
    derandomize=True,
    print_blob=True,
    suppress_health_check=[hypothesis.HealthCheck.too_slow],
)
hypothesis.settings.load_profile("tirefmu")


@pytest.fixture(scope="session")
def golden() -> Path:
    """Return the folder of numbers from elsewhere; each file's header says from where."""
    return Path(__file__).parent / "golden"


@pytest.fixture(scope="session")
def data_folder() -> Path:
    """Return the folder of measured recordings, which are not part of the project."""
    name = os.environ.get("TIREFMU_DATA")
    if not name:
        pytest.skip("TIREFMU_DATA names no folder of measured recordings (they are not part of the project)")
    folder = Path(name)
    if not folder.is_dir():
        pytest.fail(f"TIREFMU_DATA is {name}, which is no folder")
    return folder

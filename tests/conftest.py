"""What all tests share: golden numbers, measured recordings, figures without a screen, repeatable draws."""

from __future__ import annotations

import os
from collections.abc import Iterator
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


@pytest.fixture(scope="session", autouse=True)
def compiled_code(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """Keep built libraries in the session's own folder, one for all its workers, and leave the user's alone."""
    folder = tmp_path_factory.getbasetemp()
    if "PYTEST_XDIST_WORKER" in os.environ:
        folder = folder.parent
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("TIREFMU_CACHE", str(folder / "compiled"))
        yield folder / "compiled"


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

"""Fixtures of all tests: golden numbers, measured recordings, figures without a screen, repeatable random examples."""

from __future__ import annotations

import gc
import lzma
import os
import pickle
from collections.abc import Callable, Generator, Iterator
from pathlib import Path
from typing import Any

import filelock
import hypothesis
import pytest

# Set before NumPy and matplotlib are imported; commands that a test starts inherit it.
os.environ["MPLBACKEND"] = "Agg"
# Tests run on all processors: threads of BLAS would only wait for one another, which takes most of their time.
os.environ["OMP_NUM_THREADS"] = os.environ["OPENBLAS_NUM_THREADS"] = "1"

# Derandomized: a commit has the same result everywhere. No deadline and no health check of speed, because machines may
# be busy. A release draws more examples (and pytest --hypothesis-profile=default new ones).
hypothesis.settings.register_profile(
    "tirefmu",
    max_examples=100 if "TIREFMU_SLOW" in os.environ else 30,
    deadline=None,
    derandomize=True,
    print_blob=True,
    suppress_health_check=[hypothesis.HealthCheck.too_slow],
)
hypothesis.settings.load_profile("tirefmu")


@pytest.hookimpl(wrapper=True)
def pytest_collection(session: pytest.Session) -> Generator[None]:
    """In the first run, let one worker collect before the others, which find the bytecode that it has written.

    To compile tests, package and libraries takes twice as long as to collect.
    """
    cache = getattr(session.config, "cache", None)
    if cache and "PYTEST_XDIST_WORKER" in os.environ:
        folder = cache.mkdir("collected")
        with filelock.FileLock(folder / "lock"):
            if not (folder / "once").exists():
                result = yield
                (folder / "once").touch()
                return result
    return (yield)


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Skip what only a release needs to know: tests that are marked as slow."""
    if "TIREFMU_SLOW" not in os.environ:
        for item in items:
            if item.get_closest_marker("slow"):
                item.add_marker(pytest.mark.skip(reason="slow: set TIREFMU_SLOW=1"))


def pytest_collection_finish() -> None:
    """Search for garbage rarely, and not among what was imported: it takes a tenth of the time otherwise."""
    gc.set_threshold(200_000, 20, 50)
    gc.freeze()


@pytest.fixture(scope="session", autouse=True)
def quickly_compiled() -> Iterator[None]:
    """Compile what runs often with few optimizations and the Jacobians of single rows, most of the code, with none.

    Kernels run 15 times as fast as without optimization for a quarter more time of the compiler. FMUs run few steps and
    are not optimized either. Tests of optimized code name its level.

    Optimized as for a user with TIREFMU_SLOW, and where TIREFMU_MACHINE chooses an instruction set.
    """
    from tirefmu.fmu.packaging import binaries
    from tirefmu.tires.code import c_code, compiler

    with pytest.MonkeyPatch.context() as patch:
        if not {"TIREFMU_SLOW", "TIREFMU_MACHINE"} & os.environ.keys():
            patch.setattr(compiler, "FLAGS", tuple(flag.replace("-O2", "-Og") for flag in compiler.FLAGS))
            patch.setattr(c_code, "QUICKLY", ("-O0",))
            patch.setattr(binaries, "FLAGS", (*binaries.FLAGS, "-O0"))
            patch.setattr(binaries, "SMALL", ())
        yield


@pytest.fixture(scope="session", autouse=True)
def compiled_code(pytestconfig: pytest.Config, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """Cache compiled libraries and printed code in pytest's cache instead of the user's cache.

    Entries are named by the digest of what they are made from, so that the next run uses them too. `--cache-clear`
    removes them. `-p no:cacheprovider` gives each run an empty cache, shared by its workers.
    """
    cache, folder = getattr(pytestconfig, "cache", None), tmp_path_factory.getbasetemp()
    if "PYTEST_XDIST_WORKER" in os.environ:
        folder = folder.parent
    folder = cache.mkdir("compiled") if cache else folder / "compiled"
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("TIREFMU_CACHE", str(folder))
        yield folder


@pytest.fixture(scope="session", autouse=True)
def coarse_figures() -> Iterator[None]:
    """Make figures with few pixels and nothing on them: no test looks at them, and they take long.

    Tests of what is drawn request `drawn_figures`.
    """
    from matplotlib.figure import Figure

    from tirefmu.drawing import picture
    from tirefmu.tires.drawing import files

    class Unseen(Figure):
        def draw(self, renderer: object) -> None:
            """Draw nothing."""

    with pytest.MonkeyPatch.context() as patch:
        _make_figures(patch, Unseen)
        patch.setattr(picture, "DPI", 40)
        patch.setattr(picture, "PAGE_DPI", 40)
        patch.setattr(files, "DPI", 40)
        yield


@pytest.fixture
def drawn_figures() -> Iterator[None]:
    """Draw figures, with their axes where they first are."""
    from matplotlib.figure import Figure

    with pytest.MonkeyPatch.context() as patch:
        _make_figures(patch, Figure)
        yield


def _make_figures(patch: pytest.MonkeyPatch, kind: Callable[..., object]) -> None:
    from tirefmu.drawing import picture
    from tirefmu.tires.drawing import surface_figure

    for module in (picture, surface_figure):
        patch.setattr(module, "MatplotlibFigure", lambda **given: kind(**{**given, "layout": None}))


@pytest.fixture(scope="session")
def once(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str, Callable[[Path], Any]], Any]:
    """Return what computes a result with a name once for all workers, from a function of an empty folder."""
    folder = tmp_path_factory.getbasetemp()
    folder = folder.parent if "PYTEST_XDIST_WORKER" in os.environ else folder

    def result(name: str, make: Callable[[Path], Any]) -> Any:
        stored = folder / f"{name}.pickle"
        with filelock.FileLock(folder / f"{name}.lock"):
            if not stored.exists():
                (folder / name).mkdir()
                stored.write_bytes(pickle.dumps(make(folder / name)))
        return pickle.loads(stored.read_bytes())

    return result


@pytest.fixture(scope="session")
def golden() -> Path:
    """Return the folder of reference numbers; the header of each file states the source."""
    return Path(__file__).parent / "golden"


@pytest.fixture(scope="session")
def trento_table(golden: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the unpacked table of the Trento team's functions, for commands that read tables."""
    path = tmp_path_factory.mktemp("golden") / "mf96_trento.csv"
    path.write_bytes(lzma.decompress((golden / "mf96_trento.csv.xz").read_bytes()))
    return path


@pytest.fixture(scope="session")
def data_folder() -> Path:
    """Return the folder of the measured recordings, which are not part of the project."""
    name = os.environ.get("TIREFMU_DATA")
    if not name:
        pytest.skip("TIREFMU_DATA is not set: measured recordings are not part of the project")
    folder = Path(name)
    if not folder.is_dir():
        pytest.fail(f"TIREFMU_DATA is {name}, which is not a folder")
    return folder

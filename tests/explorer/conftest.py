"""Pages in a headless Chromium."""

from __future__ import annotations

import itertools

import pytest

from tirefmu import explore
from tirefmu.measurements import VirtualBench, alpha_sweeps, concatenate, kappa_sweeps
from tirefmu.symbolic.models import MODELS
from tirefmu.tires import Tire, published, read_tir

from ..chromium import launched

FIALA = {"FNOMIN": 3000.0, "UNLOADED_RADIUS": 0.31, "WIDTH": 0.15, "VERTICAL_STIFFNESS": 2e5, "CSLIP": 9e4,
         "CALPHA": 6e4, "UMIN": 0.7, "UMAX": 1.1, "ROLLING_RESISTANCE": 0.01}  # fmt: skip


@pytest.fixture(scope="session")
def tires(golden):
    """Return a tire of each model, in ISO-W."""
    magic = {name: read_tir(golden / f"MagicFormula{name[2:]}_Parameters.tir") for name in ("mf52", "mf61", "mf62")}
    brush = Tire("brush", {"FNOMIN": 3000.0, "UNLOADED_RADIUS": 0.31})
    made = {**magic, "fiala": Tire("fiala", FIALA), "brush": brush, "mf96": published("trento_hoosier").in_signs("iso")}
    assert set(made) == set(MODELS)
    return made


@pytest.fixture(scope="module")  # its event loop excludes those of other tests
def browser():
    """Return a running Chromium; skip the test without it."""
    with launched("make pages") as running:
        yield running


@pytest.fixture
def opened_file(browser):
    """Return a function that opens a page and returns it; at the end no page has reported an error."""
    contexts, problems = [], []

    def open_file(path, *, width=1400, height=900, fragment=""):
        context = browser.new_context(viewport={"width": width, "height": height}, accept_downloads=True)
        contexts.append(context)
        page = context.new_page()
        page.on("console", lambda message: problems.append(f"{message.type}: {message.text}"))
        page.on("pageerror", lambda error: problems.append(str(error)))
        page.on("request", lambda request: None if request.url.startswith("file:") else problems.append(request.url))
        page.goto(f"{path.as_uri()}{fragment}")
        return page

    yield open_file
    for context in contexts:
        context.close()
    assert not problems


@pytest.fixture
def opened(opened_file, tmp_path):
    """Return a function that writes the page of a tire, opens it and returns it."""
    count = itertools.count()

    def open_page(tire, *, width=1400, height=900, fragment="", **content):
        path = tmp_path / f"page{next(count)}.html"
        explore(tire, path, **content)
        page = opened_file(path, width=width, height=height, fragment=fragment)
        page.locator("#charts canvas").first.wait_for()
        return page

    return open_page


@pytest.fixture(scope="session")
def bench():
    """Return a recording of sweeps at two loads, in adapted SAE."""
    program = concatenate([alpha_sweeps([440.0, 900.0], sample_rate=10.0), kappa_sweeps([700.0], sample_rate=10.0)])
    return VirtualBench(published("trento_hoosier"), seed=1).run(program)

# Needs Python 3.11+, make and a C compiler; everything else is installed in $(VENV) on first use.
VENV ?= .venv
# Tests run on all processors, those of a file on one, so that they share fixtures. PYTEST_ARGS=... replaces this.
export PYTEST_ARGS ?= -n auto --dist loadfile
# Bytecode is written, also where the environment forbids it: hundreds of processes would compile the package again.
export PYTHONDONTWRITEBYTECODE :=
BIN := $(VENV)/$(if $(filter Windows_NT,$(OS)),Scripts,bin)
# Modules are compiled when they are first imported: pip would compile all of them, which takes half of its time.
INSTALL := $(BIN)/python -m pip install --quiet --no-compile --no-build-isolation --editable

# The first working Python (version managers install commands that only print a notice) that can create a venv.
PYTHON ?= $(shell for python in python3.14 python3.13 python3.12 python3.11 python3 python; do \
	$$python -c 'import ensurepip, sys, venv; sys.exit(sys.version_info < (3, 11))' >/dev/null 2>&1 \
	&& echo $$python && break; done)

.PHONY: install demo test check generate docs pages studio release matrix types clean
.NOTPARALLEL:

install: $(VENV)/installed  ## the command tirefmu in .venv/bin, with its window

demo: $(VENV)/installed  ## the full workflow on the built-in virtual bench
	$(BIN)/tirefmu demo -o demo-output

test: $(VENV)/installed-dev  ## all tests but the slow ones (TIREFMU_SLOW=1); those on measured recordings need their folder in TIREFMU_DATA
	$(BIN)/pytest $(PYTEST_ARGS)

check: $(VENV)/installed-dev types  ## lint, format, types, imports, and generated/ compared with the equations
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	cd .types && ../$(BIN)/mypy --config-file ../pyproject.toml --cache-dir ../.mypy_cache
	cd .types && ../$(BIN)/lint-imports --config ../pyproject.toml --no-cache --no-logo
	$(BIN)/tirefmu generate --check

generate: $(VENV)/installed  ## write generated/
	$(BIN)/tirefmu generate

docs: $(VENV)/installed-dev  ## the documentation site in build/site, without connections; warnings are errors; runs the notebooks
	@$(INSTALL) ".[docs]"
	rm -rf build/gallery
	NO_MKDOCS_2_WARNING=1 $(BIN)/mkdocs build
	TIREFMU_NOTEBOOKS=1 $(BIN)/pytest tests/docs $(PYTEST_ARGS)

pages: $(VENV)/installed-dev  ## the explorer page in Chromium: 1,000 slider settings per model, accessibility, frame times; every page at two widths
	@$(INSTALL) ".[browser]"
	TIREFMU_PAGES=1 $(BIN)/pytest tests/explorer $(PYTEST_ARGS)
	$(BIN)/python benchmarks/explorer_frames.py

studio: $(VENV)/installed-dev  ## the window in Chromium: from recordings to an FMU, errors of a user, accessibility, times
	@$(INSTALL) ".[browser]"
	TIREFMU_STUDIO=1 $(BIN)/pytest tests/studio -s $(PYTEST_ARGS)

release: $(VENV)/installed-dev  ## wheel and sdist in dist/, the demo of the wheel in a clean environment, the conda recipe
	@$(INSTALL) ".[release]"
	TIREFMU_SLOW=1 TIREFMU_RELEASE="$(CURDIR)/dist" $(BIN)/pytest tests/test_release.py tests/test_wheel.py tests/test_packages.py

matrix: $(VENV)/installed  ## all tests with gcc and clang, on every supported Python, and with the oldest dependencies
	@$(INSTALL) ".[matrix]"
	$(BIN)/nox -f .ci/noxfile.py $(NOX_ARGS)

# mypy and import-linter import the root under its name.
types:
	@mkdir -p .types && ln -sfn .. .types/tirefmu

clean:
	rm -rf .types build dist demo-output *.egg-info .hypothesis .mypy_cache .pytest_cache .ruff_cache
	git ls-files -z '*.py' | xargs -0 -n1 dirname | sort -u | sed 's,$$,/__pycache__,' | xargs rm -rf

# A study of benchmarks/studies.toml: "make recovery RECOVERY_ARGS=--quick" runs "python -m benchmarks recovery --quick".
.DEFAULT:
	@$(MAKE) --no-print-directory $(VENV)/installed-dev
	$(BIN)/python -m benchmarks $@ $($(shell echo $@ | tr a-z- A-Z_)_ARGS)

# pip runs without build isolation: the setuptools in $(VENV) builds everything.
$(VENV)/installed: pyproject.toml | $(VENV)/created
	@echo "Installing tirefmu into $(VENV) (once, and when pyproject.toml changes; 1 to 5 minutes)"
	@$(INSTALL) ".[studio]"
	@touch $@

$(VENV)/installed-dev: pyproject.toml | $(VENV)/created
	@echo "Installing tirefmu and its development tools into $(VENV) (once, and when pyproject.toml changes)"
	@$(INSTALL) ".[dev]" --editable benchmarks/missing_effects
	@touch $(VENV)/installed $@

$(VENV)/created:
	@test -n "$(PYTHON)" || { echo "No Python 3.11+ found: set one with 'make PYTHON=...'" >&2; exit 1; }
	@echo "Setting up $(VENV) with $$($(PYTHON) --version)"
	@$(PYTHON) -m venv --clear $(VENV)
	@$(BIN)/python -m pip install --quiet "setuptools>=77"
	@touch $@

# Needs Python 3.11+, make and a C compiler; everything else is set up in $(VENV) on first use.
VENV ?= .venv
# Tests run on every processor, those of a file on one: what they share is set up once. PYTEST_ARGS=... replaces this.
PYTEST_ARGS ?= -n auto --dist loadfile
BIN := $(VENV)/$(if $(filter Windows_NT,$(OS)),Scripts,bin)
ROOMS := symbolic generated tires measurements estimation fitting fmu diagnosis

# The first Python that really runs (version managers leave commands that only print a notice) and can make a venv.
PYTHON ?= $(shell for python in python3.13 python3.12 python3.11 python3 python; do \
	$$python -c 'import ensurepip, sys, venv; sys.exit(sys.version_info < (3, 11))' >/dev/null 2>&1 \
	&& echo $$python && break; done)

.PHONY: demo test matrix fuzz mutants discovery recovery real wine sanitize examples perturb check generate types bench bench-fit clean
.NOTPARALLEL:

demo: $(VENV)/installed  ## the whole circle on the built-in virtual bench
	$(BIN)/tirefmu demo -o demo-output

test: $(VENV)/installed-dev  ## all tests; the measured recordings' too where TIREFMU_DATA names their folder
	$(BIN)/pytest $(PYTEST_ARGS)

matrix: $(VENV)/installed  ## all tests with gcc and clang, on Python 3.11 to 3.13, and with the oldest dependencies
	@$(BIN)/python -m pip install --quiet --no-build-isolation --editable ".[matrix]"
	$(BIN)/nox $(NOX_ARGS)

fuzz: $(VENV)/installed-dev  ## 10,000 mutated files of every kind that is read; a hang is shown after a minute, where it hangs
	TIREFMU_FUZZ=10000 $(BIN)/pytest tests/fuzz -o faulthandler_timeout=60 $(PYTEST_ARGS)

mutants: $(VENV)/installed-dev  ## 33 single-line faults in a copy of the tree: which of them do the nearest tests not notice?
	$(BIN)/python benchmarks/mutants.py $(MUTANTS_ARGS)

perturb: $(VENV)/installed-dev  ## fits and a diagnosis say the same as if another processor had computed them
	TIREFMU_PERTURB=1 $(BIN)/pytest tests/fitting/test_perturbations.py $(PYTEST_ARGS)

discovery: $(VENV)/installed-dev  ## how often the diagnosis is right, over 116 made recordings
	OMP_NUM_THREADS=1 $(BIN)/python benchmarks/discovery.py $(DISCOVERY_ARGS)

recovery: $(VENV)/installed-dev  ## known coefficients found again: 100 refits a model, 50 starts; RECOVERY_ARGS=--quick for a look
	$(BIN)/python benchmarks/recovery.py $(RECOVERY_ARGS)

real: $(VENV)/installed-dev  ## the diagnosis on the measured recordings in TIREFMU_DATA, held-out sweeps judging
	$(BIN)/python benchmarks/real_discovery.py $(REAL_ARGS)

wine: $(VENV)/installed-dev  ## the FMU's Windows binary under wine64 gives the digits of the Linux one
	@$(BIN)/python -m pip install --quiet --no-build-isolation --editable ".[cross]"
	TIREFMU_WINE=1 $(BIN)/pytest tests/fmu/test_wine.py $(PYTEST_ARGS)

sanitize: $(VENV)/installed-dev  ## the FMU's C code under AddressSanitizer and UBSan, mistreated by a host in C
	TIREFMU_SANITIZE=1 $(BIN)/pytest tests/fmu/test_robustness.py $(PYTEST_ARGS)

examples: $(VENV)/installed-dev  ## FMUs in fmpy, libcosim, ecos and fmutool, and under a vehicle
	@$(BIN)/python -m pip install --quiet --no-build-isolation --editable ".[cosimulation]"
	$(BIN)/pytest tests/examples $(PYTEST_ARGS)

check: $(VENV)/installed-dev types  ## lint, format, types, and that generated/ is what the book prints
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/tirefmu generate --check

generate: $(VENV)/installed  ## print the book into generated/
	$(BIN)/tirefmu generate

bench: $(VENV)/installed  ## how long a point takes: CasADi, SymPy, NumPy, C and the batch kernels in one run
	$(BIN)/python benchmarks/evaluation.py $(BENCH_ARGS)

bench-fit: $(VENV)/installed  ## how long a fit takes, beside scipy's trf; seconds and memory up to a million rows
	$(BIN)/python benchmarks/fitting.py $(BENCH_ARGS)

# The rooms are sub-packages of tirefmu only once installed; type checkers read this tree of links instead.
types:
	@rm -rf .types && mkdir -p .types/tirefmu
	@for entry in $(ROOMS) $(filter-out %/__pycache__,$(wildcard tirefmu/*)); do \
		ln -s "../../$$entry" ".types/tirefmu/$${entry##*/}" || exit 1; done

clean:
	rm -rf .types build dist demo-output *.egg-info .hypothesis .mypy_cache .pytest_cache .ruff_cache
	find $(ROOMS) tirefmu tests -name __pycache__ -prune -exec rm -rf {} +

# pip runs without build isolation, so that the one setuptools in $(VENV) builds everything.
$(VENV)/installed: pyproject.toml | $(VENV)/created
	@echo "Installing tirefmu into $(VENV) (once, and when pyproject.toml changes)"
	@$(BIN)/python -m pip install --quiet --no-build-isolation --editable .
	@touch $@

$(VENV)/installed-dev: pyproject.toml | $(VENV)/created
	@echo "Installing tirefmu and its development tools into $(VENV) (once, and when pyproject.toml changes)"
	@$(BIN)/python -m pip install --quiet --no-build-isolation --editable ".[dev]"
	@touch $(VENV)/installed $@

$(VENV)/created:
	@test -n "$(PYTHON)" || { echo "No Python 3.11+ found: name one with 'make PYTHON=...'" >&2; exit 1; }
	@echo "Setting up $(VENV) with $$($(PYTHON) --version)"
	@$(PYTHON) -m venv --clear $(VENV)
	@$(BIN)/python -m pip install --quiet "setuptools>=77"
	@touch $@

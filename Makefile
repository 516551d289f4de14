# Needs Python 3.11+, make and a C compiler; everything else is installed in $(VENV) on first use.
VENV ?= .venv
# Tests run on all processors, those of a file on one, so that they share fixtures. PYTEST_ARGS=... replaces this.
PYTEST_ARGS ?= -n auto --dist loadfile
BIN := $(VENV)/$(if $(filter Windows_NT,$(OS)),Scripts,bin)
PACKAGES := boundary symbolic generated tires measurements estimation fitting fmu batch comparison diagnosis hosts explorer planning driving studio benchmarks/missing_effects

# The first working Python (version managers install commands that only print a notice) that can create a venv.
PYTHON ?= $(shell for python in python3.13 python3.12 python3.11 python3 python; do \
	$$python -c 'import ensurepip, sys, venv; sys.exit(sys.version_info < (3, 11))' >/dev/null 2>&1 \
	&& echo $$python && break; done)

.PHONY: install demo test matrix pages studio docs docs-commands release fuzz mutants discovery drives foreign-drive measured-drives missing-effects awkward wrong-tables recovery planning confounded coverage family real temperature wine proofs plugins prebuilt wheel sanitize warnings hosts readers examples perturb workers check generate types bench-languages bench-steps many-tires performance clean
.NOTPARALLEL:

install: $(VENV)/installed  ## the command tirefmu in .venv/bin

demo: $(VENV)/installed  ## the full workflow on the built-in virtual bench
	$(BIN)/tirefmu demo -o demo-output

test: $(VENV)/installed-dev  ## all tests; those on measured recordings need their folder in TIREFMU_DATA
	$(BIN)/pytest $(PYTEST_ARGS)

matrix: $(VENV)/installed  ## all tests with gcc and clang, on Python 3.11 to 3.13, and with the oldest dependencies
	@$(BIN)/python -m pip install --quiet --no-build-isolation --editable ".[matrix]"
	$(BIN)/nox $(NOX_ARGS)

docs: $(VENV)/installed-dev  ## the documentation site in build/site, without connections; warnings are errors; runs the notebooks
	@$(BIN)/python -m pip install --quiet --no-build-isolation --editable ".[docs]"
	rm -rf build/gallery
	NO_MKDOCS_2_WARNING=1 $(BIN)/mkdocs build
	TIREFMU_NOTEBOOKS=1 $(BIN)/pytest tests/docs $(PYTEST_ARGS)

docs-commands: $(VENV)/installed-dev  ## every block of the documentation, also those that take long
	TIREFMU_DOCS=1 $(BIN)/pytest tests/docs/test_commands.py $(PYTEST_ARGS)

release: $(VENV)/installed-dev  ## wheel and sdist in dist/, the demo of the wheel in a clean environment, the conda recipe
	@$(BIN)/python -m pip install --quiet --no-build-isolation --editable ".[release]"
	TIREFMU_RELEASE="$(CURDIR)/dist" $(BIN)/pytest tests/test_release.py tests/test_wheel.py tests/test_packages.py

pages: $(VENV)/installed-dev  ## the explorer page in Chromium: 1,000 slider settings per model, accessibility, frame times; every page at two widths
	@$(BIN)/python -m pip install --quiet --no-build-isolation --editable ".[browser]"
	TIREFMU_PAGES=1 $(BIN)/pytest tests/explorer $(PYTEST_ARGS)
	$(BIN)/python benchmarks/explorer_frames.py

studio: $(VENV)/installed-dev  ## the window in Chromium: from recordings to an FMU, errors of a user, accessibility, times
	@$(BIN)/python -m pip install --quiet --no-build-isolation --editable ".[browser]"
	TIREFMU_STUDIO=1 $(BIN)/pytest tests/studio -s $(PYTEST_ARGS)

fuzz: $(VENV)/installed-dev  ## 10,000 mutated files of every kind that is read, a million random calls of hub FMUs; a traceback is printed if a test hangs for a minute
	TIREFMU_FUZZ=10000 $(BIN)/pytest tests/fuzz -o faulthandler_timeout=60 $(PYTEST_ARGS)
	TIREFMU_FUZZ=10000 $(BIN)/pytest tests/fmu/test_robustness.py -k random_calls $(PYTEST_ARGS)

mutants: $(VENV)/installed-dev  ## 66 single-line faults in a copy of the tree: lists those that the nearest tests miss
	$(BIN)/python benchmarks/mutants.py $(MUTANTS_ARGS)

perturb: $(VENV)/installed-dev  ## fits and a diagnosis have equal results with other instruction sets and rounding
	TIREFMU_PERTURB=1 $(BIN)/pytest tests/fitting/test_perturbations.py $(PYTEST_ARGS)

workers: $(VENV)/installed-dev  ## two Dask workers, one of them killed midway: diagnoses with FMUs, a study, cross-validation, a bootstrap
	TIREFMU_WORKERS=1 $(BIN)/pytest tests/batch/test_two_workers.py tests/batch/test_intervals.py $(PYTEST_ARGS)

discovery: $(VENV)/installed-dev  ## success rate of the diagnosis over made recordings: two suites, see docs/discovery.md
	OMP_NUM_THREADS=1 $(BIN)/python benchmarks/discovery.py $(DISCOVERY_ARGS)

drives: $(VENV)/installed-dev  ## logs in MDF; made drives with a known truth: errors and coverage of the factors, see docs/drive.md
	@$(BIN)/python -m pip install --quiet --no-build-isolation --editable ".[mdf]"
	$(BIN)/pytest tests/driving -k mdf
	OMP_NUM_THREADS=1 $(BIN)/python benchmarks/drives.py $(DRIVES_ARGS)

foreign-drive: $(VENV)/installed-dev  ## a drive of the multi-body car of another program: errors of the curves of its tires
	@$(BIN)/python -m pip install --quiet --no-build-isolation --editable ".[foreign-car]"
	OMP_NUM_THREADS=1 $(BIN)/python benchmarks/foreign_drive.py

measured-drives: $(VENV)/installed-dev  ## drives of a small car in the folder dart of TIREFMU_DATA: its friction on two floors
	OMP_NUM_THREADS=1 $(BIN)/python benchmarks/dart.py $(TIREFMU_DATA)/dart

missing-effects: $(VENV)/installed-dev  ## tests of all entries of the benchmark of missing effects, and the tables of docs/missing_effects.md
	@$(BIN)/python -m pip install --quiet --no-build-isolation --editable ".[benchmark]"
	$(BIN)/pytest tests/missing_effects
	OMP_NUM_THREADS=1 $(BIN)/python -W ignore benchmarks/missing_effects_table.py

wrong-tables: $(VENV)/installed-dev  ## 60 wrong tables and 40 right ones: how many are refused, with the right option
	$(BIN)/python benchmarks/wrong_tables.py $(TABLES_ARGS)

awkward: $(VENV)/installed-dev  ## docs/awkward_inputs.md: message and exit code of 46 awkward inputs
	$(BIN)/python benchmarks/awkward_inputs.py --write

recovery: $(VENV)/installed-dev  ## recovery of known coefficients: 100 fits per model, 50 starts; RECOVERY_ARGS=--quick for a short run
	$(BIN)/python benchmarks/recovery.py $(RECOVERY_ARGS)

planning: $(VENV)/installed-dev  ## planned programs: bench time, predicted and achieved intervals, three tires
	OMP_NUM_THREADS=1 $(BIN)/python benchmarks/planning.py $(PLANNING_ARGS)

confounded: $(VENV)/installed-dev  ## confounded diagnoses and the planned next measurement
	OMP_NUM_THREADS=1 $(BIN)/python benchmarks/confounded.py $(CONFOUNDED_ARGS)

coverage: $(VENV)/installed-dev  ## coverage of intervals of made recordings: noise, offsets, a memory, an effect that the model lacks
	OMP_NUM_THREADS=1 $(BIN)/python benchmarks/coverage.py $(COVERAGE_ARGS)

family: $(VENV)/installed-dev  ## fits with a family, leaving one of 30 made tires out: coverage, combined slip
	OMP_NUM_THREADS=1 $(BIN)/python benchmarks/family.py $(FAMILY_ARGS)

real: $(VENV)/installed-dev  ## the diagnosis on the measured recordings in TIREFMU_DATA, judged on hold-out sweeps
	$(BIN)/python benchmarks/real_discovery.py $(REAL_ARGS)

temperature: $(VENV)/installed-dev  ## errors of predicted temperatures: the recordings in TIREFMU_DATA, 30 made ones; docs/temperature.md
	OMP_NUM_THREADS=1 $(BIN)/python benchmarks/temperature.py $(TIREFMU_DATA)

wine: $(VENV)/installed-dev  ## the FMU's Windows binary under wine64 compared with the Linux binary
	@$(BIN)/python -m pip install --quiet --no-build-isolation --editable ".[cross]"
	TIREFMU_WINE=1 $(BIN)/pytest tests/fmu/test_wine.py $(PYTEST_ARGS)

proofs: $(VENV)/installed  ## 24 FMUs with a proof: repeated by FMPy alone, four changes of each detected
	$(BIN)/python benchmarks/proofs.py $(PROOF_ARGS)

plugins: $(VENV)/installed-dev  ## packages with an effect, a model, a reader and a language; a diagnosis finds the effect
	TIREFMU_PLUGINS=1 $(BIN)/pytest tests/plugins $(PYTEST_ARGS)

prebuilt: $(VENV)/installed  ## FMU binaries of every model for every platform in fmu/prebuilt: export needs no compiler
	@$(BIN)/python -m pip install --quiet --no-build-isolation --editable ".[cross]"
	$(BIN)/python -m tirefmu.fmu.packaging.prebuilding $(PREBUILT_ARGS)

wheel: $(VENV)/installed prebuilt  ## the wheel with these binaries in dist
	$(BIN)/python -m pip wheel --quiet --no-deps --no-build-isolation --wheel-dir dist .

sanitize: $(VENV)/installed-dev  ## the FMU's C code under AddressSanitizer and UBSan: invalid calls, malformed values
	TIREFMU_SANITIZE=1 $(BIN)/pytest tests/fmu/test_robustness.py tests/fmu/test_prebuilt.py $(PYTEST_ARGS)

warnings: $(VENV)/installed-dev  ## gcc, clang and cppcheck have no warning in the C sources of FMUs: every model, kind of inputs and version
	TIREFMU_WARNINGS=1 $(BIN)/pytest tests/fmu/test_warnings.py $(PYTEST_ARGS) --dist load

examples: $(VENV)/installed-dev  ## FMUs in other programs, the table of docs/simulation_programs.md, and a vehicle on four tire FMUs
	@$(BIN)/python -m pip install --quiet --no-build-isolation --editable ".[cosimulation]"
	$(BIN)/pytest tests/examples $(PYTEST_ARGS)
	$(BIN)/python examples/host_table.py --write

hosts: $(VENV)/installed-dev  ## code for other programs, also with Ceres, CasADi symbols, JAX, PyTorch and rumoca where they are installed
	TIREFMU_HOSTS=1 $(BIN)/pytest tests/hosts $(PYTEST_ARGS)

readers: $(VENV)/installed-dev  ## MFeval, OpenTirePython and Chrono on files of convert: TIREFMU_MFEVAL, TIREFMU_OPENTIRE, TIREFMU_CHRONO are their paths
	$(BIN)/pytest tests/exports/test_readers.py -rP

check: $(VENV)/installed-dev types  ## lint, format, types, imports, and generated/ compared with the equations
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	cd .types && ../$(BIN)/lint-imports --config ../pyproject.toml --no-cache --no-logo
	$(BIN)/tirefmu generate --check

generate: $(VENV)/installed  ## write generated/
	$(BIN)/tirefmu generate

bench-languages: $(VENV)/installed  ## every model in every installed language compared with NumPy: the table of docs/languages.md
	$(BIN)/python benchmarks/languages.py --write $(BENCH_ARGS)

bench-steps: $(VENV)/installed  ## time of single steps of FMUs with hub inputs: median, 99.99 %, longest of a million
	$(BIN)/python benchmarks/step_times.py $(BENCH_ARGS)

many-tires: $(VENV)/installed  ## FMUs: many instances and long runs; memory, time of steps, states restored at random
	$(BIN)/python benchmarks/many_tires.py $(BENCH_ARGS)

performance: $(VENV)/installed-dev  ## docs/performance.md: start-up, fits, evaluation, memory in one run, on an idle machine
	OMP_NUM_THREADS=1 $(BIN)/python benchmarks/performance.py --write $(BENCH_ARGS)

# The packages are sub-packages of tirefmu only when installed; type checkers read this tree of links instead.
types:
	@rm -rf .types && mkdir -p .types/tirefmu
	@for entry in $(PACKAGES) $(filter-out %/__pycache__,$(wildcard tirefmu/*)); do \
		ln -s "../../$$entry" ".types/tirefmu/$${entry##*/}" || exit 1; done

clean:
	rm -rf .types build dist demo-output *.egg-info .hypothesis .mypy_cache .pytest_cache .ruff_cache
	find $(PACKAGES) tirefmu tests -name __pycache__ -prune -exec rm -rf {} +

# pip runs without build isolation: the setuptools in $(VENV) builds everything.
$(VENV)/installed: pyproject.toml | $(VENV)/created
	@echo "Installing tirefmu into $(VENV) (once, and when pyproject.toml changes; 1 to 5 minutes)"
	@$(BIN)/python -m pip install --quiet --no-build-isolation --editable .
	@touch $@

$(VENV)/installed-dev: pyproject.toml | $(VENV)/created
	@echo "Installing tirefmu and its development tools into $(VENV) (once, and when pyproject.toml changes)"
	@$(BIN)/python -m pip install --quiet --no-build-isolation --editable ".[dev]"
	@touch $(VENV)/installed $@

$(VENV)/created:
	@test -n "$(PYTHON)" || { echo "No Python 3.11+ found: set one with 'make PYTHON=...'" >&2; exit 1; }
	@echo "Setting up $(VENV) with $$($(PYTHON) --version)"
	@$(PYTHON) -m venv --clear $(VENV)
	@$(BIN)/python -m pip install --quiet "setuptools>=77"
	@touch $@

# latolato: everything here needs Python 3.11 or newer and make; the tests need Chromium too, and
# `make test-all` Firefox, which they install as root on Debian and otherwise ask for. All else is
# installed into .venv; only pip, npm and apt use the network.

SHELL := /bin/sh
.DEFAULT_GOAL := help
.DELETE_ON_ERROR:

# The first of these that is new enough, or the one you name: make demo PYTHON=/path/to/python3.
ifndef PYTHON
PYTHON := $(shell for p in python3 python3.14 python3.13 python3.12 python3.11; do \
	$$p -c 'import sys; sys.exit(sys.version_info < (3, 11))' 2>/dev/null && echo $$p && exit; \
	done; echo python3)
endif
JOBS ?= 2
# Those that record ratios. The other scripts in benchmarks/ check accuracy, or need clips or a GPU.
BENCHMARKS ?= single_run sweep strings webassembly sensitivities analysis
VENV := .venv
BIN := $(VENV)/bin
STAMPS := $(VENV)/stamps
PIP := $(BIN)/python -m pip --disable-pip-version-check

# Pictures need no screen.
export MPLBACKEND := Agg
# Without bytecode every process of the tests compiles all modules again, for ten seconds or more.
unexport PYTHONDONTWRITEBYTECODE

.PHONY: help
help: ## list the targets
	@awk -F ':.*## ' '/^[a-z-]+:.*## / { printf "  make %-9s %s\n", $$1, $$2 }' $(MAKEFILE_LIST)

.PHONY: demo
demo: $(STAMPS)/video kernels ## install, reproduce the paper's figures quickly, print the claims table
	$(BIN)/latolato reproduce --quick

.PHONY: play
play: $(STAMPS)/app kernels ## install, open the application in the browser
	$(BIN)/latolato app

.PHONY: site
site: docs $(STAMPS)/app kernels ## write the pages, the report and the documentation into build/site
	$(BIN)/latolato site build/site --docs docs/_build/html

.PHONY: measure
measure: $(STAMPS)/video kernels ## install, film a swing, track it, fit its damping: into measured/
	@mkdir -p measured
	$(BIN)/latolato synthesise --system pendulum --length "36.3 cm" --mass "108 g" \
		--damping 0.00274 --initial-angle "30 deg" --duration 10 --output measured/swing.mp4
	$(BIN)/latolato track measured/swing.mp4 --length "36.3 cm" --output measured/swing.csv \
		--report measured/swing.html
	$(BIN)/latolato fit decay measured/swing.csv --length "36.3 cm" --mass "108 g" \
		--plot measured/fit.png

.PHONY: research
research: $(STAMPS)/video kernels ## install, map 16,281 runs with their stability tongue: into researched/
	@mkdir -p researched
	$(BIN)/latolato sweep fig03cd --output researched/map.nc
	$(BIN)/latolato plot researched/map.nc --variable mean_energy --log --overlay tongue \
		--output researched/map.png

.PHONY: kernels
kernels: | $(STAMPS)/venv ## compile the numerical code, unless it is there
	@$(BIN)/python -c "import numba, ziglang" 2>/dev/null || $(PIP) install -q -e ".[kernels]"
	@$(BIN)/python .ci/kernels.py

# One process a core: threads of the linear algebra would only get in each other's way.
test test-all smoke bench docs wheel lowest: export OPENBLAS_NUM_THREADS := 1

.PHONY: test
test: $(STAMPS)/test $(STAMPS)/chromium-headless-shell kernels ## install with test extras, run the tests and the examples in docstrings
	$(BIN)/python -m pytest -n $(JOBS) --dist worksteal --doctest-modules tests src \
		--ignore tests/smoke -m "not slow" $(PYTEST_ARGS)

.PHONY: test-all
test-all: $(STAMPS)/test-all $(STAMPS)/chromium-headless-shell $(STAMPS)/firefox-esr kernels ## the slow and rare tests too, then mutants: before a release
	$(BIN)/python -m pytest -n $(JOBS) --dist worksteal --doctest-modules tests src $(PYTEST_ARGS)
	$(MAKE) mutants

.PHONY: smoke
smoke: $(STAMPS)/test $(STAMPS)/chromium-headless-shell kernels ## every preset, example, question and documented command once
	$(BIN)/python -m pytest -n $(JOBS) --dist worksteal tests/smoke $(PYTEST_ARGS)

.PHONY: doctest
doctest: $(STAMPS)/test kernels ## run the examples in docstrings only
	$(BIN)/python -m pytest --doctest-modules src $(PYTEST_ARGS)

.PHONY: coverage
coverage: $(STAMPS)/test-all $(STAMPS)/chromium-headless-shell $(STAMPS)/firefox-esr kernels ## run the tests and report the lines not reached
	$(BIN)/python -m pytest -n $(JOBS) --doctest-modules --cov --cov-report=term tests src $(PYTEST_ARGS)

.PHONY: lint
lint: $(STAMPS)/dev $(STAMPS)/typescript ## style, format, words, types, layers
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports
	$(BIN)/python .ci/javascript.py
	$(BIN)/python .ci/words.py
	$(BIN)/node $(VENV)/js/node_modules/typescript/bin/tsc -p tests/app/js

.PHONY: format
format: $(STAMPS)/dev ## apply the style and the format
	$(BIN)/ruff check --fix .
	$(BIN)/ruff format .

.PHONY: wheel
wheel: dist ## install the wheel elsewhere and try it with the newest packages
	$(BIN)/python .ci/elsewhere.py

.PHONY: lowest
lowest: dist ## install the wheel elsewhere and try it with the lowest versions that pyproject.toml allows
	$(BIN)/python .ci/elsewhere.py --lowest

.PHONY: mutants
mutants: $(STAMPS)/mutants kernels ## try thirty mutants of the sources on the tests; SEED=2 for others
	$(BIN)/python .ci/mutants.py $(SEED)

.PHONY: docs
docs: $(STAMPS)/docs kernels ## build the documentation into docs/_build/html
	$(BIN)/python -m sphinx -W --keep-going -q -d docs/_build/doctrees -b html docs docs/_build/html
	@echo "documentation: docs/_build/html/index.html"

.PHONY: pictures
pictures: $(STAMPS)/test $(STAMPS)/chromium-headless-shell kernels ## make the pictures of README and tutorial again
	$(BIN)/python .ci/pictures.py

.PHONY: bench
bench: $(STAMPS)/test kernels ## time latolato beside other codes, record ratios, write README's table
	@for name in $(BENCHMARKS); do \
		echo "== $$name"; $(BIN)/python benchmarks/$$name.py || exit 1; \
	done
	$(BIN)/python benchmarks/ratios.py

.PHONY: dist
dist: $(STAMPS)/dev ## build the sdist, and the wheel from it, into dist/; licences of all packages into build/
	rm -rf dist
	$(BIN)/python -m build --outdir dist .
	@du -h dist/*
	@mkdir -p build
	@$(BIN)/pip-licenses --order=license --format=markdown --output-file=build/licences.md

.PHONY: clean
clean: ## remove what was built, keep .venv
	rm -rf build dist docs/_build docs/_generated htmlcov .coverage .coverage.* \
		.pytest_cache .mypy_cache .ruff_cache .import_linter_cache .hypothesis
	find src tests benchmarks docs -name __pycache__ -type d -prune -exec rm -rf {} + 2>/dev/null || true

.PHONY: distclean
distclean: clean ## remove .venv as well
	rm -rf $(VENV)

# --- the environment -------------------------------------------------------------------------
# A stamp is made once its parts are installed; it is older than pyproject.toml only when the
# dependencies may have changed, so an edit of the sources installs nothing (it is editable).

# The demonstration needs `video` for its synthetic videos.
$(STAMPS)/app $(STAMPS)/video $(STAMPS)/test $(STAMPS)/test-all $(STAMPS)/docs $(STAMPS)/mutants $(STAMPS)/dev: $(STAMPS)/%: pyproject.toml | $(STAMPS)/venv
	@echo "installing latolato[$*] into $(VENV)"
	@$(PIP) install -q -e ".[$*]"
	@touch $@ $(HELD_IN_$*:%=$(STAMPS)/%)

# What an extra holds is installed with it.
HELD_IN_dev := test docs
HELD_IN_test-all := test
HELD_IN_mutants := test

# Types of the pages' modules, read from their JSDoc; Node.js itself is in the extra `test`.
$(STAMPS)/typescript: $(STAMPS)/dev
	@echo "installing typescript into $(VENV)"
	@PATH="$(CURDIR)/$(BIN):$$PATH" $(BIN)/npm install --silent --no-audit --no-fund \
		--prefix $(VENV)/js typescript@5.9
	@touch $@

# The tests of the application drive real browsers, the system's; these are Debian's packages. Pages
# need a quarter less of a processor in the one that has no windows, but any Chromium will do.
$(STAMPS)/chromium-headless-shell $(STAMPS)/firefox-esr: $(STAMPS)/%: | $(STAMPS)/venv
	@has() { for b in "$$@"; do command -v $$b >/dev/null && return 0; done; return 1; }; \
	if ! has $* && [ "$$(id -u)" = 0 ] && command -v apt-get >/dev/null; then \
		echo "installing $*: the tests of the application drive browsers"; \
		{ apt-get update -q && DEBIAN_FRONTEND=noninteractive \
			apt-get install -y -q --no-install-recommends $*; } >/dev/null || true; \
	fi; \
	has $* $(INSTEAD_OF_$*) || { echo "the tests of the application need a browser. Type"; \
		echo "    sudo apt-get install $*"; echo "and try again"; exit 1; }
	@touch $@

INSTEAD_OF_chromium-headless-shell := chromium chromium-browser google-chrome google-chrome-stable
INSTEAD_OF_firefox-esr := firefox

# Debian and Ubuntu keep ensurepip in a package of its own. Without it: use a pip that is already
# here, else fetch the package as root, else say what to type.
$(STAMPS)/venv:
	@command -v $(PYTHON) >/dev/null || { \
		echo "latolato needs Python 3.11 or newer: no '$(PYTHON)' found; name one with"; \
		echo "    make $(MAKECMDGOALS) PYTHON=/path/to/python3"; exit 1; }
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || { \
		echo "latolato needs Python 3.11 or newer: '$(PYTHON)' is $$($(PYTHON) -V 2>&1); name another with"; \
		echo "    make $(MAKECMDGOALS) PYTHON=/path/to/python3.11"; exit 1; }
	@set -e; rm -rf $(VENV); \
	package=$$($(PYTHON) -c 'import sys; print("python%d.%d-venv" % sys.version_info[:2])'); \
	has_ensurepip() { $(PYTHON) -c 'import ensurepip, venv' 2>/dev/null; }; \
	if ! has_ensurepip && $(PYTHON) -c 'import pip, venv' 2>/dev/null; then \
		$(PYTHON) -m venv --without-pip $(VENV); \
		$(PYTHON) -m pip --python $(BIN)/python install -q pip; \
	else \
		if ! has_ensurepip && [ "$$(id -u)" = 0 ] && command -v apt-get >/dev/null; then \
			echo "installing $$package: this Python cannot make virtual environments without it"; \
			{ apt-get update -q && DEBIAN_FRONTEND=noninteractive \
				apt-get install -y -q --no-install-recommends $$package; } >/dev/null || true; \
		fi; \
		has_ensurepip || { \
			echo "this Python cannot make virtual environments: ensurepip is missing. Type"; \
			if command -v apt-get >/dev/null; then echo "    sudo apt-get install $$package"; \
			else echo "    make $(MAKECMDGOALS) PYTHON=/path/to/a/complete/python3.11"; fi; \
			echo "and try again"; exit 1; }; \
		$(PYTHON) -m venv $(VENV); \
	fi
	@mkdir -p $(STAMPS)
	@touch $@

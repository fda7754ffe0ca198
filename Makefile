# From a fresh clone, with Python 3.11 or newer: `make test`, `make demo`.
# The environment is made in .venv on first use, from the versions and hashes in requirements/.

PYTHON ?= $(shell command -v python3.11 || command -v python3)
VENV ?= .venv
# As many tests at a time as there are cores.
WORKERS ?= auto
PYTEST_FLAGS ?=
BIN := $(VENV)/bin
STORIES := out/stories
# A module's tests stay together, for its fixtures; modules with slow tests are first (tests/conftest.py).
PYTEST = $(BIN)/python -m pytest -n $(WORKERS) --dist loadfile --no-loadscope-reorder --durations=10
export PIP_DISABLE_PIP_VERSION_CHECK := 1
# Compiled modules are kept: every worker and every process that a test starts imports them.
export PYTHONDONTWRITEBYTECODE :=

PAGE := src/glasshelm/bridge/static/index.html
PAGE_SOURCES := $(shell find web -name node_modules -prune -o -type f -print)

.PHONY: help install test test-fast page page-test demo stories bench safety fuzz lint format types wheel clean \
  docs docs-install docs-check docs-site

help:
	@echo "make test    all tests, on all cores, and how long they took (17 minutes on two)"
	@echo "make test-fast  those not marked slow, for the developer's loop (8 minutes on two cores)"
	@echo "make page    the bridge page, built into the package (Node from PyPI if none is there)"
	@echo "make demo    the bridge: a live page of a real ship's traffic and the pilot's advice"
	@echo "make stories two explained encounters, each a report to read in the browser"
	@echo "make bench   measured speeds of this machine"
	@echo "make safety  every pilot through 10,000 random encounters (hours)"
	@echo "make fuzz    a million mangled lines and messages to live sessions, 100,000 to the bridge (nightly)"
	@echo "make lint    ruff, layers and pyright"
	@echo "make format  ruff, eslint and prettier, with their fixes applied"
	@echo "make types   JSON schemas of frames and messages from the code, the page's types from them"
	@echo "make docs    the documentation, served on this machine"
	@echo "make docs-site  the documentation, built strictly into build/site, its notebooks run"
	@echo "make docs-check spelling and style of documentation and docstrings"
	@echo "make wheel   build the wheel and test it outside the tree"

install: $(VENV)/installed

$(VENV)/installed: pyproject.toml requirements/test.txt
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || \
	  { echo "Python 3.11 or newer is needed: make PYTHON=/path/to/python3.11"; exit 1; }
	@echo "Installing Glasshelm and what it needs into $(VENV): some minutes the first time"
	@test -x $(BIN)/python || $(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install -q --require-hashes -r requirements/test.txt
	$(BIN)/python -m pip install -q --no-deps --no-build-isolation -e .
	@touch $@

page: $(PAGE)

$(PAGE): $(PAGE_SOURCES)
	PYTHON=$(PYTHON) scripts/page build
	@touch $@

page-test:
	PYTHON=$(PYTHON) scripts/page check
	PYTHON=$(PYTHON) scripts/page test

test: install page
	$(PYTEST) $(PYTEST_FLAGS)

test-fast: install page
	$(PYTEST) -m "not slow" $(PYTEST_FLAGS)

lint: install
	$(BIN)/ruff check
	$(BIN)/ruff format --check
	$(BIN)/lint-imports --no-logo --cache-dir .cache/import-linter
	$(BIN)/pyright

format: install
	$(BIN)/ruff check --fix
	$(BIN)/ruff format
	PYTHON=$(PYTHON) scripts/page format

types: install
	$(BIN)/python scripts/schemas.py
	PYTHON=$(PYTHON) scripts/page types

demo: install page
	$(BIN)/glasshelm bridge

stories: install
	$(BIN)/glasshelm explain gulf-of-finland --advise --out $(STORIES)/gulf-of-finland
	$(BIN)/glasshelm explain imazu:5 --out $(STORIES)/imazu-5
	@echo
	@echo "A real own ship and her AIS traffic in the Gulf of Finland, with advice beside what she did:"
	@echo "  $(CURDIR)/$(STORIES)/gulf-of-finland/report.html"
	@echo "Imazu case 5, steered by the pilot:"
	@echo "  $(CURDIR)/$(STORIES)/imazu-5/report.html"

bench: install
	@for name in smoke explain_latency training; do \
	  echo "== $$name"; $(BIN)/python benchmarks/$$name.py || exit 1; done

safety: install
	$(BIN)/python benchmarks/safety.py

fuzz: install
	$(BIN)/python -m benchmarks.session_fuzz --count 1000000
	$(BIN)/python benchmarks/bridge_fuzz.py --count 100000

docs-install: install $(VENV)/installed-docs

$(VENV)/installed-docs: requirements/docs.txt | $(VENV)/installed
	$(BIN)/python -m pip install -q --require-hashes -r requirements/docs.txt
	@touch $@

docs: docs-install
	NO_MKDOCS_2_WARNING=1 $(BIN)/mkdocs serve

docs-site: docs-install
	NO_MKDOCS_2_WARNING=1 RUN_NOTEBOOKS=1 $(BIN)/mkdocs build --strict

docs-check: docs-install
	$(BIN)/codespell
	$(BIN)/python scripts/check_prose.py

wheel: install page
	rm -rf dist
	$(BIN)/python -m build --wheel --no-isolation --outdir dist
	scripts/test-wheel dist/*.whl $(PYTHON)

clean:
	rm -rf build dist out .cache .pytest_cache .ruff_cache .hypothesis

# make demo, make test: each works on a fresh clone with Python 3.11, 3.12 or 3.13, and make.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin

# The environment belongs to one Python; with another one it is made anew.
VERSION_OF := -c 'import sys; print("%d.%d" % sys.version_info[:2])'
VERSION := $(shell $(PYTHON) $(VERSION_OF))
MADE_WITH := $(shell $(BIN)/python $(VERSION_OF) 2>/dev/null)
ENV := $(VENV)/.env-$(VERSION)
CORE := $(VENV)/.core-$(VERSION)
DEV := $(VENV)/.dev-$(VERSION)
PIP := $(BIN)/python -m pip install --quiet --disable-pip-version-check

.PHONY: help demo view test test-browser test-long browser pictures notebooks docs reproduce lint dist clean

help:
	@echo "make demo       throw balls at a character made of the embedded clips (out/demo)"
	@echo "make view       throw balls yourself, in the browser"
	@echo "make test       run the tests"
	@echo "make test-browser  run those that need a browser (make browser installs one on Debian)"
	@echo "make test-long  run those that take minutes"
	@echo "make lint       ruff, pyright, import-linter"
	@echo "make pictures   make the pictures of README.md anew (experiments/pictures)"
	@echo "make notebooks  execute the notebooks at full size and keep what they show"
	@echo "make docs       build the documentation as a site (out/site); a warning is an error"
	@echo "make reproduce  run every experiment at full size, write RESULTS.md (MGJAX_CAPTURE: capture)"
	@echo "make dist       build the wheel and the source archive (dist)"
	@echo "make clean      remove $(VENV), out and dist"
	@echo "PYTHON=python3.12 chooses the Python"

$(ENV):
	@$(PYTHON) -c 'import sys; v = sys.version_info[:2]; sys.exit(0 if v >= (3, 11) else f"mgjax needs Python 3.11 or newer, {sys.executable} is {v[0]}.{v[1]}; try: make PYTHON=python3.12")'
	@test "$(MADE_WITH)" = "$(VERSION)" || $(PYTHON) -m venv --clear $(VENV)
	@touch $@

# What running needs, and all that developing needs.
$(CORE): $(ENV) pyproject.toml
	$(PIP) -e .
	@touch $@

$(DEV): $(ENV) pyproject.toml
	$(PIP) -e '.[dev]'
	@touch $(CORE) $@

demo: $(CORE)
	$(BIN)/mgjax demo --out out/demo

view: $(CORE)
	$(BIN)/mgjax view

test: $(DEV)
	$(BIN)/python -m pytest --numprocesses 2 --dist worksteal

# Each file in one process, since its tests share a running page.
test-browser: $(DEV)
	$(BIN)/python -m pytest -m browser --numprocesses 2 --dist loadfile tests/stage/browser

SUDO := $(if $(filter 0,$(shell id -u)),,sudo)
browser:
	@test -x /usr/bin/chromium || { $(SUDO) apt-get update -qq && \
	$(SUDO) apt-get install -qq -y --no-install-recommends chromium fonts-dejavu-core >/dev/null; }

pictures: $(DEV)
	$(BIN)/python -m experiments.pictures.make --applications out/pictures

reproduce: $(DEV)
	$(BIN)/python -m experiments.results.reproduce

notebooks: $(DEV)
	$(BIN)/python -m experiments.notebooks.keep $(NOTEBOOKS)

test-long: $(DEV)
	$(BIN)/python -m pytest -m long --numprocesses 2 --dist worksteal

# Readable without a server: out/site/index.html.
docs: $(DEV)
	@NO_MKDOCS_2_WARNING=1 $(BIN)/python -m mkdocs build --strict

lint: $(DEV)
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/pyright
	$(BIN)/lint-imports

dist: $(DEV)
	$(BIN)/python -m build --outdir dist

clean:
	rm -rf $(VENV) out dist

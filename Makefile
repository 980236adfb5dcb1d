# Targets for people and CI; `make setup` is all that is needed before anything else.

PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
STAMP := $(VENV)/.installed
NEW_ENOUGH := import sys; sys.exit(sys.version_info < (3, 10))

# Without bytecode each process compiles all that it imports: a start takes twice as long.
unexport PYTHONDONTWRITEBYTECODE

.DEFAULT_GOAL := help
.PHONY: help setup demo test realtime-test browser-test wheel-test check docs bench images compose-test lock clean

help:
	@echo "make setup   .venv with everything needed to run and test"
	@echo "make demo    setup, then under a minute of what it can do, with a line of what to look at"
	@echo "make test    setup, then all tests but those in real time and those of the page in a browser"
	@echo "make realtime-test  tests by the wall clock; they need the machine to themselves"
	@echo "make browser-test  the page in a headless browser; needs Chromium"
	@echo "make wheel-test  the wheel in a fresh environment without the lock, its page in a headless browser"
	@echo "make check   ruff, mypy, import-linter, spelling, and the docs with every link"
	@echo "make docs    the documentation as pages: site/index.html"
	@echo "make bench   benchmarks, each beside its floor"
	@echo "make images  the container images: emulator, walker, campaign, bridge, view"
	@echo "make compose-test   builds images and walks ten steps between two containers, plain and encrypted"
	@echo "make lock    requirements.lock anew (Python 3.10, so that it holds for all later ones)"
	@echo "make clean   remove .venv and what tools left behind; recordings in runs/ stay"

setup: $(STAMP)

$(STAMP): requirements.lock pyproject.toml
	@command -v $(PYTHON) >/dev/null || \
		{ echo "$(PYTHON) is not there; install Python 3.10 or newer, or say PYTHON=path."; exit 2; } >&2
	@$(PYTHON) -c '$(NEW_ENOUGH)' || \
		{ echo "$(PYTHON) is $$($(PYTHON) -V 2>&1); Python 3.10 or newer is needed, say PYTHON=path."; exit 2; } >&2
	@$(PYTHON) -c 'import venv, ensurepip' 2>/dev/null || \
		{ echo "$(PYTHON) cannot make virtual environments; install python3-venv (Debian, Ubuntu)."; exit 2; } >&2
	$(PYTHON) -m venv $(VENV)
	@.ci/setup $(VENV)
	@touch $@

demo: setup
	$(BIN)/nao-hil demo

# Workers take runs of neighbouring tests: what a module prepares is prepared once, and no page of the docs waits.
# One more than there are processors: some tests wait. So none has a processor for numpy's threads.
test: setup
	OPENBLAS_NUM_THREADS=1 $(BIN)/pytest -n $$(($$(getconf _NPROCESSORS_ONLN) + 1)) --dist worksteal -m "not realtime and not browser"

# One after the other, with the machine to themselves; see docs/testing.md for when one is skipped.
realtime-test: setup
	$(BIN)/pytest -m "realtime and not browser" -rs tests/system

browser-test: setup
	$(BIN)/pytest -m browser -rs

wheel-test: setup
	.ci/wheel

check: setup docs
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports
	$(BIN)/codespell *.md docs/*.md docs/how-to bridge emulator walker nao_hil examples

docs: setup
	NO_MKDOCS_2_WARNING=1 $(BIN)/mkdocs build --quiet

bench: setup
	$(BIN)/python -m tests.bench

images: setup
	docker/build compose.yaml emulator walker lola view
	docker/build compose.campaign.yaml scheduler

compose-test: setup
	docker/compose-test

# pip-compile drops the markers of what an extra asks for. pip wants the extras of what a package asks for.
QI_FOR := python_version < "3.13" and platform_machine == "x86_64"
PYBULLET_FOR := python_version < "3.12" and platform_machine == "x86_64"
lock: setup
	$(BIN)/pip-compile --quiet --generate-hashes --all-extras --no-strip-extras --allow-unsafe \
		--no-emit-index-url --no-emit-trusted-host --no-emit-find-links --no-header \
		--output-file requirements.lock pyproject.toml
	sed -i -e 's/^\(qi==[0-9.]*\) \\$$/\1 ; $(QI_FOR) \\/' \
		-e 's/^\(pybullet==[0-9.]*\) \\$$/\1 ; $(PYBULLET_FOR) \\/' requirements.lock

clean:
	rm -rf $(VENV) build dist site *.egg-info .pytest_cache .mypy_cache .ruff_cache .hypothesis .import_linter_cache

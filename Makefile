# Everything here works from a clean clone: Python >= 3.11, make and a package registry are all it asks for.
# It writes inside this folder only (and in pip's own cache, where there is one).

SHELL := bash
.SHELLFLAGS := -euo pipefail -c
.DEFAULT_GOAL := help
.ONESHELL:
.DELETE_ON_ERROR:
.NOTPARALLEL:

PYTHON ?= python3
# Where python3 is too old a newer one may stand beside it; an interpreter asked for by name is not replaced.
PYTHONS := $(PYTHON) $(if $(filter file,$(origin PYTHON)),python3.13 python3.12 python3.11)
JOBS ?= 2
EXTRAS := fe,sweep,fit,export,web,xlsx,test,lint,docs

# Caches and settings of the tools stay in the tree; a home that is empty or read-only is fine.
LOCAL := $(CURDIR)/.venv/var
export MPLBACKEND := Agg
export MPLCONFIGDIR := $(LOCAL)/matplotlib
export IPYTHONDIR := $(LOCAL)/ipython
export JUPYTER_CONFIG_DIR := $(LOCAL)/jupyter
export JUPYTER_DATA_DIR := $(LOCAL)/jupyter
export JUPYTER_RUNTIME_DIR := $(LOCAL)/jupyter/runtime
export PYTHONNOUSERSITE := 1
export PIP_DISABLE_PIP_VERSION_CHECK := 1
export PIP_USER := 0
# (each process of the tests would compile the package anew without its byte code)
unexport PYTHONHOME PYTHONPATH PYTHONDONTWRITEBYTECODE PIP_TARGET PIP_PREFIX

# Only pip keeps the user's cache, so that a second clone is quick.
USER_CACHE := $(XDG_CACHE_HOME)
export XDG_CACHE_HOME := $(LOCAL)/cache

RUN := .venv/bin/python
# What is imported is compiled then; to compile all 14 000 files takes a minute of one core.
# Old pips pin the build tools by PIP_CONSTRAINT, new ones by PIP_BUILD_CONSTRAINT.
PIP := XDG_CACHE_HOME="$(USER_CACHE)" PIP_CONSTRAINT=constraints.txt PIP_BUILD_CONSTRAINT=constraints.txt \
  $(RUN) -m pip install --quiet --no-compile
SPHINX := $(RUN) -m sphinx -q -W --keep-going -b html
PYTEST := $(RUN) -m pytest --basetemp="$(LOCAL)/pytest"

.PHONY: help
help: ## this list
	@sed -n 's/^\([a-z0-9]*\): .*## \(.*\)/  make \1|\2/p' Makefile | awk -F'|' '{ printf "%-16s %s\n", $$1, $$2 }'
	@echo "  PYTHON=python3.12 names the interpreter (make clean first), JOBS=8 the test processes."

# ---- set-up ----------------------------------------------------------------------------------------------

.PHONY: setup
setup: .venv/.dev ## create .venv with everything for work on the package

# The environment is made anew when this folder was moved or its interpreter has gone.
ifneq "$(shell test -x .venv/bin/python && cat .venv/.made 2>/dev/null)" "$(CURDIR)"
.PHONY: .venv/.made
endif

.venv/.made:
	@python=
	for candidate in $(PYTHONS); do
	  if "$$candidate" -c 'import sys; sys.exit(sys.version_info < (3, 11))' 2>/dev/null; then python=$$candidate; break; fi
	done
	if [ -z "$$python" ]; then
	  echo "squama needs Python 3.11 or newer, and $(PYTHON) is $$($(PYTHON) --version 2>/dev/null || echo 'not there'): install one, or name it with make PYTHON=..." >&2
	  exit 1
	fi
	rm -rf .venv
	if ! said=$$("$$python" -m venv .venv 2>&1); then
	  if "$$python" -c 'from ensurepip import version' 2>/dev/null; then echo "$$said" >&2; rm -rf .venv; exit 1; fi
	  rm -rf .venv
	  ask="$$python cannot make virtual environments: install the package python3-venv (apt-get install python3-venv), then run make again"
	  if [ "$$(id -u)" != 0 ] || ! command -v apt-get >/dev/null; then echo "$$ask" >&2; exit 1; fi
	  echo "installing python3-venv, which $$python needs to make .venv"
	  export DEBIAN_FRONTEND=noninteractive
	  { apt-get update -qq && apt-get install -y -qq python3-venv; } >/dev/null || { echo "$$ask" >&2; exit 1; }
	  "$$python" -m venv .venv >/dev/null || { rm -rf .venv; echo "$$ask" >&2; exit 1; }
	fi
	mkdir -p "$(LOCAL)"
	echo "$(CURDIR)" > $@

.venv/.run: .venv/.made pyproject.toml constraints.txt
	@echo "installing squama and what it needs to run in .venv"
	$(PIP) --editable .
	touch $@

.venv/.dev: .venv/.made pyproject.toml constraints.txt
	@echo "installing squama with its tools for tests, checks and docs in .venv"
	$(PIP) --editable '.[$(EXTRAS)]'
	touch .venv/.run $@

# ---- use -------------------------------------------------------------------------------------------------

.PHONY: demo
demo: .venv/.run ## the main job on examples/stiff_skin.toml: summary, picture, CSV and netCDF in out/
	@mkdir -p out
	.venv/bin/squama twist examples/stiff_skin.toml \
	  --plot out/stiff_skin.png --csv out/stiff_skin.csv --netcdf out/stiff_skin.nc | tee out/stiff_skin.txt

.PHONY: paper
paper: .venv/.run ## the paper's figures and the table of its claims, in out/paper
	@mkdir -p out
	.venv/bin/squama paper -o out/paper

.PHONY: fig6b
fig6b: .venv/.dev ## the elements' points of Fig. 6b anew (ten minutes; goes on where it was stopped)
	OMP_NUM_THREADS=2 nice $(RUN) benchmarks/fig6b.py out/fig6b

# ---- checks ----------------------------------------------------------------------------------------------

# What each process of the tests would compile anew is compiled beside the installation of the tools and lint; the docs are
# built beside the tests, without the output of their cells, which the tests execute. What both say is shown where they
# fail.
.PHONY: test
test: .venv/.run ## everything a change must pass: lint, the tests, the docs
	@echo "compiling beside the installation, ruff and mypy"
	docs=
	$(MAKE) --no-print-directory compiled > "$(LOCAL)/compiled.log" 2>&1 & compiled=$$!
	trap 'kill $$docs $$compiled 2>/dev/null || true' EXIT
	$(MAKE) --no-print-directory lint collected
	wait $$compiled || { cat "$(LOCAL)/compiled.log" >&2; exit 1; }
	echo "building the docs beside the tests"
	$(MAKE) --no-print-directory pages > "$(LOCAL)/docs.log" 2>&1 & docs=$$!
	$(MAKE) --no-print-directory pytest
	wait $$docs || { cat "$(LOCAL)/docs.log" >&2; exit 1; }
	trap - EXIT

# all code that tests compile and keep
.PHONY: compiled
compiled: .venv/.run
	$(RUN) tools/compiled.py

# the byte code of the tests, which their processes would otherwise make one beside the other
.PHONY: collected
collected: .venv/.dev
	@$(PYTEST) --collect-only -qq > "$(LOCAL)/collected.log" || { cat "$(LOCAL)/collected.log" >&2; exit 1; }

.PHONY: lint
lint: .venv/.dev ## ruff and mypy --strict
	$(RUN) -m ruff check .
	$(RUN) -m ruff format --check .
	$(RUN) -m mypy --strict

# commands of which one shows that it is there, Debian packages, and what goes without
define install
	@if command -v $(1) >/dev/null; then exit 0; fi
	ask="$(3): apt-get install $(2)"
	if [ "$$(id -u)" != 0 ] || ! command -v apt-get >/dev/null; then echo "$$ask" >&2; exit 0; fi
	echo "installing $(2)"
	export DEBIAN_FRONTEND=noninteractive
	{ apt-get update -qq && apt-get install -y -qq --no-install-recommends $(2); } >/dev/null 2>&1 || echo "$$ask" >&2
endef

.PHONY: browser
browser: ## Chromium, in which the explorer is tested; without it those tests are left out
	$(call install,chromium chromium-browser google-chrome,chromium fonts-dejavu-core,the explorer is not tested without Chromium)

.PHONY: calculix
calculix: ## CalculiX, the second finite element program; without it its tests are left out
	$(call install,ccx,calculix-ccx,decks are not run without CalculiX)

# Threads of several processes beside each other would wait for each other.
.PHONY: pytest
pytest: .venv/.dev browser
	export OPENBLAS_NUM_THREADS=1 OMP_NUM_THREADS=1
	$(PYTEST) -p xdist -n $(JOBS) --dist worksteal --benchmark-disable

.PHONY: docs
docs: .venv/.dev ## the documentation, in docs/_build/html
	$(SPHINX) -d docs/_build/doctrees docs docs/_build/html

.PHONY: pages
pages: .venv/.dev
	$(SPHINX) -t quick -d docs/_build/quick/doctrees docs docs/_build/quick/html

.PHONY: verify
verify: .venv/.dev browser calculix fig6b docs ## the long checks: stored results of elements anew, all pages, slow tests, random campaigns, then the planted errors
	export OPENBLAS_NUM_THREADS=1 OMP_NUM_THREADS=1
	$(PYTEST) -p xdist -n $(JOBS) --dist worksteal --benchmark-disable -m slow tests
	$(RUN) tests/campaigns/run.py
	$(RUN) tests/mutants/run.py --sample 400 --jobs $(JOBS)

.PHONY: mutants
mutants: .venv/.dev ## plant 400 errors, one at a time, and show that the tests catch each
	$(RUN) tests/mutants/run.py --sample 400 --jobs $(JOBS)

.PHONY: bench
bench: .venv/.dev browser ## how fast it is; writes docs/benchmarks.md
	export OPENBLAS_NUM_THREADS=1 OMP_NUM_THREADS=1
	$(RUN) benchmarks/table.py
	$(PYTEST) benchmarks/ --benchmark-only

.PHONY: clean
clean: ## remove .venv, out/ and all that was built
	rm -rf .venv .stamps out dist docs/_build docs/api .mypy_cache .ruff_cache .hypothesis .benchmarks
	find . -name .git -prune -o -name __pycache__ -type d -prune -exec rm -rf {} +

# Everything runs in .venv, which the first target that needs it makes with $(PYTHON) (3.10 or later).

PYTHON ?= python3
VENV   := .venv
BIN    := $(VENV)/bin
STAMP  := $(VENV)/.installed

.PHONY: help demo test check bench stages gallery schemas clean

help: ## list the targets
	@sed -n 's/^\([a-z]*\):.*## /\1: /p' Makefile

.venv: $(STAMP) ## make the virtual environment with everything in it

$(STAMP): pyproject.toml
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 10))' || { \
	  echo 'usdfoot needs Python 3.10 or later; name one: make PYTHON=python3.12' >&2; exit 1; }
	@$(PYTHON) -c 'import ensurepip, venv' || { \
	  echo 'this Python cannot make virtual environments; on Debian and Ubuntu: apt-get install python3-venv' >&2; exit 1; }
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --disable-pip-version-check --quiet --editable '.[dev]'
	@# what plans crowds is 1 MB; its own dependencies, which only its viewer uses, are over 1 GB
	$(BIN)/python -m pip install --disable-pip-version-check --quiet --no-deps --only-binary :all: 'jupedsim>=1.3' \
	  || echo 'JuPedSim could not be installed: the tests of plan crowd are skipped' >&2
	@touch $(STAMP)

demo: $(STAMP) ## animate the obstacle course and the stepping stones into build/demo
	$(BIN)/python tools/demo.py

test: $(STAMP) ## run the tests
	$(BIN)/python -m pytest

check: $(STAMP) ## lint, types, import contract, tests
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports
	$(BIN)/python -m pytest

bench: $(STAMP) ## measure the speed
	$(BIN)/python tools/bench.py

stages: $(STAMP) ## make stages/ again
	$(BIN)/python tools/make_stages.py

gallery: $(STAMP) ## draw the pictures of stages/gallery again
	$(BIN)/python tools/gallery.py

schemas: $(STAMP) ## make generatedSchema.usda and plugInfo.json again from schema.usda
	$(BIN)/python tools/make_schemas.py

clean: ## remove what the other targets made, except stages/ and schemas/
	rm -rf $(VENV) build dist .pytest_cache .hypothesis .mypy_cache .ruff_cache .import_linter_cache
	find usdfoot tests tools -name __pycache__ -type d -prune -exec rm -rf {} +

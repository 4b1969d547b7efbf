# Needs python3 (3.11 or 3.12, with venv and headers), git, gcc, g++, cmake and make; `make setup` checks for each.

PYTHON ?= python3
TRIALS ?= 300
PYTEST_ARGS ?= -n 2 --dist loadfile
FAULTS_ARGS ?=
# empty: setup does not compile the kernel
WARM ?= 1

SHELL := /bin/bash
export PYTHON TRIALS WARM ATLAS_TRIALS ATLAS_BAG ATLAS_FILE PAPER PAPER_BAGS PAPER_TRIALS

# Tests stay on this machine, and leave nothing in /dev/shm when they kill a node.
TEST_ENV := ROS_AUTOMATIC_DISCOVERY_RANGE=LOCALHOST FASTDDS_BUILTIN_TRANSPORTS=UDPv4

.PHONY: help setup check test test-faults coverage docs demo arms atlas paper lint build clean

help: ## show this list
	@awk -F ':.*## ' '/^[a-z-]+:.*## / {printf "make %-11s %s\n", $$1, $$2}' $(MAKEFILE_LIST)
	@echo "PYTHON=python3.12 chooses the interpreter, TRIALS=300 the length of the demo, PYTEST_ARGS='-n 2 -k name' the tests, FAULTS_ARGS likewise, ATLAS_TRIALS=3000 the atlas's, PAPER='tpe6 tpe7' which of the paper's studies."

setup: ## make .venv/ and install/, or what of them is out of date
	@.ci/setup.sh

check: ## the quick round: lint, and the tests that start no node and are not slow (after setup)
	@$(MAKE) --no-print-directory lint
	@$(TEST_ENV) .ci/in-env pytest -q -m "not ros and not slow" $(PYTEST_ARGS)

test: setup ## setup, then ruff, mypy and all tests
	@$(MAKE) --no-print-directory lint
	@$(TEST_ENV) .ci/in-env pytest $(PYTEST_ARGS)

test-faults: setup ## setup, then the long tests of faults, some two hours; says what it lacks (root, iptables, …)
	@$(TEST_ENV) .ci/in-env pytest -v $(FAULTS_ARGS) tests/faults

coverage: ## lines of mobo_core that the tests of `make check` run, by room (after setup)
	@$(TEST_ENV) .ci/in-env pytest -q -m "not ros and not slow" --cov=mobo_core --cov-report= $(PYTEST_ARGS)
	@.venv/bin/python .ci/coverage_by_room.py

docs: ## API reference of mobo_core into build/docs/, without warnings (after setup)
	@.venv/bin/python .ci/docs.py

demo: setup ## setup, then a study of 300 trials over ROS 2, recorded in bags/, and a report of it
	@.ci/demo.sh

atlas: setup ## setup, then the study of 250,000 trials behind the atlas that mobo brings; goes on where it stopped
	@.ci/atlas.sh

paper: setup ## setup, then the studies of docs/paper.md, hours of them; goes on where it stopped
	@.ci/paper.sh

arms: setup ## setup, then the catalogue's real arms evaluated, and a page with all of them in build/arms/
	@.ci/in-env mobo arms evaluate -o build/arms

lint: ## ruff, mypy and import contracts (after setup)
	@.venv/bin/ruff check .
	@.venv/bin/mypy
	@PYTHONPATH=ros_pkgs/mobo .venv/bin/lint-imports

build: ## build the messages and nodes into install/ anew
	@.ci/setup.sh build

clean: ## remove all that setup made; bags stay
	rm -rf .venv build install log .mypy_cache .pytest_cache .ruff_cache .import_linter_cache .hypothesis .coverage
	find . -name __pycache__ -type d -prune -exec rm -rf {} +

# What a person types: demo, test, lint, types, colcon, clean. Sets up a virtual environment of its own on the way.
#
# Without ROS: installs ROS 2 Jazzy from pip, and compiles the two message packages that pip lacks (interfaces/).
# With ROS sourced (AMENT_PREFIX_PATH is set): uses that ROS, and installs neither.

PYTHON ?= python3
VENV ?= .venv
DEMO_ARGS ?=
PYTEST_ARGS ?=

ifdef AMENT_PREFIX_PATH
WITH_ROS := .
WITH_ROS_DEV := '.[test,lint]'
else
WITH_ROS := '.[ros]' ./interfaces
WITH_ROS_DEV := '.[ros,test,lint]'
endif

BIN := $(VENV)/bin
PIP := $(BIN)/python -m pip install --disable-pip-version-check --quiet
CREATED := $(VENV)/.created
READY := $(VENV)/.ready-to-run
READY_DEV := $(VENV)/.ready-to-develop
# What an installation depends on; the package itself is installed editable, so its sources are not among it.
INPUTS := setup.py setup.cfg pyproject.toml Makefile \
  $(wildcard interfaces/*.* interfaces/build_messages/*.py aerial_gnss_ros/bags/msg/*/msg/*.msg)

# Nodes of the demo and the tests talk on this machine only.
export ROS_AUTOMATIC_DISCOVERY_RANGE := LOCALHOST

.PHONY: help demo test lint types colcon clean
.DELETE_ON_ERROR:

help:
	@echo "make demo     find three robots in a simulated flight, live (DEMO_ARGS=\"--duration 10\")"
	@echo "make test     all tests (PYTEST_ARGS=\"-k geodesy\")"
	@echo "make lint     style and likely mistakes"
	@echo "make types    mypy --strict"
	@echo "make colcon   build as on a robot, into build/ and install/"
	@echo "make clean    remove what the others made"

demo: $(READY)
	$(BIN)/aerial-gnss demo $(DEMO_ARGS)

test: $(READY_DEV)
	$(BIN)/python -m pytest $(PYTEST_ARGS)

lint: $(READY_DEV)
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .

types: $(READY_DEV)
	$(BIN)/mypy

colcon: $(READY_DEV)
	$(BIN)/colcon build --base-paths .

clean:
	rm -rf $(VENV) .venv-* build install log interfaces/build *.egg-info interfaces/*.egg-info
	rm -rf .pytest_cache .mypy_cache .ruff_cache .hypothesis

$(CREATED):
	@command -v $(PYTHON) >/dev/null || { echo "there is no $(PYTHON): sudo apt install python3" >&2; exit 2; }
	@$(PYTHON) tools/check_machine.py
	$(PYTHON) -m venv --clear $(VENV)
	@touch $@

$(READY): $(INPUTS) | $(CREATED)
	@echo "Setting up $(VENV); the first time this takes about a minute"
	$(PIP) --editable $(WITH_ROS)
	@touch $@

$(READY_DEV): $(READY)
	$(PIP) --editable $(WITH_ROS_DEV)
	@touch $@

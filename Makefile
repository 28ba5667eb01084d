# What a person types: demo, test, lint, types, docs, check, colcon, clean. Sets up a virtual environment of its own on the way.
#
# Without ROS: installs ROS 2 Jazzy from pip, and compiles the two message packages that pip lacks (interfaces/).
# With ROS sourced (AMENT_PREFIX_PATH is set): uses that ROS, and installs neither.

PYTHON ?= python3
DEMO_ARGS ?=
PYTEST_ARGS ?=
# Processes that run tests side by side: more than two cores, for tests of nodes mostly wait.
JOBS ?= 4

ifdef AMENT_PREFIX_PATH
VENV ?= .venv-beside-ros
# The messages of apt's ROS are compiled for numpy 1.26 and do not load with numpy 2.
PACKAGE := . 'numpy<2'
PACKAGE_DEV := '.[test,lint]' 'numpy<2'
PACKAGE_DOCS := '.[docs]' 'numpy<2'
MESSAGES :=
else
VENV ?= .venv
PACKAGE := '.[ros]'
PACKAGE_DEV := '.[ros,test,lint]'
PACKAGE_DOCS := '.[ros,docs]'
MESSAGES := $(VENV)/.messages
endif

BIN := $(VENV)/bin
# The last flag only matters to pip before 23.1, which otherwise warns at length about one of the wheels of ROS.
PIP := $(BIN)/python -m pip install --disable-pip-version-check --quiet --use-pep517
CREATED := $(VENV)/.created
MESSAGES_INPUTS := $(wildcard interfaces/*.* interfaces/build_messages/*.py aerial_gnss_ros/bags/msg/*/msg/*.msg)
INPUTS := setup.py setup.cfg pyproject.toml $(MESSAGES)
READY := $(VENV)/.ready-to-run
READY_DEV := $(VENV)/.ready-to-develop
READY_DOCS := $(VENV)/.ready-to-document

# test/conftest.py says which tests stay together.
SIDE_BY_SIDE := -n $(JOBS) --dist loadscope --no-loadscope-reorder
# Ends a process whose test hangs, also in native code (pytest 9; older ones only print where it hangs).
TIMEOUT := -o faulthandler_timeout=400 -o faulthandler_exit_on_timeout=true

# Nodes of the demo and the tests talk on this machine only.
export ROS_AUTOMATIC_DISCOVERY_RANGE := LOCALHOST
# Empty is unset: hundreds of programs of the tests import what one of them has compiled.
export PYTHONDONTWRITEBYTECODE :=

.PHONY: help demo test quick check lint types docs colcon clean
.DELETE_ON_ERROR:

help:
	@echo "make demo     find three robots in a simulated flight, live (DEMO_ARGS=\"--duration 10\")"
	@echo "make test     all tests, four at a time (PYTEST_ARGS=\"-k geodesy\", JOBS=5)"
	@echo "make lint     style and likely mistakes"
	@echo "make types    mypy --strict"
	@echo "make docs     the documentation as a site, build/docs/html/index.html; a warning is an error"
	@echo "make quick    these two, and all tests but those of installations and nodes"
	@echo "make check    all that CI runs, fast parts first"
	@echo "make colcon   build as on a robot, into build/ and install/"
	@echo "make clean    remove what the others made"

demo: $(READY)
	$(BIN)/aerial-gnss demo $(DEMO_ARGS)

test: $(READY_DEV)
	$(BIN)/python -m pytest $(SIDE_BY_SIDE) $(TIMEOUT) -m "not pages and not browser" $(PYTEST_ARGS)

quick: lint types
	$(BIN)/python -m pytest $(SIDE_BY_SIDE) $(TIMEOUT) -q -m "not slow and not pages and not browser" --ignore=test/nodes $(PYTEST_ARGS)

check:
	.ci/run

lint: $(READY_DEV)
	$(BIN)/python tools/headers.py
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .

types: $(READY_DEV)
	$(BIN)/mypy

docs: $(READY_DOCS)
	$(BIN)/python -m sphinx -E -W --keep-going -q -b html -d build/docs/doctrees docs build/docs/html
	@echo "build/docs/html/index.html"

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

$(VENV)/.messages: $(MESSAGES_INPUTS) | $(CREATED)
	@echo "Compiling the message packages that ROS from pip lacks: half a minute, once"
	$(PIP) ./interfaces
	@touch $@

# Editable: changed sources need no new installation, only changed dependencies do.
$(READY): $(INPUTS) | $(CREATED)
	@echo "Installing the package and its dependencies: about a minute, once"
	$(PIP) --editable $(PACKAGE)
	@touch $@

# Both contain all that READY does, and neither takes away from the other.
$(READY_DEV): $(INPUTS) | $(CREATED)
	@echo "Installing the package and what tests and checks it: about a minute, once"
	$(PIP) --editable $(PACKAGE_DEV)
	@touch $(READY) $@

$(READY_DOCS): $(INPUTS) | $(CREATED)
	$(PIP) --editable $(PACKAGE_DOCS)
	@touch $(READY) $@

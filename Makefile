# Common tasks. TORCH chooses the build of PyTorch: the default is the one of pip's index (on Linux
# often one for GPUs); another, say,  make demo TORCH="torch --index-url URL-OF-THE-CPU-BUILD".
PYTHON ?= python3
TORCH ?= torch==2.13.0
VENV ?= .venv
BIN := $(VENV)/bin
JOBS ?= 2
# Versions that are known to work; CONSTRAINTS= takes the newest instead. PyTorch is not among
# them: its build is chosen by TORCH.
CONSTRAINTS ?= -c constraints/dev.txt

.PHONY: demo ros2 tesseract test test-all test-oldest package changelog lint bench bench-quick docs constraints clean

demo: $(VENV)/.demo
	$(BIN)/demospec demo --out runs/demo

$(VENV)/bin/pip:
	$(PYTHON) -m venv $(VENV)
	$(BIN)/pip install -q --upgrade pip

# torch goes first: a bare range would bring gigabytes of CUDA packages.
$(VENV)/.demo: pyproject.toml | $(VENV)/bin/pip
	$(BIN)/pip install -q $(TORCH)
	$(BIN)/pip install -q $(CONSTRAINTS) -e ".[vision]"
	touch $@

$(VENV)/.dev: pyproject.toml | $(VENV)/bin/pip
	$(BIN)/pip install -q $(TORCH)
	$(BIN)/pip install -q $(CONSTRAINTS) -e ".[all,dev]"
	touch $@ $(VENV)/.demo

lint: $(VENV)/.dev
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports

# ROS 2's wheels for the tests that use them, apart: one of them changes how every Python starts.
ros2: $(VENV)/.dev
	$(PYTHON) -m venv $(VENV)-ros
	$(VENV)-ros/bin/pip install -q ros-rclpy ros-rmw-fastrtps-cpp ros-geometry-msgs ros-nav-msgs \
		ros-visualization-msgs ros-diagnostic-msgs

# Tesseract, for the test in which it reads its export: 280 MB, and an older NumPy in other releases.
tesseract: $(VENV)/.dev
	$(PYTHON) -m venv $(VENV)-tesseract
	$(VENV)-tesseract/bin/pip install -q tesseract-robotics

test: $(VENV)/.dev
	$(BIN)/pytest -q -n $(JOBS)

test-all: $(VENV)/.dev
	$(BIN)/pytest -q -n $(JOBS) -m "slow or not slow"

# The core at the lowest versions that pyproject.toml allows, without extras. Other packages'
# deprecations of each other are theirs; every other warning is an error, as always.
OLDEST := $(VENV)-oldest
OLDEST_TESTS ?= tests/geometry tests/scene/test_scenes.py tests/scene/test_drawn_pictures.py \
	tests/demonstrations tests/demonstrations_io tests/readers/test_tables_and_json.py \
	tests/readers/test_tour.py tests/rules/test_clearance.py tests/rules/test_query.py \
	tests/rules/test_goodness.py tests/audit tests/planning/test_plan.py \
	tests/planning/test_cost_map.py tests/planning/test_distance.py tests/monitor/test_monitor.py \
	tests/monitor/test_filter.py tests/cli/test_plan_commands.py tests/core/test_errors_and_files.py \
	tests/core/test_frames.py
test-oldest: $(VENV)/.dev
	$(BIN)/uv venv -q --clear --python $(PYTHON) $(OLDEST)
	$(BIN)/uv pip compile -q --resolution lowest-direct --python $(OLDEST) pyproject.toml \
		-o $(OLDEST)/lowest.txt > $(OLDEST)/resolved.txt
	$(BIN)/uv pip install -q --python $(OLDEST) -c $(OLDEST)/lowest.txt -e . \
		pytest hypothesis jsonschema "pandas<3" qpsolvers daqp
	OMP_NUM_THREADS=1 $(OLDEST)/bin/python -m pytest -q -p no:cacheprovider \
		-W ignore::DeprecationWarning $(OLDEST_TESTS)

# A wheel and an sdist in dist/, checked as an index would.
package: $(VENV)/.dev
	rm -rf dist
	$(BIN)/python -m build --installer uv > /dev/null
	$(BIN)/twine check --strict dist/*

# The fragments of changelog.d/ under one heading of CHANGELOG.md:  make changelog VERSION=0.2.0
changelog:
	$(PYTHON) changelog.d/gather.py $(VERSION)

# A few minutes on two cores; the table is benchmarks/results/suite.md.
bench: $(VENV)/.dev
	$(BIN)/python benchmarks/run.py

bench-quick: $(VENV)/.dev
	$(BIN)/python benchmarks/run.py --quick

docs: $(VENV)/.dev
	NO_MKDOCS_2_WARNING=1 $(BIN)/mkdocs build --strict

constraints: $(VENV)/.dev
	$(BIN)/python constraints/make.py

clean:
	rm -rf $(VENV) runs site

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

.PHONY: demo ros2 test test-all lint bench bench-quick docs constraints clean

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

test: $(VENV)/.dev
	$(BIN)/pytest -q -n $(JOBS)

test-all: $(VENV)/.dev
	$(BIN)/pytest -q -n $(JOBS) -m "slow or not slow"

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

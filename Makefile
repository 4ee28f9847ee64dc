# Each target does all set-up it needs: a virtual environment in .venv, a release
# build of the core, the package installed into it.

PYTHON ?= python3
VENV   := .venv
BIN    := $(VENV)/bin
OUT    := out

RUST_SOURCES := $(shell find rust Cargo.toml Cargo.lock pyproject.toml -type f 2>/dev/null)

# Processes that run the Python tests; those of one class or file share what they prepare.
JOBS ?= 2
PYTEST := $(BIN)/python -m pytest -n $(JOBS) --dist loadscope
CARGO_FLAGS := --release --locked

.PHONY: run build check test test-all lint style types bench docs wheel clean tools

run: $(VENV)/built
	$(BIN)/locosweep reproduce all --robot examples/locosnake.toml --out $(OUT)
	$(BIN)/locosweep optimum --robot examples/locosnake.toml --segments 2:8
	$(BIN)/locosweep gait examples/gait_single.toml --out $(OUT)/gait --force
	$(BIN)/locosweep heatmap mean_velocity --robot examples/locosnake.toml \
	  --set drive_limit=inf --x slope_deg=0:25:1000 --y mu_static=0.1:1:1000 \
	  --best-over segments=2:128 --out $(OUT)/optimal_segments.png
	$(BIN)/locosweep reproduce gap --out $(OUT)/gap
	$(BIN)/locosweep diagnose $(OUT)/gap/runs.csv --nominal $(OUT)/gap/nominal.toml --out $(OUT)/diagnosis --force
	@echo "locosweep: the paper's figures and table, the paper's gait in gait/, and the map of the best segment count lie in $(CURDIR)/$(OUT); the diagnosis of the paper's own gap is $(CURDIR)/$(OUT)/diagnosis/report.html"

build: $(VENV)/built

# After an edit of Python: no compiler runs, and tests are those of single modules.
check: style types
	@$(BIN)/locosweep --version >/dev/null 2>&1 || { echo "make check: the unit tests need the compiled core, which is missing: \`make build\` compiles and installs it, once"; exit 1; }
	@test -z "$$(find $(RUST_SOURCES) -newer $(VENV)/built)" || echo "make check: the compiled core is older than its sources: \`make build\` renews it"
	$(PYTEST) -m "not slow and not whole" tests

# What every change has to pass. All packages are selected, so that the core is compiled with
# the same features of its dependencies as for the package, and not again.
test: $(VENV)/built lint
	$(PYTEST) -m "not slow" --doctest-modules python/locosweep tests
	cargo test $(CARGO_FLAGS) --workspace

# What is left out above for its time, too: whole diagnoses that take seconds each, batteries
# of points, runs, robots and pairs of effects, and benches as short as shows that they run.
test-all: test docs
	LOCOSWEEP_SITE=$(CURDIR)/$(OUT)/docs $(PYTEST) -m slow tests
	cargo test $(CARGO_FLAGS) --workspace -- --ignored
	cargo bench --locked --workspace --bench sweep -- --test
	cargo bench --locked --workspace --bench dynamics -- --test
	$(BIN)/python benches/border.py --quick
	$(BIN)/python benches/heatmap.py --quick
	$(BIN)/python benches/diagnosis.py --quick
	$(BIN)/python benches/peers.py --quick
	$(BIN)/python benches/dynamics_peers.py --quick
	$(BIN)/python benches/stored.py --quick

# Clippy generates no code; in the release profile it shares what a build has compiled.
lint: $(VENV)/built style types
	$(BIN)/python -m mypy.stubtest locosweep._core
	cargo clippy $(CARGO_FLAGS) --workspace --all-targets -- -D warnings

style: $(VENV)/installed
	cargo fmt --all --check
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .

types: $(VENV)/installed
	$(BIN)/mypy

bench: $(VENV)/built
	$(BIN)/python -c 'import tomllib; print("\n".join(tomllib.load(open("pyproject.toml", "rb"))["project"]["optional-dependencies"]["peers"]))' > $(VENV)/peers.txt
	@while read -r peer; do $(BIN)/pip install --quiet --disable-pip-version-check "$$peer" </dev/null || echo "cannot install $$peer: its rows will say so"; done <$(VENV)/peers.txt
	cargo bench --locked --workspace --bench sweep
	cargo bench --locked --workspace --bench dynamics
	$(BIN)/python benches/border.py
	$(BIN)/python benches/heatmap.py
	$(BIN)/python benches/diagnosis.py
	$(BIN)/python benches/peers.py
	$(BIN)/python benches/dynamics_peers.py
	$(BIN)/python benches/stored.py

# The pages of docs/, the gallery with what its scripts draw, and the reference of the package. A warning
# is an error. The stamp is of the packages that this alone needs.
docs: $(VENV)/built $(VENV)/docs
	$(BIN)/python docs/site/build.py --out $(OUT)/docs

$(VENV)/docs: pyproject.toml | $(VENV)/installed
	$(BIN)/python -c 'import tomllib; print("\n".join(tomllib.load(open("pyproject.toml", "rb"))["project"]["optional-dependencies"]["docs"]))' > $(VENV)/docs.txt
	$(BIN)/pip install --quiet --disable-pip-version-check -r $(VENV)/docs.txt
	touch $@

# One wheel for all Pythons from 3.11 on.
wheel: $(VENV)/installed
	$(BIN)/maturin build --release --locked --strip --out dist

clean:
	rm -rf target $(VENV) $(OUT) dist

# What has to be there already, said in one line if it is not.
tools:
	@command -v cargo >/dev/null || { echo "locosweep needs Rust 1.89 or later: cargo is not on the PATH"; exit 1; }
	@command -v $(PYTHON) >/dev/null || { echo "locosweep needs Python 3.11 or later: $(PYTHON) is not on the PATH"; exit 1; }
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || { echo "locosweep needs Python 3.11 or later: $(PYTHON) is older (set PYTHON=...)"; exit 1; }
	@$(PYTHON) -c 'import venv, ensurepip' 2>/dev/null || { echo "locosweep needs Python's venv module (on Debian: the package python3-venv)"; exit 1; }
	@command -v cc >/dev/null || { echo "locosweep needs a C compiler (as the linker of Rust): cc is not on the PATH"; exit 1; }

$(VENV)/installed: pyproject.toml Cargo.toml | tools
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -c 'import tomllib; p = tomllib.load(open("pyproject.toml", "rb"))["project"]; print("\n".join(p["dependencies"] + p["optional-dependencies"]["dev"]))' > $(VENV)/requirements.txt
	$(BIN)/pip install --quiet --disable-pip-version-check -r $(VENV)/requirements.txt
	touch $@

$(VENV)/built: $(VENV)/installed $(RUST_SOURCES)
	VIRTUAL_ENV=$(CURDIR)/$(VENV) PIP_DISABLE_PIP_VERSION_CHECK=1 $(BIN)/maturin develop --release --locked --generate-stubs >$(VENV)/build.log || { cat $(VENV)/build.log; exit 1; }
	touch $@

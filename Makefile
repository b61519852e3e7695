# Two commands do everything: `make reproduce` and `make test`. Both make .venv first.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin

.PHONY: reproduce test test-all lint gallery docs picture bench certificates dist clean

reproduce: $(VENV)/installed
	$(BIN)/lmic reproduce

test: $(VENV)/installed-dev lint
	$(BIN)/pytest -n 2 -m "not long"

test-all: $(VENV)/installed-dev lint
	$(BIN)/pytest -n 2

lint: $(VENV)/installed-dev
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy

gallery: $(VENV)/installed
	$(BIN)/lmic gallery -o site/gallery

# the site, with the gallery, and with the papers' report where make reproduce has made one; a warning fails
docs: $(VENV)/installed-docs
	rm -rf site
	$(BIN)/sphinx-build --fail-on-warning --keep-going --quiet --doctree-dir build/doctrees docs site
	@echo site/index.html

# the README's first picture
picture: $(VENV)/installed
	mkdir -p build && rm -f build/oscillator.jsonl
	$(BIN)/lmic sweep standard.bounded_real_continuous --plant standard.oscillator \
	    --over s=0:0.6:31 --over dependence:P=constant,1,2 -o build/oscillator.jsonl --plot docs/oscillator.svg

# the source archive, the wheel made from it, and what an index would say of both
dist: $(VENV)/installed-dev
	rm -rf dist
	$(BIN)/python -m build --no-isolation --outdir dist .
	$(BIN)/twine check --strict dist/*

# minutes; make bench MODE= leaves nothing out and takes much longer, most of it in CVXPY and PICOS
MODE := --quick
bench: $(VENV)/installed-bench
	$(BIN)/python benchmarks/certify.py
	$(BIN)/python benchmarks/run.py $(MODE)

CERTIFIED := peixoto2025.table1 $(foreach norm,hinf l2linf,wu2007.table1.$(norm).point wu2007.table1.$(norm).box) \
    mustafa chen2006.no_delay chen2006.example2 chen2006.nft chen2006.lft

# the enclosures behind the papers' tables, which the tests prove anew
certificates: $(VENV)/installed
	$(BIN)/lmic reproduce $(CERTIFIED) --certify certificates
	for theorem in theorem1 corollary1; do for eps in 1 10 50 1000; do \
	    $(BIN)/lmic solve peixoto2025.$$theorem --plant theorems/peixoto2025/example1.toml --set eps=$$eps \
	        --certify certificates/peixoto2025.$$theorem.eps$$eps.json || exit 1; \
	done; done

clean:
	rm -rf $(VENV) build dist reports site .mypy_cache .ruff_cache .pytest_cache .hypothesis
	find . -name __pycache__ -prune -exec rm -rf {} +

$(VENV)/bin/python:
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --upgrade pip

$(VENV)/installed: $(VENV)/bin/python pyproject.toml
	$(BIN)/python -m pip install --quiet --editable .
	touch $@

$(VENV)/installed-bench: $(VENV)/bin/python pyproject.toml
	$(BIN)/python -m pip install --quiet --editable ".[bench]"
	touch $@ $(VENV)/installed

$(VENV)/installed-docs: $(VENV)/bin/python pyproject.toml
	$(BIN)/python -m pip install --quiet --editable ".[docs]"
	touch $@ $(VENV)/installed

$(VENV)/installed-dev: $(VENV)/bin/python pyproject.toml
	$(BIN)/python -m pip install --quiet --editable ".[dev]"
	touch $@ $(VENV)/installed

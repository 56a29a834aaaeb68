# Two commands do everything on a fresh machine with Python 3.11 or later:
#   make run    the console            make test    every check and test
# Both create .venv, install what is needed and fetch the models; neither needs root, both may be repeated.

# The first of these that runs and is new enough; python3 first, because it is what its owner chose.
PYTHON ?= $(shell for python in python3 python3.13 python3.12 python3.11; do \
	$$python -c 'import sys; sys.exit(sys.version_info < (3, 11))' 2>/dev/null && echo $$python && break; done)
VENV := .venv
BIN := $(VENV)/bin
INSTALLED := $(VENV)/.installed

.PHONY: run test check pictures clean

run: $(INSTALLED)
	@$(BIN)/sayso models pull
	@$(BIN)/sayso $(ARGS)

test: check
	@$(BIN)/sayso models pull whisper-base whisper-tiny.en
	$(BIN)/pytest $(ARGS)

check: $(INSTALLED)
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports

pictures: $(INSTALLED)
	$(BIN)/python -m tests.tui.pictures

$(INSTALLED): pyproject.toml constraints.txt
	@test -n "$(PYTHON)" || { echo "sayso needs Python 3.11 or later: make PYTHON=/path/to/python3.11 …" >&2; exit 2; }
	@test -x $(BIN)/python || $(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --upgrade "pip>=25.1"
	$(BIN)/python -m pip install --disable-pip-version-check --progress-bar on --quiet -c constraints.txt -e ".[dev]"
	@touch $@

clean:
	rm -rf $(VENV) .mypy_cache .pytest_cache .ruff_cache .import_linter_cache

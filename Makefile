# Two commands do everything on a fresh machine with Python 3.11 or later:
#   make run    the console            make test    every check and test
# Both create .venv, install what is needed and fetch the models; neither needs root, both may be repeated.

# The first of these that runs and is new enough; python3 first, because it is what its owner chose.
PYTHON ?= $(shell for python in python3 python3.13 python3.12 python3.11; do \
	$$python -c 'import sys; sys.exit(sys.version_info < (3, 11))' 2>/dev/null && echo $$python && break; done)
VENV := .venv
BIN := $(VENV)/bin
INSTALLED := $(VENV)/.installed

# What a virtual microphone needs; the tests that speak into one are skipped without it.
SOUND := libportaudio2 pulseaudio pulseaudio-utils libasound2-plugins

.PHONY: run test test-audio sound test-web test-ros check reader pictures clean

run: $(INSTALLED)
	@$(BIN)/sayso models pull
	@$(BIN)/sayso $(ARGS)

test: check
	@$(BIN)/sayso models pull whisper-base whisper-tiny.en qwen2.5-coder-1.5b piper-joe speech-embedding multilingual-e5-small
	@$(BIN)/python -m tests.ros.environment
	@$(BIN)/python -m compileall -q -j 0 config engine tui tests
ifdef ARGS
	$(BIN)/pytest $(ARGS)
else
	$(BIN)/python -m tests.whole
endif

# The tests at a virtual microphone, for certain. As root it installs what they need.
test-audio: sound $(INSTALLED)
	@$(BIN)/sayso models pull whisper-base
	TEST_AUDIO=required $(BIN)/pytest tests/audio $(ARGS)

sound:
	@if [ "$$(id -u)" = 0 ] && command -v apt-get >/dev/null && ! dpkg -s $(SOUND) >/dev/null 2>&1; then \
		apt-get install --yes --quiet --no-install-recommends $(SOUND) || \
		{ apt-get update --quiet && apt-get install --yes --quiet --no-install-recommends $(SOUND); }; fi

# The tests in a browser, for certain. As root it installs one.
test-web: $(INSTALLED)
	@if [ "$$(id -u)" = 0 ] && command -v apt-get >/dev/null && ! command -v chromium >/dev/null; then \
		apt-get install --yes --quiet --no-install-recommends chromium || \
		{ apt-get update --quiet && apt-get install --yes --quiet --no-install-recommends chromium; }; fi
	TEST_WEB=required $(BIN)/pytest tests/e2e/test_web.py $(ARGS)

check: $(INSTALLED)
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports

# The tests against real nodes of ROS 2, for certain. SAYSO_ROSBRIDGE names the folder of a rosbridge_suite, to try that too.
test-ros: $(INSTALLED)
	@TEST_ROS=required $(BIN)/python -m tests.ros.environment
	TEST_ROS=required $(BIN)/pytest tests/ros $(ARGS)

# Trains the learned reader anew, in an hour or so on two cores. PUBLIC is a folder with HuRIC and GPSR, if any.
reader: $(INSTALLED)
	@$(BIN)/sayso models pull multilingual-e5-small
	$(BIN)/pip install --quiet --constraint constraints.txt --editable '.[train]'
	$(BIN)/python -m engine.understanding.training.lexicon
	$(BIN)/python -m engine.understanding.training.train $(if $(PUBLIC),--public $(PUBLIC)) $(ARGS)

pictures: $(INSTALLED)
	$(BIN)/python -m tests.tui.pictures
	$(BIN)/python -m tests.tui.cast

$(INSTALLED): pyproject.toml constraints.txt
	@test -n "$(PYTHON)" || { echo "sayso needs Python 3.11 or later: make PYTHON=/path/to/python3.11 …" >&2; exit 2; }
	@test -x $(BIN)/python || $(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --upgrade "pip>=25.1"
	$(BIN)/python -m pip install --disable-pip-version-check --progress-bar on --quiet -c constraints.txt -e ".[dev]"
	@$(BIN)/python -m compileall -q config engine tui # as pip does it for what it copies: the first start is as quick as the second
	@touch $@

clean:
	rm -rf $(VENV) .ros .mypy_cache .pytest_cache .ruff_cache .import_linter_cache

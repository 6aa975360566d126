# The Python package: a module linked of the command's own objects, so that its numbers are the command's.
.PHONY: python wheel
PYTHON_LINK := build/python/link.txt
PACKAGE := sim_hal/python
# What pip asks of the network it has: the build's tools are in the environment.
PIP := $(PYTHON) -m pip --quiet --disable-pip-version-check

#: make python wheel   the Python package: into .venv, or as a wheel into build/wheel
python: setup-python
	@$(MAKE) $(PYTHON_LINK)
	@$(PIP) install --no-deps --no-build-isolation ./$(PACKAGE)

wheel: setup-python
	@$(MAKE) $(PYTHON_LINK)
	@$(PIP) wheel --no-deps --no-build-isolation --wheel-dir build/wheel ./$(PACKAGE)

$(PYTHON_LINK): $(call object,$(LOOKS)) $(TICK_AND_RIG) $(RIG_FILES)
	@mkdir -p $(@D)
	@printf '%s\n' $(abspath $^) $(LIBRARIES) > $@

setup-python:
	@scripts/setup.sh python

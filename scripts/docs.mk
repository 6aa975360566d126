# The documentation.
.PHONY: docs readme

#: make docs           the documentation site: build/docs/index.html
docs: python
	@$(MAKE) $(BUILD)/berth
	@$(PYTHON) scripts/docs.py

#: make readme         run the commands that README and guides show again and write what they print
readme: setup
	@$(MAKE) all
	@$(PYTHON) scripts/readme.py

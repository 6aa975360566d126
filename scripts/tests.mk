# Tests, in tiers by how long they take; scripts/test.sh says what each tier runs.
.PHONY: test quick-test full-test setup-test

#: make quick-test     unit, contract and theory tests, and the Python tests that are not long
quick-test: setup-test
	@scripts/test.sh quick

#: make test           adds sanitizers, replays on arm64, a real-time kernel, hidden effects and lint
test: setup-test
	@scripts/test.sh test

#: make full-test      everything: long tests, all sanitizers, both kernels, Debian 13, hidden effects' scores
full-test: setup-test
	@scripts/test.sh full

setup-test:
	@scripts/setup.sh test

#: make fuzz           broken files for every reader of files, under libFuzzer; goes on where it ended (SECONDS=60 each)
.PHONY: fuzz
fuzz: setup-test
	@$(MAKE) build/berth
	@$(MAKE) FUZZ=1 build/fuzz/parsers
	@$(PYTHON) scripts/fuzz.py --seconds $(or $(SECONDS),60)

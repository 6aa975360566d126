# berth. `make run` and `make test` install what they need, build and do what they say; `make help` lists the rest.
# Here is what a user does. How it is done stands in scripts/*.mk, by topic: programs, tests, target, care.
BUILD := build
PYTHON := .venv/bin/python
.DEFAULT_GOAL := help

include $(addprefix scripts/,programs.mk tests.mk target.mk docs.mk python.mk care.mk)

.PHONY: help run map figures diagnose score bench jitter setup clean
help:
	@sed -n 's/^#: //p' $(MAKEFILE_LIST)

#: make run            set up, build, run the reference case ess: log, HTML report and PNG in
#:                     build/runs/ess/latest, beside earlier runs
run: setup
	@$(MAKE) all
	build/berth run ess
	@build/berth report build/runs/ess/latest

#: make all            build build/berth and build/berth-loop; with WERROR=1 warnings are errors
all: $(BUILD)/berth $(BUILD)/berth-loop

#: make map            stability maps of the reference case: CSV files and pictures in build/maps
map: setup
	@$(MAKE) all
	@for vary in elasticity mass; do build/berth map ess --vary $$vary || exit; done
	@$(PYTHON) scripts/map_picture.py build/maps/ess-elasticity.csv build/maps/ess-mass.csv

#: make figures        the paper's figures and claims, computed, for ess and for ess-paper: pages and pictures in
#:                     build/figures and build/figures/ess-paper
figures: setup
	@$(MAKE) all
	@$(PYTHON) scripts/figures.py --beside ess-paper

#: make diagnose       what a rig file gets wrong: RECORD=log RIG=file, or a built-in example; report in
#:                     build/diagnosis
# The example: the robot of the run has a transfer behaviour that the rig `ess` knows nothing of.
RECORD ?= build/diagnosis/example/ess.ulg
RIG ?= ess
diagnose: setup
	@$(MAKE) all
ifeq ($(origin RECORD),file)
	build/berth run ess --set robot.transfer_frequency_Hz=12 --set sensor.noise_N=0.3 --set run.duration_s=40 \
		--set profile.kind=multisine --set profile.amplitude_m=0.01 --set profile.duration_s=20 \
		--out build/diagnosis/example
endif
	build/berth diagnose $(RECORD) --rig $(RIG) --out build/diagnosis
	@build/berth report build/diagnosis

#: make score          how often the diagnosis is right: 300 records with hidden effects (SEED=6001, COUNT=300)
score: setup-test
	@$(MAKE) all
	@$(PYTHON) tests/hidden_effects/score.py --seed $(or $(SEED),6001) --count $(or $(COUNT),300)

#: make bench          time the tick, the closed loop, stability maps and a diagnosis against other people's
#:                     libraries
bench: setup-test
	@$(MAKE) all build/tick_bench build/arm_bench build/arm_peers
	@$(PYTHON) scripts/bench.py
	@$(PYTHON) scripts/bench_arm.py
	@$(PYTHON) scripts/bench_map.py
	@$(PYTHON) scripts/bench_diagnose.py

#: make jitter         how late this machine wakes the loop, beside cyclictest; picture in build/jitter
jitter: setup-target
	@$(MAKE) build/berth-target
	@scripts/jitter.sh

setup:
	@scripts/setup.sh run

clean:
	rm -rf build

# berth. `make run` and `make test` install what they need, build and do what they say; `make help` lists the rest.

CROSS_COMPILE ?=
SANITIZE ?=
ifneq ($(CROSS_COMPILE),)
BUILD := build/$(CROSS_COMPILE:%-=%)
else ifneq ($(SANITIZE),)
BUILD := build/sanitize
else
BUILD := build
endif
CC := $(CROSS_COMPILE)gcc
CXX := $(CROSS_COMPILE)g++
ifneq ($(SANITIZE),)
# Clang builds with sanitizers in half of gcc's time, and sees other mistakes.
CC := clang
CXX := clang++
endif
# Where ccache is installed, what was compiled in one clone is not compiled again in another.
CCACHE := $(shell command -v ccache)
export CCACHE_NOHASHDIR := 1
PYTHON := .venv/bin/python
MAKEFLAGS += --no-print-directory
ifeq ($(MAKELEVEL),0)
MAKEFLAGS += -j$(shell nproc)
endif

# --- sources: a folder is listed, a new file in it is built ------------------------------------------------------
FIRMWARE := $(filter-out firmware/main.c,$(wildcard firmware/*.c firmware/*.cpp firmware/can/*.c \
	firmware/compensation/*.c firmware/compensation/*.cpp firmware/arm/*.c firmware/arm/*.cpp))
HAL := $(wildcard hal/*.c hal/*.cpp hal/rig/*.cpp)
SIM := $(filter-out sim_hal/solver/cvode_solver.cpp sim_hal/arm/urdf%,$(wildcard sim_hal/*.cpp sim_hal/hil/*.cpp sim_hal/plant/*.cpp sim_hal/effects/*.cpp \
	sim_hal/solver/*.cpp sim_hal/stability/*.cpp sim_hal/compensation/*.cpp sim_hal/log/*.cpp sim_hal/diagnosis/*.cpp sim_hal/diagnosis/*/*.cpp \
	sim_hal/rths/*.cpp sim_hal/arm/*.cpp))
CLI := $(wildcard sim_hal/cli/*.cpp)
TARGET := $(wildcard hal/linux/*.cpp)
FAR_END := $(wildcard sim_hal/far_end/*.cpp) hal/linux/can_socket.cpp hal/linux/can_link.cpp
CPP_TESTS := $(wildcard tests/unit/*.cpp tests/theory/*.cpp tests/contract/*.cpp tests/scenarios/*.cpp)
TARGET_TESTS := $(wildcard tests/linux/*.cpp) tests/contract/hal_test.cpp tests/unit/main.cpp
BENCH := tests/bench/tick_bench.cpp
RIGS := $(wildcard sim_hal/rigs/*.toml sim_hal/robots/*.toml sim_hal/arms/*.toml)

# --- flags --------------------------------------------------------------------------------------------------------
# The firmware gives the same bits on every machine: no fused multiply-add, no vectorised Eigen (its packets may be
# fused), and one set of Eigen macros for the whole program, so that a template means one thing.
ARITHMETIC := -ffp-contract=off -fno-math-errno -DEIGEN_DONT_VECTORIZE -DEIGEN_RUNTIME_NO_MALLOC
WARNINGS := -Wall -Wextra -Wshadow -Werror
COMMON := -O2 -g1 $(ARITHMETIC) $(WARNINGS) -MMD -MP -I.
EFFECTS = $(call object,$(filter sim_hal/effects/%,$(SIM)))
LIBRARIES :=
PKG_CONFIG := pkg-config
ifeq ($(CROSS_COMPILE),)
# SUNDIALS, zlib and tinyxml2 are for the host only.
COMMON += -isystem /usr/include/eigen3
SIM += sim_hal/solver/cvode_solver.cpp $(wildcard sim_hal/arm/urdf*.cpp)
SIM_FLAGS := -DBERTH_WITH_SUNDIALS -DBERTH_WITH_ZLIB -DBERTH_WITH_URDF
LIBRARIES += -lsundials_cvode -lsundials_nvecserial -lsundials_sunnonlinsolfixedpoint -lz -ltinyxml2
else
# libgpiod for the target is unpacked beside the objects.
SYSROOT := $(BUILD)/sysroot
PKG_CONFIG := PKG_CONFIG_LIBDIR=$(SYSROOT)/usr/lib/$(CROSS_COMPILE:%-=%)/pkgconfig PKG_CONFIG_SYSROOT_DIR=$(abspath $(SYSROOT)) \
	pkg-config
COMMON += -isystem $(BUILD)/include
LDFLAGS += -static
endif
ifneq ($(SANITIZE),)
COMMON += -fsanitize=address,undefined -fno-sanitize-recover=all -O1
# For the time that it takes: every reference taken in Eigen's and the standard library's templates is looked at.
# Null pointers that are used still end the program, and so does what lies beyond its object; misaligned ones are not
# seen here.
HOST_ONLY := -fno-sanitize=null,alignment,object-size,vptr,pointer-overflow
LDFLAGS += -fsanitize=address,undefined
endif

# The files of a folder are compiled a batch at a time, as headers take most of the time. FILE_BY_FILE=1 is for who
# changes them often: it makes less again, and misses no include.
FILE_BY_FILE ?=
ifeq ($(FILE_BY_FILE),)
# Other programs link these without their folders, or they have flags of their own.
ALONE := tests/unit/main.cpp tests/contract/hal_test.cpp sim_hal/hil/sim_hal.cpp $(wildcard sim_hal/solver/*_steps.cpp)
# Before the set-up there may be no Python.
in_batches = $(filter $(ALONE),$(1)) \
	$(if $(shell command -v python3),$(shell scripts/batches.py $(BUILD)/batch $(filter-out $(ALONE),$(1))))
HAL := $(filter-out hal/rig/%,$(HAL)) $(call in_batches,$(filter hal/rig/%,$(HAL)))
SIM := $(call in_batches,$(SIM))
CLI := $(call in_batches,$(CLI))
CPP_TESTS := $(call in_batches,$(CPP_TESTS))
TARGET_TESTS := $(call in_batches,$(TARGET_TESTS))
endif

# What runs at every tick is optimised across its files: codec, buses and channels are many small functions.
# Sanitizers look at each by itself, and link in a tenth of the time.
TICK_PATH := $(FIRMWARE) $(wildcard hal/*.c hal/*.cpp hal/linux/*.cpp) $(filter sim_hal/hil/% sim_hal/plant/%,$(SIM))
ACROSS_FILES := $(if $(SANITIZE),,-flto=auto)
LDFLAGS += -O2 $(ACROSS_FILES)

object = $(patsubst %,$(BUILD)/obj/%.o,$(1))
LOOP_OBJECTS := $(call object,$(FIRMWARE) $(HAL) $(SIM) build/rigs.cpp)
# The loop and its simulated rig, here or at the far end, without what looks at them.
FAR_END_OBJECTS := $(call object,$(FIRMWARE) $(HAL) $(filter sim_hal/hil/% sim_hal/plant/% sim_hal/solver/% sim_hal/effects/%,$(SIM)) \
	build/rigs.cpp)

.PRECIOUS: build/%/include build/%/sysroot
.PHONY: all readme run test quick-test slow-test lint format codec bench map figures diagnose score target target-programs guest-programs target-image guest-shell jitter setup setup-test setup-target clean help
.DEFAULT_GOAL := help

help:
	@echo "make run            set up, build, run the reference case ess: log, HTML report and PNG in build/runs"
	@echo "make test           set up and run the tests: unit, theory, replay, arm64, sanitizers, lint"
	@echo "make quick-test     the tests without sanitizers, arm64 and lint"
	@echo "make slow-test      the tests that take longest, which the others leave out; all C++ tests with sanitizers"
	@echo "make map            stability maps of the reference case: CSV files and pictures in build/maps"
	@echo "make figures        the paper's figures and claims, computed: page and pictures in build/figures"
	@echo "make diagnose       what a rig file gets wrong: RECORD=log RIG=file, or a built-in example; report in"
	@echo "                    build/diagnosis"
	@echo "make score          how often the diagnosis is right: 300 records with hidden effects (SEED=6001, COUNT=300)"
	@echo "make bench          time the tick, the closed loop, stability maps and a diagnosis against other people's"
	@echo "                    libraries"
	@echo "make target         the loop on real-time kernels in QEMU, arm64 and amd64, over real CAN and GPIO drivers"
	@echo "make jitter         how late this machine wakes the loop, beside cyclictest; picture in build/jitter"
	@echo "make CROSS_COMPILE=aarch64-linux-gnu- target-image    Debian package of the loop for a board"
	@echo "make all            build build/berth and build/berth-loop"
	@echo "make CROSS_COMPILE=aarch64-linux-gnu- all    the same for arm64 in build/aarch64-linux-gnu"
	@echo "make codec          generate the CAN codec again from firmware/can/berth.dbc"
	@echo "make readme         run the commands shown in the README again and write what they print"
	@echo "make format lint    clang-format in place; clang-format, clang-tidy and shellcheck"

# --- what a user does ---------------------------------------------------------------------------------------------
run: setup
	@$(MAKE) all
	build/berth run ess --out build/runs
	@$(PYTHON) scripts/report.py build/runs/ess.ulg

test: setup-test
	@scripts/test.sh full

quick-test: setup-test
	@scripts/test.sh quick

slow-test: setup-test
	@$(MAKE) SANITIZE=1 build/sanitize/cpp_tests
	build/sanitize/cpp_tests -tce='no_side_effects*'
	@$(MAKE) all
	@$(PYTHON) -m pytest -q -ra -n $(shell nproc) -p no:cacheprovider -m slow tests/python

readme: setup
	@$(MAKE) all
	@$(PYTHON) scripts/readme.py

score: setup-test
	@$(MAKE) all
	@$(PYTHON) tests/hidden_effects/score.py --seed $(or $(SEED),6001) --count $(or $(COUNT),300)

bench: setup-test
	@$(MAKE) all build/tick_bench build/arm_bench build/arm_peers
	@$(PYTHON) scripts/bench.py
	@$(PYTHON) scripts/bench_arm.py
	@$(PYTHON) scripts/bench_map.py
	@$(PYTHON) scripts/bench_diagnose.py

map: setup
	@$(MAKE) all
	@for vary in elasticity mass; do build/berth map ess --vary $$vary || exit; done
	@$(PYTHON) scripts/map_picture.py build/maps/ess-elasticity.csv build/maps/ess-mass.csv

figures: setup
	@$(MAKE) all
	@$(PYTHON) scripts/figures.py

target: setup-target
	@$(MAKE) target-programs
	@$(PYTHON) -m pytest -q -ra -p no:cacheprovider tests/target

# Lines from the terminal run in the guest, until exit.
guest-shell: setup-target
	@scripts/guest/run.py --shell --arch $(or $(ARCH),arm64)

jitter: setup-target
	@$(MAKE) build/berth-target
	@scripts/jitter.sh

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
	@$(PYTHON) scripts/diagnosis_report.py build/diagnosis

setup:
	@scripts/setup.sh run

setup-target:
	@scripts/setup.sh target

setup-test:
	@scripts/setup.sh test

# --- programs -----------------------------------------------------------------------------------------------------
all: $(BUILD)/berth $(BUILD)/berth-loop

$(BUILD)/berth: $(call object,$(CLI)) $(LOOP_OBJECTS)
	@echo "link $@"
	@$(CXX) $(LDFLAGS) -o $@ $^ $(LIBRARIES)

$(BUILD)/berth-loop: $(call object,firmware/main.c) $(FAR_END_OBJECTS)
	@echo "link $@"
	@$(CXX) $(LDFLAGS) -o $@ $^ $(LIBRARIES)

$(BUILD)/cpp_tests: $(call object,$(CPP_TESTS)) $(LOOP_OBJECTS)
	@echo "link $@"
	@$(CXX) $(LDFLAGS) -o $@ $^ $(LIBRARIES)

$(BUILD)/berth-target: $(call object,firmware/main.c $(FIRMWARE) $(HAL) $(TARGET) build/rigs.cpp) $(EFFECTS) $(BUILD)/obj/gpio.o
	@echo "link $@"
	@$(CXX) $(LDFLAGS) -o $@ $^ $$($(PKG_CONFIG) --libs libgpiod) -pthread

# libgpiod's major version decides.
$(BUILD)/obj/gpio.o: hal/linux/gpio_v1.c hal/linux/gpio_v2.c hal/linux/gpio_lines.h | $(SYSROOT)
	@mkdir -p $(@D)
	@version=$$($(PKG_CONFIG) --modversion libgpiod) && file=hal/linux/gpio_v$${version%%.*}.c && echo "cc   $$file" && \
		$(COMPILED_C) $$($(PKG_CONFIG) --cflags libgpiod) -c $$file -o $@

build/%/sysroot:
	@scripts/sysroot.sh $@ $*

$(BUILD)/berth-rig: $(call object,$(FAR_END)) $(FAR_END_OBJECTS)
	@echo "link $@"
	@$(CXX) $(LDFLAGS) -o $@ $^ $(LIBRARIES)

$(BUILD)/arm_bench: $(call object,tests/bench/arm_bench.cpp) $(LOOP_OBJECTS)
	@echo "link $@"
	@$(CXX) $(LDFLAGS) -o $@ $^ $(LIBRARIES)

# Pinocchio and MuJoCo as their Python packages bring them, with their own flags.
PACKAGES = $(shell $(PYTHON) -c "import sysconfig; print(sysconfig.get_paths()['platlib'])")
build/arm_peers: tests/bench/arm_peers.cpp tests/bench/timed.h
	@echo "c++  $<"
	@$(CXX) -std=c++17 -O2 -DBOOST_MPL_LIMIT_LIST_SIZE=30 -DBOOST_MPL_CFG_NO_PREPROCESSED_HEADERS \
		-isystem /usr/include/eigen3 -isystem $(PACKAGES)/mujoco/include -isystem $(PACKAGES)/cmeel.prefix/include \
		-isystem tests/bench/pinocchio_lacks $< -o $@ \
		-L$(PACKAGES)/cmeel.prefix/lib -lpinocchio_default -lpinocchio_parsers $(wildcard $(PACKAGES)/mujoco/libmujoco.so.*) \
		-Wl,-rpath,$(PACKAGES)/cmeel.prefix/lib:$(PACKAGES)/mujoco

# One side of a CANopen bus, for peers in Python.
$(BUILD)/peer: $(call object,tests/peers/peer.cpp) $(FAR_END_OBJECTS)
	@echo "link $@"
	@$(CXX) $(LDFLAGS) -o $@ $^ $(LIBRARIES)

TARGET_TEST_OBJECTS := $(call object,$(TARGET_TESTS) $(TARGET) sim_hal/far_end/far_end.cpp) $(filter-out %/sim_hal.cpp.o,$(FAR_END_OBJECTS))
$(BUILD)/target_tests: $(TARGET_TEST_OBJECTS) $(BUILD)/obj/gpio.o
	@echo "link $@"
	@$(CXX) $(LDFLAGS) -o $@ $^ $$($(PKG_CONFIG) --libs libgpiod) $(LIBRARIES) -pthread

# The same with libgpiod 2, whatever the system has.
$(BUILD)/target_tests_gpiod2: $(TARGET_TEST_OBJECTS) $(BUILD)/obj/gpio2.o $(BUILD)/libgpiod2/libgpiod.a
	@echo "link $@"
	@$(CXX) $(LDFLAGS) -o $@ $^ $(LIBRARIES) -pthread

$(BUILD)/obj/gpio2.o: hal/linux/gpio_v2.c hal/linux/gpio_lines.h | $(BUILD)/libgpiod2/libgpiod.a
	@echo "cc   $<"
	@$(COMPILED_C) -isystem $(BUILD)/libgpiod2/include -c $< -o $@

$(BUILD)/libgpiod2/libgpiod.a: scripts/libgpiod2.sh
	@scripts/libgpiod2.sh $(@D) $(CROSS_COMPILE)

# What the guests run, for both architectures of `make target`.
GUEST_TRIPLETS := aarch64-linux-gnu x86_64-linux-gnu
target-programs:
	@$(MAKE) $(BUILD)/berth
	@for triplet in $(GUEST_TRIPLETS); do $(MAKE) CROSS_COMPILE=$$triplet- guest-programs || exit; done

guest-programs: $(BUILD)/berth-target $(BUILD)/berth-rig $(BUILD)/target_tests $(BUILD)/target_tests_gpiod2 target-image

target-image: $(BUILD)/berth-target
	@CROSS_COMPILE=$(CROSS_COMPILE) scripts/target_image.sh $(BUILD)

$(BUILD)/tick_bench: $(call object,$(BENCH)) $(LOOP_OBJECTS)
	@echo "link $@"
	@$(CXX) $(LDFLAGS) -o $@ $^ $(LIBRARIES)

build/rigs.cpp: scripts/embed_rigs.py $(RIGS)
	@mkdir -p $(@D)
	@python3 $< $@ $(RIGS)

COMPILED_C = $(CCACHE) $(CC) -std=c11 -D_GNU_SOURCE $(COMMON)
COMPILED_CXX = $(CCACHE) $(CXX) -std=c++17 $(COMMON) $(SIM_FLAGS)

$(BUILD)/obj/%.c.o: %.c | $(if $(CROSS_COMPILE),$(BUILD)/include)
	@mkdir -p $(@D)
	@echo "cc   $<"
	@$(COMPILED_C) -c $< -o $@

$(BUILD)/obj/%.cpp.o: %.cpp | $(if $(CROSS_COMPILE),$(BUILD)/include)
	@mkdir -p $(@D)
	@echo "c++  $<"
	@$(COMPILED_CXX) -c $< -o $@

# What a file calls its own may hide what another file of the batch does.
$(BUILD)/obj/%.cpp.o: $(BUILD)/batch/%.cpp | $(if $(CROSS_COMPILE),$(BUILD)/include)
	@mkdir -p $(@D)
	@echo "c++  $*.cpp"
	@$(COMPILED_CXX) -Wno-shadow -c $< -o $@

$(call object,$(TICK_PATH)): COMMON += $(ACROSS_FILES)

$(call object,$(CLI) $(filter-out sim_hal/hil/% sim_hal/plant/%,$(SIM)) $(CPP_TESTS)): COMMON += $(HOST_ONLY)

# A diagnosis replays a record some thousand times.
$(call object,$(filter sim_hal/diagnosis/% sim_hal/effects/% sim_hal/solver/%_steps.cpp,$(SIM))): COMMON += $(if $(SANITIZE)$(CROSS_COMPILE),,-O3 $(ACROSS_FILES))

# A target runs the loop and replays it: one diagnoses on a PC, and what is not optimised further is compiled sooner.
$(call object,$(CLI) $(filter sim_hal/diagnosis/% sim_hal/stability/% sim_hal/compensation/% sim_hal/arm/% sim_hal/rths/%,$(SIM))): COMMON += $(if $(CROSS_COMPILE),-O1)

# Maps evaluate millions of characteristic equations: unrolled, and complex products without a care for infinity.
$(call object,$(filter sim_hal/stability/%,$(SIM))): COMMON += $(if $(SANITIZE)$(CROSS_COMPILE),,-O3 -fcx-limited-range)

# The commit goes into one object, which is made again when it changes.
COMMIT := $(shell git describe --always --dirty --abbrev=12 2>/dev/null || echo unknown)
$(BUILD)/obj/hal/version.cpp.o: COMMON += -DBERTH_COMMIT='"$(COMMIT)"'
$(BUILD)/obj/hal/version.cpp.o: $(BUILD)/commit
$(BUILD)/commit: FORCE
	@mkdir -p $(@D)
	@echo '$(COMMIT)' | cmp -s - $@ || echo '$(COMMIT)' > $@
FORCE:

# Header-only libraries of the host that a cross compiler may see; its own system headers stay its own.
build/%/include:
	@mkdir -p $@
	@ln -sfn /usr/include/eigen3/Eigen $@/Eigen
	@ln -sfn /usr/include/eigen3/unsupported $@/unsupported
	@for library in toml++ CLI nlohmann doctest; do ln -sfn /usr/include/$$library $@/$$library; done

# --- the codec, committed as generated ----------------------------------------------------------------------------
codec: setup
	@scripts/codec.sh firmware/can

# --- care ---------------------------------------------------------------------------------------------------------
OWN_C := $(wildcard firmware/*.[ch] firmware/compensation/*.[ch] firmware/arm/*.c firmware/arm/arm_config.h firmware/arm/sine.h firmware/can/codec.h hal/*.[ch] hal/linux/*.c)
# Pinocchio's headers would be read along with arm_peers.cpp, for minutes.
OWN_CPP := $(filter-out tests/bench/arm_peers.cpp,$(wildcard firmware/*.cpp firmware/compensation/*.cpp firmware/arm/*.cpp hal/*.cpp hal/*/*.cpp hal/*/*.h sim_hal/*.cpp sim_hal/*.h sim_hal/*/*.cpp sim_hal/*/*.h sim_hal/*/*/*.cpp sim_hal/*/*/*.h tests/*/*.cpp tests/*/*.h))

format: setup-test
	@clang-format -i $(OWN_C) $(OWN_CPP)

lint: setup-test
	@scripts/lint.sh $(OWN_C) $(OWN_CPP)

clean:
	rm -rf build

-include $(shell find $(BUILD)/obj -name '*.d' 2>/dev/null)

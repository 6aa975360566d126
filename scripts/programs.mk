# Sources, flags and how the programs are linked. Variables that change what is built:
#   CROSS_COMPILE=aarch64-linux-gnu-   for another machine, in build/aarch64-linux-gnu
#   SANITIZE=1                         with address and undefined-behaviour sanitizers, in build/sanitize
#   FUZZ=1                             the same with what libFuzzer has to see, in build/fuzz
#   WERROR=1                           warnings are errors, as in our own tests
#   FILE_BY_FILE=1                     each file by itself, which rebuilds less after a small edit
CROSS_COMPILE ?=
SANITIZE ?=
FUZZ ?=
WERROR ?=
FILE_BY_FILE ?=
ifneq ($(CROSS_COMPILE),)
BUILD := build/$(CROSS_COMPILE:%-=%)
else ifneq ($(FUZZ),)
BUILD := build/fuzz
SANITIZE := 1
else ifneq ($(SANITIZE),)
BUILD := build/sanitize
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
MAKEFLAGS += --no-print-directory
ifeq ($(MAKELEVEL),0)
MAKEFLAGS += -j$(shell nproc)
endif

# --- sources: a folder is listed, a new file in it is built ------------------------------------------------------
sources = $(wildcard $(foreach folder,$(1),$(folder)/*.c $(folder)/*.cpp))
FIRMWARE := $(filter-out firmware/main.c,$(call sources,firmware $(addprefix firmware/,can compensation arm)))
HAL := $(call sources,hal hal/rig)
EFFECTS := $(call sources,sim_hal/effects)
# The rig in virtual time, and what only looks at it.
RIG_IN_TIME := $(call sources,$(addprefix sim_hal/,hil plant solver))
LOOKS := $(call sources,sim_hal $(addprefix sim_hal/,stability compensation commission log rths arm diagnosis) $(wildcard sim_hal/diagnosis/*))
CLI := $(call sources,sim_hal/cli)
TARGET := $(wildcard hal/linux/*.cpp)
FAR_END := $(call sources,sim_hal/far_end) hal/linux/can_socket.cpp hal/linux/can_link.cpp
RIGS := $(wildcard sim_hal/rigs/*.toml sim_hal/robots/*.toml sim_hal/arms/*.toml)
CPP_TESTS := $(call sources,$(addprefix tests/,unit theory contract scenarios))
TARGET_TESTS := $(call sources,tests/linux) tests/contract/hal_test.cpp tests/unit/main.cpp
ifneq ($(CROSS_COMPILE),)
# SUNDIALS and tinyxml2 are for the host only.
RIG_IN_TIME := $(filter-out %/cvode_solver.cpp,$(RIG_IN_TIME))
LOOKS := $(filter-out sim_hal/arm/urdf%,$(LOOKS))
endif

# The files of a folder are compiled a batch at a time: headers, Eigen's above all, take most of the time.
ifeq ($(FILE_BY_FILE),)
# Other programs link these without their folders, or they have flags of their own.
ALONE := tests/unit/main.cpp tests/contract/hal_test.cpp sim_hal/hil/sim_hal.cpp sim_hal/solver/decompositions.cpp hal/version.cpp \
	$(wildcard sim_hal/solver/*_steps.cpp)
# Before the set-up there may be no Python.
in_batches = $(filter $(ALONE) %.c,$(1)) \
	$(if $(shell command -v python3),$(shell scripts/batches.py $(BUILD)/batch $(filter-out $(ALONE) %.c,$(1))))
HAL := $(call in_batches,$(HAL))
EFFECTS := $(call in_batches,$(EFFECTS))
RIG_IN_TIME := $(call in_batches,$(RIG_IN_TIME))
LOOKS := $(call in_batches,$(LOOKS))
CLI := $(call in_batches,$(CLI))
CPP_TESTS := $(call in_batches,$(CPP_TESTS))
TARGET_TESTS := $(call in_batches,$(TARGET_TESTS))
endif

# --- flags --------------------------------------------------------------------------------------------------------
# The firmware gives the same bits on every machine: no fused multiply-add, no vectorised Eigen (its packets may be
# fused), and one set of Eigen macros for the whole program, so that a template means one thing.
ARITHMETIC := -ffp-contract=off -fno-math-errno -DEIGEN_DONT_VECTORIZE -DEIGEN_RUNTIME_NO_MALLOC
# In a batch a local variable may have the name of another file's function, and clang knows no lesser -Wshadow.
WARNINGS := -Wall -Wextra $(if $(FILE_BY_FILE),-Wshadow,$(if $(SANITIZE),,-Wshadow=local)) $(if $(WERROR),-Werror)
COMMON = -O2 -g1 $(ARITHMETIC) $(WARNINGS) -MMD -MP -I.
LIBRARIES :=
LDFLAGS := -O2
PKG_CONFIG := pkg-config
ifeq ($(CROSS_COMPILE),)
COMMON += -isystem /usr/include/eigen3
# The Python module is of the same objects. Hidden, what they call of each other is called directly all the same.
COMMON += -fPIC -fvisibility=hidden
SIM_FLAGS := -DBERTH_WITH_SUNDIALS -DBERTH_WITH_ZLIB -DBERTH_WITH_URDF
# From its version 7 on, SUNDIALS keeps what all its parts share in a library of its own, and where it was built with MPI
# its headers want that.
LIBRARIES += -lsundials_cvode -lsundials_nvecserial -lsundials_sunnonlinsolfixedpoint
ifneq ($(wildcard /usr/lib/*/libsundials_core.so),)
LIBRARIES += -lsundials_core $(shell pkg-config --libs mpi 2>/dev/null)
COMMON += $(patsubst -I%,-isystem %,$(shell pkg-config --cflags-only-I mpi 2>/dev/null))
endif
LIBRARIES += -lz -ltinyxml2
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
ifneq ($(FUZZ),)
COMMON += -fsanitize=fuzzer-no-link
endif

object = $(patsubst %,$(BUILD)/obj/%.o,$(1))
optimised = $(if $(SANITIZE)$(CROSS_COMPILE),,$(1))

# What runs at every tick is optimised across its files as it is linked: codec, buses and channels are many small
# functions. Programs that only test it share one object of it, which is an eighth slower and made once; in one partition,
# as with several GCC 12 fails inside. Sanitizers look at each file by itself.
TICK := $(call object,$(FIRMWARE) $(filter-out hal/rig/% hal/version.cpp,$(HAL)))
TICK_AND_RIG := $(TICK) $(call object,$(RIG_IN_TIME))
RIG_FILES := $(call object,$(filter hal/rig/% hal/version.cpp,$(HAL)) $(EFFECTS) build/rigs.cpp)
ONCE_TICK := $(TICK)
ONCE_TICK_AND_RIG := $(TICK_AND_RIG)
FAR_RIG := $(filter-out %/hil/sim_hal.cpp.o,$(call object,$(RIG_IN_TIME)))
ifeq ($(SANITIZE),)
$(TICK_AND_RIG): COMMON += -flto
$(addprefix $(BUILD)/,berth berth-loop berth-target tick_bench): LDFLAGS += -flto=auto
ONCE := $(addprefix $(BUILD)/obj/,tick.o tick_and_rig.o far_rig.o)
$(BUILD)/obj/tick.o: $(TICK)
$(BUILD)/obj/tick_and_rig.o: $(TICK_AND_RIG)
$(BUILD)/obj/far_rig.o: $(FAR_RIG)
$(ONCE):
	@echo "lto  $@"
	@$(CXX) -O2 -flto -flto-partition=one -r -flinker-output=nolto-rel -o $@ $^
ONCE_TICK := $(BUILD)/obj/tick.o
ONCE_TICK_AND_RIG := $(BUILD)/obj/tick_and_rig.o
FAR_RIG := $(BUILD)/obj/far_rig.o
endif

$(call object,$(CLI) $(EFFECTS) $(RIG_IN_TIME) $(LOOKS) $(CPP_TESTS)): COMMON += $(HOST_ONLY)
# The command prints and parses; libraries made of templates compile sooner this way.
$(call object,$(CLI)): COMMON += -O1
# A diagnosis replays a record some thousand times.
$(call object,$(EFFECTS) $(filter sim_hal/diagnosis/% sim_hal/solver/%_steps.cpp,$(RIG_IN_TIME) $(LOOKS))): COMMON += $(call optimised,-O3)
# Maps evaluate millions of characteristic equations: unrolled, and complex products without a care for infinity.
$(call object,$(filter sim_hal/stability/%,$(LOOKS))): COMMON += $(call optimised,-O3 -fcx-limited-range)

COMPILED_C = $(CCACHE) $(CC) -std=c11 -D_GNU_SOURCE $(COMMON)
COMPILED_CXX = $(CCACHE) $(CXX) -std=c++17 $(COMMON) $(SIM_FLAGS)
COMPILE = @mkdir -p $(@D); echo "$(1)  $(patsubst $(BUILD)/batch/%,%,$<)"; $(2) -c $< -o $@
OBJECT_NEEDS = scripts/programs.mk | $(if $(CROSS_COMPILE),$(BUILD)/include)

$(BUILD)/obj/%.c.o: %.c $(OBJECT_NEEDS)
	$(call COMPILE,cc ,$(COMPILED_C))

$(BUILD)/obj/%.cpp.o: %.cpp $(OBJECT_NEEDS)
	$(call COMPILE,c++,$(COMPILED_CXX))

$(BUILD)/obj/%.cpp.o: $(BUILD)/batch/%.cpp $(OBJECT_NEEDS)
	$(call COMPILE,c++,$(COMPILED_CXX))

# --- programs -----------------------------------------------------------------------------------------------------
.PHONY: all mutants-command FORCE
LINK = @echo "link $@"; $(CXX) $(LDFLAGS) -o $@ $(filter %.o %.a,$^)
GPIO_LIBRARY = $$($(PKG_CONFIG) --libs libgpiod)

$(BUILD)/berth: $(call object,$(CLI) $(LOOKS)) $(TICK_AND_RIG) $(RIG_FILES)
	$(LINK) $(LIBRARIES)

# The loop and its simulated rig, here or at the far end, without what looks at them.
$(BUILD)/berth-loop: $(call object,firmware/main.c) $(TICK_AND_RIG) $(RIG_FILES)
	$(LINK) $(LIBRARIES)

$(BUILD)/berth-rig: $(call object,$(FAR_END)) $(ONCE_TICK_AND_RIG) $(RIG_FILES)
	$(LINK) $(LIBRARIES)

$(BUILD)/berth-target: $(call object,firmware/main.c $(TARGET)) $(TICK) $(RIG_FILES) $(BUILD)/obj/gpio.o
	$(LINK) $(GPIO_LIBRARY) -pthread

$(BUILD)/cpp_tests: $(call object,$(CPP_TESTS) $(LOOKS)) $(ONCE_TICK_AND_RIG) $(RIG_FILES)
	$(LINK) $(LIBRARIES)

# For scripts/mutants.py: how a file of the firmware is compiled, and how the tests are linked of what.
mutants-command: $(BUILD)/cpp_tests
	@echo '$(filter-out ccache %/ccache -MMD -MP,$(COMPILED_C))'
	@echo '$(CXX) $(LDFLAGS) -- $(filter %.o,$(call object,$(CPP_TESTS) $(LOOKS)) $(ONCE_TICK_AND_RIG) $(RIG_FILES)) $(LIBRARIES)'

TARGET_TEST_OBJECTS := $(call object,$(TARGET_TESTS) $(TARGET) sim_hal/far_end/far_end.cpp) $(ONCE_TICK) $(FAR_RIG) $(RIG_FILES)
$(BUILD)/target_tests: $(TARGET_TEST_OBJECTS) $(BUILD)/obj/gpio.o
	$(LINK) $(GPIO_LIBRARY) $(LIBRARIES) -pthread

# The same with libgpiod 2, whatever the system has.
$(BUILD)/target_tests_gpiod2: $(TARGET_TEST_OBJECTS) $(BUILD)/obj/gpio2.o $(BUILD)/libgpiod2/libgpiod.a
	$(LINK) $(LIBRARIES) -pthread

# One side of a CANopen bus, for peers in Python.
$(BUILD)/peer: $(call object,tests/peers/peer.cpp) $(ONCE_TICK_AND_RIG) $(RIG_FILES)
	$(LINK) $(LIBRARIES)

# Readers of files under libFuzzer: with SANITIZE=1 it sees no way through the code but this file's, with FUZZ=1 all.
$(call object,tests/fuzz/parsers.cpp): COMMON += -fsanitize=fuzzer-no-link
$(BUILD)/parsers: $(call object,tests/fuzz/parsers.cpp $(LOOKS)) $(ONCE_TICK_AND_RIG) $(RIG_FILES)
	$(LINK) -fsanitize=fuzzer $(LIBRARIES)

# What another architecture is asked for: to run a rig and to replay a log.
$(BUILD)/replay: $(call object,tests/peers/replay.cpp $(filter sim_hal/log/%,$(LOOKS))) $(ONCE_TICK_AND_RIG) $(RIG_FILES)
	$(LINK) $(LIBRARIES)

$(BUILD)/tick_bench $(BUILD)/arm_bench $(BUILD)/campaign_bench: $(BUILD)/%_bench: $(BUILD)/obj/tests/bench/%_bench.cpp.o $(call object,$(LOOKS)) $(TICK_AND_RIG) $(RIG_FILES)
	$(LINK) $(LIBRARIES)

# Pinocchio and MuJoCo as their Python packages bring them, with their own flags.
PACKAGES = $(shell $(PYTHON) -c "import sysconfig; print(sysconfig.get_paths()['platlib'])")
build/arm_peers: tests/bench/arm_peers.cpp tests/bench/timed.h
	@echo "c++  $<"
	@$(CXX) -std=c++17 -O2 -DBOOST_MPL_LIMIT_LIST_SIZE=30 -DBOOST_MPL_CFG_NO_PREPROCESSED_HEADERS \
		-isystem /usr/include/eigen3 -isystem $(PACKAGES)/mujoco/include -isystem $(PACKAGES)/cmeel.prefix/include \
		-isystem tests/bench/pinocchio_lacks $< -o $@ \
		-L$(PACKAGES)/cmeel.prefix/lib -lpinocchio_default -lpinocchio_parsers $(wildcard $(PACKAGES)/mujoco/libmujoco.so.*) \
		-Wl,-rpath,$(PACKAGES)/cmeel.prefix/lib:$(PACKAGES)/mujoco

# --- what is made before it is compiled ---------------------------------------------------------------------------
# libgpiod's major version decides.
$(BUILD)/obj/gpio.o: hal/linux/gpio_v1.c hal/linux/gpio_v2.c hal/linux/gpio_lines.h | $(SYSROOT)
	@mkdir -p $(@D)
	@version=$$($(PKG_CONFIG) --modversion libgpiod) && file=hal/linux/gpio_v$${version%%.*}.c && echo "cc   $$file" && \
		$(COMPILED_C) $$($(PKG_CONFIG) --cflags libgpiod) -c $$file -o $@

$(BUILD)/obj/gpio2.o: hal/linux/gpio_v2.c hal/linux/gpio_lines.h | $(BUILD)/libgpiod2/libgpiod.a
	@echo "cc   $<"
	@$(COMPILED_C) -isystem $(BUILD)/libgpiod2/include -c $< -o $@

$(BUILD)/libgpiod2/libgpiod.a: scripts/libgpiod2.sh
	@scripts/libgpiod2.sh $(@D) $(CROSS_COMPILE)

.PRECIOUS: build/%/include build/%/sysroot
build/%/sysroot:
	@scripts/sysroot.sh $@ $*

# Header-only libraries of the host that a cross compiler may see; its own system headers stay its own.
build/%/include:
	@mkdir -p $@
	@ln -sfn /usr/include/eigen3/Eigen $@/Eigen
	@ln -sfn /usr/include/eigen3/unsupported $@/unsupported
	@for library in toml++ CLI nlohmann doctest; do ln -sfn /usr/include/$$library $@/$$library; done

build/rigs.cpp: scripts/embed_rigs.py $(RIGS)
	@mkdir -p $(@D)
	@python3 $< $@ $(RIGS)

# The commit goes into one object, which is made again when it changes.
COMMIT := $(shell git describe --always --dirty --abbrev=12 2>/dev/null || echo unknown)
$(BUILD)/obj/hal/version.cpp.o: COMMON += -DBERTH_COMMIT='"$(COMMIT)"'
$(BUILD)/obj/hal/version.cpp.o: $(BUILD)/commit
$(BUILD)/commit: FORCE
	@mkdir -p $(@D)
	@echo '$(COMMIT)' | cmp -s - $@ || echo '$(COMMIT)' > $@
FORCE:

-include $(shell find $(BUILD)/obj -name '*.d' 2>/dev/null)

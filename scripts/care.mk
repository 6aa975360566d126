# What keeps the code in order.
.PHONY: codec format lint mutants

#: make codec          generate the CAN codec again from firmware/can/berth.dbc
codec: setup
	@scripts/codec.sh firmware/can

# Generated code is not among them. Pinocchio's headers would be read along with arm_peers.cpp, for minutes.
OWN := $(wildcard firmware/*.[ch] firmware/compensation/*.[ch] firmware/arm/*.c firmware/arm/arm_config.h firmware/arm/sine.h \
	firmware/can/codec.h hal/*.[ch] hal/linux/*.c firmware/*.cpp firmware/compensation/*.cpp firmware/arm/*.cpp \
	hal/*.cpp hal/*/*.cpp hal/*/*.h $(addprefix sim_hal/,*.cpp *.h */*.cpp */*.h */*/*.cpp */*/*.h) tests/*/*.cpp tests/*/*.h)
OWN := $(filter-out tests/bench/arm_peers.cpp,$(OWN))

#: make format lint    clang-format in place; clang-format, clang-tidy, shellcheck and the rules of the house
format: setup-test
	@clang-format -i $(OWN)

lint: setup-test
	@scripts/lint.sh $(OWN)

#: make compile_commands.json   how each file is compiled, for editors (clangd)
COMPILE_COMMANDS ?= compile_commands.json
compile_commands.json: scripts/compile_commands.py scripts/programs.mk FORCE
	@python3 $< '$(COMPILED_C)' '$(COMPILED_CXX) -DBERTH_COMMIT="editor"' > $(COMPILE_COMMANDS)

#: make mutants        how many small mistakes in the safety units the C++ tests notice (COUNT=25 of each file)
mutants: setup-test
	@$(PYTHON) scripts/mutants.py --count $(or $(COUNT),25)

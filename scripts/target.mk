# The loop on real-time kernels in QEMU, and the package for a board.
.PHONY: target target-programs guest-programs target-image guest-shell setup-target

#: make target         the loop on real-time kernels in QEMU, arm64 and amd64, over real CAN and GPIO drivers
target: setup-target
	@$(MAKE) target-programs
	@$(PYTHON) -m pytest -q -ra -p no:cacheprovider tests/target

#: make CROSS_COMPILE=aarch64-linux-gnu- target-image    Debian package of the loop for a board
target-image: $(BUILD)/berth-target
	@CROSS_COMPILE=$(CROSS_COMPILE) scripts/target_image.sh $(BUILD)

#: make guest-shell    lines from the terminal run in the guest, until exit (ARCH=arm64 or amd64)
guest-shell: setup-target
	@scripts/guest/run.py --shell --arch $(or $(ARCH),arm64)

# What the guests run, for both architectures of `make target`.
GUEST_TRIPLETS := aarch64-linux-gnu x86_64-linux-gnu
target-programs:
	@$(MAKE) $(BUILD)/berth
	@for triplet in $(GUEST_TRIPLETS); do $(MAKE) CROSS_COMPILE=$$triplet- guest-programs || exit; done

guest-programs: $(BUILD)/berth-target $(BUILD)/berth-rig $(BUILD)/target_tests $(BUILD)/target_tests_gpiod2 target-image

setup-target:
	@scripts/setup.sh target

.PHONY: demo figures test test-python test-view test-web bench bench-smoke ci

# The soft hand pressed on a cylinder; pictures, GLB and report in out/hand_press.
# `make demo ARGS=--allow-software` takes a software adapter where there is no GPU.
demo:
	cargo run --release -p supple-cli -- simulate assets/scenes/hand_press.toml -o out/hand_press $(ARGS)

# Every figure of the paper as a scene that is run, drawn and checked: a gallery in out/figures.
# `make figures ARGS="--only finger_slide"` makes one of them.
figures:
	cargo run --release -p supple-lab -- -o out/figures $(ARGS)

# Installs a software Vulkan driver if there is no driver (Debian), then runs every test.
test:
	.ci/install-vulkan
	cargo test --workspace
	@echo "The packages have tests of their own: make test-python, make test-web."

# Builds the Python package into python/.venv, and runs its tests.
test-python:
	.ci/test-python

# Drives the window of `supple view` under Xvfb, which it installs on Debian.
test-view:
	.ci/test-view

# Builds the npm package's wasm, and runs its tests in Node and in headless Chromium, which it installs on Debian.
# `make test-web COMPARE=1` builds it without SIMD as well, and times both.
test-web:
	COMPARE=$(COMPARE) .ci/test-web

bench:
	cargo bench

bench-smoke:
	cargo bench --profile dev -- --test

ci:
	.ci/run

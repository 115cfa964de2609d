# Two commands for a fresh Debian 12: `make demo` and `make test`. Everything else is CMake.
BUILD := build
JOBS  ?= $(shell nproc)
CMAKE_FLAGS ?= --preset dev

.PHONY: all build demo test sanitize packages clean

all: build

packages:
	@cmake/install-packages.sh cmake/debian-packages.txt

build: packages
	@cmake $(CMAKE_FLAGS) -B $(BUILD) >$(BUILD).log 2>&1 || { cat $(BUILD).log; exit 1; }
	@cmake --build $(BUILD) -j $(JOBS)

demo: build
	@examples/demo.sh $(BUILD)/bin/veridyn out/demo

test: build
	@ctest --test-dir $(BUILD) --output-on-failure -j $(JOBS)

# The second test configuration: address and undefined-behaviour sanitizers.
sanitize: packages
	@cmake --preset asan
	@cmake --build build-asan -j $(JOBS)
	@ctest --test-dir build-asan --output-on-failure -j $(JOBS)

clean:
	rm -rf build build-asan out

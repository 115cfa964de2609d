# Two commands for a fresh Debian 12: `make demo` and `make test`. Everything else is CMake.
BUILD := build
JOBS  ?= $(shell nproc)
CMAKE_FLAGS ?= --preset dev

.PHONY: all tool build demo test test-long python notebooks wheel ros ros-test mpi growth deb release build-times readme docs causes thesis bare sanitize coverage races fuzz memcheck mutants symbols bill tidy packages packages-all packages-tests clean

# The tool and the programs of packages/dvrk, packages/cooperation and packages/calibration.
all: packages-all
	@cmake $(CMAKE_FLAGS) -B $(BUILD) -DVERIDYN_TESTS=OFF -DVERIDYN_BENCHMARKS=OFF $(ALL_PACKAGES) >$(BUILD).log 2>&1 || { cat $(BUILD).log; exit 1; }
	@cmake --build $(BUILD) -j $(JOBS) --target veridyn_programs

ALL_PACKAGES := "-DVERIDYN_BUILD_PACKAGES=dvrk;cooperation;calibration"

packages:
	@cmake/install-packages.sh cmake/debian-packages.txt

packages-all:
	@cmake/install-packages.sh cmake/debian-packages.txt cmake/debian-packages-packages.txt

packages-tests:
	@cmake/install-packages.sh cmake/debian-packages.txt cmake/debian-packages-packages.txt cmake/debian-packages-tests.txt cmake/debian-packages-python.txt cmake/debian-packages-deb.txt

# The library's tool alone; what packages, tests and Python need is neither installed nor built.
tool: packages
	@cmake $(CMAKE_FLAGS) -B $(BUILD) -DVERIDYN_TESTS=OFF -DVERIDYN_BENCHMARKS=OFF -DVERIDYN_PYTHON=OFF -DVERIDYN_BUILD_PACKAGES=NONE >$(BUILD).log 2>&1 || { cat $(BUILD).log; exit 1; }
	@cmake --build $(BUILD) -j $(JOBS) --target veridyn_tool

build: packages-tests
	@cmake $(CMAKE_FLAGS) -B $(BUILD) -DVERIDYN_TESTS=ON -DVERIDYN_BENCHMARKS=ON -DVERIDYN_PYTHON=ON $(ALL_PACKAGES) >$(BUILD).log 2>&1 || { cat $(BUILD).log; exit 1; }
	@cmake --build $(BUILD) -j $(JOBS)

# The Python module, in $(BUILD)/python, which holds the library; see docs/python.md.
python: packages-all
	@cmake/install-packages.sh cmake/debian-packages-python.txt
	@cmake $(CMAKE_FLAGS) -B $(BUILD) -DVERIDYN_PYTHON=ON -DBUILD_SHARED_LIBS=OFF $(ALL_PACKAGES) >$(BUILD).log 2>&1 || { cat $(BUILD).log; exit 1; }
	@cmake --build $(BUILD) -j $(JOBS) --target veridyn_python
	@echo "import veridyn works with PYTHONPATH=$(BUILD)/python"

# The notebooks' outputs, stored in them; needs what tests need.
notebooks: python packages-tests
	@PYTHONPATH=$(BUILD)/python /usr/bin/python3 python/notebooks/run.py python/notebooks/*.ipynb

# A wheel of the Python module for this machine's Python, in $(BUILD)/wheel; pip installs it without a compiler.
wheel: python
	@cmake/install-packages.sh cmake/debian-packages-wheel.txt
	@rm -rf $(BUILD)/wheel
	@VERIDYN_BUILD_DIR=$(abspath $(BUILD)) /usr/bin/python3 -m pip wheel --quiet --no-build-isolation --no-deps --no-index -w $(BUILD)/wheel .
	@ls $(BUILD)/wheel/*.whl

# The ROS 1 packages, in $(BUILD)/ros; see packages/ros/docs/ros.md. The library never needs them.
ros: all
	@cmake/install-packages.sh cmake/debian-packages-ros.txt
	@cmake --build $(BUILD) -j $(JOBS) --target veridyn_libraries
	@packages/ros/build.sh $(BUILD) $(JOBS)

# A laboratory's client against a master of its own; says so where ROS is absent.
ros-test: ros
	@packages/ros/test.sh $(BUILD)

# The same tool for mpirun; see docs/scale.md. In a folder that is built already only one file is compiled anew.
mpi: packages
	@cmake/install-packages.sh cmake/debian-packages-mpi.txt
	@cmake $(CMAKE_FLAGS) -B $(BUILD) -DVERIDYN_MPI=ON >$(BUILD).log 2>&1 || { cat $(BUILD).log; exit 1; }
	@cmake --build $(BUILD) -j $(JOBS) --target veridyn_tool
	@echo "mpirun -n N $(BUILD)/bin/veridyn identify ... spreads recordings over N ranks"

# Time and memory by rows, recordings, joints and bodies: docs/growth.json and docs/growth.svg. Three minutes on a quiet machine; EARLIER=TOOL runs beside.
growth: build
	@python3 tests/benchmark/growth.py $(BUILD)/bin/veridyn --benchmark $(BUILD)/bin/veridyn-benchmark \
	  $(if $(EARLIER),--beside $(EARLIER)) --json docs/growth.json --svg docs/growth.svg

# Debian packages in $(BUILD)/debs, as cmake/packages.cmake lists them. The library becomes shared: in a folder that is built
# already it is linked anew, and nothing is compiled.
deb: packages-all
	@cmake/install-packages.sh cmake/debian-packages-python.txt cmake/debian-packages-deb.txt
	@cmake $(CMAKE_FLAGS) -B $(BUILD) -DVERIDYN_PYTHON=ON -DBUILD_SHARED_LIBS=ON $(ALL_PACKAGES) >$(BUILD).log 2>&1 || { cat $(BUILD).log; exit 1; }
	@cmake --build $(BUILD) -j $(JOBS) --target veridyn_programs --target veridyn_python --target veridyn_libraries
	@rm -rf $(BUILD)/debs
	@cd $(BUILD) && cpack -B debs >cpack.log 2>&1 || { cat cpack.log; exit 1; }
	@ls $(BUILD)/debs/*.deb
	@if command -v lintian >/dev/null; then lintian --allow-root $(BUILD)/debs/*.deb; fi

# What a version publishes, in $(BUILD)/release: made of the last commit, and tried on a bare Debian root.
release:
	@MAKE="$(MAKE)" cmake/release.sh $(BUILD)

# The book as a site with search and the reference of the C++ headers: $(BUILD)/site/html/index.html. Dead links are errors.
docs:
	@cmake/install-packages.sh cmake/debian-packages-docs.txt
	@VERIDYN=$(BUILD)/bin/veridyn docs/build-site.sh $(BUILD)/site

# The pictures of docs/causes.md: what each cause adds to a torque, by `veridyn simulate`.
causes: tool
	@docs/causes.py $(BUILD)/bin/veridyn

# The thesis's tables and figures beside ours: docs/thesis-figures.md, made anew.
thesis:
	@$(MAKE) --no-print-directory readme PAGES=docs/thesis-figures.md

# Seconds of each unit of the last build in $(BUILD), the longest first; UNITS=40 of them, and the sum.
build-times:
	@awk -F'\t' '!/^#/ {took[$$4] = $$2 - $$1} END {for (unit in took) {sum += took[unit]; printf "%8.1f s  %s\n", took[unit] / 1000, unit}; \
	  printf "%8.1f s  all, over the jobs that ran side by side\n", sum / 1000}' $(BUILD)/.ninja_log | sort -rn | head -n $$(($(or $(UNITS),40) + 1))

# Every list of packages in cmake/ and the Dockerfile, tried in a bare Debian root; as root.
bare: build
	@for what in root tool tests python mpi ros docs docker; do tests/bare/bare_debian.sh $(BUILD) $$what || exit 1; done

demo: tool
	@examples/demo.sh $(BUILD)/bin/veridyn out/demo

# What fails beside other tests runs a second time alone: a wrong result fails twice, a machine that is too busy does not.
test: build
	@ctest --test-dir $(BUILD) --output-on-failure -j $(JOBS) || \
	  { tests/summary.sh $(BUILD); echo "Again, one at a time:"; ctest --test-dir $(BUILD) --output-on-failure --rerun-failed; }
	@tests/summary.sh $(BUILD)

# Every test, with those that take tens of minutes: each package by itself on the installed library, and bare Debian roots.
test-long: test
	@cmake -DVERIDYN_PACKAGES_ALONE=ON -DVERIDYN_BARE=ON -B $(BUILD) >$(BUILD).log 2>&1 || { cat $(BUILD).log; exit 1; }
	@ctest --test-dir $(BUILD) --output-on-failure -L 'long|bare'
	@cmake -DVERIDYN_PACKAGES_ALONE=OFF -DVERIDYN_BARE=OFF -B $(BUILD) >$(BUILD).log

# Blocks of the README and of the pages below, made anew by the commands in them; tests compare them.
PAGES ?= README.md docs/own-robot.md
readme: all python
	@for page in $(PAGES); do PATH="$(CURDIR)/$(BUILD)/bin:/usr/bin:$$PATH" VERIDYN_SOURCE="$(CURDIR)" \
	  /usr/bin/python3 tests/readme/blocks.py write $$page out/readme || exit 1; done

# The second test configuration, by clang: address and undefined-behaviour sanitizers, all rooms or ROOM="recordings model ...";
# SANITIZER=tsan: the thread sanitizer.
SANITIZER ?= asan
sanitize: packages-tests
	@cmake/install-packages.sh cmake/debian-packages-fuzz.txt
	@cmake --preset $(SANITIZER)
	@cmake --build build-$(SANITIZER) -j $(JOBS) $(addprefix --target test_,$(ROOM))
	@echo "$(SANITIZER): $(or $(ROOM),all rooms)"
	@ASAN_OPTIONS=allocator_may_return_null=1 \
	  ctest --test-dir build-$(SANITIZER) --output-on-failure -j $(JOBS) $(if $(ROOM),-R "^($$(echo $(ROOM) | tr ' ' '|'))/")

# Lines, functions and branches that the tests of ROOM="control dvrk ..." (default: all) run of src/ROOM, or of SHOW="dvrk";
# build-coverage/coverage/index.html has the source.
coverage: packages-tests
	@cmake/install-packages.sh cmake/debian-packages-fuzz.txt
	@cmake --preset coverage >build-coverage.log 2>&1 || { cat build-coverage.log; exit 1; }
	@cmake --build build-coverage -j $(JOBS) $(addprefix --target test_,$(ROOM))
	@LLVM_PROFILE_FILE=$(CURDIR)/build-coverage/profiles/%4m.profraw \
	  ctest --test-dir build-coverage --output-on-failure -j $(JOBS) $(if $(ROOM),-R "^($$(echo $(ROOM) | tr ' ' '|'))/")
	@tests/coverage.sh build-coverage $(or $(SHOW),$(ROOM))

# The tests that start threads, as they are built, under valgrind's helgrind: races and locks in two orders. Nothing is compiled.
races: build
	@cmake/install-packages.sh cmake/debian-packages-fuzz.txt
	@tests/races/run.sh $(BUILD)

# The fuzzer of all readers, each for SECONDS from seeds and tests/fuzz/corpus, or TARGETS alone; findings in $(BUILD)/fuzz/findings.
SECONDS ?= 600
fuzz: build
	@cmake/install-packages.sh cmake/debian-packages-fuzz.txt
	@cmake -G Ninja -S tests/fuzz -B $(BUILD)/fuzz -DCMAKE_CXX_COMPILER=clang++ -DVERIDYN_BUILD=$(abspath $(BUILD)) >$(BUILD)-fuzz.log 2>&1 || { cat $(BUILD)-fuzz.log; exit 1; }
	@cmake --build $(BUILD)/fuzz -j $(JOBS)
	@tests/fuzz/run.sh $(BUILD)/fuzz $(SECONDS) $(TARGETS)

# The rooms' tests under valgrind, as they are built: slower than sanitizers, and nothing is compiled. ROOMS="math model ...".
ROOMS ?= math model recordings fuzz out_of_memory control dvrk
memcheck: build
	@cmake/install-packages.sh cmake/debian-packages-fuzz.txt
	@for room in $(ROOMS); do echo "test_$$room"; valgrind -q --error-exitcode=9 --leak-check=full --errors-for-leak-kinds=definite \
	  $(BUILD)/bin/test_$$room --gtest_brief=1 || exit 1; done

# Small breaks of the sources, each of which tests must notice; survivors are listed. ROOM="watch dvrk_io ...".
mutants: build
	@python3 tests/mutants/mutants.py $(BUILD) $(ROOM)

# clang-tidy with the checks of .clang-tidy and clang's warnings, over all units of the build or SOURCES="src/control/*.cpp".
TIDY_UNITS = sed -n 's/^ *"file": "\(.*\)",*$$/\1/p' $(BUILD)/tidy/compile_commands.json | grep -v -e /tests/ -e cmake_pch -e page_files
tidy: build
	@cmake/install-packages.sh cmake/debian-packages-fuzz.txt
	@mkdir -p $(BUILD)/tidy && sed 's/-Winvalid-pch//g; s/-include [^ ]*cmake_pch.hxx//g' $(BUILD)/compile_commands.json >$(BUILD)/tidy/compile_commands.json
	@$(if $(SOURCES),printf '%s\n' $(SOURCES),$(TIDY_UNITS)) | xargs -n 1 -P $(JOBS) clang-tidy -p $(BUILD)/tidy --quiet \
	  --extra-arg=-Qunused-arguments --extra-arg=-Wno-unknown-warning-option --extra-arg=-Wconversion --extra-arg=-Wno-sign-conversion

# Functions that programs link with, in tests/structure/symbols.txt; a test notices one that went away.
symbols: build
	@python3 tests/structure/symbols.py write $(BUILD)

# What the tool is made of, with versions and licences (CycloneDX): $(BUILD)/veridyn.cdx.json.
bill: tool
	@python3 cmake/bill_of_materials.py $(BUILD)/bin/veridyn $$(sed -n 's/^project(veridyn VERSION \([0-9.]*\).*/\1/p' CMakeLists.txt) $(BUILD)/veridyn.cdx.json
	@echo $(BUILD)/veridyn.cdx.json

clean:
	rm -rf build build-asan build-coverage build-tsan out

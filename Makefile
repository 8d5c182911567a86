# The commands of developers and newcomers. `make demo` and `make test` work on a fresh machine.
SHELL := /bin/bash
# Debian's Python comes before any other, because catkin, pybind11 and rospy must use the same interpreter.
export PATH := /usr/bin:$(PATH)
export CCACHE_DIR ?= $(HOME)/.cache/ccache
# With these two settings clones of this repository share objects, whatever their paths are.
export CCACHE_BASEDIR := $(CURDIR)
export CCACHE_NOHASHDIR := 1
# Without this setting ccache does not keep objects that use precompiled headers.
export CCACHE_SLOPPINESS := pch_defines,time_macros

# The packages of ROS Noetic install below this folder what Debian has below /usr (octomap).
ifneq ($(wildcard /opt/ros/noetic),)
export CMAKE_PREFIX_PATH := /opt/ros/noetic:$(CMAKE_PREFIX_PATH)
endif

WS := build/ws
JOBS ?= 2
SEED ?= 1
WORLD ?= forest
DATA ?= ../shared/data/kitti_0001

.PHONY: help all deps build flight core demo demo-real test test-install deb bench sanitize lint tidy docs format clean

all: build

help:  ## Lists these commands.
	@grep -hE '^[a-z-]+:.*##' $(MAKEFILE_LIST) | sed -E 's/:[^#]*## */\t/' | expand -t 16
	@echo "Variables: JOBS=$(JOBS) SEED=$(SEED) WORLD=$(WORLD) DATA=$(DATA)"

deps:
	@scripts/dev/install_deps

build: deps  ## Builds everything, with the C++ tests, in the workspace build/ws.
	@scripts/dev/build_workspace $(WS) $(JOBS) all tests

# Builds everything that a flight needs, without the C++ tests.
flight: deps
	@scripts/dev/build_workspace $(WS) $(JOBS) all

core: deps  ## Builds the core, its Python module and its tests without ROS, in build/core.
	@mkdir -p build
	@cmake -S . -B build/core -DCMAKE_CXX_COMPILER_LAUNCHER=ccache > build/core-cmake.log || (cat build/core-cmake.log; false)
	@$(MAKE) --no-print-directory -C build/core -j$(JOBS) 2>&1 | scripts/dev/progress core build/core.log || (grep -n error build/core.log; false)

demo: flight  ## Flies a simulated world (WORLD, SEED) and leaves summary and pictures in build/demo.
	@scripts/dev/in_workspace $(WS) scripts/demo --seed $(SEED) --world $(WORLD) --out build/demo

demo-real: flight  ## Maps a recording (DATA: a rosbag, or a folder of raw scans) into build/demo_real.
	@scripts/dev/in_workspace $(WS) scripts/demo_real --data $(DATA) --out build/demo_real

test: build  ## Runs every test: C++, Python and ROS.
	@scripts/dev/run_tests $(WS)

test-install: deps  ## Installs voxnav in three ways, builds against each and flies from it.
	@scripts/dev/run_install_tests build/install $(JOBS)

deb: deps  ## Builds a Debian package in build/deb.
	@scripts/dev/build_deb build/deb $(JOBS)

bench: deps  ## Measures voxnav beside PCL and OctoMap.
	@scripts/dev/run_benchmarks build/bench $(JOBS)

sanitize: deps  ## Runs the C++ tests under the address, undefined behaviour and thread sanitizers.
	@scripts/dev/run_sanitizers build/sanitize $(JOBS)

lint: deps  ## Checks formatting, Python style and types, and the rules of test/lint.
	@scripts/dev/run_lint

tidy: build  ## Runs clang-tidy on every C++ source that changed since it was clean.
	@scripts/dev/install_deps tidy
	@scripts/dev/run_tidy $(WS)/build --jobs $(JOBS)

docs: build  ## Builds the site of the documentation in build/docs/html.
	@scripts/dev/install_deps docs
	@scripts/dev/in_workspace $(WS) scripts/dev/run_docs build/docs

format: deps  ## Formats the C++ sources.
	@git ls-files '*.hpp' '*.cpp' | xargs clang-format -i

clean:  ## Deletes everything that was built.
	rm -rf build

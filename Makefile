# Everything a developer or a newcomer types. `make demo` and `make test` work on a fresh machine.
SHELL := /bin/bash
# Debian's Python before any other: catkin, pybind11 and rospy must agree on one interpreter.
export PATH := /usr/bin:$(PATH)
export CCACHE_DIR ?= $(HOME)/.cache/ccache
# Objects are shared between clones of this repository, wherever they lie.
export CCACHE_BASEDIR := $(CURDIR)
export CCACHE_NOHASHDIR := 1
# What ccache asks for to keep objects made with precompiled headers.
export CCACHE_SLOPPINESS := pch_defines,time_macros

# Where a binary ROS keeps what Debian has below /usr (octomap).
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

help:  ## Lists what can be made.
	@grep -hE '^[a-z-]+:.*##' $(MAKEFILE_LIST) | sed -E 's/:[^#]*## */\t/' | expand -t 16
	@echo "Variables: JOBS=$(JOBS) SEED=$(SEED) WORLD=$(WORLD) DATA=$(DATA)"

deps:
	@scripts/dev/install_deps

build: deps  ## Everything, with the C++ tests, in the workspace build/ws.
	@scripts/dev/build_workspace $(WS) $(JOBS) all tests

# What flies, without the C++ tests.
flight: deps
	@scripts/dev/build_workspace $(WS) $(JOBS) all

core: deps  ## The core, its Python module and its tests without ROS, in build/core.
	@mkdir -p build
	@cmake -S . -B build/core -DCMAKE_CXX_COMPILER_LAUNCHER=ccache > build/core-cmake.log || (cat build/core-cmake.log; false)
	@$(MAKE) --no-print-directory -C build/core -j$(JOBS) 2>&1 | scripts/dev/progress core build/core.log || (grep -n error build/core.log; false)

demo: flight  ## Flies a simulated world (WORLD, SEED) and leaves summary and pictures in build/demo.
	@scripts/dev/in_workspace $(WS) scripts/demo --seed $(SEED) --world $(WORLD) --out build/demo

demo-real: flight  ## Maps a recording (DATA: a rosbag, or a folder of raw scans) into build/demo_real.
	@scripts/dev/in_workspace $(WS) scripts/demo_real --data $(DATA) --out build/demo_real

test: build  ## Every test: C++, Python and ROS.
	@scripts/dev/run_tests $(WS)

test-install: deps  ## Installs voxnav in three ways, builds against it and flies from there alone.
	@scripts/dev/run_install_tests build/install $(JOBS)

deb: deps  ## A Debian package in build/deb.
	@scripts/dev/build_deb build/deb $(JOBS)

bench: deps  ## Measures voxnav beside its yardsticks.
	@scripts/dev/run_benchmarks build/bench $(JOBS)

sanitize: deps  ## C++ tests under the address, undefined behaviour and thread sanitizers.
	@scripts/dev/run_sanitizers build/sanitize $(JOBS)

lint: deps  ## Formatting, Python style, and rules about the files themselves.
	@scripts/dev/run_lint

tidy: build  ## clang-tidy on every C++ source; what was clean and has not changed is not looked at again.
	@scripts/dev/install_deps tidy
	@scripts/dev/run_tidy $(WS)/build --jobs $(JOBS)

docs: build  ## The site of the documentation, in build/docs/html.
	@scripts/dev/install_deps docs
	@scripts/dev/in_workspace $(WS) scripts/dev/run_docs build/docs

format: deps  ## Formats the C++ sources.
	@git ls-files '*.hpp' '*.cpp' | xargs clang-format -i

clean:  ## Deletes everything that was built.
	rm -rf build

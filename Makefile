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

.PHONY: all deps build core demo demo-real test bench sanitize lint format clean

all: build

deps:
	@scripts/dev/install_deps

build: deps
	@scripts/dev/build_workspace $(WS) $(JOBS)

core: deps
	@mkdir -p build
	@cmake -S . -B build/core -DCMAKE_CXX_COMPILER_LAUNCHER=ccache > build/core-cmake.log || (cat build/core-cmake.log; false)
	@$(MAKE) --no-print-directory -C build/core -j$(JOBS)

demo: build
	@scripts/dev/in_workspace $(WS) scripts/demo --seed $(SEED) --world $(WORLD) --out build/demo

demo-real: build
	@scripts/dev/in_workspace $(WS) scripts/demo_real --data $(DATA) --out build/demo_real

test: build
	@scripts/dev/run_tests $(WS)

bench:
	@scripts/dev/install_deps bench
	@scripts/dev/run_benchmarks build/bench $(JOBS)

sanitize: deps
	@scripts/dev/run_sanitizers build/sanitize $(JOBS)

lint: deps
	@scripts/dev/run_lint

format: deps
	@git ls-files '*.hpp' '*.cpp' | xargs clang-format -i

clean:
	rm -rf build

.PHONY: tidy docs

tidy: build  ## clang-tidy on every C++ source; what was clean and has not changed is not looked at again.
	@scripts/dev/install_deps tidy
	@scripts/dev/run_tidy $(WS)/build --jobs $(JOBS)

docs: build  ## The site of the documentation, in build/docs/html.
	@scripts/dev/install_deps docs
	@scripts/dev/in_workspace $(WS) scripts/dev/run_docs build/docs

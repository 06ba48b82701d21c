#!/usr/bin/env bash
# Runs a binary of tests so that it prints the seconds of each test, which the stable toolchain does only on request. A
# binary without libtest does not read the arguments.
export RUSTC_BOOTSTRAP=1
exec "$@" -Zunstable-options --report-time

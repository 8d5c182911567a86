// SPDX-License-Identifier: BSD-3-Clause
// Nothing: a target needs a source, and this one exists for its precompiled headers.

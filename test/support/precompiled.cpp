// SPDX-License-Identifier: BSD-3-Clause
// This file is empty because its target exists only for its precompiled headers, and a target needs a source.

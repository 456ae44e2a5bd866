// SPDX-License-Identifier: MIT
// Gives the precompiled headers of all test programs a target: see CMakeLists.txt.

// SPDX-License-Identifier: Apache-2.0
#pragma once

// One binary for any x86-64: the dynamic linker picks the version of the machine. Others get the plain one.
#if defined(__x86_64__) && defined(__gnu_linux__) && !defined(MTFKIT_NO_CLONES)
#define MTFKIT_CLONES __attribute__((target_clones("avx512f", "avx2", "default")))
#else
#define MTFKIT_CLONES
#endif

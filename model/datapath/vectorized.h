#pragma once

#include <cstddef>  // brings in the C library's own macros

/// METABUFFER_VECTORIZED, before the definition of a function: compiles the function for the baseline processor and for
/// one with wider vectors; the loader chooses. The function must have internal linkage, and functions that it calls must
/// be inlined (METABUFFER_INLINE) to get the wider vectors too.
///
/// Compile a file that uses it without link-time optimization, which fails with Clang. Under sanitizers there is one
/// version only, since the loader chooses before they are set up.
#if defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(memory_sanitizer) || \
    __has_feature(thread_sanitizer) || __has_feature(undefined_behavior_sanitizer)
#define METABUFFER_SANITIZED
#endif
#endif
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define METABUFFER_SANITIZED
#endif

#if defined(__x86_64__) && defined(__ELF__) && defined(__GLIBC__) && !defined(METABUFFER_SANITIZED) && \
    defined(__has_attribute)
#if __has_attribute(target_clones)
#define METABUFFER_VECTORIZED __attribute__((target_clones("avx2", "default")))
#endif
#endif
#ifndef METABUFFER_VECTORIZED
#define METABUFFER_VECTORIZED
#endif

#if defined(__GNUC__)
#define METABUFFER_INLINE __attribute__((always_inline)) inline
#else
#define METABUFFER_INLINE inline
#endif

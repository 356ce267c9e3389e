#pragma once

namespace metabuffer::functional {

// A release has to run on every processor of its architecture, so it may not be compiled for AVX2, without
// which loops over pixels lose much of their speed. So such a loop is compiled twice, and each call takes the
// one that the processor can run. Where that cannot be had there is just the ordinary one, with the same
// results. Under the sanitizers too: there speed does not count, and the tests thus try the ordinary loops.

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define METABUFFER_REFERENCE_SANITIZED 1
#elif defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(memory_sanitizer) || __has_feature(thread_sanitizer)
#define METABUFFER_REFERENCE_SANITIZED 1
#endif
#endif

#if defined(__x86_64__) && defined(__GNUC__) && !defined(METABUFFER_REFERENCE_SANITIZED)
#define METABUFFER_REFERENCE_AVX2 1
#endif

/// Before the operator() of a loop: it becomes part of each function that calls it, and is compiled for the
/// processor that that function is for.
#if defined(__GNUC__)
#define METABUFFER_REFERENCE_LOOP __attribute__((always_inline))
#else
#define METABUFFER_REFERENCE_LOOP
#endif

#ifdef METABUFFER_REFERENCE_AVX2
template <typename Loop, typename... Arguments>
__attribute__((target("avx2"))) void run_loop_with_avx2(Loop loop, Arguments... arguments) {
    loop(arguments...);
}
#endif

/// Calls a loop that is marked with METABUFFER_REFERENCE_LOOP.
template <typename Loop, typename... Arguments>
void run_loop(Loop loop, Arguments... arguments) {
#ifdef METABUFFER_REFERENCE_AVX2
    if (__builtin_cpu_supports("avx2")) {
        run_loop_with_avx2(loop, arguments...);
        return;
    }
#endif
    loop(arguments...);
}

}  // namespace metabuffer::functional

#pragma once

namespace metabuffer::functional {

// A release runs on every processor of its architecture, so it may not be compiled for AVX2; without it, loops
// over pixels reach a fraction of the speed. So such a loop is compiled twice, and the one that the processor
// can run is taken when it is called. Only where that cannot be had, or says nothing as under the sanitizers,
// there is just the ordinary one, which has the same results.

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define METABUFFER_SANITIZED 1
#elif defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(memory_sanitizer) || __has_feature(thread_sanitizer)
#define METABUFFER_SANITIZED 1
#endif
#endif

#if defined(__x86_64__) && defined(__GNUC__) && !defined(METABUFFER_SANITIZED)
#define METABUFFER_HAS_AVX2_LOOPS 1
#endif

/// Before the operator() of a loop: it becomes part of each function that calls it, and is compiled for the
/// processor that that function is for.
#if defined(__GNUC__)
#define METABUFFER_VECTOR_LOOP __attribute__((always_inline))
#else
#define METABUFFER_VECTOR_LOOP
#endif

#ifdef METABUFFER_HAS_AVX2_LOOPS
template <typename Loop, typename... Arguments>
__attribute__((target("avx2"))) void run_loop_with_avx2(Loop loop, Arguments... arguments) {
    loop(arguments...);
}
#endif

/// Calls a loop that is marked with METABUFFER_VECTOR_LOOP.
template <typename Loop, typename... Arguments>
void run_loop(Loop loop, Arguments... arguments) {
#ifdef METABUFFER_HAS_AVX2_LOOPS
    if (__builtin_cpu_supports("avx2")) {
        run_loop_with_avx2(loop, arguments...);
        return;
    }
#endif
    loop(arguments...);
}

}  // namespace metabuffer::functional

#pragma once

namespace metabuffer::functional {

// A release must run on every processor of its architecture, so it must not be compiled for AVX2 as a whole. But
// without AVX2, loops over pixels are much slower. So such a loop is compiled twice, and each call runs the version
// that suits the processor. Where that is not possible there is only the ordinary version, with the same results. Under
// the sanitizers, where speed does not matter, there is only that one too, so the tests run it.

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

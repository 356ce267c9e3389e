#pragma once

/// METABUFFER_ADDRESS_SANITIZER: defined if the test is built with the address sanitizer, by gcc or clang.

#if defined(__SANITIZE_ADDRESS__)
#define METABUFFER_ADDRESS_SANITIZER
#elif defined(__has_feature)
#if __has_feature(address_sanitizer)
#define METABUFFER_ADDRESS_SANITIZER
#endif
#endif

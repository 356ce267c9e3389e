#include "test_session.h"

#define CATCH_CONFIG_RUNNER
#include <catch2/catch.hpp>

namespace metabuffer::test {

int run_session(int argc, const char* const* argv) { return Catch::Session().run(argc, argv); }

}  // namespace metabuffer::test

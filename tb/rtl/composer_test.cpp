#include <catch2/catch.hpp>

#include "random_composer.h"

namespace metabuffer::test::composer_test {

TEST_CASE("composer: in lockstep with its reference") {
    LockstepBench bench(71);
    run_random_composers(bench, Smoothing::kReplicate, 40, 4000);
}

}  // namespace metabuffer::test::composer_test

#include "tlm/buffer_time.h"

#include <catch2/catch.hpp>

#include "unit/tlm/column_replay.h"

namespace metabuffer::test {
namespace {

TEST_CASE("buffer time: agrees with a clocked column in glitch mode") {
    const auto seed = random_seed(501);
    INFO("METABUFFER_SEED=" << seed);
    SetupRange range;
    const ColumnReplay::Met met = replay_random_columns(seed, 400, range);
    printf("bursts %d unknown %d undecided %d drops %d ahead %d cb %d levels %d starved %ld late %ld replayed %ld stalled %ld\n", met.bursts, met.slots_unknown, met.undecided, met.drops, met.ahead, met.callbacks, met.levels, met.starved, met.late, met.replayed, met.stalled);
}
TEST_CASE("buffer time: agrees with a clocked column in stall mode") {
    const auto seed = random_seed(502);
    INFO("METABUFFER_SEED=" << seed);
    SetupRange range;
    range.stall = true;
    const ColumnReplay::Met met = replay_random_columns(seed, 400, range);
    printf("bursts %d unknown %d undecided %d drops %d ahead %d cb %d levels %d starved %ld late %ld replayed %ld stalled %ld\n", met.bursts, met.slots_unknown, met.undecided, met.drops, met.ahead, met.callbacks, met.levels, met.starved, met.late, met.replayed, met.stalled);
}

}  // namespace
}  // namespace metabuffer::test

#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace metabuffer::test {

/// How many random machines the tests of every day run, kMachinesPerBatch in one elaboration; their seeds are
/// 1, 2, ...
constexpr int kBatches = 24;
constexpr int kMachinesPerBatch = 8;

/// Registers "NAME of seeds 1 to 8" and so on as Catch test cases. METABUFFER_SEED replays one machine instead, in
/// any of them. A failure also says how to shrink it, by scripts/soak and `soak_option`, which makes it run the same
/// machines. Returns true, for a constant to be initialized with.
bool register_random_batches(const std::string& name,
                             const std::function<void(const std::vector<std::uint64_t>&)>& run,
                             const std::string& soak_option = {});

}  // namespace metabuffer::test

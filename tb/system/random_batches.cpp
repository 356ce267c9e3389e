#include "random_batches.h"

#include <catch2/catch.hpp>
#include <cstdlib>

#include "support/random_seed.h"

namespace metabuffer::test {
namespace {

constexpr int kQuickBatches = 10;
constexpr int kFirstBatches = 3;  ///< the sanitizers run these; what the others add is repetition

class RandomBatch final : public Catch::ITestInvoker {
  public:
    RandomBatch(int batch, std::function<void(const std::vector<std::uint64_t>&)> run,
                std::string soak_option)
        : batch_(batch), run_(std::move(run)), soak_option_(std::move(soak_option)) {}

    void invoke() const override {
        std::vector<std::uint64_t> seeds;
        if (std::getenv("METABUFFER_SEED") != nullptr) {
            seeds.push_back(random_seed(0));
        } else {
            for (int machine = 0; machine < kMachinesPerBatch; ++machine) {
                seeds.push_back(static_cast<std::uint64_t>(batch_ * kMachinesPerBatch + machine + 1));
            }
        }
        INFO("to make a machine that fails as small as it can be while failing: scripts/soak 1 SEED"
             << soak_option_);
        run_(seeds);
    }

  private:
    int batch_;
    std::function<void(const std::vector<std::uint64_t>&)> run_;
    std::string soak_option_;
};

}  // namespace

bool register_random_batches(const std::string& name,
                             const std::function<void(const std::vector<std::uint64_t>&)>& run,
                             const std::string& soak_option) {
    for (int batch = 0; batch < kBatches; ++batch) {
        const std::string seeds = " of seeds " + std::to_string(batch * kMachinesPerBatch + 1) + " to " +
                                  std::to_string((batch + 1) * kMachinesPerBatch);
        const std::string tags = batch < kFirstBatches   ? "[system][random]"
                                 : batch < kQuickBatches ? "[system][random][repeat]"
                                                         : "[system][random][slow]";
        // Registers in its constructor, as the macro does for a function.
        const Catch::AutoReg registration(new RandomBatch(batch, run, soak_option), CATCH_INTERNAL_LINEINFO,
                                          Catch::StringRef(), Catch::NameAndTags{name + seeds, tags});
    }
    return true;
}

}  // namespace metabuffer::test

#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <random>
#include <string>

namespace metabuffer::test {

/// The seed of a random test: METABUFFER_SEED if it is set, else the test's own default. Print it with INFO so
/// that a failure can be replayed.
inline std::uint64_t random_seed(std::uint64_t default_seed) {
    const char* text = std::getenv("METABUFFER_SEED");
    return text != nullptr ? std::stoull(text) : default_seed;
}

/// Uniform integers, the same on every platform for the same seed (std::uniform_int_distribution is not).
class Random {
  public:
    explicit Random(std::uint64_t seed) : engine_(seed) {}
    /// low..high, both included.
    int between(int low, int high) {
        const auto span = static_cast<std::uint64_t>(static_cast<std::int64_t>(high) - low) + 1;
        return static_cast<int>(low + static_cast<std::int64_t>(engine_() % span));
    }
    bool one_in(int n) { return between(1, n) == 1; }
    std::uint64_t bits() { return engine_(); }

  private:
    std::mt19937_64 engine_;
};

template <typename Value, std::size_t kCount>
Value one_of(Random& random, const std::array<Value, kCount>& values) {
    return values[static_cast<std::size_t>(random.between(0, static_cast<int>(kCount) - 1))];
}

}  // namespace metabuffer::test

#pragma once

#include <cstdint>
#include <string>

namespace metabuffer::charts {

/// Numbers as bytes, one after the other; small numbers take few bytes (LEB128). NumberReader of run_data.js reads them
/// back.
class NumberLog {
  public:
    void add(std::uint64_t number) {
        constexpr std::uint64_t kBits = 0x7F;
        constexpr std::uint64_t kMore = 0x80;
        for (; number > kBits; number >>= 7U) bytes_ += static_cast<char>((number & kBits) | kMore);
        bytes_ += static_cast<char>(number);
    }
    /// Writes 0, -1, 1, -2, ... as 0, 1, 2, 3, ..., so that numbers near zero take few bytes.
    void add_signed(std::int64_t number) {
        const auto bits = static_cast<std::uint64_t>(number);
        add(number < 0 ? ~(bits << 1U) : bits << 1U);
    }
    const std::string& bytes() const { return bytes_; }

  private:
    std::string bytes_;
};

}  // namespace metabuffer::charts

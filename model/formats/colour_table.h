#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace metabuffer {

/// What becomes of each value of R, G and B after the averaging of an output framebuffer: a table of 256 values a channel,
/// which never changes. It lets the colours of displays match where tiles meet (section 2 of the paper).
class ColourTable {
  public:
    static constexpr std::size_t kChannels = 3;
    static constexpr std::size_t kValues = 256;
    static constexpr std::int64_t kBits = std::int64_t{kChannels} * kValues * 8;

    using Channel = std::array<std::uint8_t, kValues>;
    using Channels = std::array<Channel, kChannels>;  ///< R, G, B

    explicit ColourTable(const Channels& channels) : channels_(channels) {}

    const Channels& channels() const { return channels_; }

    friend bool operator==(const ColourTable& a, const ColourTable& b) { return a.channels_ == b.channels_; }

  private:
    Channels channels_;
};

/// The table that the host computes for a display: round(255 * min(1, gain * v / 255) ^ (1 / gamma)), halves up. Gains of
/// R, G, B and gamma are more than 0.
ColourTable colour_table(const double (&gain)[ColourTable::kChannels], double gamma);

}  // namespace metabuffer

#pragma once

#include <cstddef>
#include <cstdint>

#include "rtl/signals.h"

namespace metabuffer::test {

/// A beat of `count` pixels from the segment's pixel `first` on. remaining: pixels of the burst that come after it.
/// word_of: the word of a pixel, by its index.
template <typename WordOf>
rtl::BusBeat pixel_beat(int frame, int destination, std::int64_t first, int count, std::int64_t remaining,
                        const WordOf& word_of) {
    rtl::BusBeat beat;
    beat.kind = rtl::BusBeat::Kind::kPixels;
    beat.frame = static_cast<std::uint32_t>(frame);
    beat.destination = static_cast<std::uint16_t>(destination);
    beat.first = static_cast<std::uint32_t>(first);
    beat.count = static_cast<std::uint8_t>(count);
    beat.remaining = static_cast<std::uint32_t>(remaining);
    for (int i = 0; i < count; ++i) beat.words[static_cast<std::size_t>(i)] = word_of(first + i);
    return beat;
}

}  // namespace metabuffer::test

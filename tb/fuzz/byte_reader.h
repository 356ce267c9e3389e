#pragma once

#include <cstddef>
#include <cstdint>

namespace metabuffer::fuzz {

/// Reads numbers from the front of a fuzz test's input, little-endian; zeros after its end.
class ByteReader {
  public:
    ByteReader(const std::uint8_t* data, std::size_t size) : data_(data), size_(size) {}

    bool empty() const { return place_ >= size_; }
    std::uint8_t u8() { return place_ < size_ ? data_[place_++] : std::uint8_t{0}; }
    std::uint16_t u16() {
        const unsigned low = u8();
        return static_cast<std::uint16_t>(low | static_cast<unsigned>(u8()) << 8U);
    }
    std::int16_t i16() { return static_cast<std::int16_t>(u16()); }

  private:
    const std::uint8_t* data_;
    std::size_t size_;
    std::size_t place_ = 0;
};

}  // namespace metabuffer::fuzz

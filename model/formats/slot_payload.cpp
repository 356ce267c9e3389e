#include "formats/slot_payload.h"

#include <algorithm>

namespace metabuffer {
namespace {

constexpr std::size_t kByteBits = 8;
constexpr std::size_t kMostSlotBits = 16;

std::size_t slot_bits(std::size_t rows) {
    std::size_t bits = 1;
    while ((std::size_t{1} << bits) < rows) ++bits;
    return bits;
}

std::size_t bytes_of_bits(std::size_t bits) { return (bits + kByteBits - 1) / kByteBits; }

}  // namespace

std::size_t slots_in_payload(std::size_t payload_bytes, std::size_t rows) {
    if (payload_bytes <= kSlotPayloadHeaderBytes) return 0;
    const std::size_t bits = (payload_bytes - kSlotPayloadHeaderBytes) * kByteBits;
    return std::min(bits / slot_bits(rows), kMostPayloadSlots);
}

std::vector<std::uint8_t> encode_slots(const std::vector<int>& slots, std::size_t rows) {
    const std::size_t bits = slot_bits(rows);
    std::vector<std::uint8_t> payload{kSlotPayloadMark, static_cast<std::uint8_t>(bits),
                                      static_cast<std::uint8_t>(slots.size() & 0xFFU),
                                      static_cast<std::uint8_t>(slots.size() >> kByteBits)};
    payload.resize(kSlotPayloadHeaderBytes + bytes_of_bits(slots.size() * bits));
    std::size_t at = 0;
    for (const int slot : slots) {
        for (std::size_t bit = 0; bit < bits; ++bit, ++at) {
            const unsigned value = (static_cast<unsigned>(slot) >> bit) & 1U;
            payload[kSlotPayloadHeaderBytes + at / kByteBits] |=
                static_cast<std::uint8_t>(value << (at % kByteBits));
        }
    }
    return payload;
}

std::optional<std::vector<int>> decode_slots(const std::vector<std::uint8_t>& payload) {
    if (payload.size() < kSlotPayloadHeaderBytes || payload[0] != kSlotPayloadMark) return std::nullopt;
    const std::size_t bits = payload[1];
    const std::size_t count = payload[2] | (std::size_t{payload[3]} << kByteBits);
    if (bits < 1 || bits > kMostSlotBits) return std::nullopt;
    if (payload.size() != kSlotPayloadHeaderBytes + bytes_of_bits(count * bits)) return std::nullopt;
    std::vector<int> slots(count, 0);
    std::size_t at = 0;
    for (int& slot : slots) {
        for (std::size_t bit = 0; bit < bits; ++bit, ++at) {
            const unsigned byte = payload[kSlotPayloadHeaderBytes + at / kByteBits];
            slot |= static_cast<int>(((byte >> (at % kByteBits)) & 1U) << bit);
        }
    }
    return slots;
}

}  // namespace metabuffer

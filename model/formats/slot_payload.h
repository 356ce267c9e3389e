#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

namespace metabuffer {

/// How the host sends the slot table of a pair (section 5 of the paper leaves such work to the host's CPU): as the
/// payload of the depth frame's control scanline. A slot is the index of a row in the colour frame's table, from 0.
///
/// | bytes | content |
/// | --- | --- |
/// | 1 | 'S' |
/// | 1 | bits of a slot, 1 to 16 |
/// | 2 | number of slots, little-endian |
/// | the rest | the slots, one after the other from the lowest bit on; zero after the last one |
constexpr std::uint8_t kSlotPayloadMark = 'S';
constexpr std::size_t kSlotPayloadHeaderBytes = 4;
constexpr std::size_t kMostPayloadSlots = 65535;

/// How many slots of a table of `rows` rows fit into a payload.
std::size_t slots_in_payload(std::size_t payload_bytes, std::size_t rows);

/// slots: each less than rows; at most kMostPayloadSlots of them. rows: 1 to 65536.
std::vector<std::uint8_t> encode_slots(const std::vector<int>& slots, std::size_t rows);

/// None if these bytes are not a slot table.
std::optional<std::vector<int>> decode_slots(const std::vector<std::uint8_t>& payload);

}  // namespace metabuffer

#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

namespace metabuffer {

/// How the host sends the slot table of a pair (section 5 of the paper leaves such work to the host's CPU): as the
/// payload of the control scanline of the pair's depth frame, whose own table is not used. A slot is the index of a row
/// in the table of the pair's colour frame, from 0.
///
/// Bytes: 'S', the bits of a slot (1 to 16), the number of slots (two bytes, little-endian), and the slots one after the
/// other from the lowest bit of the next byte on; the bits that are left in the last byte are zero.
constexpr std::uint8_t kSlotPayloadMark = 'S';
constexpr std::size_t kSlotPayloadHeaderBytes = 4;
constexpr std::size_t kMostPayloadSlots = 65535;

/// The slots of a table of so many rows for which a payload of so many bytes has room.
std::size_t slots_in_payload(std::size_t payload_bytes, std::size_t rows);

/// places: each less than rows; at most kMostPayloadSlots of them. rows: 1 to 65536.
std::vector<std::uint8_t> encode_slots(const std::vector<int>& places, std::size_t rows);

/// None if these bytes are not a slot table.
std::optional<std::vector<int>> decode_slots(const std::vector<std::uint8_t>& payload);

}  // namespace metabuffer

#pragma once

#include <cstdint>

namespace metabuffer {

/// Why a frame or a pair was rejected at the link (section 4).
enum class RejectCause : std::uint8_t { kGeometry, kMagic, kVersion, kKind, kCrc, kPair };
constexpr int kRejectCauseCount = 6;

}  // namespace metabuffer

#pragma once

#include <cstdint>

namespace metabuffer {

/// Who waits for whom on a link. kLockstep: composited frame k is made of pair k. kFreeRunning: the source sends
/// without pause, and a frame is made of the newest whole pair.
enum class Pacing : std::uint8_t { kLockstep, kFreeRunning };

}  // namespace metabuffer

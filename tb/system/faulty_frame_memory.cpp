#include "tlm/frame_memory.h"
#include "tlm/payload.h"

// Replaces the frame memory of level tlm, with a mistake: it forgets to close its page when a frame begins. So a frame
// that starts where the one before ended has one page miss too few. The shrinker must find the smallest machine that
// shows it.

/// In the source that follows, no access is a frame's first one.
#define new_frame broken_off && false
// NOLINTNEXTLINE(bugprone-suspicious-include)
#include "tlm/frame_memory.cpp"

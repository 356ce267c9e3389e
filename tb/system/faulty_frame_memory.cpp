#include "tlm/frame_memory.h"
#include "tlm/payload.h"

// Stands in for the frame memory of level tlm with a mistake: it forgets to close its page when a frame begins, so that
// a frame that starts where the one before ended misses a page too few. For the shrinker to find the smallest machine
// that shows it.

/// In the source that follows, no access is a frame's first one.
#define new_frame peek && false
// NOLINTNEXTLINE(bugprone-suspicious-include)
#include "tlm/frame_memory.cpp"

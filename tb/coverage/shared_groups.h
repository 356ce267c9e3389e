#pragma once

#include "coverage.h"

/// Groups whose goals are hit, and so declared, in several files.
namespace metabuffer::coverage::groups {

constexpr GroupTitle kArbitration{"bus/arbitration", "what each arbitration can answer"};
constexpr GroupTitle kBeat{"bus/beat", "pixels in a beat, and what limits them"};
constexpr GroupTitle kBusreadyDrop{"bus/busready-drop", "where in a burst a composer takes BUSREADY back"};
constexpr GroupTitle kPage{"memory/page", "pages of the frame memory"};
constexpr GroupTitle kBuffer{"composer/buffer", "states of the buffer"};
constexpr GroupTitle kReplication{"composer/replication", "Dmultiple of segments that are composited"};
constexpr GroupTitle kSmoothing{"composer/smoothing", "segments that are smoothed, and what they wait for"};
constexpr GroupTitle kDepth{"compose/depth", "extreme depths and what is upstream"};
constexpr GroupTitle kStarvationPlace{"starvation/place", "where pixels starve (glitch)"};
constexpr GroupTitle kStall{"stall", "how a column stands still (stall)"};
constexpr GroupTitle kPipeready{"pipeready", "when a composer raises PIPEREADY"};
constexpr GroupTitle kSequence{"frames/sequence", "how frames follow each other"};
constexpr GroupTitle kPacing{"link/pacing", "what the link answers"};
constexpr GroupTitle kSupersample{"supersample", "averaging"};

}  // namespace metabuffer::coverage::groups

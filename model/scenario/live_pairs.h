#pragma once

#include <cstdint>

namespace metabuffer {

/// Whether a scenario may have renderers whose images come from applications.
enum class LiveRenderers : std::uint8_t { kRefused, kAccepted };

/// Where the pairs of live links come from: applications that run while the model does. What comes becomes part of the
/// scenario, which the levels read: a pair is another of the renderer's frames, a pair that does not come is a fault
/// of kind missing, and a silent link one of kind delay. So the scenario of a run that has ended gives the same run
/// again.
class LivePairs {
  public:
    enum class Next : std::uint8_t {
        kPair,     ///< it is frame `pair` of the renderer now
        kMissing,  ///< it will not come: faults of kind missing keep both its frames from the link
        kSilence,  ///< not now: a fault of kind delay keeps the link silent for one pair time more
        kEnd,      ///< no further pair comes on any link, and the scenario's number of frames says so
    };

    LivePairs() = default;
    LivePairs(const LivePairs&) = delete;
    LivePairs& operator=(const LivePairs&) = delete;
    virtual ~LivePairs() = default;

    /// A link is about to begin a pair, or has been silent before it for one pair time. renderer: index, from 0. May wait
    /// for the application.
    virtual Next next(int renderer, std::uint32_t pair) = 0;
};

}  // namespace metabuffer

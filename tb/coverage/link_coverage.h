#pragma once

#include <cstdint>
#include <set>

#include "coverage.h"
#include "rtl/signals.h"
#include "scenario/scenario.h"

namespace metabuffer::coverage {

class BusCoverage;

/// Follows what a renderer's decoder tells and what its framebuffer makes of it: why a frame shows a fresh pair or
/// the last one again.
class LinkCoverage {
  public:
    LinkCoverage(Coverage& coverage, const Scenario& scenario) : coverage_(coverage), scenario_(scenario) {}

    /// The decoder tells something.
    void event(const rtl::DecoderEvent& event, const BusCoverage& bus);
    /// The bus has begun to send frame `frame`, from 0.
    void frame_starts(int frame);

  private:
    bool lockstep() const { return scenario_.pacing == Pacing::kLockstep; }

    Coverage& coverage_;
    const Scenario& scenario_;
    std::set<std::uint32_t> good_;  ///< numbers of whole pairs
    std::set<std::uint32_t> lost_;
    bool whole_ = false;       ///< free-running: the back bank holds a pair
    bool superseded_ = false;  ///< free-running: one was overwritten
    bool shown_ = false;       ///< a pair has been taken
};

}  // namespace metabuffer::coverage

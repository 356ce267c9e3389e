#pragma once

#include <cstdint>
#include <set>

#include "cover_group.h"
#include "rtl/signals.h"
#include "scenario/scenario.h"
#include "shared_groups.h"

namespace metabuffer::coverage {

class BusCoverage;

struct PairGoals : CoverGroup {
    explicit PairGoals(Coverage& coverage) : CoverGroup(coverage, groups::kPacing) {}
    Bin lockstep_fresh = bin("lockstep, fresh");
    Bin again_at_timeout = bin("lockstep, again at the timeout");
    Bin again_as_lost = bin("lockstep, again as the pair is lost");
    Bin again_as_later_is_there = bin("lockstep, again as a later pair is there");
    Bin bus_waits = bin("lockstep, bus waits for the link");
    Bin link_waits = bin("lockstep, link waits for the bus");
    Bin free_running_fresh = bin("free-running, fresh");
    Bin waits_for_pair_under_way = bin("free-running, waits for the pair under way");
};

/// Follows what a renderer's decoder reports and what its framebuffer does with it: why a frame shows a fresh pair or
/// the last one again.
class LinkCoverage {
  public:
    /// Goals and scenario must outlive it.
    LinkCoverage(const PairGoals& goals, const Scenario& scenario) : goals_(goals), scenario_(scenario) {}

    /// The decoder reports something.
    void event(const rtl::DecoderEvent& event, const BusCoverage& bus);
    /// The bus has begun to send frame `frame`, from 0.
    void frame_starts(int frame);

  private:
    bool lockstep() const { return scenario_.pacing == Pacing::kLockstep; }

    const PairGoals& goals_;
    const Scenario& scenario_;
    std::set<std::uint32_t> good_;  ///< numbers of whole pairs
    std::set<std::uint32_t> lost_;
    bool whole_ = false;       ///< free-running: the back bank holds a pair
    bool superseded_ = false;  ///< free-running: one was overwritten
    bool shown_ = false;       ///< a pair has been taken
};

}  // namespace metabuffer::coverage

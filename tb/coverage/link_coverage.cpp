#include "link_coverage.h"

#include "bus_coverage.h"

namespace metabuffer::coverage {
namespace {

/// A request takes a few clocks to the link's side: a bus idle for longer has asked and waits.
constexpr std::int64_t kAskedClocks = 16;

}  // namespace

void LinkCoverage::event(const rtl::DecoderEvent& event, const BusCoverage& bus) {
    const char* group = "link/pacing";
    if (event.pair_lost) lost_.insert(event.lost_number);
    if (event.colour_start) {
        superseded_ = superseded_ || whole_;
        whole_ = false;
    }
    if (!event.pair_good) return;
    good_.insert(event.number);
    whole_ = true;
    const bool more = bus.frames() < scenario_.frames;
    const bool bus_waits = bus.idle_clocks() > kAskedClocks;
    if (lockstep()) {
        if (more && bus.frames() > 0) {
            coverage_.hit_if(bus_waits, group, "lockstep, bus waits for the link");
            coverage_.hit_if(bus.idle_clocks() == 0, group, "lockstep, link waits for the bus");
        }
    } else {
        coverage_.hit_if(more && shown_ && superseded_ && bus_waits, group,
                         "free-running, waits for the pair under way");
    }
}

void LinkCoverage::frame_starts(int frame) {
    const char* group = "link/pacing";
    if (!lockstep()) {
        coverage_.hit_if(whole_, group, "free-running, fresh");
        shown_ = shown_ || whole_;
        whole_ = superseded_ = false;
        return;
    }
    const auto wanted = static_cast<std::uint32_t>(frame);
    if (good_.count(wanted) != 0) {
        coverage_.hit(group, "lockstep, fresh");
    } else if (good_.upper_bound(wanted) != good_.end()) {
        coverage_.hit(group, "lockstep, again as a later pair is there");
    } else {
        coverage_.hit(group, lost_.count(wanted) != 0 ? "lockstep, again as the pair is lost"
                                                      : "lockstep, again at the timeout");
    }
}

}  // namespace metabuffer::coverage

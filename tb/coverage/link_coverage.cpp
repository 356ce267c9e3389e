#include "link_coverage.h"

#include "bus_coverage.h"

namespace metabuffer::coverage {
namespace {

/// A request takes a few clocks to the link's side: a bus that is idle for longer has asked and waits.
constexpr std::int64_t kAskedClocks = 16;

}  // namespace

void LinkCoverage::event(const rtl::DecoderEvent& event, const BusCoverage& bus) {
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
            goals_.bus_waits.hit_if(bus_waits);
            goals_.link_waits.hit_if(bus.idle_clocks() == 0);
        }
    } else {
        goals_.waits_for_pair_under_way.hit_if(more && shown_ && superseded_ && bus_waits);
    }
}

void LinkCoverage::frame_starts(int frame) {
    if (!lockstep()) {
        goals_.free_running_fresh.hit_if(whole_);
        shown_ = shown_ || whole_;
        whole_ = superseded_ = false;
        return;
    }
    const auto wanted = static_cast<std::uint32_t>(frame);
    if (good_.count(wanted) != 0) {
        goals_.lockstep_fresh.hit();
    } else if (good_.upper_bound(wanted) != good_.end()) {
        goals_.again_as_later_is_there.hit();
    } else {
        (lost_.count(wanted) != 0 ? goals_.again_as_lost : goals_.again_at_timeout).hit();
    }
}

}  // namespace metabuffer::coverage

#pragma once

#include <cstddef>

#include "cover_group.h"
#include "rtl/framebuffer_wires.h"
#include "scenario/scenario.h"

namespace metabuffer::coverage {

struct ArbiterGoals : CoverGroup {
    explicit ArbiterGoals(Coverage& coverage)
        : CoverGroup(coverage, {"arbiter/answer", "what a bus arbiter answers, by its wires"}) {}
    Cross<Arbitration> granted{*this, every<Arbitration>("", ", granted at once")};
    Cross<Arbitration> granted_late{*this, every<Arbitration>("", ", granted after grant_cycles")};
    Ranges requests{*this, {{1, "granted of one request"}, {2, "of two"}, {3, "of more"}}};
    Ranges recovered{*this, {{0, "no slot recovered"}, {1, "one"}, {2, "several"}}};
    Bin slot_wraps = bin("the pointer goes from the table's end to its beginning");
    Bin slot_lost = bin("a slot is lost");
    Bin nothing_usable = bin("rows are pending, and none can be granted");
    Bin ready_without_pixels = bin("a composer is ready whose row has nothing left");
    Bin answer_of_none = bin("an answer that took clocks grants nothing");
    Bin table_awaited = bin("the bus waits for a table that is built");
};

/// Follows the wires between one bus port and its arbiter, clock by clock.
class ArbiterCoverage {
  public:
    /// Goals and scenario must outlive it.
    ArbiterCoverage(const ArbiterGoals& goals, const Scenario& scenario);

    /// A clock without reset.
    void clock(rtl::FramebufferWires& wires);

  private:
    const ArbiterGoals& goals_;
    const BusConfig& bus_;
    bool searched_ = false;  ///< in the clock before
    int slot_ = 0;
};

}  // namespace metabuffer::coverage

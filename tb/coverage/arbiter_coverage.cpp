#include "arbiter_coverage.h"

namespace metabuffer::coverage {

ArbiterCoverage::ArbiterCoverage(const ArbiterGoals& goals, const Scenario& scenario)
    : goals_(goals), bus_(scenario.bus) {}

void ArbiterCoverage::clock(rtl::FramebufferWires& wires) {
    const bool search = wires.search.read();
    const int slot = wires.slot.read();
    if (wires.take.read()) {
        int requests = 0;
        bool pending = false;
        for (std::size_t line = 0; line < wires.pending.size(); ++line) {
            const bool has_pixels = wires.pending[line].read();
            const bool ready = wires.ready[line].read();
            requests += has_pixels && ready ? 1 : 0;
            pending = pending || has_pixels;
            goals_.ready_without_pixels.hit_if(ready && !has_pixels);
        }
        if (wires.grant_valid.read()) {
            (bus_.grant_cycles > 0 ? goals_.granted_late : goals_.granted)(bus_.arbitration).hit();
            if (requests > 0) goals_.requests(requests).hit();
            goals_.recovered(wires.recovered.read()).hit();
        } else if (wires.lost.read()) {
            goals_.slot_lost.hit();
        } else if (search) {
            goals_.table_awaited.hit_if(bus_.slot_table == SlotTableMaker::kBuilt && bus_.grant_cycles == 0);
        } else {
            goals_.nothing_usable.hit_if(pending);
            goals_.answer_of_none.hit_if(searched_ && bus_.grant_cycles > 0);
        }
    }
    goals_.slot_wraps.hit_if(slot < slot_ && wires.pending.size() > 1 && !wires.start.read());
    slot_ = slot;
    searched_ = search;
}

}  // namespace metabuffer::coverage

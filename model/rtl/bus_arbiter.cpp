#include "rtl/bus_arbiter.h"

namespace metabuffer::rtl {

BusArbiter::BusArbiter(const sc_core::sc_module_name& name, Arbitration arbitration)
    : Block(name), policy_(make_policy(arbitration)) {}

void BusArbiter::start_frame(const std::vector<Segment>& segments) {
    policy_->start_frame(segments);
    slot_ = 0;
    granted_row_ = -1;
}

BusGrant BusArbiter::pick(const std::vector<BusRequest>& requests) {
    const BusGrant grant = policy_->pick(requests);
    slot_ = policy_->slot();
    if (grant.kind == BusGrant::Kind::kBurst) {
        granted_row_ = grant.row;
    }
    return grant;
}

void BusArbiter::trace(sc_core::sc_trace_file* file) const {
    sc_core::sc_trace(file, slot_, path("slot"));
    sc_core::sc_trace(file, granted_row_, path("granted_row"));
}

}  // namespace metabuffer::rtl

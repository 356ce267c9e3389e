#include "rtl/bus_fault.h"

#include <algorithm>
#include <utility>

#include "host/text.h"

namespace metabuffer::rtl {

BusFault::BusFault(const sc_core::sc_module_name& name, const Scenario& scenario, std::size_t display,
                   std::vector<std::size_t> faults, FaultTally& tally)
    : Block(name),
      scenario_(scenario),
      destination_(static_cast<std::uint16_t>(display + 1)),
      faults_(std::move(faults)),
      tally_(tally),
      core_period_picoseconds_(clock_period_picoseconds(scenario.clocks.core_mhz)) {
    SC_METHOD(update);
    sensitive << bus_i;
    dont_initialize();
}

/// Called once for each beat: two beats in a row differ at least in the frame or the position that they name.
void BusFault::update() {
    const BusBeat& beat = bus_i.read();
    if (beat.kind != BusBeat::Kind::kNone && loses(beat)) {
        ++lost_beats_;
        lost_pixels_ += is_of(beat, LostBeats::kPixels) ? beat.count : 0;
        bus_o.write(BusBeat{});
        return;
    }
    bus_o.write(beat);
}

bool BusFault::is_of(const BusBeat& beat, LostBeats of) const {
    const bool pixels = beat.kind == BusBeat::Kind::kPixels;
    if (of == LostBeats::kPixels) {
        return pixels && beat.destination == destination_;
    }
    return of == LostBeats::kAny || !pixels;
}

bool BusFault::loses(const BusBeat& beat) {
    const std::int64_t read_at = clock_edge_number(core_period_picoseconds_) + 1;
    const auto found = std::find_if(faults_.begin(), faults_.end(), [&](std::size_t fault) {
        const Fault& cause = scenario_.faults[fault];
        return is_of(beat, cause.of) && read_at >= cause.from_cycle && tally_.count(fault) < cause.beats;
    });
    if (found == faults_.end()) {
        return false;
    }
    tally_.add(*found);
    return true;
}

void BusFault::trace(sc_core::sc_trace_file* file) const {
    sc_trace(file, bus_i.read(), path("BUS_in"));
    sc_trace(file, bus_o.read(), path("BUS"));
    sc_core::sc_trace(file, lost_pixels_, path("lost_pixels"));
}

std::string BusFault::waiting_for() const {
    return lost_beats_ == 0 ? "" : "has lost " + text::counted(lost_beats_, "beat");
}

}  // namespace metabuffer::rtl

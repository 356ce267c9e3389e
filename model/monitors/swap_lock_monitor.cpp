#include "monitors/swap_lock_monitor.h"

#include <algorithm>
#include <limits>

#include "monitors/picture_reference.h"
#include "rtl/wires.h"

namespace metabuffer::monitors {
namespace {

/// Registers of the receiver on the way into another clock domain.
constexpr std::int64_t kSynchronizerEdges = 2;

bool high(const sc_core::sc_in<bool>& wire) { return wire.read(); }

const char* level(bool high) { return high ? "high" : "low"; }

using rtl::now_picoseconds;

}  // namespace

SwapLockMonitor::SwapLockMonitor(const sc_core::sc_module_name& name, const Scenario& scenario,
                                 ViolationLog& log)
    : sc_core::sc_module(name),
      framedone_i("framedone_i", static_cast<std::size_t>(scenario.displays.count())),
      framebad_i("framebad_i", static_cast<std::size_t>(scenario.displays.count())),
      link_i("link_i", static_cast<std::size_t>(scenario.displays.count())),
      timing_(scenario.displays.timing()),
      core_period_picoseconds_(clock_period_picoseconds(scenario.clocks.core_mhz)),
      dvi_period_picoseconds_(clock_period_picoseconds(scenario.clocks.dvi_out_mhz)),
      log_(log) {
    restart();
    const int last_row = static_cast<int>(scenario.renderers.size()) - 1;
    for (const Fault& fault : scenario.faults) {
        if (fault.kind == FaultKind::kRandomStalls && fault.renderer == last_row) holds_.emplace_back(fault);
    }
    SC_METHOD(core_edge);
    sensitive << clk_i.pos();
    dont_initialize();
    SC_METHOD(dvi_edge);
    sensitive << dvi_clk_i.pos();
    dont_initialize();
}

void SwapLockMonitor::restart() {
    state_ = State();
    state_.displays.resize(framedone_i.size());
    for (Display& display : state_.displays) {
        display.picture = ColourImage(timing_.active_pixels, timing_.active_lines);
    }
}

// ---- core clock ----

void SwapLockMonitor::core_edge() {
    if (reset_i.read()) return;
    const std::int64_t cycle = rtl::clock_edge_number(core_period_picoseconds_);
    check_wires(cycle);
    for (std::size_t d = 0; d < state_.displays.size(); ++d) check_framedone(d, cycle);
}

void SwapLockMonitor::check_wires(std::int64_t cycle) {
    const bool all_done = std::all_of(framedone_i.begin(), framedone_i.end(), high);
    const bool any_bad = std::any_of(framebad_i.begin(), framebad_i.end(), high);
    const bool swaplock = swaplock_i.read();
    const bool swapskip = swapskip_i.read();
    const bool may_be_late = !swaplock && contain(holds_, cycle);
    const bool swaplock_right = swaplock == all_done || (may_be_late && !state_.swaplock);
    const bool swapskip_right = swapskip == any_bad || (may_be_late && !swapskip && !state_.swapskip);
    if (!state_.wires_reported && !swaplock_right) {
        found_core("swap-lock/all-done", "SWAPLOCK",
                   std::string("it is ") + level(!all_done) + " while " +
                       (all_done ? "every FRAMEDONE is high" : "a FRAMEDONE is low"));
    }
    if (!state_.wires_reported && !swapskip_right) {
        found_core("swap-lock/any-bad", "SWAPSKIP",
                   std::string("it is ") + level(!any_bad) + " while " +
                       (any_bad ? "a FRAMEBAD is high" : "every FRAMEBAD is low"));
    }
    state_.wires_reported = !swaplock_right || !swapskip_right;
    state_.swaplock = swaplock;
    state_.swapskip = swapskip;
}

void SwapLockMonitor::check_framedone(std::size_t d, std::int64_t cycle) {
    Display& display = state_.displays[d];
    const bool framedone = framedone_i[d].read();
    const bool framebad = framebad_i[d].read();
    const std::string signal = rtl::numbered("FRAMEDONE", d);
    if (display.framedone && !framedone && cycle != state_.fall_cycle) {
        found_core("swap-lock/framedone-fall", signal,
                   "it falls without a swap that has come back over " + std::to_string(kSynchronizerEdges) +
                       " core clocks");
    } else if (framedone && cycle == state_.fall_cycle) {
        found_core("swap-lock/framedone-fall", signal,
                   "it is still high " + std::to_string(kSynchronizerEdges) + " core clocks after the swap");
    }
    if (!display.framedone && framedone) {
        if (++display.rises > state_.swaps + 1) {
            found_core("swap-lock/framedone-rise", signal,
                       "it rises for the " + std::to_string(display.rises) + "th time after " +
                           std::to_string(state_.swaps) + " swaps");
        } else if (cycle < earliest_rise_cycle(cycle)) {
            found_core("swap-lock/framedone-rise", signal,
                       "it rises before the end of the swap before has come back");
        }
    }
    if (display.framedone && framedone && framebad != display.framebad) {
        found_core("swap-lock/framebad", rtl::numbered("FRAMEBAD", d),
                   std::string("it becomes ") + level(framebad) + " while FRAMEDONE is high");
    }
    display.framedone = framedone;
    display.framebad = framebad;
}

/// On a slow core clock the swap that a FRAMEDONE has asked for may have been made before the rise is sampled: that
/// rise is judged by the swap before.
std::int64_t SwapLockMonitor::earliest_rise_cycle(std::int64_t cycle) const {
    const std::int64_t risen_picoseconds = (cycle - 1) * core_period_picoseconds_;
    return risen_picoseconds < state_.swap_picoseconds ? state_.previous_rise_cycle : state_.rise_cycle;
}

// ---- DVI output clock ----

/// An edge samples what the edge before it has driven, and then decides as the outputs do at the same edge.
void SwapLockMonitor::dvi_edge() {
    if (reset_i.read()) {
        if (!state_.dvi_reset) restart();
        return;
    }
    if (state_.dvi_reset) {
        state_.dvi_reset = false;
        // The first frame is preceded by its vertical sync.
        state_.position =
            std::int64_t{timing_.frame_lines() - DviTiming::kVerticalSyncLines} * timing_.line_clocks();
    } else {
        take_clock();
        if (++state_.position == timing_.frame_clocks()) state_.position = 0;
    }
    synchronize();
    if (state_.position == 0) start_dvi_frame();
}

void SwapLockMonitor::synchronize() {
    const bool swaplock = state_.swaplock_captured;
    state_.swaplock_captured = swaplock_i.read();
    if (!swaplock && state_.swap_level) {
        state_.swap_level = false;
        state_.rise_cycle = now_picoseconds() / core_period_picoseconds_ + kSynchronizerEdges + 1;
    } else if (swaplock && !state_.swap_level) {
        state_.swap_pending = true;
        state_.skip_pending = swapskip_i.read();  // stable as long as SWAPLOCK
    }
}

void SwapLockMonitor::start_dvi_frame() {
    state_.fresh = state_.swap_pending;
    state_.swap_pending = false;
    state_.in_step_reported = false;
    for (Display& display : state_.displays) {
        display.next_value = 0;
        display.reported = false;
    }
    if (!state_.fresh) return;
    state_.kept = state_.skip_pending;
    ++state_.swaps;
    kept_frames_ += state_.kept ? 1 : 0;
    state_.swap_level = true;
    state_.previous_rise_cycle = state_.rise_cycle;
    state_.swap_picoseconds = now_picoseconds();
    state_.rise_cycle = std::numeric_limits<std::int64_t>::max();  // known when the level has fallen
    // Seen by two registers of the core clock; FRAMEDONE is written at the second and sampled one edge later.
    state_.fall_cycle = now_picoseconds() / core_period_picoseconds_ + kSynchronizerEdges + 1;
}

void SwapLockMonitor::take_clock() {
    const bool vsync = link_i[0].read().vsync;
    for (std::size_t d = 0; d < state_.displays.size(); ++d) {
        const rtl::DviLink& link = link_i[d].read();
        if (link.vsync != vsync && !state_.in_step_reported) {
            state_.in_step_reported = true;
            found_dvi("swap-lock/in-step", d,
                      std::string("VSYNC is ") + level(link.vsync) + " and not so on display 1");
        }
        if (link.de) take_pixel(d, link.data);
    }
}

void SwapLockMonitor::take_pixel(std::size_t d, std::uint32_t data) {
    Display& display = state_.displays[d];
    std::vector<std::uint32_t>& values = display.picture.values;
    if (display.next_value == values.size()) return;  // more than a frame has: the DVI monitor checks this
    std::uint32_t& value = values[display.next_value];
    if (value != data) {
        if ((!state_.fresh || state_.kept) && !display.reported) {
            display.reported = true;
            const auto width = static_cast<std::size_t>(timing_.active_pixels);
            const std::string where = "pixel " + std::to_string(display.next_value % width) + "," +
                                      std::to_string(display.next_value / width) + " changes from " +
                                      colour_text(value) + " to " + colour_text(data);
            found_dvi(
                state_.fresh ? "swap-lock/kept" : "swap-lock/picture", d,
                where + (state_.fresh ? " though SWAPSKIP was high" : " in a DVI frame without a swap"));
        }
        value = data;
    }
    if (++display.next_value == values.size() && state_.fresh && on_picture_) {
        on_picture_({d, frame(), rtl::clock_edge_number(dvi_period_picoseconds_), display.picture});
    }
}

void SwapLockMonitor::found_core(const char* rule, const std::string& signal, const std::string& what) {
    log_.add({rule, signal, "core", rtl::clock_edge_number(core_period_picoseconds_), frame(), what});
}

void SwapLockMonitor::found_dvi(const char* rule, std::size_t display, const std::string& what) {
    log_.add({rule, rtl::numbered("DVI_OUT", display), "dvi_out",
              rtl::clock_edge_number(dvi_period_picoseconds_), frame(), what});
}

}  // namespace metabuffer::monitors

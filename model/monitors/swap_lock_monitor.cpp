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

std::int64_t now_picoseconds() { return static_cast<std::int64_t>(sc_core::sc_time_stamp().value()); }

}  // namespace

SwapLockMonitor::SwapLockMonitor(const sc_core::sc_module_name& name, const Scenario& scenario,
                                 ViolationLog& log)
    : sc_core::sc_module(name),
      framedone_i("framedone_i", static_cast<std::size_t>(scenario.displays.count())),
      framebad_i("framebad_i", static_cast<std::size_t>(scenario.displays.count())),
      link_i("link_i", static_cast<std::size_t>(scenario.displays.count())),
      timing_{scenario.displays.width_pixels, scenario.displays.height_pixels},
      core_period_picoseconds_(clock_period_picoseconds(scenario.clocks.core_mhz)),
      dvi_period_picoseconds_(clock_period_picoseconds(scenario.clocks.dvi_out_mhz)),
      log_(log),
      displays_(static_cast<std::size_t>(scenario.displays.count())) {
    for (Display& display : displays_) {
        display.picture = ColourImage(timing_.active_pixels, timing_.active_lines);
    }
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

// ---- core clock ----

void SwapLockMonitor::core_edge() {
    if (reset_i.read()) return;
    const std::int64_t cycle = rtl::clock_edge_number(core_period_picoseconds_);
    check_wires(cycle);
    for (std::size_t d = 0; d < displays_.size(); ++d) check_framedone(d, cycle);
}

void SwapLockMonitor::check_wires(std::int64_t cycle) {
    const bool all_done = std::all_of(framedone_i.begin(), framedone_i.end(), high);
    const bool any_bad = std::any_of(framebad_i.begin(), framebad_i.end(), high);
    const bool swaplock = swaplock_i.read();
    const bool swapskip = swapskip_i.read();
    const bool may_be_late = !swaplock && contain(holds_, cycle);
    const bool swaplock_right = swaplock == all_done || (may_be_late && !swaplock_);
    const bool swapskip_right = swapskip == any_bad || (may_be_late && !swapskip && !swapskip_);
    if (!wires_told_ && !swaplock_right) {
        found_core("swap-lock/all-done", "SWAPLOCK",
                   std::string("it is ") + level(!all_done) + " while " +
                       (all_done ? "every FRAMEDONE is high" : "a FRAMEDONE is low"));
    }
    if (!wires_told_ && !swapskip_right) {
        found_core("swap-lock/any-bad", "SWAPSKIP",
                   std::string("it is ") + level(!any_bad) + " while " +
                       (any_bad ? "a FRAMEBAD is high" : "every FRAMEBAD is low"));
    }
    wires_told_ = !swaplock_right || !swapskip_right;
    swaplock_ = swaplock;
    swapskip_ = swapskip;
}

void SwapLockMonitor::check_framedone(std::size_t d, std::int64_t cycle) {
    Display& display = displays_[d];
    const bool framedone = framedone_i[d].read();
    const bool framebad = framebad_i[d].read();
    const std::string signal = rtl::numbered("FRAMEDONE", d);
    if (display.framedone && !framedone && cycle != fall_cycle_) {
        found_core("swap-lock/framedone-fall", signal,
                   "it falls without a swap that has come back over " + std::to_string(kSynchronizerEdges) +
                       " core clocks");
    } else if (framedone && cycle == fall_cycle_) {
        found_core("swap-lock/framedone-fall", signal,
                   "it is still high " + std::to_string(kSynchronizerEdges) + " core clocks behind the swap");
    }
    if (!display.framedone && framedone) {
        if (++display.rises > swaps_ + 1) {
            found_core("swap-lock/framedone-rise", signal,
                       "it rises for the " + std::to_string(display.rises) + "th time after " +
                           std::to_string(swaps_) + " swaps");
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
    return risen_picoseconds < swap_picoseconds_ ? previous_rise_cycle_ : rise_cycle_;
}

// ---- DVI output clock ----

/// An edge samples what the edge before it has driven, and then decides as the outputs do at the same edge.
void SwapLockMonitor::dvi_edge() {
    if (reset_i.read()) {
        dvi_reset_ = true;
        return;
    }
    if (dvi_reset_) {
        dvi_reset_ = false;
        // The first frame is preceded by its vertical sync.
        position_ =
            std::int64_t{timing_.frame_lines() - DviTiming::kVerticalSyncLines} * timing_.line_clocks();
    } else {
        take_clock();
        if (++position_ == timing_.frame_clocks()) position_ = 0;
    }
    synchronize();
    if (position_ == 0) start_dvi_frame();
}

void SwapLockMonitor::synchronize() {
    const bool swaplock = swaplock_captured_;
    swaplock_captured_ = swaplock_i.read();
    if (!swaplock && swap_level_) {
        swap_level_ = false;
        rise_cycle_ = now_picoseconds() / core_period_picoseconds_ + kSynchronizerEdges + 1;
    } else if (swaplock && !swap_level_) {
        swap_pending_ = true;
        skip_pending_ = swapskip_i.read();  // stands as long as SWAPLOCK
    }
}

void SwapLockMonitor::start_dvi_frame() {
    fresh_ = swap_pending_;
    swap_pending_ = false;
    in_step_told_ = false;
    for (Display& display : displays_) {
        display.next_value = 0;
        display.told = false;
    }
    if (!fresh_) return;
    kept_ = skip_pending_;
    ++swaps_;
    kept_frames_ += kept_ ? 1 : 0;
    swap_level_ = true;
    previous_rise_cycle_ = rise_cycle_;
    swap_picoseconds_ = now_picoseconds();
    rise_cycle_ = std::numeric_limits<std::int64_t>::max();  // known when the level has fallen
    // Seen by two registers of the core clock; FRAMEDONE is written at the second and sampled one edge later.
    fall_cycle_ = now_picoseconds() / core_period_picoseconds_ + kSynchronizerEdges + 1;
}

void SwapLockMonitor::take_clock() {
    const bool vsync = link_i[0].read().vsync;
    for (std::size_t d = 0; d < displays_.size(); ++d) {
        const rtl::DviLink& link = link_i[d].read();
        if (link.vsync != vsync && !in_step_told_) {
            in_step_told_ = true;
            found_dvi("swap-lock/in-step", d,
                      std::string("VSYNC is ") + level(link.vsync) + " and not so on display 1");
        }
        if (link.de) take_pixel(d, link.data);
    }
}

void SwapLockMonitor::take_pixel(std::size_t d, std::uint32_t data) {
    Display& display = displays_[d];
    std::vector<std::uint32_t>& values = display.picture.values;
    if (display.next_value == values.size()) return;  // more than a frame has: the DVI monitor's affair
    std::uint32_t& value = values[display.next_value];
    if (value != data) {
        if ((!fresh_ || kept_) && !display.told) {
            display.told = true;
            const auto width = static_cast<std::size_t>(timing_.active_pixels);
            const std::string where = "pixel " + std::to_string(display.next_value % width) + "," +
                                      std::to_string(display.next_value / width) + " changes from " +
                                      colour_text(value) + " to " + colour_text(data);
            found_dvi(fresh_ ? "swap-lock/kept" : "swap-lock/picture", d,
                      where + (fresh_ ? " though SWAPSKIP was high" : " in a DVI frame without a swap"));
        }
        value = data;
    }
    if (++display.next_value == values.size() && fresh_ && on_picture_) {
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

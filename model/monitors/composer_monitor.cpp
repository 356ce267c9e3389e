#include "monitors/composer_monitor.h"

#include <algorithm>
#include <sstream>

#include "rtl/handshake_fault.h"

namespace metabuffer::monitors {
namespace {

// One report a frame and wire for each of these.
constexpr const char* kWire = "wire";
constexpr const char* kRaster = "raster";
constexpr const char* kOverflow = "overflow";

std::string text(const rtl::PipePixel& value) {
    std::ostringstream out;
    out << std::hex << std::showbase << value.pixel.word() << (value.lost ? " marked lost" : "");
    return out.str();
}

}  // namespace

ComposerMonitor::ComposerMonitor(const sc_core::sc_module_name& name, const Scenario& scenario, int renderer,
                                 int display, ViolationLog& log)
    : sc_core::sc_module(name),
      composer_("composer " + std::to_string(renderer + 1) + ", " + std::to_string(display + 1) + ": "),
      core_period_picoseconds_(clock_period_picoseconds(scenario.clocks.core_mhz)),
      observer_(scenario, renderer, display),
      reporter_(log) {
    for (const Fault& fault : scenario.faults) {
        const bool stalls = fault.kind == FaultKind::kRandomStalls;
        const bool own_display = stalls || fault.display == display + 1;
        const FaultWindow hold = FaultWindow(fault).and_behind(1);
        if (fault.renderer == renderer && own_display) {
            if (stalls || fault.kind == FaultKind::kBusreadyLow) {
                // After the fault BUSREADY stays low until the burst that it has stopped is over for the composer too.
                busready_holds_.push_back(
                    hold.and_behind(rtl::HandshakeFault::stopped_burst_cycles(scenario)));
            }
            if (stalls) tableready_holds_.push_back(hold);
            if (stalls && scenario.composer.may_stall()) {
                stall_holds_.push_back(hold);
            }
        }
        if (rtl::HandshakeFault::pipeready_row(fault.renderer) == renderer && own_display &&
            (stalls || fault.kind == FaultKind::kPipereadyLow)) {
            pipeready_holds_.push_back(hold);
        }
    }
}

void ComposerMonitor::end_of_elaboration() {
    busready_name_ = signal_name(busready_o);
    tableready_name_ = signal_name(tableready_o);
    startframe_name_ = signal_name(startframe_o);
    pipe_name_ = signal_name(pipe_o);
    pipeready_name_ = signal_name(pipeready_o);
    stall_name_ = signal_name(stall_o);
    bus_name_ = signal_name(bus_i);
}

void ComposerMonitor::clock_edge() {
    const std::int64_t cycle = rtl::clock_edge_number(core_period_picoseconds_);
    if (seen_reset_) {
        check_outputs(cycle);
    }
    if (reset_i.read()) {
        observer_.reset(pipemaster_i.read());
        seen_reset_ = true;
        pipeready_before_ = startframe_read_ = false;
        return;
    }
    const ComposerInputs inputs{bus_i.read(), startframe_i.read(), pipe_i.read(), pipeready_i.read(),
                                column_stall_i.read()};
    observe(inputs, cycle);
    if (!observer_.idle(inputs) || startframe_read_) {
        clocked_.stay_awake();
    }
}

void ComposerMonitor::observe(const ComposerInputs& inputs, std::int64_t cycle) {
    pipeready_before_ = pipeready_o.read();
    pixel_x_ = observer_.x();
    pixel_y_ = observer_.y();
    const int frame_before = observer_.frame();
    observer_.edge(inputs, cycle);
    startframe_read_ = observer_.frame() != frame_before;
    if (startframe_read_ && !pipeready_before_) {
        reporter_.report(kWire, "pipeready/unready", signal_name(startframe_i), cycle, observer_.frame(),
                         composer_ + "STARTFRAME while its PIPEREADY is low");
    }
    if (observer_.overflowed()) {
        reporter_.report(kOverflow, "composer/occupancy", bus_name_, cycle, observer_.newest_frame(),
                         composer_ + "pixel " + std::to_string(inputs.bus.first) +
                             " of its segment comes to a full buffer: " +
                             std::to_string(observer_.held_pixels()) + " pixels are held");
    }
    if (observer_.table_refused()) {
        reporter_.report(kOverflow, "composer/table", bus_name_, cycle, observer_.newest_frame() + 1,
                         composer_ + "a third frame's table comes while two frames are kept");
    }
}

// ---- the outputs ----

void ComposerMonitor::check_wire(const char* rule, bool seen, bool expected, const std::string& signal,
                                 std::int64_t cycle, std::int64_t frame, const char* why) {
    if (seen != expected) {
        reporter_.report(kWire, rule, signal, cycle, frame,
                         composer_ + "is " + level_name(seen) + ", should be " + level_name(expected) + why);
    }
}

void ComposerMonitor::check_outputs(std::int64_t cycle) {
    const ComposerOutputs& expected = observer_.expected();
    check_pipe(cycle);
    const bool startframe = startframe_o.read();
    if (startframe != expected.startframe) {
        // The next raster position is not known any more: the frame's pixels are not checked.
        const std::int64_t frame = observer_.frame() + (startframe && !observer_.running() ? 1 : 0);
        check_wire(observer_.stood_still() ? "pipeline/freeze" : "pipeline/startframe", startframe,
                   expected.startframe, startframe_name_, cycle, frame,
                   observer_.stood_still() ? ": the column stood still"
                                           : ": one clock after STARTFRAME was read, "
                                             "of a PIPEMASTER after its PIPEREADY");
        reporter_.mute(kRaster, pipe_name_, frame);
        reporter_.mute(kWire, pipe_name_, frame);
    }
    const std::int64_t announced = observer_.announced_pixels();
    if (const bool busready = busready_o.read() || (expected.busready && contain(busready_holds_, cycle));
        busready != expected.busready) {
        const std::string why = ": " + std::to_string(observer_.held_pixels()) + " pixels held, " +
                                std::to_string(announced) + " of a burst to come";
        check_wire("composer/busready", busready, expected.busready, busready_name_, cycle,
                   observer_.newest_frame(), why.c_str());
    }
    const bool tableready = tableready_o.read() || (expected.tableready && contain(tableready_holds_, cycle));
    check_wire("composer/tableready", tableready, expected.tableready, tableready_name_, cycle,
               observer_.newest_frame(), ": high while another frame's row can be kept");
    const bool stall = stall_o.read() && (expected.stall || !contain(stall_holds_, cycle));
    check_wire("composer/stall", stall, expected.stall, stall_name_, cycle, observer_.frame(),
               ": high while the next raster pixel has not come");
    check_pipeready(cycle);
}

void ComposerMonitor::check_pipe(std::int64_t cycle) {
    const rtl::PipePixel& seen = pipe_o.read();
    const rtl::PipePixel& expected = observer_.expected().pipe;
    const bool same = seen.valid == expected.valid &&
                      (!seen.valid || (seen.pixel == expected.pixel && seen.lost == expected.lost));
    if (same) {
        return;
    }
    const std::int64_t frame = observer_.frame();
    const std::string where =
        composer_ + "raster position " + std::to_string(pixel_x_) + ", " + std::to_string(pixel_y_) + ": ";
    if (observer_.stood_still()) {
        reporter_.report(kRaster, "pipeline/freeze", pipe_name_, cycle, frame,
                         where + "changes while the column stands still");
    } else if (seen.valid != expected.valid) {
        reporter_.report(kRaster, "pipeline/raster", pipe_name_, cycle, frame,
                         seen.valid ? composer_ + "a pixel outside a frame's raster" : where + "no pixel");
    } else {
        reporter_.report(kWire, seen.pixel == expected.pixel ? "composer/lost" : "composer/pixel", pipe_name_,
                         cycle, frame, where + "is " + text(seen) + ", should be " + text(expected));
    }
}

void ComposerMonitor::check_pipeready(std::int64_t cycle) {
    const bool seen = pipeready_o.read();
    const bool expected = observer_.expected().pipeready;
    if (seen == expected || (!seen && !pipeready_before_ && contain(pipeready_holds_, cycle))) {
        return;
    }
    const std::int64_t next_frame = observer_.frame() + (observer_.running() ? 0 : 1);
    const char* rule = "pipeready/late";
    const char* why = ": prefetched, and PIPEREADY from below was read";
    if (!seen && pipeready_before_) {
        rule = "pipeready/taken-back";
        why = " until STARTFRAME";
    } else if (seen && (observer_.running() || observer_.expected().startframe)) {
        rule = "pipeready/startframe";
        why = " from STARTFRAME to the frame's end";
    } else if (seen && !observer_.prefetched()) {
        rule = "pipeready/prefetched";
        why = ": the next frame's table is not whole, or its segment neither whole nor filling the buffer";
    } else if (seen) {
        rule = "pipeready/below";
        why = ": no PIPEREADY for the next frame was read from below";
    }
    check_wire(rule, seen, expected, pipeready_name_, cycle, next_frame, why);
    observer_.set_pipeready(seen);
}

}  // namespace metabuffer::monitors

#include "monitors/dvi_monitor.h"

#include <catch2/catch.hpp>
#include <memory>

#include "altered_machine.h"
#include "monitors/link_plan.h"

namespace metabuffer::test::dvi_monitor_test {

namespace {

constexpr DviTiming kOutput{kAlteredWidth, kAlteredHeight};
constexpr int kSyncStart = kAlteredWidth + DviTiming::kHorizontalFrontPixels;
constexpr int kFirstActiveLine = DviTiming::kVerticalBackLines;

enum class Plan : std::uint8_t { kOfTheScenario, kWithoutFaults };

/// A monitor on display 1 and one on the link of renderer 1, of which one clock is altered.
struct DviBench : AlteredBench {
    monitors::DviMonitor output;
    monitors::DviMonitor input;

    DviBench(const sc_core::sc_module_name& name, WatchedMachine& watched, Plan plan = Plan::kOfTheScenario)
        : AlteredBench(name, watched),
          output("output", output_link(), log),
          input("input", input_link(plan), log) {
        output.clk_i(machine.dvi_out_clk());
        output.reset_i(machine.reset());
        output.link_i(wires.link_out[0]);
        input.clk_i(machine.dvi_in_clk());
        input.reset_i(machine.reset());
        input.link_i(wires.link_in[0]);
    }

    static monitors::DviMonitor::Link output_link() {
        monitors::DviMonitor::Link link;
        link.kind = monitors::DviMonitor::Kind::kOutput;
        link.timing = kOutput;
        link.signal = "DVI_OUT_1";
        link.clock = "dvi_out";
        link.next_frame = [number = std::int64_t{-2}]() mutable {
            return monitors::DviMonitor::Frame{++number, false};
        };
        return link;
    }
    monitors::DviMonitor::Link input_link(Plan known) const {
        monitors::DviMonitor::Link link;
        link.kind = monitors::DviMonitor::Kind::kInput;
        link.timing = scenario.renderers[0].timing();
        link.signal = "DVI_IN_1";
        link.clock = "dvi_in";
        link.next_frame = [known, plan = monitors::LinkPlan(scenario, 0)]() mutable {
            const auto frame = plan.next();
            return monitors::DviMonitor::Frame{frame.pair, frame.corrupt && known == Plan::kOfTheScenario};
        };
        return link;
    }
};

using Change = std::function<void(rtl::DviLink&)>;

/// Changes one clock of a link of index 0, whose wires are named.
std::function<void(DviBench&)> alter(rtl::SignalArray<rtl::DviLink> rtl::Wires::*links, int frame, int line,
                                     int x, const Change& change) {
    return [=](DviBench& bench) {
        const DviTiming timing =
            links == &rtl::Wires::link_out ? kOutput : bench.scenario.renderers[0].timing();
        bench.alter = [=, &bench, position = LinkPosition(timing)](std::int64_t next,
                                                                   rtl::Wires& real) mutable {
            rtl::DviLink link = (real.*links)[0].read();
            if (!position.step(link) || position.frame() != frame || position.line() != line ||
                position.x() != x) {
                return;
            }
            bench.edge = next;
            change(link);
            (bench.wires.*links)[0].write(link);
        };
    };
}

Scenario with_fault(FaultKind kind, FrameKind frame) {
    Fault fault;
    fault.pair = 1;
    fault.kind = kind;
    fault.frame = frame;
    fault.delay_pairs = kind == FaultKind::kDelay ? 1 : 0;
    return test::with_fault(altered_scenario(), fault);
}

constexpr FaultKind kLineFaults[] = {FaultKind::kShortLine, FaultKind::kLongLine, FaultKind::kShortFrame,
                                     FaultKind::kLongFrame};

void de_low(rtl::DviLink& link) { link.de = false; }
void de_high(rtl::DviLink& link) { link.de = true; }
void hsync_low(rtl::DviLink& link) { link.hsync = false; }
void hsync_high(rtl::DviLink& link) { link.hsync = true; }
void vsync_high(rtl::DviLink& link) { link.vsync = true; }

}  // namespace

TEST_CASE("DVI monitor: its rules in a table", "[monitors]") {
    AlteredRuleTable<DviBench> rules;
    rules.of(altered_scenario());
    rules.row("a run by the rules", {}, {}, [](const auto& bench) {
        CHECK(bench.output.frames_seen() >= kAlteredFrames);
        CHECK(bench.input.frames_seen() == 2 * kAlteredFrames);
    });
    // A clock of the output's second whole frame. The monitor checks again from the next frame on.
    const auto row = [&rules](const char* name, const char* rule, int line, int x, const Change& change) {
        rules.row(name, {{rule, "DVI_OUT_1", 0, 1, "dvi_out"}},
                  alter(&rtl::Wires::link_out, 1, line, x, change),
                  [](const auto& bench) { CHECK(bench.output.frames_seen() > 2); });
    };
    constexpr int kLine = kFirstActiveLine + 1;
    constexpr int kEndOfLines = kFirstActiveLine + kAlteredHeight;
    row("DE ends early", "dvi/active-pixels", kLine, kAlteredWidth - 1, de_low);
    row("DE ends late", "dvi/active-pixels", kLine, kAlteredWidth, de_high);
    row("a line begins late", "dvi/line-length", kLine, 0, de_low);
    row("a line begins a clock early", "dvi/line-length", kLine - 1, kOutput.line_clocks() - 1, de_high);
    row("an active line in the back porch", "dvi/active-lines", kFirstActiveLine - 1, 0, de_high);
    row("an active line too many", "dvi/active-lines", kEndOfLines, 0, de_high);
    row("HSYNC a clock late", "dvi/hsync", 3, kSyncStart, hsync_low);
    row("HSYNC a clock long", "dvi/hsync", 3, kSyncStart + DviTiming::kHorizontalSyncPixels, hsync_high);
    row("VSYNC a line early", "dvi/vsync", kEndOfLines, 0, vsync_high);
    row("VSYNC changes within a line", "dvi/vsync-at-line-start", kLine + 1, 40, vsync_high);

    // The depth frame of pair 0 follows the colour frame's VSYNC at once.
    rules.row("an input link of the wrong mode", {{"dvi/active-pixels", "DVI_IN_1", 0, 0, "dvi_in"}},
              alter(&rtl::Wires::link_in, 1, 9, 5, de_low));
    rules.row(
        "an input link is silent within a frame", {{"dvi/line-length", "DVI_IN_1", 0, 1, "dvi_in"}},
        [](auto& bench) {
            const LinkPosition start(bench.scenario.renderers[0].timing());
            bench.alter = [&bench, position = start](std::int64_t next, rtl::Wires& real) mutable {
                if (!position.step(real.link_in[0].read()) || position.frame() != 2 || position.line() < 8)
                    return;
                if (bench.edge < 0) bench.edge = next;
                bench.wires.link_in[0].write(rtl::DviLink{});
            };
        });
    rules.row("an input link comes up with two vertical syncs", {{"dvi/vsync", "DVI_IN_1", 0, -1, "dvi_in"}},
              [](auto& bench) {
                  bench.edge = 50;
                  bench.alter = [&bench](std::int64_t next, rtl::Wires& /*real*/) {
                      if (next == bench.edge) bench.wires.link_in[0].write(rtl::DviLink{});
                  };
              });
    rules.of(with_fault(FaultKind::kShortLine, FrameKind::kDepth), Plan::kWithoutFaults);
    rules.row("a frame of faulty lines where none is scripted",
              {{"dvi/active-pixels", "DVI_IN_1", 0, 1, "dvi_in"}},
              alter(&rtl::Wires::link_in, 3, 12, 23, [](auto& /*link*/) {}));
    rules.run_and_check();
}

TEST_CASE("DVI monitor: frames that the scenario corrupts are legal and those after them are checked",
          "[monitors]") {
    const auto other_faults = {FaultKind::kMissing, FaultKind::kDelay, FaultKind::kRepeated, FaultKind::kCrc};
    std::vector<FaultKind> kinds(std::begin(kLineFaults), std::end(kLineFaults));
    kinds.insert(kinds.end(), other_faults);
    MachineRuns runs;  // under all monitors; a violation throws
    for (const FaultKind kind : kinds) {
        for (const FrameKind frame : {FrameKind::kColour, FrameKind::kDepth}) {
            runs.push_back(std::make_unique<MachineRun>("machine_" + std::to_string(runs.size()),
                                                        with_fault(kind, frame)));
        }
    }
    CHECK(run_to_end(runs));
}

TEST_CASE("link plan: frames come as the scenario scripts them", "[monitors]") {
    const auto frames_of = [](FaultKind kind) {
        const Scenario scenario = with_fault(kind, FrameKind::kColour);
        monitors::LinkPlan plan(scenario, 0);
        std::string text;
        for (int i = 0; i < 6; ++i) {
            const auto frame = plan.next();
            text += (frame.kind == FrameKind::kColour ? " c" : " d") + std::to_string(frame.pair) +
                    (frame.corrupt ? "!" : "");
        }
        return text;
    };
    CHECK(frames_of(FaultKind::kCrc) == " c0 d0 c1 d1 c2 d2");
    CHECK(frames_of(FaultKind::kMissing) == " c0 d0 d1 c2 d2 c3");
    CHECK(frames_of(FaultKind::kRepeated) == " c0 d0 c1 c1 d1 c2");
    for (const FaultKind kind : kLineFaults) CHECK(frames_of(kind) == " c0 d0 c1! d1 c2 d2");
}

}  // namespace metabuffer::test::dvi_monitor_test

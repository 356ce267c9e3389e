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

/// A monitor on display 1 and one on the link of renderer 1, of which one clock is altered.
struct Bench : AlteredMachine {
    monitors::DviMonitor output;
    monitors::DviMonitor input;
    std::int64_t edge = -1;

    explicit Bench(Scenario scenario = altered_scenario())
        : AlteredMachine(std::move(scenario)),
          output("output", output_link(), log),
          input("input", input_link(), log) {
        output.clk_i(machine.dvi_out_clk());
        output.reset_i(machine.reset());
        output.link_i(wires().link_out[0]);
        input.clk_i(machine.dvi_in_clk());
        input.reset_i(machine.reset());
        input.link_i(wires().link_in[0]);
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
    monitors::DviMonitor::Link input_link() const {
        monitors::DviMonitor::Link link;
        link.kind = monitors::DviMonitor::Kind::kInput;
        link.timing = scenario().renderers[0].timing();
        link.signal = "DVI_IN_1";
        link.clock = "dvi_in";
        link.next_frame = [plan = monitors::LinkPlan(scenario(), 0)]() mutable {
            const auto frame = plan.next();
            return monitors::DviMonitor::Frame{frame.pair, frame.spoilt};
        };
        return link;
    }

    /// Changes one clock of the output's second whole frame.
    void alter_output(int line, int x, const std::function<void(rtl::DviLink&)>& change) {
        altered.alter = [=, position = LinkPosition(kOutput)](std::int64_t next, rtl::Wires& real) mutable {
            rtl::DviLink link = real.link_out[0].read();
            if (!position.step(link) || position.frame() != 1 || position.line() != line ||
                position.x() != x) {
                return;
            }
            edge = next;
            change(link);
            wires().link_out[0].write(link);
        };
    }
    void check_output(const std::string& rule) {
        run();
        check_first(rule, "DVI_OUT_1", "dvi_out", edge, 1);
        CHECK(violations.size() == 1);  // it checks again from the next frame on
        CHECK(output.frames_seen() > 2);
    }
};

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

}  // namespace

TEST_CASE("DVI monitor: a legal run breaks no rule", "[monitors]") {
    Bench bench;
    bench.run();
    for (const auto& violation : bench.violations) FAIL(to_string(violation));
    CHECK(bench.output.frames_seen() >= kAlteredFrames);
    CHECK(bench.input.frames_seen() == 2 * kAlteredFrames);
}

TEST_CASE("DVI monitor: DE ends too early", "[monitors]") {
    Bench bench;
    bench.alter_output(kFirstActiveLine + 1, kAlteredWidth - 1, [](auto& link) { link.de = false; });
    bench.check_output("dvi/active-pixels");
}

TEST_CASE("DVI monitor: DE ends too late", "[monitors]") {
    Bench bench;
    bench.alter_output(kFirstActiveLine + 1, kAlteredWidth, [](auto& link) { link.de = true; });
    bench.check_output("dvi/active-pixels");
}

TEST_CASE("DVI monitor: a line that begins late", "[monitors]") {
    Bench bench;
    bench.alter_output(kFirstActiveLine + 1, 0, [](auto& link) { link.de = false; });
    bench.check_output("dvi/line-length");
}

TEST_CASE("DVI monitor: a line that begins a clock early", "[monitors]") {
    Bench bench;
    bench.alter_output(kFirstActiveLine, kOutput.line_clocks() - 1, [](auto& link) { link.de = true; });
    bench.check_output("dvi/line-length");
}

TEST_CASE("DVI monitor: an active line in the back porch", "[monitors]") {
    Bench bench;
    bench.alter_output(kFirstActiveLine - 1, 0, [](auto& link) { link.de = true; });
    bench.check_output("dvi/active-lines");
}

TEST_CASE("DVI monitor: an active line too many", "[monitors]") {
    Bench bench;
    bench.alter_output(kFirstActiveLine + kAlteredHeight, 0, [](auto& link) { link.de = true; });
    bench.check_output("dvi/active-lines");
}

TEST_CASE("DVI monitor: HSYNC a clock late", "[monitors]") {
    Bench bench;
    bench.alter_output(3, kSyncStart, [](auto& link) { link.hsync = false; });
    bench.check_output("dvi/hsync");
}

TEST_CASE("DVI monitor: HSYNC a clock long", "[monitors]") {
    Bench bench;
    bench.alter_output(3, kSyncStart + DviTiming::kHorizontalSyncPixels,
                       [](auto& link) { link.hsync = true; });
    bench.check_output("dvi/hsync");
}

TEST_CASE("DVI monitor: VSYNC a line early", "[monitors]") {
    Bench bench;
    bench.alter_output(kFirstActiveLine + kAlteredHeight, 0, [](auto& link) { link.vsync = true; });
    bench.check_output("dvi/vsync");
}

TEST_CASE("DVI monitor: VSYNC changes within a line", "[monitors]") {
    Bench bench;
    bench.alter_output(kFirstActiveLine + 2, 40, [](auto& link) { link.vsync = true; });
    bench.check_output("dvi/vsync-at-line-start");
}

TEST_CASE("DVI monitor: an input link of the wrong mode", "[monitors]") {
    Bench bench;
    const DviTiming timing = bench.scenario().renderers[0].timing();
    LinkPosition position(timing);
    bench.altered.alter = [&](std::int64_t next, rtl::Wires& real) {
        rtl::DviLink link = real.link_in[0].read();
        // The depth frame of pair 0 follows the colour frame's VSYNC at once.
        if (position.step(link) && position.frame() == 1 && position.line() == 9 && position.x() == 5) {
            bench.edge = next;
            link.de = false;
            bench.wires().link_in[0].write(link);
        }
    };
    bench.run();
    bench.check_first("dvi/active-pixels", "DVI_IN_1", "dvi_in", bench.edge, 0);
}

TEST_CASE("DVI monitor: an input link that is silent within a frame", "[monitors]") {
    Bench bench;
    LinkPosition position(bench.scenario().renderers[0].timing());
    bench.altered.alter = [&](std::int64_t next, rtl::Wires& real) {
        if (!position.step(real.link_in[0].read()) || position.frame() != 2 || position.line() < 8) return;
        if (bench.edge < 0) bench.edge = next;
        bench.wires().link_in[0].write(rtl::DviLink{});
    };
    bench.run();
    bench.check_first("dvi/line-length", "DVI_IN_1", "dvi_in", bench.edge, 1);
}

TEST_CASE("DVI monitor: an input link comes up with one vertical sync", "[monitors]") {
    Bench bench;
    bench.altered.alter = [&](std::int64_t next, rtl::Wires&) {
        constexpr std::int64_t kInTheSync = 50;
        if (next != kInTheSync) return;
        bench.edge = next;
        bench.wires().link_in[0].write(rtl::DviLink{});
    };
    bench.run();
    bench.check_first("dvi/vsync", "DVI_IN_1", "dvi_in", bench.edge, -1);
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

TEST_CASE("DVI monitor: a frame of faulty lines where none is scripted", "[monitors]") {
    Scenario spoilt = with_fault(FaultKind::kShortLine, FrameKind::kDepth);
    Bench bench(spoilt);
    monitors::DviMonitor::Link link = bench.input_link();
    link.next_frame = [pair = std::int64_t{-1}]() mutable {
        return monitors::DviMonitor::Frame{++pair / 2, false};
    };
    monitors::DviMonitor monitor("unknowing", link, bench.log);
    monitor.clk_i(bench.machine.dvi_in_clk());
    monitor.reset_i(bench.machine.reset());
    monitor.link_i(bench.wires().link_in[0]);
    bench.run();
    REQUIRE(bench.violations.size() == 1);
    CHECK(bench.violations[0].rule == "dvi/active-pixels");
    CHECK(bench.violations[0].signal == "DVI_IN_1");
}

TEST_CASE("link plan: frames come as the scenario scripts them", "[monitors]") {
    const auto frames_of = [](FaultKind kind) {
        const Scenario scenario = with_fault(kind, FrameKind::kColour);
        monitors::LinkPlan plan(scenario, 0);
        std::string text;
        for (int i = 0; i < 6; ++i) {
            const auto frame = plan.next();
            text += (frame.kind == FrameKind::kColour ? " c" : " d") + std::to_string(frame.pair) +
                    (frame.spoilt ? "!" : "");
        }
        return text;
    };
    CHECK(frames_of(FaultKind::kCrc) == " c0 d0 c1 d1 c2 d2");
    CHECK(frames_of(FaultKind::kMissing) == " c0 d0 d1 c2 d2 c3");
    CHECK(frames_of(FaultKind::kRepeated) == " c0 d0 c1 c1 d1 c2");
    for (const FaultKind kind : kLineFaults) CHECK(frames_of(kind) == " c0 d0 c1! d1 c2 d2");
}

}  // namespace metabuffer::test::dvi_monitor_test

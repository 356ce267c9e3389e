#include "rtl/dvi_source.h"

#include <catch2/catch.hpp>
#include <memory>
#include <string>
#include <vector>

#include "clocked_testbench.h"
#include "dvi_waveform.h"
#include "monitors/dvi_monitor.h"
#include "monitors/link_plan.h"
#include "scenario/link_program.h"
#include "support/images.h"
#include "support/scenarios.h"

namespace metabuffer::test::dvi_source_test {
namespace {

using rtl::DviLink;
using rtl::DviSource;

constexpr int kWidth = 12;  // room for a control scanline with one row
constexpr int kHeight = 3;
constexpr int kActiveLines = kHeight + 1;
constexpr int kFirstSync = kSyncLines * line_clocks(kWidth);
constexpr int kFrame = frame_clocks(kWidth, kActiveLines);
constexpr int kPair = 2 * kFrame;

/// A source and its wires. A monitor watches the link's timing, except in frames that a fault corrupts.
struct SourceBench {
    Scenario scenario;
    sc_core::sc_signal<bool> request;
    sc_core::sc_signal<DviLink> link;
    sc_core::sc_signal<int> clock_ppm;
    sc_core::sc_signal<TmdsDisturbance> disturbance;
    DviSource source;
    monitors::ViolationLog violations;
    monitors::DviMonitor monitor;
    const Recording<DviLink>& sent;

    SourceBench(ClockedTestbench& bench, const std::string& name, Scenario with)
        : scenario(std::move(with)),
          source(name.c_str(), scenario, 0),
          monitor((name + "_monitor").c_str(), monitored_link(), violations),
          sent(bench.core.record(link)) {
        source.clk_i(bench.core.clk);
        source.reset_i(bench.reset);
        source.pair_request_i(request);
        source.link_o(link);
        source.clock_ppm_o(clock_ppm);
        source.disturbance_o(disturbance);
        monitor.clk_i(bench.core.clk);
        monitor.reset_i(bench.reset);
        monitor.link_i(link);
        bench.trace(source);
    }

    monitors::DviMonitor::Link monitored_link() const {
        return {monitors::DviMonitor::Kind::kInput, scenario.renderers.front().timing(), "link", "dvi_in",
                [plan = monitors::LinkPlan(scenario, 0)]() mutable {
                    const monitors::LinkPlan::Frame frame = plan.next();
                    return monitors::DviMonitor::Frame{frame.pair, frame.spoilt};
                }};
    }
};

Scenario source_scenario(int pairs, std::vector<Fault> faults = {}) {
    Random random(11);
    Scenario scenario = small_scenario(8, 8);
    scenario.frames = pairs;
    std::vector<PixelImage> images;
    for (int i = 0; i < 3; ++i) images.push_back(noise_image(random, kWidth, kHeight));
    scenario.renderers.push_back(renderer_of(images, {table_row(1, {1, 0}, {7, 3}, {-1, 2})}));
    scenario.faults = std::move(faults);
    return scenario;
}

Fault fault_of(FaultKind kind, std::uint32_t pair, FrameKind frame, int delay_pairs = 0) {
    Fault fault;
    fault.kind = kind;
    fault.pair = pair;
    fault.frame = frame;
    fault.delay_pairs = delay_pairs;
    return fault;
}

LinkLines lines_of(const Scenario& scenario, std::uint32_t pair, FrameKind kind) {
    const Renderer& renderer = scenario.renderers.front();
    const ControlScanline content = control_content(scenario, renderer, pair, kind);
    return renderer_lines(renderer.image_of_pair(pair), kind, pair, content.table, content.payload);
}

void append_pair(Waveform& wave, const Scenario& scenario, std::uint32_t pair) {
    append_frame(wave, kWidth, lines_of(scenario, pair, FrameKind::kColour));
    append_frame(wave, kWidth, lines_of(scenario, pair, FrameKind::kDepth));
}

/// The vertical sync before the first pair.
Waveform first_sync() {
    Waveform wave;
    for (int clock = 0; clock < kFirstSync; ++clock) {
        DviLink link;
        link.vsync = true;
        wave.push_back(link);
    }
    return wave;
}

/// Checks that the link carries this waveform from `first_clock` on.
void check_wave(const Recording<DviLink>& sent, int first_clock, const Waveform& wanted) {
    for (std::size_t i = 0; i < wanted.size(); ++i) {
        const int clock = first_clock + static_cast<int>(i);
        INFO("clock " << clock << ", " << i << " into the waveform: " << sent.at(clock) << " for "
                      << wanted[i]);
        REQUIRE(sent.at(clock) == wanted[i]);
    }
}

/// The pixels of the active line that starts at a clock.
std::vector<std::uint32_t> line_at(const Recording<DviLink>& sent, int clock) {
    std::vector<std::uint32_t> line;
    for (int x = 0; x < kWidth; ++x) line.push_back(sent.at(clock + x).data);
    return line;
}

std::uint8_t byte_at(const std::vector<std::uint32_t>& line, int index) {
    return static_cast<std::uint8_t>(line[static_cast<std::size_t>(index / 3)] >> (16 - 8 * (index % 3)));
}

TEST_CASE("dvi source: in reset the link is idle, after it comes one vertical sync of whole lines") {
    ClockedTestbench bench;
    SourceBench dut(bench, "source", source_scenario(1));
    bench.run_through(kFirstSync + 10);
    CHECK(dut.sent.at(-1) == DviLink{});
    CHECK(dut.sent.clocks_where([](const DviLink& link) { return link.vsync; }) ==
          clock_range(0, kFirstSync));
    CHECK(dut.sent.clocks_where([](const DviLink& link) { return link.de; }).empty());
}

TEST_CASE("dvi source: a pair is a colour and a depth frame of exact geometry, clock by clock") {
    ClockedTestbench bench;
    SourceBench dut(bench, "source", source_scenario(1));
    bench.core.drive(dut.request, 0, true);
    bench.run_through(kFirstSync + kPair);
    Waveform wanted = first_sync();
    append_pair(wanted, dut.scenario, 0);
    check_wave(dut.sent, 0, wanted);
}

TEST_CASE("dvi source: the control scanline holds the host's record, byte for byte") {
    ClockedTestbench bench;
    Scenario scenario = source_scenario(3);
    for (RendererFrame& entry : scenario.renderers.front().frames) entry.slots = {1};
    SourceBench dut(bench, "source", scenario);
    bench.core.drive(dut.request, 0, true);
    bench.run_through(kFirstSync + 3 * kPair);
    for (int frame = 0; frame < 6; ++frame) {
        INFO("frame " << frame);
        const auto line = line_at(dut.sent, kFirstSync + frame * kFrame + clock_in_frame(kWidth, 0, 0));
        CHECK(byte_at(line, 0) == 'M');
        CHECK(byte_at(line, 1) == 'B');
        CHECK(byte_at(line, 2) == 'U');
        CHECK(byte_at(line, 3) == 'F');
        CHECK(byte_at(line, 4) == 1);
        CHECK(byte_at(line, 5) == frame % 2);
        CHECK(byte_at(line, 8) == frame / 2);  // the same number in both frames of a pair
        const DecodedScanline decoded = decode_control_scanline(line);
        REQUIRE(decoded.defect == ScanlineDefect::kNone);
        if (frame % 2 == 1) {
            CHECK(byte_at(line, 6) == 0);                                                  // no row
            CHECK(decoded.content.payload == std::vector<std::uint8_t>{'S', 1, 1, 0, 0});  // a slot of row 0
            CHECK(byte_at(line, 23) == 0);  // zero behind the content
            continue;
        }
        CHECK(byte_at(line, 6) == 1);      // one row
        CHECK(byte_at(line, 16) == 1);     // Dcomp
        CHECK(byte_at(line, 18) == 1);     // Sx
        CHECK(byte_at(line, 22) == 7);     // Sdx
        CHECK(byte_at(line, 26) == 0xFF);  // Dx = -1
        CHECK(byte_at(line, 27) == 0xFF);
        CHECK(byte_at(line, 28) == 2);  // Dy
        CHECK(byte_at(line, 34) == 0);  // zero behind the content
        CHECK(decoded.content.table == dut.scenario.renderers.front().frames.front().table);
    }
}

TEST_CASE("dvi source: z24 sends all 24 bits of Z in the depth frame") {
    ClockedTestbench bench;
    Scenario scenario = source_scenario(1);
    scenario.depth_format = DepthFormat::kZ24;
    PixelImage image = scenario.renderers.front().images.front()->pixels();
    image.at(2, 1) = Pixel(1, 2, 3, 255, 0xABCDEFU);
    scenario.renderers.front().images.front() = std::make_shared<const StoredImage>(image);
    SourceBench dut(bench, "source", scenario);
    bench.core.drive(dut.request, 0, true);
    bench.run_through(kFirstSync + kPair);
    CHECK(dut.sent.at(kFirstSync + clock_in_frame(kWidth, 2, 2)).data == 0x010203U);
    CHECK(dut.sent.at(kFirstSync + kFrame + clock_in_frame(kWidth, 2, 2)).data == 0xABCDEFU);
}

TEST_CASE("dvi source: lockstep waits for the request and starts in the clock that sees it") {
    ClockedTestbench bench;
    SourceBench first(bench, "first", source_scenario(2));
    SourceBench later(bench, "later", source_scenario(2));
    const int request_clock = kFirstSync + 100;
    bench.core.drive(first.request, request_clock, true);
    bench.core.drive(later.request, request_clock + 1, true);
    bench.run_through(request_clock + 2 * kPair + 2);
    const int first_pixel = clock_in_frame(kWidth, 0, 0);
    CHECK_FALSE(first.sent.at(request_clock + first_pixel - 1).de);
    CHECK(first.sent.at(request_clock + first_pixel).de);
    CHECK_FALSE(later.sent.at(request_clock + first_pixel).de);
    CHECK(later.sent.at(request_clock + first_pixel + 1).de);
    // With the request still high the second pair follows the first without a gap.
    Waveform wanted;
    append_pair(wanted, first.scenario, 0);
    append_pair(wanted, first.scenario, 1);
    check_wave(first.sent, request_clock, wanted);
}

TEST_CASE("dvi source: however long it has been idle, a pair starts in the clock that sees the request") {
    ClockedTestbench bench;
    constexpr int kSources = 24;
    std::vector<std::unique_ptr<SourceBench>> sources;
    const auto request_clock = [](int source) { return kFirstSync + 40 + source; };
    for (int source = 0; source < kSources; ++source) {
        sources.push_back(
            std::make_unique<SourceBench>(bench, "source_" + std::to_string(source), source_scenario(1)));
        bench.core.drive(sources.back()->request, request_clock(source), true);
    }
    const int first_pixel = clock_in_frame(kWidth, 0, 0);
    bench.run_through(request_clock(kSources) + first_pixel);
    for (int source = 0; source < kSources; ++source) {
        INFO("request at clock " << request_clock(source));
        const Recording<DviLink>& sent = sources[static_cast<std::size_t>(source)]->sent;
        const std::vector<int> active = sent.clocks_where([](const DviLink& link) { return link.de; });
        REQUIRE_FALSE(active.empty());
        CHECK(active.front() == request_clock(source) + first_pixel);
    }
}

TEST_CASE("dvi source: a request during a pair is ignored, only its level after the pair counts") {
    ClockedTestbench bench;
    SourceBench dut(bench, "source", source_scenario(2));
    bench.core.drive(dut.request, 0, true);
    // High until the pair's last clock, low at the clock after it, high again 50 clocks later.
    const int behind_pair = kFirstSync + kPair;
    bench.core.drive(dut.request, behind_pair, false);
    bench.core.drive(dut.request, behind_pair + 50, true);
    bench.run_through(behind_pair + 50 + kPair);
    const int first_pixel = clock_in_frame(kWidth, 0, 0);
    const auto de = [](const DviLink& link) { return link.de; };
    std::vector<int> active = dut.sent.clocks_where(de);
    const auto second_pair = std::lower_bound(active.begin(), active.end(), behind_pair);
    REQUIRE(second_pair != active.end());
    CHECK(*second_pair == behind_pair + 50 + first_pixel);
    // Between the pairs the link stays in blanking. No further VSYNC rises, which for a receiver would be the end of a
    // frame.
    for (int clock = behind_pair; clock < behind_pair + 50 + first_pixel; ++clock) {
        INFO("clock " << clock);
        REQUIRE_FALSE(dut.sent.at(clock).de);
        REQUIRE_FALSE((dut.sent.at(clock).vsync && !dut.sent.at(clock - 1).vsync));
    }
}

TEST_CASE("dvi source: lockstep sends as many pairs as the scenario has frames, then stays in blanking") {
    ClockedTestbench bench;
    SourceBench dut(bench, "source", source_scenario(2));
    bench.core.drive(dut.request, 0, true);
    bench.run_through(kFirstSync + 3 * kPair);
    const auto active = dut.sent.clocks_where([](const DviLink& link) { return link.de; });
    CHECK(active.size() == std::size_t{2} * 2 * kWidth * kActiveLines);
    CHECK(active.back() < kFirstSync + 2 * kPair);
}

TEST_CASE(
    "dvi source: free-running sends pair after pair without pause or request, the last image again and "
    "again") {
    ClockedTestbench bench;
    Scenario scenario = source_scenario(1);
    scenario.pacing = Pacing::kFreeRunning;
    SourceBench dut(bench, "source", scenario);
    bench.run_through(kFirstSync + 5 * kPair);
    Waveform wanted = first_sync();
    for (std::uint32_t pair = 0; pair < 5; ++pair) append_pair(wanted, dut.scenario, pair);
    check_wave(dut.sent, 0, wanted);
}

// ---- faults ----

/// Runs a free-running source with one fault in the colour or depth frame of pair 1 and checks everything up
/// to the end of pair 2: `spoil` turns the good lines of the faulty frame into what must be sent.
void check_spoilt_frame(const Fault& fault, const std::function<void(LinkLines&)>& spoil) {
    ClockedTestbench bench;
    const FrameKind frame = fault.frame;
    Scenario scenario = source_scenario(1, {fault});
    scenario.pacing = Pacing::kFreeRunning;
    SourceBench dut(bench, "source", scenario);
    Waveform wanted = first_sync();
    for (std::uint32_t pair = 0; pair < 3; ++pair) {
        for (const FrameKind half : {FrameKind::kColour, FrameKind::kDepth}) {
            LinkLines lines = lines_of(scenario, pair, half);
            if (pair == 1 && half == frame) spoil(lines);
            append_frame(wanted, kWidth, lines);
        }
    }
    bench.run_through(static_cast<int>(wanted.size()));
    check_wave(dut.sent, 0, wanted);
    CHECK(dut.source.injected_faults() == 1);
}

void check_spoilt_frame(FaultKind kind, FrameKind frame, const std::function<void(LinkLines&)>& spoil) {
    check_spoilt_frame(fault_of(kind, 1, frame), spoil);
}

void flip(std::vector<std::uint32_t>& line, int byte) {
    line[static_cast<std::size_t>(byte / 3)] ^= 0xFFU << (16 - 8 * (byte % 3));
}

TEST_CASE("dvi source: fault magic corrupts the magic and nothing else") {
    check_spoilt_frame(FaultKind::kMagic, FrameKind::kColour, [](LinkLines& lines) {
        flip(lines.front(), 0);
        REQUIRE(decode_control_scanline(lines.front()).defect == ScanlineDefect::kMagic);
    });
}

TEST_CASE("dvi source: fault version corrupts the version and nothing else") {
    check_spoilt_frame(FaultKind::kVersion, FrameKind::kDepth, [](LinkLines& lines) {
        flip(lines.front(), 4);
        REQUIRE(decode_control_scanline(lines.front()).defect == ScanlineDefect::kVersion);
    });
}

TEST_CASE("dvi source: fault crc corrupts the CRC and nothing else") {
    check_spoilt_frame(FaultKind::kCrc, FrameKind::kDepth, [](LinkLines& lines) {
        flip(lines.front(), 12);
        REQUIRE(decode_control_scanline(lines.front()).defect == ScanlineDefect::kCrc);
    });
}

TEST_CASE("dvi source: fault kind sends kind 2 under a correct CRC") {
    check_spoilt_frame(FaultKind::kKind, FrameKind::kColour, [](LinkLines& lines) {
        const DecodedScanline good = decode_control_scanline(lines.front());
        lines.front() = control_line(kWidth, static_cast<FrameKind>(2), 1, good.content.table);
        REQUIRE(decode_control_scanline(lines.front()).defect == ScanlineDefect::kKind);
    });
}

TEST_CASE("dvi source: fault number sends the pair's number plus one under a correct CRC") {
    check_spoilt_frame(FaultKind::kNumber, FrameKind::kDepth, [](LinkLines& lines) {
        const DecodedScanline good = decode_control_scanline(lines.front());
        lines.front() = control_line(kWidth, FrameKind::kDepth, 2, good.content.table);
        REQUIRE(decode_control_scanline(lines.front()).defect == ScanlineDefect::kNone);
    });
}

TEST_CASE("dvi source: fault short-line takes one pixel off the last scanline and keeps the line's clocks") {
    check_spoilt_frame(FaultKind::kShortLine, FrameKind::kColour,
                       [](LinkLines& lines) { lines.back().pop_back(); });
}

TEST_CASE("dvi source: fault long-line adds one pixel to the last scanline and keeps the line's clocks") {
    check_spoilt_frame(FaultKind::kLongLine, FrameKind::kDepth,
                       [](LinkLines& lines) { lines.back().push_back(0); });
}

TEST_CASE("dvi source: fault short-frame leaves the last scanline out") {
    check_spoilt_frame(FaultKind::kShortFrame, FrameKind::kDepth, [](LinkLines& lines) { lines.pop_back(); });
}

TEST_CASE("dvi source: fault long-frame adds a scanline") {
    check_spoilt_frame(FaultKind::kLongFrame, FrameKind::kColour,
                       [](LinkLines& lines) { lines.emplace_back(std::size_t{kWidth}, 0U); });
}

TEST_CASE("dvi source: fault short-frame leaves as many scanlines out as it says") {
    Fault fault = fault_of(FaultKind::kShortFrame, 1, FrameKind::kColour);
    fault.lines = kHeight;
    check_spoilt_frame(fault, [](LinkLines& lines) { lines.resize(1); });
}

TEST_CASE("dvi source: fault long-frame adds as many scanlines as it says") {
    Fault fault = fault_of(FaultKind::kLongFrame, 1, FrameKind::kDepth);
    fault.lines = kHeight;
    check_spoilt_frame(fault, [](LinkLines& lines) {
        lines.resize(lines.size() + kHeight, std::vector<std::uint32_t>(std::size_t{kWidth}, 0U));
    });
}

TEST_CASE("dvi source: fault control-byte flips bits of one byte of the control scanline") {
    Fault fault = fault_of(FaultKind::kControlByte, 1, FrameKind::kDepth);
    fault.byte = 22;
    fault.bits = 0x81;
    check_spoilt_frame(fault, [](LinkLines& lines) { lines.front()[22 / 3] ^= 0x81U << 8; });
}

TEST_CASE("dvi source: fault pixel-bits flips link bits of one pixel in a colour frame") {
    Fault fault = fault_of(FaultKind::kPixelBits, 1, FrameKind::kColour);
    fault.x = 7;
    fault.y = 1;
    fault.bits = 0x80'01'F0;
    check_spoilt_frame(fault, [](LinkLines& lines) { lines[2][7] ^= 0x8001F0U; });
}

TEST_CASE("dvi source: fault pixel-bits flips link bits of one pixel in a depth frame") {
    Fault fault = fault_of(FaultKind::kPixelBits, 1, FrameKind::kDepth);
    fault.x = kWidth - 1;
    fault.y = kHeight - 1;
    fault.bits = 0xFF'FF'FF;
    check_spoilt_frame(fault, [](LinkLines& lines) { lines.back().back() ^= 0xFFFFFFU; });
}

TEST_CASE("dvi source: fault other-pair sends number and image and table of the next pair") {
    ClockedTestbench bench;
    Scenario scenario = source_scenario(1, {fault_of(FaultKind::kOtherPair, 1, FrameKind::kDepth)});
    scenario.pacing = Pacing::kFreeRunning;
    scenario.renderers[0].frames[2].table = {table_row(1, {2, 0}, {3, 3}, {0, 0})};
    SourceBench dut(bench, "source", scenario);
    bench.run_through(kFirstSync + 3 * kPair);
    Waveform wanted = first_sync();
    append_pair(wanted, scenario, 0);
    append_frame(wanted, kWidth, lines_of(scenario, 1, FrameKind::kColour));
    append_frame(wanted, kWidth, lines_of(scenario, 2, FrameKind::kDepth));
    append_pair(wanted, scenario, 2);
    check_wave(dut.sent, 0, wanted);
    CHECK(dut.source.injected_faults() == 1);
}

TEST_CASE("dvi source: fault repeated sends a frame twice without a gap and each fault of it counts once") {
    ClockedTestbench bench;
    Scenario scenario = source_scenario(1, {fault_of(FaultKind::kRepeated, 1, FrameKind::kColour),
                                            fault_of(FaultKind::kShortLine, 1, FrameKind::kColour),
                                            fault_of(FaultKind::kRepeated, 2, FrameKind::kDepth)});
    scenario.pacing = Pacing::kFreeRunning;
    SourceBench dut(bench, "source", scenario);
    bench.run_through(kFirstSync + 5 * kPair);
    Waveform wanted = first_sync();
    append_pair(wanted, scenario, 0);
    LinkLines short_line = lines_of(scenario, 1, FrameKind::kColour);
    short_line.back().pop_back();
    for (int times = 0; times < 2; ++times) append_frame(wanted, kWidth, short_line);
    append_frame(wanted, kWidth, lines_of(scenario, 1, FrameKind::kDepth));
    append_pair(wanted, scenario, 2);
    append_frame(wanted, kWidth, lines_of(scenario, 2, FrameKind::kDepth));
    append_pair(wanted, scenario, 3);
    check_wave(dut.sent, 0, wanted);
    CHECK(dut.source.injected_faults() == 3);
}

TEST_CASE(
    "dvi source: fault repeated on a depth frame delays a requested pair and no request starts it early") {
    ClockedTestbench bench;
    SourceBench dut(bench, "source",
                    source_scenario(2, {fault_of(FaultKind::kRepeated, 0, FrameKind::kDepth)}));
    bench.core.drive(dut.request, 0, true);
    bench.run_through(kFirstSync + 3 * kPair);
    Waveform wanted = first_sync();
    append_pair(wanted, dut.scenario, 0);
    append_frame(wanted, kWidth, lines_of(dut.scenario, 0, FrameKind::kDepth));
    append_pair(wanted, dut.scenario, 1);
    check_wave(dut.sent, 0, wanted);
}

TEST_CASE(
    "dvi source: fault drift is reported with the first clock of its pair and stands until the next drift") {
    ClockedTestbench bench;
    Fault fast = fault_of(FaultKind::kDrift, 1, FrameKind::kColour);
    fast.ppm = 300;
    Fault normal = fault_of(FaultKind::kDrift, 3, FrameKind::kColour);
    Scenario scenario = source_scenario(1, {normal, fast});
    scenario.pacing = Pacing::kFreeRunning;
    SourceBench dut(bench, "source", scenario);
    const Recording<int>& ppm = bench.core.record(dut.clock_ppm);
    bench.run_through(kFirstSync + 4 * kPair);
    for (int clock = 0; clock < kFirstSync + 4 * kPair; ++clock) {
        const int pair = (clock - kFirstSync) / kPair;
        INFO("clock " << clock);
        REQUIRE(ppm.at(clock) == (clock >= kFirstSync && (pair == 1 || pair == 2) ? 300 : 0));
    }
    Waveform wanted = first_sync();
    for (std::uint32_t pair = 0; pair < 4; ++pair) append_pair(wanted, scenario, pair);
    check_wave(dut.sent, 0, wanted);  // nothing else changes
    CHECK(dut.source.injected_faults() == 2);
}

TEST_CASE(
    "dvi source: flips of bits are reported for their pixel alone, a late channel until it is in step "
    "again") {
    ClockedTestbench bench;
    const auto character_fault = [](FaultKind kind, std::uint32_t pair, FrameKind frame, TmdsChannel channel,
                                    int line, int clock) {
        Fault fault = fault_of(kind, pair, frame);
        fault.channel = channel;
        fault.at_line = line;
        fault.at_clock = clock;
        return fault;
    };
    constexpr int kLine = line_clocks(kWidth);
    constexpr int kLastLine = kFrame / kLine - 1;
    Fault flip = character_fault(FaultKind::kTmdsBits, 0, FrameKind::kDepth, TmdsChannel::kRed, 7, 4);
    flip.bits = 0x203;
    Fault last =
        character_fault(FaultKind::kTmdsBits, 1, FrameKind::kDepth, TmdsChannel::kBlue, kLastLine, kLine - 1);
    last.bits = 0x001;
    Fault slip = character_fault(FaultKind::kTmdsSlip, 0, FrameKind::kColour, TmdsChannel::kGreen, 0, 0);
    slip.late_bits = 7;
    Fault in_step = character_fault(FaultKind::kTmdsSlip, 1, FrameKind::kColour, TmdsChannel::kGreen, 2, 3);
    Fault skew = character_fault(FaultKind::kTmdsSkew, 0, FrameKind::kDepth, TmdsChannel::kRed, 7, 4);
    skew.late_characters = 3;
    Scenario scenario = source_scenario(2, {flip, last, slip, in_step, skew});
    scenario.links.layer = LinkLayer::kTmds;
    scenario.pacing = Pacing::kFreeRunning;
    SourceBench dut(bench, "source", scenario);
    const Recording<TmdsDisturbance>& disturbed = bench.core.record(dut.disturbance);
    bench.run_through(kFirstSync + 3 * kPair);
    const int at_flip = kFirstSync + kFrame + 7 * kLine + 4;
    const int at_last = kFirstSync + 2 * kPair - 1;
    const int at_slip = kFirstSync;
    const int at_in_step = kFirstSync + kPair + 2 * kLine + 3;
    for (int clock = 0; clock < kFirstSync + 3 * kPair; ++clock) {
        TmdsDisturbance wanted;
        if (clock == at_flip) wanted.flips[2] = 0x203;
        if (clock == at_last) wanted.flips[0] = 0x001;
        if (clock >= at_slip && clock < at_in_step) wanted.late_bits[1] = 7;
        if (clock >= at_flip) wanted.late_characters[2] = 3;
        INFO("clock " << clock);
        REQUIRE(disturbed.at(clock) == wanted);
    }
    CHECK(dut.source.injected_faults() == 5);
    Waveform wanted = first_sync();
    for (std::uint32_t pair = 0; pair < 3; ++pair) append_pair(wanted, scenario, pair);
    check_wave(dut.sent, 0, wanted);  // the pixels are what they were
}

TEST_CASE("dvi source: fault missing leaves a frame out without a gap, of either kind or both") {
    ClockedTestbench bench;
    const auto faults = [](std::initializer_list<FrameKind> kinds) {
        std::vector<Fault> list;
        for (const FrameKind kind : kinds) list.push_back(fault_of(FaultKind::kMissing, 1, kind));
        return list;
    };
    const std::vector<std::vector<Fault>> cases = {faults({FrameKind::kColour}), faults({FrameKind::kDepth}),
                                                   faults({FrameKind::kColour, FrameKind::kDepth})};
    std::vector<std::unique_ptr<SourceBench>> duts;
    for (std::size_t i = 0; i < cases.size(); ++i) {
        Scenario scenario = source_scenario(1, cases[i]);
        scenario.pacing = Pacing::kFreeRunning;
        duts.push_back(std::make_unique<SourceBench>(bench, "source_" + std::to_string(i), scenario));
    }
    bench.run_through(kFirstSync + 3 * kPair);
    for (std::size_t i = 0; i < cases.size(); ++i) {
        INFO("case " << i);
        const Scenario& scenario = duts[i]->scenario;
        Waveform wanted = first_sync();
        append_pair(wanted, scenario, 0);
        if (i == 0) append_frame(wanted, kWidth, lines_of(scenario, 1, FrameKind::kDepth));
        if (i == 1) append_frame(wanted, kWidth, lines_of(scenario, 1, FrameKind::kColour));
        append_pair(wanted, scenario, 2);
        check_wave(duts[i]->sent, 0, wanted);
    }
}

TEST_CASE("dvi source: fault delay keeps the link silent for whole pair times before the frame") {
    ClockedTestbench bench;
    Scenario colour = source_scenario(1, {fault_of(FaultKind::kDelay, 1, FrameKind::kColour, 1)});
    Scenario depth = source_scenario(1, {fault_of(FaultKind::kDelay, 1, FrameKind::kDepth, 2)});
    colour.pacing = depth.pacing = Pacing::kFreeRunning;
    SourceBench first(bench, "first", colour);
    SourceBench second(bench, "second", depth);
    bench.run_through(kFirstSync + 5 * kPair);

    Waveform wanted;
    append_pair(wanted, colour, 1);
    append_pair(wanted, colour, 2);
    check_wave(first.sent, kFirstSync + kPair + kPair, wanted);

    wanted.clear();
    append_frame(wanted, kWidth, lines_of(depth, 1, FrameKind::kDepth));
    append_pair(wanted, depth, 2);
    check_wave(second.sent, kFirstSync + kPair + kFrame + 2 * kPair, wanted);

    const auto silent = [](const SourceBench& dut, int from, int clocks) {
        for (int clock = from; clock < from + clocks; ++clock) {
            INFO("clock " << clock);
            REQUIRE_FALSE(dut.sent.at(clock).de);
            REQUIRE_FALSE((dut.sent.at(clock).vsync && !dut.sent.at(clock - 1).vsync));
        }
    };
    silent(first, kFirstSync + kPair, kPair);
    silent(second, kFirstSync + kPair + kFrame, 2 * kPair);
}

TEST_CASE("dvi source: a reset in the middle of a pair starts again with the first sync and pair 0") {
    ClockedTestbench bench;
    SourceBench dut(bench, "source", source_scenario(2));
    bench.core.drive(dut.request, 0, true);
    const int reset_clock = kFirstSync + kPair + kFrame / 2;
    bench.core.pulse(bench.reset, reset_clock);
    bench.run_through(reset_clock + kFirstSync + kPair + 1);
    CHECK(dut.sent.at(reset_clock) == DviLink{});
    Waveform wanted = first_sync();
    append_pair(wanted, dut.scenario, 0);
    check_wave(dut.sent, reset_clock + 1, wanted);
}

TEST_CASE("dvi source: a reset is seen after any number of idle clocks") {
    ClockedTestbench bench;
    SourceBench dut(bench, "source", source_scenario(1));
    const int restart = kFirstSync + 500;
    bench.core.pulse(bench.reset, restart);
    bench.run_through(restart + kFirstSync + 10);
    CHECK_FALSE(dut.sent.at(restart).vsync);
    check_wave(dut.sent, restart + 1, first_sync());
    CHECK_FALSE(dut.sent.at(restart + 1 + kFirstSync).vsync);
}

TEST_CASE("dvi source: a reset at any moment of a pair leaves what power-up leaves") {
    ClockedTestbench bench;
    SourceBench dut(bench, "source", source_scenario(2));
    bench.core.drive(dut.request, 0, true);
    Waveform wanted = first_sync();
    append_pair(wanted, dut.scenario, 0);
    constexpr int kStride = 211;
    std::vector<int> resets;
    for (int moment = 3; moment < kFirstSync + kPair; moment += kStride) {
        resets.push_back((resets.empty() ? 0 : resets.back() + 1) + moment);
        bench.core.pulse(bench.reset, resets.back());
    }
    bench.run_through(resets.back() + kFirstSync + kPair + 1);
    int from = 0;
    for (const int reset : resets) {
        INFO("the reset at clock " << reset);
        check_wave(dut.sent, from, Waveform(wanted.begin(), wanted.begin() + (reset - from)));
        CHECK(dut.sent.at(reset) == DviLink{});
        from = reset + 1;
    }
    check_wave(dut.sent, from, wanted);
}

TEST_CASE("dvi source: a reset ends what delays a channel") {
    Fault skew = fault_of(FaultKind::kTmdsSkew, 0, FrameKind::kColour);
    skew.channel = TmdsChannel::kRed;
    skew.late_characters = 3;
    TmdsDisturbance late;
    late.late_characters.at(static_cast<std::size_t>(skew.channel)) = 3;
    Scenario scenario = source_scenario(1, {skew});
    scenario.links.layer = LinkLayer::kTmds;
    ClockedTestbench bench;
    SourceBench dut(bench, "source", scenario);
    const Recording<TmdsDisturbance>& disturbances = bench.core.record(dut.disturbance);
    bench.core.drive(dut.request, 0, true);
    const int reset_clock = kFirstSync + kFrame / 2;
    bench.core.pulse(bench.reset, reset_clock);
    bench.run_through(reset_clock + 2);
    CHECK(disturbances.at(reset_clock - 1) == late);
    CHECK(disturbances.at(reset_clock) == TmdsDisturbance{});
}

}  // namespace
}  // namespace metabuffer::test::dvi_source_test

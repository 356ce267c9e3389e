#include "tlm/dvi_decoder.h"

#include <array>
#include <catch2/catch.hpp>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "clocked_testbench.h"
#include "dvi_waveform.h"
#include "rtl/dvi_decoder.h"
#include "socket_bench.h"
#include "support/images.h"
#include "support/scenarios.h"

namespace metabuffer::test::dvi_decoder_test {
namespace {

constexpr int kWidth = 24;  // room for two rows
constexpr int kHeight = 3;
constexpr int kActiveLines = kHeight + 1;
constexpr int kFrame = frame_clocks(kWidth, kActiveLines);

/// Clocks in a frame at which something shows on the link.
constexpr int kBehindControl = clock_in_frame(kWidth, kWidth, 0);
constexpr int kVsync = vsync_in_frame(kWidth, kActiveLines);
/// The decoder samples a clock of the link one clock later, and the framebuffer reads it another clock later.
constexpr int kClocksBehindLink = 2;

struct DecoderBench {
    Initiator<tlm::DviFrame> source{"dvi_source"};
    tlm::DviDecoder decoder{"dvi_decoder", DviTiming{kWidth, kActiveLines}, 0};
    Target<tlm::DecodedFrame> framebuffer{"input_framebuffer"};
    StoredImage image{noise_image(1, kWidth, kHeight)};
    tlm::Message<tlm::DviFrame> frame;
    std::vector<tlm::DecodedFrame> decoded;

    DecoderBench() {
        source.socket.bind(decoder.link_socket);
        decoder.framebuffer_socket.bind(framebuffer.socket);
        framebuffer.on_transport = [this](::tlm::tlm_generic_payload& payload) {
            decoded.push_back(tlm::content_of<tlm::DecodedFrame>(payload));
        };
    }

    void make(FrameKind kind, std::uint32_t number, const ViewportTable& table = {}) {
        *frame = tlm::DviFrame{};
        frame->image = &image;
        frame->control = control_line(kWidth, kind, number, table);
        frame->active_lines = kActiveLines;
        frame->last_line_pixels = kWidth;
    }
    /// What the decoder makes of the frame.
    const tlm::DecodedFrame& send(std::int64_t first_edge) {
        frame->first_edge = first_edge;
        const std::size_t before = decoded.size();
        REQUIRE(source.send(frame.payload()) == ::tlm::TLM_OK_RESPONSE);
        REQUIRE(decoded.size() == before + 1);
        return decoded.back();
    }
};

TEST_CASE("dvi decoder: a pair's verdicts come after its control scanline and at its vertical sync") {
    DecoderBench dut;
    elaborate();
    const ViewportTable table = {table_row(1, {1, 2}, {3, 1}, {-1, -2}, 3)};
    dut.make(FrameKind::kColour, 7, table);
    const tlm::DecodedFrame colour = dut.send(1000);
    REQUIRE(colour.events.size() == 1);
    CHECK(colour.events[0].edge == 1000 + kBehindControl + kClocksBehindLink);
    CHECK(colour.events[0].colour_start);
    CHECK(colour.events[0].number == 7);
    CHECK(colour.events[0].table == table);
    CHECK_FALSE(colour.events[0].pair_good);
    CHECK(colour.first_pixel_edge == 1000 + clock_in_frame(kWidth, 0, 1) + kClocksBehindLink);
    CHECK(colour.pixels == kWidth * kHeight);
    dut.make(FrameKind::kDepth, 7);
    const tlm::DecodedFrame depth = dut.send(1000 + kFrame);
    REQUIRE(depth.events.size() == 1);
    const tlm::LinkEvent& good = depth.events[0];
    CHECK(good.edge == 1000 + kFrame + kVsync + kClocksBehindLink);
    CHECK(good.pair_good);
    CHECK(good.number == 7);
    CHECK(good.colour == &dut.image);
    CHECK(good.depth == &dut.image);
    // The event's edge is that of the framebuffer; this one is that of the decoder, which samples the pixel.
    CHECK(good.last_pixel_edge == 1000 + kFrame + clock_in_frame(kWidth, kWidth - 1, kActiveLines - 1) + 1);
    CHECK(dut.decoder.rejected_frames(100'000) == std::array<std::int64_t, kRejectCauseCount>{});
}

struct FaultCase {
    std::string name;
    FrameKind frame;
    std::function<void(tlm::DviFrame&)> corrupt;
    RejectCause cause;
    int clock;        ///< on the link
    bool lost_known;  ///< the control scanline was good, or the colour frame before it
};

void flip(tlm::DviFrame& frame, int byte) {
    frame.control[static_cast<std::size_t>(byte / 3)] ^= std::uint32_t{0xFF} << (8 * (2 - byte % 3));
}

std::vector<FaultCase> fault_cases() {
    const int last_line = kActiveLines - 1;
    std::vector<FaultCase> cases;
    for (const FrameKind kind : {FrameKind::kColour, FrameKind::kDepth}) {
        const bool depth = kind == FrameKind::kDepth;
        cases.push_back(
            {"magic", kind, [](auto& f) { flip(f, 0); }, RejectCause::kMagic, kBehindControl, depth});
        cases.push_back(
            {"version", kind, [](auto& f) { flip(f, 4); }, RejectCause::kVersion, kBehindControl, depth});
        cases.push_back(
            {"crc", kind, [](auto& f) { flip(f, 12); }, RejectCause::kCrc, kBehindControl, depth});
        cases.push_back({"kind", kind,
                         [](auto& f) { f.control = control_line(kWidth, static_cast<FrameKind>(2), 1); },
                         RejectCause::kKind, kBehindControl, depth});
        cases.push_back({"short line", kind, [](auto& f) { --f.last_line_pixels; }, RejectCause::kGeometry,
                         clock_in_frame(kWidth, kWidth - 1, last_line), true});
        cases.push_back({"long line", kind, [](auto& f) { ++f.last_line_pixels; }, RejectCause::kGeometry,
                         clock_in_frame(kWidth, kWidth, last_line), true});
        cases.push_back({"short frame", kind, [](auto& f) { --f.active_lines; }, RejectCause::kGeometry,
                         vsync_in_frame(kWidth, last_line), true});
        cases.push_back({"long frame", kind, [](auto& f) { ++f.active_lines; }, RejectCause::kGeometry,
                         clock_in_frame(kWidth, 0, kActiveLines), true});
    }
    cases.push_back({"number", FrameKind::kDepth,
                     [](auto& f) { f.control = control_line(kWidth, FrameKind::kDepth, 2); },
                     RejectCause::kPair, kBehindControl, true});
    return cases;
}

TEST_CASE("dvi decoder: each fault is reported at the clock in which it shows and loses its own pair only") {
    DecoderBench dut;
    elaborate();
    std::int64_t edge = 50;
    std::int64_t rejected = 0;
    for (const FaultCase& fault : fault_cases()) {
        INFO(fault.name << (fault.frame == FrameKind::kColour ? " in the colour frame"
                                                              : " in the depth frame"));
        const bool colour_corrupt = fault.frame == FrameKind::kColour;
        dut.make(FrameKind::kColour, 1);
        if (colour_corrupt) fault.corrupt(*dut.frame);
        tlm::DecodedFrame decoded = dut.send(edge);
        if (!colour_corrupt) {
            CHECK(dut.decoder.waiting_for(edge + kFrame) == "waits for the depth frame of pair 1");
            edge += 2 * kFrame;
            dut.make(FrameKind::kDepth, 1);
            fault.corrupt(*dut.frame);
            decoded = dut.send(edge);
        }
        REQUIRE_FALSE(decoded.events.empty());
        const tlm::LinkEvent& event = decoded.events.back();
        CHECK(event.rejected);
        CHECK(event.cause == fault.cause);
        CHECK(event.edge == edge + fault.clock + kClocksBehindLink);
        CHECK(event.pair_lost == fault.lost_known);
        if (fault.lost_known) CHECK(event.lost_number == 1);
        // The rejection has been counted since the clock in which the decoder samples it.
        ++rejected;
        const auto count = [&](std::int64_t through) {
            std::int64_t sum = 0;
            for (const std::int64_t cause : dut.decoder.rejected_frames(through)) sum += cause;
            return sum;
        };
        CHECK(count(edge + fault.clock) == rejected - 1);
        CHECK(count(edge + fault.clock + 1) == rejected);
        CHECK(dut.decoder.waiting_for(edge + fault.clock + 1) == "waits for a good colour frame");
        edge += 2 * kFrame;
        if (colour_corrupt) {
            // The other frame of the pair is ignored; its pair is known to be lost.
            dut.make(FrameKind::kDepth, 1);
            const tlm::DecodedFrame depth = dut.send(edge);
            REQUIRE(depth.events.size() == 1);
            CHECK(depth.events[0].pair_lost);
            CHECK(depth.events[0].lost_number == 1);
            CHECK_FALSE(depth.events[0].rejected);
            CHECK(depth.pixels == 0);
            edge += 2 * kFrame;
        }
        dut.make(FrameKind::kColour, 9);
        CHECK(dut.send(edge).events.at(0).colour_start);
        dut.make(FrameKind::kDepth, 9);
        CHECK(dut.send(edge + 2 * kFrame).events.at(0).pair_good);
        CHECK(count(edge + 4 * kFrame) == rejected);
        edge += 4 * kFrame;
    }
}

TEST_CASE("dvi decoder: a vertical sync without lines before it is not a frame") {
    DecoderBench dut;
    elaborate();
    dut.make(FrameKind::kColour, 3);
    REQUIRE(dut.send(100).events.size() == 1);
    dut.make(FrameKind::kDepth, 3);
    dut.frame->active_lines = 1;
    dut.frame->last_line_pixels = 0;
    CHECK(dut.send(100 + kFrame).events.empty());
    CHECK(dut.decoder.rejected_frames(100 + 2 * kFrame) == std::array<std::int64_t, kRejectCauseCount>{});
    dut.make(FrameKind::kDepth, 3);
    const tlm::DecodedFrame depth = dut.send(100 + 2 * kFrame);
    REQUIRE(depth.events.size() == 1);
    CHECK(depth.events[0].pair_good);
}

TEST_CASE("dvi decoder: a control scanline that is too long is not read") {
    DecoderBench dut;
    elaborate();
    dut.make(FrameKind::kColour, 3);
    dut.frame->active_lines = 1;
    ++dut.frame->last_line_pixels;
    const tlm::DecodedFrame decoded = dut.send(100);
    CHECK_FALSE(decoded.kind);
    REQUIRE(decoded.events.size() == 1);
    CHECK(decoded.events[0].rejected);
    CHECK(decoded.events[0].cause == RejectCause::kGeometry);
    CHECK_FALSE(decoded.events[0].colour_start);
}

TEST_CASE("dvi decoder: a frame whose control scanline cannot be read has no kind, whatever came before it") {
    DecoderBench dut;
    elaborate();
    dut.make(FrameKind::kColour, 3);
    CHECK(dut.send(100).kind == FrameKind::kColour);
    dut.make(FrameKind::kDepth, 3);
    dut.frame->control[0] ^= 1U;  // the magic
    CHECK_FALSE(dut.send(100 + kFrame).kind);
}

TEST_CASE("dvi decoder: a frame without its extension is an error of the model") {
    DecoderBench dut;
    elaborate();
    CHECK(report_of_empty_payload(dut.source) == kExtensionReport);
}

// ---- beside the clocked decoder ----

struct RandomFrame {
    std::int64_t first_clock = 0;
    std::vector<std::uint32_t> control;
    FrameKind kind = FrameKind::kColour;
    int active_lines = kActiveLines;
    int last_line_pixels = kWidth;
};

RandomFrame random_frame(Random& random, std::uint32_t& pair, bool& depth_next) {
    RandomFrame frame;
    frame.kind = (depth_next != random.one_in(12)) ? FrameKind::kDepth : FrameKind::kColour;
    depth_next = frame.kind == FrameKind::kColour;
    if (frame.kind == FrameKind::kColour) ++pair;
    const std::uint32_t number =
        pair + (random.one_in(10) ? static_cast<std::uint32_t>(random.between(-2, 2)) : 0);
    ViewportTable table;
    for (int i = random.between(0, 2); i > 0; --i) table.push_back(table_row(i, {i, 0}, {1, 1}, {0, 0}));
    std::vector<std::uint8_t> payload(static_cast<std::size_t>(random.between(0, 5)));
    for (std::uint8_t& byte : payload) byte = static_cast<std::uint8_t>(random.between(0, 255));
    frame.control = control_line(kWidth, random.one_in(20) ? static_cast<FrameKind>(5) : frame.kind, number,
                                 table, payload);
    if (random.one_in(6)) {
        const int byte = random.one_in(3) ? 4 : random.between(0, 15);
        frame.control[static_cast<std::size_t>(byte / 3)] ^= std::uint32_t{1} << (8 * (2 - byte % 3));
    }
    if (random.one_in(5)) frame.active_lines = random.between(1, kActiveLines + 2);
    if (random.one_in(5)) frame.last_line_pixels = random.between(1, kWidth + 3);
    return frame;
}

bool reports_anything(const rtl::DecoderEvent& event) {
    return event.rejected || event.pair_lost || event.colour_start || event.pair_good;
}

TEST_CASE("dvi decoder: frames with random faults give the clocked decoder's events at its clocks") {
    const auto seed = random_seed(551);
    INFO("METABUFFER_SEED=" << seed);
    Random random(seed);
    DecoderBench dut;

    ClockedTestbench bench;
    sc_core::sc_signal<rtl::DviLink> link;
    sc_core::sc_signal<rtl::DecodedPixel> pixel;
    sc_core::sc_signal<rtl::DecoderEvent> event;
    rtl::DviDecoder clocked("clocked_dvi_decoder", DviTiming{kWidth, kActiveLines});
    clocked.clk_i(bench.core.clk);
    clocked.reset_i(bench.reset);
    clocked.link_i(link);
    clocked.pixel_o(pixel);
    clocked.event_o(event);
    const Recording<rtl::DecodedPixel>& pixels = bench.core.record(pixel);
    const Recording<rtl::DecoderEvent>& events = bench.core.record(event);
    Waveform wave;
    append_blank_lines(wave, kWidth, 2, true);
    std::vector<RandomFrame> frames;
    std::uint32_t pair = 0;
    bool depth_next = false;
    for (int i = 0; i < 250; ++i) {
        RandomFrame frame = random_frame(random, pair, depth_next);
        frame.first_clock = static_cast<std::int64_t>(wave.size());
        LinkLines lines(static_cast<std::size_t>(frame.active_lines), std::vector<std::uint32_t>(kWidth, 1));
        lines.front() = frame.control;
        lines.back().resize(static_cast<std::size_t>(frame.last_line_pixels), 1);
        append_frame(wave, kWidth, lines);
        frames.push_back(frame);
    }
    bench.core.each_clock([&](int clock) {
        const auto index = static_cast<std::size_t>(clock);
        link.write(index < wave.size() ? wave[index] : rtl::DviLink{});
    });
    bench.run_through(static_cast<int>(wave.size()) + 4);

    std::vector<tlm::LinkEvent> reported;
    std::array<int, kRejectCauseCount> causes{};
    for (std::size_t i = 0; i < frames.size(); ++i) {
        const RandomFrame& frame = frames[i];
        INFO("frame " << i);
        dut.make(frame.kind, 0);
        dut.frame->control = frame.control;
        dut.frame->active_lines = frame.active_lines;
        dut.frame->last_line_pixels = frame.last_line_pixels;
        const tlm::DecodedFrame& decoded = dut.send(frame.first_clock);
        reported.insert(reported.end(), decoded.events.begin(), decoded.events.end());
        const std::int64_t end =
            i + 1 < frames.size() ? frames[i + 1].first_clock : static_cast<std::int64_t>(wave.size());
        std::int64_t taken = 0;
        for (std::int64_t clock = frame.first_clock; clock < end; ++clock) {
            taken += pixels.at(static_cast<int>(clock)).valid ? 1 : 0;
        }
        CHECK(decoded.pixels == taken);
    }
    const std::vector<int> clocks = events.clocks_where(reports_anything);
    REQUIRE(reported.size() == clocks.size());
    int good = 0;
    int with_payload = 0;
    int payload_from = 0;
    for (std::size_t i = 0; i < reported.size(); ++i) {
        const rtl::DecoderEvent& wanted = events.at(clocks[i]);
        INFO("clock " << clocks[i]);
        REQUIRE(reported[i].edge == clocks[i] + kClocksBehindLink);
        REQUIRE(reported[i].rejected == wanted.rejected);
        if (wanted.rejected) {
            REQUIRE(reported[i].cause == wanted.cause);
            ++causes[static_cast<std::size_t>(wanted.cause)];
        }
        REQUIRE(reported[i].pair_lost == wanted.pair_lost);
        if (wanted.pair_lost) REQUIRE(reported[i].lost_number == wanted.lost_number);
        REQUIRE(reported[i].colour_start == wanted.colour_start);
        REQUIRE(reported[i].pair_good == wanted.pair_good);
        if (wanted.colour_start || wanted.pair_good) REQUIRE(reported[i].number == wanted.number);
        if (wanted.colour_start) {
            ViewportTable table;
            for (int row = clocks[i] + 1; events.at(row).row; ++row)
                table.push_back(events.at(row).table_row);
            REQUIRE(reported[i].table == table);
        }
        if (wanted.colour_start) payload_from = clocks[i];
        if (wanted.pair_good) {
            std::vector<std::uint8_t> payload;
            for (int clock = payload_from; clock < clocks[i]; ++clock) {
                const rtl::DecoderEvent& event_now = events.at(clock);
                payload.insert(payload.end(), event_now.payload.begin(),
                               event_now.payload.begin() + event_now.payload_bytes);
            }
            REQUIRE(reported[i].payload == payload);
            with_payload += payload.empty() ? 0 : 1;
        }
        good += wanted.pair_good ? 1 : 0;
    }
    CHECK(dut.decoder.rejected_frames(static_cast<std::int64_t>(wave.size()) + 4) ==
          clocked.rejected_frames());
    CHECK(good > 10);
    CHECK(with_payload > 5);
    for (int cause = 0; cause < kRejectCauseCount; ++cause) {
        INFO(reject_cause_key(static_cast<RejectCause>(cause)));
        CHECK(causes[static_cast<std::size_t>(cause)] > 0);
    }
}

}  // namespace
}  // namespace metabuffer::test::dvi_decoder_test

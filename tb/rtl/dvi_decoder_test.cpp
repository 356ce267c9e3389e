#include "rtl/dvi_decoder.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <iterator>
#include <numeric>
#include <vector>

#include "clocked_testbench.h"
#include "dvi_waveform.h"
#include "support/images.h"
#include "support/rows.h"
#include "support/scenarios.h"

namespace metabuffer::test::dvi_decoder_test {
namespace {

using rtl::DecodedPixel;
using rtl::DecoderEvent;
using rtl::DviDecoder;
using rtl::DviLink;

constexpr int kWidth = 40;  // room for four rows
constexpr int kHeight = 3;
constexpr int kActiveLines = kHeight + 1;
constexpr int kFrame = frame_clocks(kWidth, kActiveLines);
constexpr int kStartLines = 2;  // of VSYNC before the first frame
constexpr int kStart = kStartLines * line_clocks(kWidth);

/// Clocks in a frame at which the decoder can report something: the first one after the control scanline, the first one
/// after an active line, and the one at which VSYNC rises.
constexpr int kBehindControl = clock_in_frame(kWidth, kWidth, 0);
constexpr int kVsync = vsync_in_frame(kWidth, kActiveLines);
constexpr int behind_line(int active_line) { return clock_in_frame(kWidth, kWidth, active_line); }

struct NumberedEvent {
    int clock = 0;
    DecoderEvent event;
};

/// A decoder whose link plays a waveform from clock 0 on.
struct DecoderBench {
    ClockedTestbench bench;
    sc_core::sc_signal<DviLink> link;
    sc_core::sc_signal<DecodedPixel> pixel;
    sc_core::sc_signal<DecoderEvent> event;
    DviDecoder decoder;
    const Recording<DviLink>& links;
    const Recording<DecodedPixel>& pixels;
    const Recording<DecoderEvent>& events;
    Waveform wave;

    explicit DecoderBench(int width = kWidth, int active_lines = kActiveLines)
        : decoder("dvi_decoder", DviTiming{width, active_lines}),
          links(bench.core.record(link)),
          pixels(bench.core.record(pixel)),
          events(bench.core.record(event)) {
        decoder.clk_i(bench.core.clk);
        decoder.reset_i(bench.reset);
        decoder.link_i(link);
        decoder.pixel_o(pixel);
        decoder.event_o(event);
        bench.trace(decoder);
        bench.core.each_clock([this](int clock) {
            const auto index = static_cast<std::size_t>(clock);
            link.write(index < wave.size() ? wave[index] : DviLink{});
        });
    }

    void add_start() { append_blank_lines(wave, kWidth, kStartLines, true); }
    /// Appends a frame. Returns the clock at which it starts.
    int add(const LinkLines& lines) {
        const auto start = static_cast<int>(wave.size());
        append_frame(wave, kWidth, lines);
        return start;
    }
    void run() { bench.run_through(static_cast<int>(wave.size()) + 2); }

    std::vector<int> event_clocks() const {
        return events.clocks_where([](const DecoderEvent& now) { return !(now == DecoderEvent{}); });
    }
    std::vector<int> payload_clocks() const {
        return events.clocks_where([](const DecoderEvent& now) { return now.payload_bytes > 0; });
    }
    std::vector<std::uint8_t> payload() const {
        std::vector<std::uint8_t> passed;
        for (const int clock : payload_clocks()) {
            const DecoderEvent& event_now = events.at(clock);
            passed.insert(passed.end(), event_now.payload.begin(),
                          event_now.payload.begin() + event_now.payload_bytes);
        }
        return passed;
    }
    std::vector<int> pixel_clocks() const {
        return pixels.clocks_where([](const DecodedPixel& now) { return now.valid; });
    }
};

LinkLines colour(std::uint32_t number, const ViewportTable& table = {}) {
    return renderer_lines(noise_image(number + 1, kWidth, kHeight), FrameKind::kColour, number, table);
}
LinkLines depth(std::uint32_t number, const ViewportTable& table = {}) {
    return renderer_lines(noise_image(number + 1, kWidth, kHeight), FrameKind::kDepth, number, table);
}

DecoderEvent colour_start(std::uint32_t number) {
    DecoderEvent event;
    event.colour_start = true;
    event.number = number;
    return event;
}
DecoderEvent pair_good(std::uint32_t number) {
    DecoderEvent event;
    event.pair_good = true;
    event.number = number;
    return event;
}
DecoderEvent pair_lost(std::uint32_t number) {
    DecoderEvent event;
    event.pair_lost = true;
    event.lost_number = number;
    return event;
}
DecoderEvent rejected(RejectCause cause) {
    DecoderEvent event;
    event.rejected = true;
    event.cause = cause;
    return event;
}
DecoderEvent rejected(RejectCause cause, std::uint32_t lost) {
    DecoderEvent event = pair_lost(lost);
    event.rejected = true;
    event.cause = cause;
    return event;
}

/// Checks that these events come at their clocks, and none at any other.
void check_events(const DecoderBench& dut, const std::vector<NumberedEvent>& wanted) {
    std::vector<int> clocks;
    for (const NumberedEvent& entry : wanted) clocks.push_back(entry.clock);
    CHECK(dut.event_clocks() == clocks);
    for (const NumberedEvent& entry : wanted) {
        INFO("clock " << entry.clock);
        const DecoderEvent& got = dut.events.at(entry.clock);
        CHECK(got.rejected == entry.event.rejected);
        if (entry.event.rejected) CHECK(got.cause == entry.event.cause);
        CHECK(got.pair_lost == entry.event.pair_lost);
        if (entry.event.pair_lost) CHECK(got.lost_number == entry.event.lost_number);
        CHECK(got.colour_start == entry.event.colour_start);
        CHECK(got.pair_good == entry.event.pair_good);
        if (entry.event.pair_good || entry.event.colour_start) CHECK(got.number == entry.event.number);
        CHECK(got.row == entry.event.row);
        if (entry.event.row) CHECK(got.table_row == entry.event.table_row);
    }
}

/// A good pair's events.
void expect_pair(std::vector<NumberedEvent>& events, int start, std::uint32_t number) {
    events.push_back({start + kBehindControl, colour_start(number)});
    events.push_back({start + kFrame + kVsync, pair_good(number)});
}

std::int64_t rejects(const DecoderBench& dut, RejectCause cause) {
    return dut.decoder.rejected_frames()[static_cast<std::size_t>(cause)];
}
std::int64_t all_rejects(const DecoderBench& dut) {
    std::int64_t sum = 0;
    for (const std::int64_t count : dut.decoder.rejected_frames()) sum += count;
    return sum;
}

TEST_CASE("dvi decoder: in reset and on an idle link nothing is reported") {
    DecoderBench dut;
    dut.bench.run_through(500);
    CHECK(dut.events.at(-1) == DecoderEvent{});
    CHECK(dut.pixels.at(-1) == DecodedPixel{});
    CHECK(dut.event_clocks().empty());
    CHECK(dut.pixel_clocks().empty());
}

TEST_CASE(
    "dvi decoder: a pixel on the link at one clock is on pixel_o after the next, with address and kind") {
    DecoderBench dut;
    dut.add_start();
    const int start = dut.add(colour(5));
    dut.add(depth(5));
    dut.run();
    std::vector<int> wanted;
    for (int frame = 0; frame < 2; ++frame) {
        for (int y = 0; y < kHeight; ++y) {
            for (int x = 0; x < kWidth; ++x) {
                wanted.push_back(start + frame * kFrame + clock_in_frame(kWidth, x, y + 1));
            }
        }
    }
    REQUIRE(dut.pixel_clocks() == wanted);  // the control scanline is not among them
    std::size_t next = 0;
    for (int frame = 0; frame < 2; ++frame) {
        for (int address = 0; address < kWidth * kHeight; ++address, ++next) {
            const int clock = wanted[next];
            INFO("clock " << clock);
            CHECK(dut.links.at(clock).de);
            CHECK(dut.pixels.at(clock).data == dut.links.at(clock).data);
            CHECK(dut.pixels.at(clock).address == static_cast<std::uint32_t>(address));
            CHECK(dut.pixels.at(clock).kind == static_cast<FrameKind>(frame));
        }
    }
}

TEST_CASE("dvi decoder: the control scanline's verdict comes as DE falls, the pair's as VSYNC rises") {
    DecoderBench dut;
    dut.add_start();
    const int start = dut.add(colour(7));
    dut.add(depth(7));
    dut.add(colour(8));
    dut.add(depth(8));
    dut.run();
    std::vector<NumberedEvent> events;
    expect_pair(events, start, 7);
    expect_pair(events, start + 2 * kFrame, 8);
    check_events(dut, events);
    // The clocks meant are the first with DE low and the first with VSYNC high.
    CHECK(dut.links.at(start + kBehindControl - 1).de);
    CHECK_FALSE(dut.links.at(start + kBehindControl).de);
    CHECK_FALSE(dut.links.at(start + kVsync - 1).vsync);
    CHECK(dut.links.at(start + kVsync).vsync);
    CHECK(all_rejects(dut) == 0);
}

TEST_CASE(
    "dvi decoder: the colour frame's rows follow its verdict one a clock, the depth frame's rows are "
    "ignored") {
    const ViewportTable table = {table_row(1, {1, 2}, {3, 1}, {-1, -2}, 3),
                                 table_row(2, {0, 0}, {1, 1}, {5, 6}),
                                 table_row(9, {7, 0}, {2, 2}, {0, 0}, 255)};
    DecoderBench dut;
    dut.add_start();
    const int start = dut.add(colour(0, table));
    dut.add(depth(0, {table_row(4, {4, 0}, {4, 1}, {4, 4})}));
    dut.run();
    std::vector<NumberedEvent> events = {{start + kBehindControl, colour_start(0)}};
    for (int row = 0; row < 3; ++row) {
        DecoderEvent event;
        event.row = true;
        event.table_row = table[static_cast<std::size_t>(row)];
        events.push_back({start + kBehindControl + 1 + row, event});
    }
    events.push_back({start + kFrame + kVsync, pair_good(0)});
    check_events(dut, events);
}

TEST_CASE(
    "dvi decoder: a depth frame's payload passes in the clocks of its bytes, a colour frame's does not") {
    DecoderBench dut;
    dut.add_start();
    const PixelImage image = noise_image(1, kWidth, kHeight);
    const std::vector<std::uint8_t> payload{10, 20, 30, 40, 50, 60, 70};
    dut.add(renderer_lines(image, FrameKind::kColour, 7, {}, payload));
    // Rows shift the payload: 16 + 16 + 2 bytes come before it.
    const int start =
        dut.add(renderer_lines(image, FrameKind::kDepth, 7, {table_row(1, {0, 0}, {1, 1}, {0, 0})}, payload));
    dut.run();
    const auto clocks = dut.payload_clocks();
    const int first = start + clock_in_frame(kWidth, 34 / 3, 0);
    REQUIRE(clocks == std::vector<int>{first, first + 1, first + 2});
    CHECK(dut.payload() == payload);
    CHECK(dut.events.at(first).payload_bytes == 2);  // bytes 34 and 35
}

TEST_CASE(
    "dvi decoder: rows before the payload and its bytes are as many as both bytes of their counts say") {
    constexpr int kRows = 0x102;
    constexpr int kWide = 1500;
    ViewportTable table;
    for (int i = 0; i < kRows; ++i) table.push_back(table_row(i + 1, {i, 0}, {1, 1}, {i, 0}));
    std::vector<std::uint8_t> payload(0x12B);
    std::iota(payload.begin(), payload.end(), std::uint8_t{10});
    const PixelImage image = noise_image(23, kWide, 1);
    DecoderBench dut(kWide, 2);
    append_blank_lines(dut.wave, kWide, 1, true);
    append_frame(dut.wave, kWide, renderer_lines(image, FrameKind::kColour, 0, table, payload));
    const auto start = static_cast<int>(dut.wave.size());
    append_frame(dut.wave, kWide, renderer_lines(image, FrameKind::kDepth, 0, table, payload));
    dut.run();
    const auto clocks = dut.payload_clocks();
    CHECK(dut.payload() == payload);
    REQUIRE_FALSE(clocks.empty());
    // Header, rows and the payload's length come before it.
    CHECK(clocks.front() == start + clock_in_frame(kWide, (16 + 16 * kRows + 2) / 3, 0));
}

TEST_CASE("dvi decoder: no payload passes without a colour frame before it") {
    DecoderBench dut;
    dut.add_start();
    const PixelImage image = noise_image(1, kWidth, kHeight);
    dut.add(renderer_lines(image, FrameKind::kDepth, 0, {}, {1, 2, 3}));
    dut.add(colour(1));
    dut.add(depth(1));
    dut.add(renderer_lines(image, FrameKind::kDepth, 1, {}, {1, 2, 3}));  // sent twice
    dut.run();
    CHECK(dut.payload_clocks().empty());
}

TEST_CASE("dvi decoder: a long table's rows run on beside the first pixels") {
    constexpr int kRows = 100;
    constexpr int kWide = 550;
    ViewportTable table;
    for (int i = 0; i < kRows; ++i) table.push_back(table_row(i + 1, {i, 0}, {1, 1}, {i, 0}));
    const PixelImage image = noise_image(21, kWide, 1);
    DecoderBench dut(kWide, 2);
    append_blank_lines(dut.wave, kWide, 1, true);
    append_frame(dut.wave, kWide, renderer_lines(image, FrameKind::kColour, 0, table));
    dut.run();
    const int verdict = line_clocks(kWide) + clock_in_frame(kWide, kWide, 0);
    const int first_pixel = line_clocks(kWide) + clock_in_frame(kWide, 0, 1);
    REQUIRE(first_pixel - verdict < kRows);
    CHECK(dut.events.clocks_where([](const DecoderEvent& event) { return event.row; }) ==
          clock_range(verdict + 1, verdict + 1 + kRows));
    CHECK(dut.events.at(verdict + kRows).table_row == table.back());
    CHECK(dut.pixel_clocks() == clock_range(first_pixel, first_pixel + kWide));
}

// ---- start-up ----

TEST_CASE("dvi decoder: a link that comes up in the middle of a frame is ignored up to the first VSYNC") {
    DecoderBench dut;
    append_frame(dut.wave, kWidth, colour(3));
    dut.wave.erase(dut.wave.begin(), dut.wave.begin() + clock_in_frame(kWidth, 5, 1));
    dut.add(depth(3));
    const int start = dut.add(colour(4));
    dut.add(depth(4));
    dut.run();
    // The depth frame's own colour frame was never seen whole. Nothing is rejected, but its pair will not come.
    std::vector<NumberedEvent> events = {{start - kFrame + kBehindControl, pair_lost(3)}};
    expect_pair(events, start, 4);
    check_events(dut, events);
    CHECK(dut.pixel_clocks().front() == start + clock_in_frame(kWidth, 0, 1));
    CHECK(all_rejects(dut) == 0);
}

TEST_CASE("dvi decoder: a further VSYNC without lines between them is not a frame") {
    DecoderBench dut;
    dut.add_start();
    append_blank_lines(dut.wave, kWidth, 3, false);
    append_blank_lines(dut.wave, kWidth, 1, true);
    append_blank_lines(dut.wave, kWidth, 3, false);
    append_blank_lines(dut.wave, kWidth, 1, true);
    const int start = dut.add(colour(0));
    append_blank_lines(dut.wave, kWidth, 3, false);
    append_blank_lines(dut.wave, kWidth, 1, true);
    const int depth_start = dut.add(depth(0));
    dut.run();
    check_events(dut, {{start + kBehindControl, colour_start(0)}, {depth_start + kVsync, pair_good(0)}});
}

TEST_CASE("dvi decoder: VSYNC ends a frame as it rises, not for as long as it stands") {
    DecoderBench dut;
    dut.add_start();
    // It still stands while the colour frame's lines come.
    const auto start = static_cast<int>(dut.wave.size());
    append_blank_lines(dut.wave, kWidth, kBackLines, true);
    for (const auto& line : colour(0)) append_line(dut.wave, kWidth, line, true);
    append_blank_lines(dut.wave, kWidth, kFrontLines, false);
    append_blank_lines(dut.wave, kWidth, kSyncLines, true);
    dut.add(depth(0));
    dut.run();
    std::vector<NumberedEvent> events;
    expect_pair(events, start, 0);
    check_events(dut, events);
}

// ---- rejections ----

/// Plays good pair 0, pair 1 with one corrupt frame, good pair 2. The rejection is due at `clock` of the corrupt frame
/// with the event given. If the other frame of pair 1 is a depth frame, it is ignored, and its pair is reported as lost
/// unless that is known already.
void check_rejection(FrameKind spoilt, const std::function<void(LinkLines&)>& spoil, int clock,
                     RejectCause cause, bool lost_known) {
    DecoderBench dut;
    dut.add_start();
    std::vector<NumberedEvent> events;
    expect_pair(events, dut.add(colour(0)), 0);
    dut.add(depth(0));
    LinkLines colour_lines = colour(1);
    LinkLines depth_lines = depth(1);
    spoil(spoilt == FrameKind::kColour ? colour_lines : depth_lines);
    const int colour_frame = dut.add(colour_lines);
    const int depth_frame = dut.add(depth_lines);
    const DecoderEvent rejection = lost_known ? rejected(cause, 1) : rejected(cause);
    const int verdict = (spoilt == FrameKind::kColour ? colour_frame : depth_frame) + clock;
    if (spoilt == FrameKind::kDepth) {
        events.push_back({colour_frame + kBehindControl, colour_start(1)});
        events.push_back({verdict, rejection});
    } else {
        if (lost_known) events.push_back({colour_frame + kBehindControl, colour_start(1)});
        events.push_back({verdict, rejection});
        events.push_back({depth_frame + kBehindControl, pair_lost(1)});
    }
    const int good = dut.add(colour(2));
    dut.add(depth(2));
    expect_pair(events, good, 2);
    dut.run();
    check_events(dut, events);
    CHECK(rejects(dut, cause) == 1);
    CHECK(all_rejects(dut) == 1);
    // From the rejection to the next good colour frame no pixel is passed on.
    for (const int pixel_clock : dut.pixel_clocks()) {
        INFO("pixel at clock " << pixel_clock);
        CHECK((pixel_clock < verdict || pixel_clock > good));
    }
}

void break_byte(LinkLines& lines, int byte) {
    lines.front()[static_cast<std::size_t>(byte / 3)] ^= 1U << (16 - 8 * (byte % 3));
}

TEST_CASE("dvi decoder: rejects a bad magic in a colour frame") {
    check_rejection(
        FrameKind::kColour, [](LinkLines& lines) { break_byte(lines, 3); }, kBehindControl,
        RejectCause::kMagic, false);
}
TEST_CASE("dvi decoder: rejects a bad magic in a depth frame, and the pair with it") {
    check_rejection(
        FrameKind::kDepth, [](LinkLines& lines) { break_byte(lines, 0); }, kBehindControl,
        RejectCause::kMagic, true);
}
TEST_CASE("dvi decoder: rejects a bad version") {
    check_rejection(
        FrameKind::kColour, [](LinkLines& lines) { break_byte(lines, 4); }, kBehindControl,
        RejectCause::kVersion, false);
}
TEST_CASE("dvi decoder: rejects a bad CRC") {
    check_rejection(
        FrameKind::kDepth, [](LinkLines& lines) { break_byte(lines, 8); }, kBehindControl, RejectCause::kCrc,
        true);
}
TEST_CASE("dvi decoder: rejects an unknown kind under a good CRC") {
    check_rejection(
        FrameKind::kDepth,
        [](LinkLines& lines) { lines.front() = control_line(kWidth, static_cast<FrameKind>(2), 1); },
        kBehindControl, RejectCause::kKind, true);
}
TEST_CASE("dvi decoder: rejects a line one pixel short as DE falls after it") {
    check_rejection(
        FrameKind::kColour, [](LinkLines& lines) { lines[2].pop_back(); }, behind_line(2) - 1,
        RejectCause::kGeometry, true);
}
TEST_CASE("dvi decoder: rejects a line one pixel long at the pixel too many") {
    check_rejection(
        FrameKind::kDepth, [](LinkLines& lines) { lines[3].push_back(0); }, behind_line(3),
        RejectCause::kGeometry, true);
}
TEST_CASE("dvi decoder: rejects a control scanline one pixel short before it reads its content") {
    check_rejection(
        FrameKind::kColour, [](LinkLines& lines) { lines[0].pop_back(); }, kBehindControl - 1,
        RejectCause::kGeometry, false);
}
TEST_CASE("dvi decoder: rejects a frame one line short as VSYNC rises after it") {
    check_rejection(
        FrameKind::kDepth, [](LinkLines& lines) { lines.pop_back(); },
        vsync_in_frame(kWidth, kActiveLines - 1), RejectCause::kGeometry, true);
}
TEST_CASE("dvi decoder: rejects a colour frame one line short as VSYNC rises after it") {
    check_rejection(
        FrameKind::kColour, [](LinkLines& lines) { lines.pop_back(); },
        vsync_in_frame(kWidth, kActiveLines - 1), RejectCause::kGeometry, true);
}
TEST_CASE("dvi decoder: rejects a frame one line long at the first pixel of that line") {
    check_rejection(
        FrameKind::kColour, [](LinkLines& lines) { lines.push_back(lines.back()); },
        clock_in_frame(kWidth, 0, kActiveLines), RejectCause::kGeometry, true);
}

TEST_CASE("dvi decoder: a colour frame after a colour frame tears the first pair and starts the second") {
    DecoderBench dut;
    dut.add_start();
    const int first = dut.add(colour(0));
    const int second = dut.add(colour(1));
    dut.add(depth(1));
    dut.run();
    DecoderEvent torn = rejected(RejectCause::kPair, 0);
    torn.colour_start = true;
    torn.number = 1;
    check_events(dut, {{first + kBehindControl, colour_start(0)},
                       {second + kBehindControl, torn},
                       {second + kFrame + kVsync, pair_good(1)}});
    CHECK(rejects(dut, RejectCause::kPair) == 1);
}

TEST_CASE("dvi decoder: a depth frame of another number tears the pair, and the lower of the two is lost") {
    // 5 and 6: the depth frame's number is wrong, or frames are missing. 8 and 7: the colour frame's is
    // wrong.
    DecoderBench dut;
    dut.add_start();
    const int first = dut.add(colour(5));
    dut.add(depth(6));
    const int second = dut.add(colour(8));
    dut.add(depth(7));
    const int good = dut.add(colour(9));
    dut.add(depth(9));
    dut.run();
    std::vector<NumberedEvent> events = {{first + kBehindControl, colour_start(5)},
                                         {first + kFrame + kBehindControl, rejected(RejectCause::kPair, 5)},
                                         {second + kBehindControl, colour_start(8)},
                                         {second + kFrame + kBehindControl, rejected(RejectCause::kPair, 7)}};
    expect_pair(events, good, 9);
    check_events(dut, events);
    CHECK(rejects(dut, RejectCause::kPair) == 2);
    // The depth half of a torn pair is never passed on.
    for (const int clock : dut.pixel_clocks()) {
        if (clock < good) CHECK(dut.pixels.at(clock).kind == FrameKind::kColour);
    }
}

TEST_CASE("dvi decoder: frame numbers count on from 2^32 - 1 to 0 and the one before is the lost one") {
    constexpr std::uint32_t kLast = 0xFFFF'FFFFU;
    DecoderBench dut;
    dut.add_start();
    const int first = dut.add(colour(kLast));
    dut.add(depth(0));
    const int second = dut.add(colour(0));
    dut.add(depth(kLast));
    const int good = dut.add(colour(1));
    dut.add(depth(1));
    dut.run();
    std::vector<NumberedEvent> events = {
        {first + kBehindControl, colour_start(kLast)},
        {first + kFrame + kBehindControl, rejected(RejectCause::kPair, kLast)},
        {second + kBehindControl, colour_start(0)},
        {second + kFrame + kBehindControl, rejected(RejectCause::kPair, kLast)}};
    expect_pair(events, good, 1);
    check_events(dut, events);
}

TEST_CASE("dvi decoder: a depth frame after a whole pair lacks its colour frame") {
    DecoderBench dut;
    dut.add_start();
    const int first = dut.add(colour(0));
    dut.add(depth(0));
    const int lone = dut.add(depth(1));
    const int good = dut.add(colour(2));
    dut.add(depth(2));
    dut.run();
    std::vector<NumberedEvent> events;
    expect_pair(events, first, 0);
    events.push_back({lone + kBehindControl, rejected(RejectCause::kPair, 1)});
    expect_pair(events, good, 2);
    check_events(dut, events);
}

TEST_CASE("dvi decoder: a colour frame sent twice begins its pair again and loses none") {
    DecoderBench dut;
    dut.add_start();
    const int first = dut.add(colour(4));
    const int second = dut.add(colour(4));
    dut.add(depth(4));
    dut.run();
    DecoderEvent again = colour_start(4);
    again.rejected = true;
    again.cause = RejectCause::kPair;
    check_events(dut, {{first + kBehindControl, colour_start(4)},
                       {second + kBehindControl, again},
                       {second + kFrame + kVsync, pair_good(4)}});
    CHECK(rejects(dut, RejectCause::kPair) == 1);
}

TEST_CASE("dvi decoder: a depth frame sent twice is rejected after its whole pair and loses none") {
    DecoderBench dut;
    dut.add_start();
    const int first = dut.add(colour(4));
    dut.add(depth(4));
    const int second = dut.add(depth(4));
    const int good = dut.add(colour(5));
    dut.add(depth(5));
    dut.run();
    std::vector<NumberedEvent> events;
    expect_pair(events, first, 4);
    DecoderEvent again;
    again.rejected = true;
    again.cause = RejectCause::kPair;
    events.push_back({second + kBehindControl, again});
    expect_pair(events, good, 5);
    check_events(dut, events);
    CHECK(rejects(dut, RejectCause::kPair) == 1);
    // Nothing of it reaches the memory, where the whole pair may still stand.
    for (const int clock : dut.pixel_clocks()) CHECK((clock < second || clock >= good));
}

TEST_CASE("dvi decoder: after a rejection further bad frames are counted, depth frames are ignored") {
    DecoderBench dut;
    dut.add_start();
    LinkLines bad_first = colour(0);
    break_byte(bad_first, 0);
    LinkLines bad_second = colour(1);
    break_byte(bad_second, 4);
    const int first = dut.add(bad_first);
    const int first_depth = dut.add(depth(0));
    const int second = dut.add(bad_second);
    const int second_depth = dut.add(depth(1));
    const int good = dut.add(colour(2));
    dut.add(depth(2));
    dut.run();
    std::vector<NumberedEvent> events = {{first + kBehindControl, rejected(RejectCause::kMagic)},
                                         {first_depth + kBehindControl, pair_lost(0)},
                                         {second + kBehindControl, rejected(RejectCause::kVersion)},
                                         {second_depth + kBehindControl, pair_lost(1)}};
    expect_pair(events, good, 2);
    check_events(dut, events);
    CHECK(rejects(dut, RejectCause::kMagic) == 1);
    CHECK(rejects(dut, RejectCause::kVersion) == 1);
    CHECK(all_rejects(dut) == 2);
}

TEST_CASE("dvi decoder: a reset in the middle of a pair forgets it") {
    DecoderBench dut;
    dut.add_start();
    const int first = dut.add(colour(0));
    const int lone = dut.add(depth(0));
    const int good = dut.add(colour(1));
    dut.add(depth(1));
    dut.bench.core.pulse(dut.bench.reset, first + kFrame - line_clocks(kWidth));
    dut.run();
    // The reset fell within the first frame's VSYNC, which is still high after it: frames start there.
    std::vector<NumberedEvent> events = {{first + kBehindControl, colour_start(0)},
                                         {lone + kBehindControl, pair_lost(0)}};
    expect_pair(events, good, 1);
    check_events(dut, events);
}

TEST_CASE("dvi decoder: a reset at any moment of a pair leaves what power-up leaves") {
    constexpr int kStride = 127;  // not a divisor of a line
    DecoderBench dut;
    dut.add_start();
    const ViewportTable table(3, segment_row({2, 2}));
    std::vector<int> good;
    std::vector<int> resets;
    // The clocks behind a verdict and behind a row, and many others.
    std::vector<int> moments{kBehindControl + 1, kBehindControl + 2, kFrame + kVsync + 1};
    for (int moment = 5; moment < 2 * kFrame; moment += kStride) moments.push_back(moment);
    for (const int reset : moments) {
        const int cut = dut.add(colour(7, table));
        dut.add(depth(7, table));
        resets.push_back(cut + reset);
        dut.bench.core.pulse(dut.bench.reset, resets.back());
        good.push_back(dut.add(colour(1)));
        dut.add(depth(1));
    }
    dut.run();
    const std::vector<int> told = dut.event_clocks();
    for (std::size_t i = 0; i < resets.size(); ++i) {
        INFO("the reset at clock " << resets[i]);
        REQUIRE(dut.events.at(resets[i]) == DecoderEvent{});
        REQUIRE(dut.pixels.at(resets[i]) == DecodedPixel{});
        // No row of the table before the reset comes after it.
        REQUIRE(std::none_of(told.begin(), told.end(), [&](int clock) {
            return clock >= resets[i] && clock < good[i] && dut.events.at(clock).row;
        }));
    }
    for (const int start : good) {
        INFO("pair at clock " << start);
        std::vector<int> clocks;
        std::copy_if(told.begin(), told.end(), std::back_inserter(clocks),
                     [start](int clock) { return clock >= start && clock < start + 2 * kFrame; });
        REQUIRE(clocks == std::vector<int>{start + kBehindControl, start + kFrame + kVsync});
        REQUIRE(dut.events.at(clocks[0]) == colour_start(1));
        REQUIRE(dut.events.at(clocks[1]) == pair_good(1));
    }
}

}  // namespace
}  // namespace metabuffer::test::dvi_decoder_test

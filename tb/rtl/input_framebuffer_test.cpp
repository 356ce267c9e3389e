#include "rtl/input_framebuffer.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "clocked_testbench.h"
#include "datapath/arbitration/arbitration_table.h"
#include "dvi_waveform.h"
#include "monitors/bus_monitor.h"
#include "scenario/derived_timing.h"
#include "support/images.h"
#include "support/random_seed.h"
#include "support/scenarios.h"

namespace metabuffer::test::input_framebuffer_test {
namespace {

using rtl::BusBeat;
using rtl::DecodedPixel;
using rtl::DecoderEvent;
using rtl::InputFramebuffer;
using BeatKind = rtl::BusBeat::Kind;

/// An input framebuffer between a decoder and the composers of its row, all played by the test. The bus's protocol
/// monitor watches it.
struct InputBench {
    Scenario scenario;
    ClockDomain& core;
    ClockDomain& link;
    sc_core::sc_signal<DecodedPixel> pixel;
    sc_core::sc_signal<DecoderEvent> event;
    sc_core::sc_signal<bool> pair_request;
    std::vector<std::unique_ptr<sc_core::sc_signal<bool>>> busready;    ///< high unless a test drives it
    std::vector<std::unique_ptr<sc_core::sc_signal<bool>>> tableready;  ///< likewise
    sc_core::sc_signal<BusBeat> bus;
    InputFramebuffer framebuffer;
    monitors::ViolationLog violations;
    monitors::BusMonitor monitor;
    const Recording<BusBeat>& beats;
    const Recording<bool>& requests;
    std::vector<const Recording<bool>*> busreadies;

    InputBench(ClockedTestbench& bench, const std::string& name, Scenario with,
               ClockDomain* link_domain = nullptr)
        : scenario(std::move(with)),
          core(bench.core),
          link(link_domain != nullptr ? *link_domain : bench.core),
          framebuffer(name.c_str(), scenario, 0),
          monitor((name + "_monitor").c_str(), scenario, 0, violations),
          beats(core.record(bus)),
          requests(link.record(pair_request)) {
        framebuffer.clk_i(core.clk);
        framebuffer.reset_i(bench.reset);
        framebuffer.dvi_clk_i(link.clk);
        framebuffer.pixel_i(pixel);
        framebuffer.event_i(event);
        framebuffer.pair_request_o(pair_request);
        framebuffer.bus_o(bus);
        monitor.clk_i(core.clk);
        monitor.reset_i(bench.reset);
        monitor.bus_i(bus);
        for (int d = 0; d < scenario.displays.count(); ++d) {
            const std::string suffix = "_" + name + "_" + std::to_string(d + 1);
            busready.push_back(
                std::make_unique<sc_core::sc_signal<bool>>(("busready" + suffix).c_str(), true));
            tableready.push_back(
                std::make_unique<sc_core::sc_signal<bool>>(("tableready" + suffix).c_str(), true));
            framebuffer.busready_i[static_cast<std::size_t>(d)](*busready.back());
            framebuffer.tableready_i[static_cast<std::size_t>(d)](*tableready.back());
            monitor.busready_i[static_cast<std::size_t>(d)](*busready.back());
            monitor.tableready_i[static_cast<std::size_t>(d)](*tableready.back());
            busreadies.push_back(&core.record(*busready.back()));
        }
        bench.trace(framebuffer);
        link.each_clock([this](int clock) {
            const auto event_now = events_.find(clock);
            event.write(event_now == events_.end() ? DecoderEvent{} : event_now->second);
            const auto pixel_now = pixels_.find(clock);
            pixel.write(pixel_now == pixels_.end() ? DecodedPixel{} : pixel_now->second);
        });
    }

    // ---- what the decoder reports, by link clock ----

    DecoderEvent& event_at(int clock) { return events_[clock]; }
    void colour_start(int clock, std::uint32_t number) {
        event_at(clock).colour_start = true;
        event_at(clock).number = number;
    }
    void pair_good(int clock, std::uint32_t number) {
        event_at(clock).pair_good = true;
        event_at(clock).number = number;
    }
    void pair_lost(int clock, std::uint32_t number) {
        event_at(clock).pair_lost = true;
        event_at(clock).lost_number = number;
    }
    /// One frame's pixels, one a clock. Returns the clock after the last.
    int put_pixels(int clock, const PixelImage& image, FrameKind kind) {
        std::uint32_t address = 0;
        for (const auto& line : image_lines(image, kind)) {
            for (const std::uint32_t data : line)
                pixels_[clock++] = DecodedPixel{true, kind, address++, data};
        }
        return clock;
    }
    /// A colour frame's verdict, rows and pixels. Returns the clock after the last pixel.
    int put_colour(int clock, std::uint32_t number, const ViewportTable& table, const PixelImage& image) {
        colour_start(clock, number);
        int row_clock = clock;
        for (const ViewportRow& row : table) {
            event_at(++row_clock).row = true;
            event_at(row_clock).table_row = row;
        }
        return std::max(put_pixels(clock + 1, image, FrameKind::kColour), row_clock + 1);
    }
    /// The slot table that the host sends with a depth frame.
    void put_slots(int clock, const ViewportTable& table) {
        constexpr std::size_t kRoomBytes = 4096;
        const std::vector<std::uint8_t> payload =
            slot_payload(scenario.bus.arbitration,
                         validate_table(table, scenario.limits(scenario.renderers.front())), kRoomBytes);
        for (std::size_t byte = 0; byte < payload.size(); ++byte) {
            DecoderEvent& event = event_at(clock + static_cast<int>(byte) / kLinkBytesPerPixel);
            event.payload[event.payload_bytes++] = payload[byte];
        }
    }
    /// A whole pair from `clock` on. Returns the clock of its verdict: good.
    int put_pair(int clock, std::uint32_t number, const ViewportTable& table, const PixelImage& image) {
        const int depth = put_colour(clock, number, table, image);
        put_slots(depth, table);
        const int verdict = put_pixels(depth, image, FrameKind::kDepth);
        pair_good(verdict, number);
        return verdict;
    }
    /// The same, such that the verdict comes at a given clock.
    void put_pair_until(int verdict, std::uint32_t number, const ViewportTable& table,
                        const PixelImage& image) {
        put_pair(verdict - 1 - 2 * static_cast<int>(image.values.size()), number, table, image);
    }

    /// Display d (from 1) takes no slot at edge `clock`.
    void drop_busready(int d, int clock, int clocks = 1) {
        core.drive(*busready[static_cast<std::size_t>(d - 1)], clock, false);
        core.drive(*busready[static_cast<std::size_t>(d - 1)], clock + clocks, true);
    }

    // ---- what came out ----

    RendererCounters counters() const { return framebuffer.counters(); }
    BusCounters bus_counters() const { return counters().bus; }

    std::vector<int> clocks_of(BeatKind kind) const {
        return beats.clocks_where([kind](const BusBeat& beat) { return beat.kind == kind; });
    }
    std::vector<int> pixel_clocks_of(int destination) const {
        return beats.clocks_where([destination](const BusBeat& beat) {
            return beat.kind == BeatKind::kPixels && beat.destination == destination;
        });
    }

  private:
    std::map<int, DecoderEvent> events_;
    std::map<int, DecodedPixel> pixels_;
};

/// With link and core on one clock, the pair's verdict is answered in its clock and crosses two registers. The
/// broadcast begins in the clock after that.
constexpr int kVerdictToFrameStart = 3;
/// From a frame's last beat: one clock to ask, two registers to the link, two back, and the broadcast.
constexpr int kLastBeatToFrameStart = 6;
constexpr int kVerdict = 400;  ///< of the first pair in most tests
constexpr int kFrameStart = kVerdict + kVerdictToFrameStart;

constexpr int kImageWidth = 16;
constexpr int kImageHeight = 4;

struct BusSpeed {
    int width_bits = 64;
    int words_per_cycle = 1;
    int burst = 8;
    int page_words = 4096;
    int page_miss = 0;
};

Scenario input_scenario(const BusSpeed& speed, int displays = 1, int frames = 1) {
    Scenario scenario = small_scenario(64, 64, displays);
    scenario.frames = frames;
    scenario.bus.width_bits = speed.width_bits;
    scenario.bus.burst_pixels = speed.burst;
    scenario.bus.arbitration = Arbitration::kRoundRobin;
    scenario.memory.words_per_cycle = speed.words_per_cycle;
    scenario.memory.page_words = speed.page_words;
    scenario.memory.page_miss_cycles = speed.page_miss;
    scenario.composer.buffer_pixels = 1024;
    scenario.composer.ready_space_pixels = 16;
    scenario.link_timeout_pairs = 1;
    scenario.renderers.push_back(renderer_of({PixelImage(kImageWidth, kImageHeight)}));
    return scenario;
}

PixelImage image_of(std::uint64_t seed) { return noise_image(seed, kImageWidth, kImageHeight); }

/// Rows of 16 x 1 pixels each for displays 1, 2, ...: source row d to display d.
ViewportTable one_line_each(int displays) {
    ViewportTable table;
    for (int d = 1; d <= displays; ++d) {
        table.push_back(table_row(d, {0, d - 1}, {kImageWidth, 1}, {0, 0}));
    }
    return table;
}

std::vector<Pixel> segment_pixels(const PixelImage& image, const ViewportRow& row) {
    std::vector<Pixel> pixels;
    for (int y = row.sy; y < row.sy + row.sdy; ++y) {
        for (int x = row.sx; x < row.sx + row.sdx; ++x) pixels.push_back(image.at(x, y));
    }
    return pixels;
}

/// All pixels that were sent to a display from a clock on, and before another.
std::vector<Pixel> sent_to(const InputBench& dut, int destination, int from, int to) {
    std::vector<Pixel> pixels;
    for (const int clock : dut.pixel_clocks_of(destination)) {
        if (clock < from || clock >= to) continue;
        const BusBeat& beat = dut.beats.at(clock);
        for (int i = 0; i < beat.count; ++i) pixels.emplace_back(beat.words[static_cast<std::size_t>(i)]);
    }
    return pixels;
}

/// Checks that each of these beats is on the bus at its clock, and none at any other.
void check_bus(const InputBench& dut, const std::map<int, BusBeat>& wanted) {
    for (int clock = 0; clock < dut.beats.end_clock(); ++clock) {
        const auto entry = wanted.find(clock);
        const BusBeat beat = entry == wanted.end() ? BusBeat{} : entry->second;
        INFO("clock " << clock << ": " << dut.beats.at(clock) << " for " << beat);
        REQUIRE(dut.beats.at(clock) == beat);
    }
}

BusBeat pixel_beat(int destination, const std::vector<Pixel>& pixels, std::size_t first, int count,
                   int remaining) {
    BusBeat beat;
    beat.kind = BeatKind::kPixels;
    beat.destination = static_cast<std::uint16_t>(destination);
    beat.count = static_cast<std::uint8_t>(count);
    beat.remaining = static_cast<std::uint32_t>(remaining);
    beat.first = static_cast<std::uint32_t>(first);
    for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i)
        beat.words[i] = pixels[first + i].word();
    return beat;
}

// ---- asking for a pair ----

TEST_CASE(
    "input framebuffer: in reset bus and pair request are idle, the request rises at the first link clock") {
    ClockedTestbench bench;
    InputBench dut(bench, "dut", input_scenario({}));
    bench.run_through(50);
    CHECK_FALSE(dut.requests.at(-1));
    CHECK(dut.requests.high() == clock_range(0, 51));
    CHECK(dut.beats.at(-1) == BusBeat{});
    CHECK(dut.clocks_of(BeatKind::kNone) == clock_range(0, 51));
}

TEST_CASE("input framebuffer: a good pair that is waited for is broadcast three clocks after its verdict") {
    ClockedTestbench bench;
    InputBench dut(bench, "dut", input_scenario({}));
    dut.put_pair_until(kVerdict, 0, one_line_each(1), image_of(81));
    bench.run_through(kFrameStart + 60);
    CHECK(dut.clocks_of(BeatKind::kFrameStart) == std::vector<int>{kFrameStart});
    // The pair went straight to the front: the back bank was never occupied.
    CHECK(dut.requests.falls().empty());
}

TEST_CASE("input framebuffer: a pair that is good before it is asked for occupies the back bank until then") {
    ClockedTestbench bench;
    InputBench dut(bench, "dut", input_scenario({}, 1, 2));
    dut.put_pair_until(kVerdict, 0, one_line_each(1), image_of(82));
    dut.put_pair(kVerdict + 1, 1, one_line_each(1), image_of(83));
    // Frame 0 is held back until pair 1 is whole.
    const int hold = 300;
    dut.drop_busready(1, 0, kVerdict + hold);
    bench.run_through(kVerdict + hold + 100);
    const int verdict = kVerdict + 2 + 2 * kImageWidth * kImageHeight;
    const int last_beat = kVerdict + hold + kImageWidth - 1;
    CHECK(dut.requests.falls() == std::vector<int>{verdict});
    CHECK(dut.requests.rises() == std::vector<int>{0, last_beat + 3});  // one clock to ask, two registers
    CHECK(dut.clocks_of(BeatKind::kFrameStart) ==
          std::vector<int>{kFrameStart, last_beat + kLastBeatToFrameStart});
    CHECK(sent_to(dut, 1, 0, last_beat + 1) == segment_pixels(image_of(82), one_line_each(1)[0]));
    CHECK(sent_to(dut, 1, last_beat + 1, 9999) == segment_pixels(image_of(83), one_line_each(1)[0]));
    CHECK(dut.counters().repeated_frames == 0);
    CHECK(dut.counters().dropped_frames == 0);
}

void check_crossing(std::int64_t link_period_picoseconds) {
    ClockedTestbench bench;
    ClockDomain& link = bench.add_clock("link", link_period_picoseconds);
    InputBench dut(bench, "dut", input_scenario({}, 1, 2), &link);
    const PixelImage first = image_of(84);
    const PixelImage second = image_of(85);
    dut.put_pair_until(300, 0, one_line_each(1), first);
    // The second pair is whole long before it is asked for.
    const int verdict = dut.put_pair(301, 1, one_line_each(1), second);
    const std::int64_t core_clock =
        (verdict + 10) * link_period_picoseconds / ClockedTestbench::kCorePeriodPicoseconds;
    const auto hold = static_cast<int>(core_clock);
    dut.drop_busready(1, 0, hold);
    bench.run_through(hold + 150);

    const int start = seen_at(link, 300, bench.core) + 1;
    const int last_beat = hold + kImageWidth - 1;
    const int answered = seen_at(bench.core, last_beat + 1, link);
    CHECK(dut.clocks_of(BeatKind::kFrameStart) ==
          std::vector<int>{start, seen_at(link, answered, bench.core) + 1});
    CHECK(dut.requests.falls() == std::vector<int>{verdict});
    CHECK(dut.requests.rises() == std::vector<int>{0, answered});
    CHECK(sent_to(dut, 1, 0, last_beat + 1) == segment_pixels(first, one_line_each(1)[0]));
    CHECK(sent_to(dut, 1, last_beat + 1, 9999) == segment_pixels(second, one_line_each(1)[0]));
}

TEST_CASE("input framebuffer: from a faster link each value crosses at its two registers' clock") {
    check_crossing(6'100);
}
TEST_CASE("input framebuffer: from a slower link each value crosses at its two registers' clock") {
    check_crossing(33'300);
}

// ---- the table ----

TEST_CASE("input framebuffer: a table row takes 128 bits' worth of clocks on each bus width, at least one") {
    ClockedTestbench bench;
    const std::map<int, int> clocks_per_row = {{16, 8}, {32, 4}, {64, 2}, {128, 1}, {256, 1}, {512, 1}};
    const ViewportTable table = {table_row(3, {1, 2}, {5, 1}, {-3, -4}, 5),
                                 table_row(1, {15, 3}, {1, 1}, {63, 63}),
                                 table_row(2, {0, 0}, {1, 1}, {0, 7}, 255)};
    std::map<int, std::unique_ptr<InputBench>> duts;
    for (const auto& [width, clocks] : clocks_per_row) {
        BusSpeed speed;
        speed.width_bits = width;
        duts[width] =
            std::make_unique<InputBench>(bench, "dut_" + std::to_string(width), input_scenario(speed, 3));
        for (int d = 1; d <= 3; ++d) duts[width]->drop_busready(d, 0, 10'000);  // the table and no pixels
        duts[width]->put_pair_until(kVerdict, 0, table, image_of(86));
    }
    bench.run_through(kFrameStart + 100);
    for (const auto& [width, clocks] : clocks_per_row) {
        INFO(width << " bits");
        std::map<int, BusBeat> wanted = {{kFrameStart, BusBeat::frame_start(0, false)}};
        for (int row = 0; row < 3; ++row) {
            wanted[kFrameStart + (row + 1) * clocks] = BusBeat::table_row(
                0, static_cast<std::uint32_t>(row), table[static_cast<std::size_t>(row)], row == 2);
        }
        check_bus(*duts[width], wanted);
        for (int row = 0; row < 3; ++row) {
            CHECK(duts[width]->beats.at(kFrameStart + (row + 1) * clocks).row() ==
                  table[static_cast<std::size_t>(row)]);
        }
        CHECK(duts[width]->bus_counters().table_cycles == 1 + 3 * clocks);
    }
}

TEST_CASE("input framebuffer: an empty table is one beat, the frame start, which is its last") {
    ClockedTestbench bench;
    InputBench dut(bench, "dut", input_scenario({}, 2));
    dut.put_pair_until(kVerdict, 0, {}, image_of(87));
    bench.run_through(kFrameStart + 50);
    check_bus(dut, {{kFrameStart, BusBeat::frame_start(0, true)}});
}

TEST_CASE("input framebuffer: the broadcast polls until every TABLEREADY is high and begins in that clock") {
    ClockedTestbench bench;
    InputBench dut(bench, "dut", input_scenario({}, 3));
    dut.put_pair_until(kVerdict, 0, one_line_each(3), image_of(88));
    bench.core.drive(*dut.tableready[0], 0, false);
    bench.core.drive(*dut.tableready[2], 0, false);
    bench.core.drive(*dut.tableready[0], kFrameStart + 5, true);
    bench.core.drive(*dut.tableready[2], kFrameStart + 17, true);
    bench.run_through(kFrameStart + 100);
    CHECK(dut.clocks_of(BeatKind::kFrameStart) == std::vector<int>{kFrameStart + 17});
    CHECK(dut.bus_counters().poll_cycles == 17);
}

TEST_CASE("input framebuffer: rows that break a rule are dropped and counted, the others are broadcast") {
    ClockedTestbench bench;
    InputBench dut(bench, "dut", input_scenario({}, 2));
    const ViewportRow good = table_row(2, {0, 0}, {4, 1}, {0, 0});
    dut.put_pair_until(kVerdict, 0,
                       {table_row(3, {0, 0}, {1, 1}, {0, 0}), good, table_row(2, {0, 1}, {4, 1}, {0, 0}),
                        table_row(1, {14, 0}, {4, 1}, {0, 0})},
                       image_of(89));
    bench.run_through(kFrameStart + 50);
    const int row_clock = kFrameStart + 2;
    REQUIRE(dut.clocks_of(BeatKind::kTableRow) == std::vector<int>{row_clock});
    CHECK(dut.beats.at(row_clock).row() == good);
    CHECK(dut.beats.at(row_clock).last);
    const auto& rejected = dut.counters().rejected_rows;
    CHECK(rejected[static_cast<std::size_t>(RowDefect::kDisplay)] == 1);
    CHECK(rejected[static_cast<std::size_t>(RowDefect::kDuplicate)] == 1);
    CHECK(rejected[static_cast<std::size_t>(RowDefect::kSource)] == 1);
    CHECK(dut.counters().rejected_row_messages.size() == 3);
}

// ---- bursts, beats and pages ----

/// When and how one segment's pixels go to a lone composer that is always ready. The first burst begins in the first
/// clock after the table, each burst in the clock of its grant. On an open page beats follow without a gap; a word of
/// another page comes page_miss clocks later. A burst of one beat is followed by a clock without a beat, since BUSREADY
/// cannot count it yet.
std::map<int, BusBeat> lone_schedule(const BusSpeed& speed, const PixelImage& image, const ViewportRow& row,
                                     int first_clock) {
    const int bus_pixels = std::max(1, speed.width_bits / 64);
    const int most = std::min(bus_pixels, speed.words_per_cycle);
    const int beat_clocks = std::max(1, 64 / speed.width_bits);
    std::vector<int> pages;
    for (int y = row.sy; y < row.sy + row.sdy; ++y) {
        for (int x = row.sx; x < row.sx + row.sdx; ++x) {
            pages.push_back((y * image.width_pixels + x) / speed.page_words);
        }
    }
    const std::vector<Pixel> pixels = segment_pixels(image, row);
    std::map<int, BusBeat> schedule;
    int clock = first_clock;
    int open_page = -1;
    std::size_t next = 0;
    while (next < pixels.size()) {
        int burst = std::min<int>(speed.burst, static_cast<int>(pixels.size() - next));
        int beats = 0;
        while (burst > 0) {
            if (pages[next] != open_page) {
                open_page = pages[next];
                clock += speed.page_miss;
            }
            int count = 1;
            while (count < most && count < burst &&
                   pages[next + static_cast<std::size_t>(count)] == open_page) {
                ++count;
            }
            burst -= count;
            schedule[clock + beat_clocks - 1] = pixel_beat(row.dcomp, pixels, next, count, burst);
            next += static_cast<std::size_t>(count);
            clock += beat_clocks;
            ++beats;
        }
        if (beats == 1) ++clock;
    }
    return schedule;
}

TEST_CASE(
    "input framebuffer: beats on every bus width, memory width, burst length and page size, clock by clock") {
    ClockedTestbench bench;
    const PixelImage image = image_of(90);
    // Source rows that end within pages and bursts: 13 of 16 pixels.
    const ViewportRow row = table_row(1, {2, 0}, {13, 4}, {0, 0});
    std::vector<BusSpeed> speeds;
    for (const int width : {16, 32, 64, 128, 256, 512}) {
        for (const int words : {1, 3, 8}) {
            for (const int burst : {1, 8, 11, 100}) {
                for (const auto& [page_words, page_miss] :
                     std::vector<std::pair<int, int>>{{4096, 6}, {16, 5}, {7, 1}, {1, 2}, {5, 0}}) {
                    speeds.push_back({width, words, burst, page_words, page_miss});
                }
            }
        }
    }
    std::vector<std::unique_ptr<InputBench>> duts;
    for (const BusSpeed& speed : speeds) {
        duts.push_back(
            std::make_unique<InputBench>(bench, "dut_" + std::to_string(duts.size()), input_scenario(speed)));
        duts.back()->put_pair_until(kVerdict, 0, {row}, image);
    }
    bench.run_through(kFrameStart + 600);
    for (std::size_t i = 0; i < speeds.size(); ++i) {
        const BusSpeed& speed = speeds[i];
        INFO(speed.width_bits << " bits, " << speed.words_per_cycle << " words a cycle, bursts of "
                              << speed.burst << ", pages of " << speed.page_words << ", misses of "
                              << speed.page_miss);
        const int row_clock = kFrameStart + std::max(1, 128 / speed.width_bits);
        std::map<int, BusBeat> wanted = lone_schedule(speed, image, row, row_clock + 1);
        wanted[kFrameStart] = BusBeat::frame_start(0, false);
        wanted[row_clock] = BusBeat::table_row(0, 0, row, true);
        check_bus(*duts[i], wanted);
    }
}

TEST_CASE(
    "input framebuffer: two composers in turn, each burst's first beat right after the last beat of the "
    "burst before") {
    ClockedTestbench bench;
    InputBench eights(bench, "eights", input_scenario({}, 2));
    BusSpeed one_beat;
    one_beat.burst = 1;
    InputBench ones(bench, "ones", input_scenario(one_beat, 2));
    const PixelImage image = image_of(91);
    const ViewportTable table = one_line_each(2);
    eights.put_pair_until(kVerdict, 0, table, image);
    ones.put_pair_until(kVerdict, 0, table, image);
    bench.run_through(kFrameStart + 80);
    const int first = kFrameStart + 4 + 1;
    CHECK(eights.clocks_of(BeatKind::kPixels) == clock_range(first, first + 2 * kImageWidth));
    CHECK(ones.clocks_of(BeatKind::kPixels) == clock_range(first, first + 2 * kImageWidth));
    for (int i = 0; i < 2 * kImageWidth; ++i) {
        INFO("beat " << i);
        CHECK(eights.beats.at(first + i).destination == 1 + i / 8 % 2);
        CHECK(eights.beats.at(first + i).remaining == static_cast<std::uint32_t>(7 - i % 8));
        CHECK(ones.beats.at(first + i).destination == 1 + i % 2);
    }
}

TEST_CASE("input framebuffer: a new frame finds no page open") {
    ClockedTestbench bench;
    BusSpeed speed;
    speed.page_miss = 5;
    InputBench dut(bench, "dut", input_scenario(speed, 1, 2));
    dut.put_pair_until(kVerdict, 0, one_line_each(1), image_of(92));
    dut.pair_lost(kVerdict + 1, 1);  // the second frame is the first pair again
    bench.run_through(kFrameStart + 100);
    const int first = kFrameStart + 2 + 1 + 5;
    const int second = first + kImageWidth - 1 + kLastBeatToFrameStart + 2 + 1 + 5;
    std::vector<int> wanted = clock_range(first, first + kImageWidth);
    for (const int clock : clock_range(second, second + kImageWidth)) wanted.push_back(clock);
    CHECK(dut.clocks_of(BeatKind::kPixels) == wanted);
    CHECK(dut.bus_counters().page_misses == 2);
    CHECK(dut.bus_counters().page_miss_cycles == 10);
}

TEST_CASE("input framebuffer: edf with a single display sends its segment as every policy does") {
    ClockedTestbench bench;
    Scenario scenario = input_scenario({}, 1, 1);
    scenario.bus.arbitration = Arbitration::kEdf;
    InputBench dut(bench, "dut", scenario);
    dut.put_pair_until(kVerdict, 0, one_line_each(1), image_of(93));
    bench.run_through(kFrameStart + 40);
    CHECK(sent_to(dut, 1, kFrameStart, kFrameStart + 40) ==
          segment_pixels(image_of(93), one_line_each(1).front()));
}

// ---- BUSREADY ----

/// Two composers in turn on a bus of one pixel a clock, bursts of 8. Composer 1's first burst starts at
/// kFirstBeat; its BUSREADY is low at one edge. How many beats of the burst go out?
constexpr int kFirstBeat = kFrameStart + 4 + 1;

TEST_CASE(
    "input framebuffer: a BUSREADY drop in a burst stops it before that clock's beat, and the next slot "
    "starts in the same clock") {
    ClockedTestbench bench;
    // A drop at the burst's second clock was written before its first beat had been sampled, and one at its
    // ninth answers for a further slot: neither cuts it.
    const std::map<int, int> beats_left = {{1, 8}, {2, 2}, {3, 3}, {4, 4}, {6, 6}, {7, 7}, {8, 8}};
    const PixelImage image = image_of(93);
    const ViewportTable table = one_line_each(2);
    std::map<int, std::unique_ptr<InputBench>> duts;
    for (const auto& [drop, beats] : beats_left) {
        duts[drop] =
            std::make_unique<InputBench>(bench, "dut_" + std::to_string(drop), input_scenario({}, 2));
        duts[drop]->put_pair_until(kVerdict, 0, table, image);
        duts[drop]->drop_busready(1, kFirstBeat + drop);
    }
    bench.run_through(kFirstBeat + 60);
    for (const auto& [drop, beats] : beats_left) {
        INFO("BUSREADY low at the burst's clock " << drop);
        const InputBench& dut = *duts[drop];
        for (int i = 0; i < beats; ++i) {
            CHECK(dut.beats.at(kFirstBeat + i).destination == 1);
            CHECK(dut.beats.at(kFirstBeat + i).remaining == static_cast<std::uint32_t>(7 - i));
        }
        for (int i = 0; i < 8; ++i) CHECK(dut.beats.at(kFirstBeat + beats + i).destination == 2);
        CHECK(dut.beats.at(kFirstBeat + beats + 8).destination == 1);
        // Composer 1's next burst goes on where the cut one ended, and nothing is lost or sent twice.
        CHECK(dut.beats.at(kFirstBeat + beats + 8).words[0] == image.at(beats, 0).word());
        CHECK(sent_to(dut, 1, 0, 9999) == segment_pixels(image, table[0]));
        CHECK(sent_to(dut, 2, 0, 9999) == segment_pixels(image, table[1]));
        // No clock of the bus is lost to the drop.
        CHECK(dut.clocks_of(BeatKind::kPixels) == clock_range(kFirstBeat, kFirstBeat + 2 * kImageWidth));
    }
}

TEST_CASE("input framebuffer: a stop while a page is being opened ends the burst at once") {
    ClockedTestbench bench;
    BusSpeed speed;
    speed.page_words = 4;
    speed.page_miss = 10;
    InputBench dut(bench, "dut", input_scenario(speed, 2));
    const PixelImage image = image_of(94);
    dut.put_pair_until(kVerdict, 0, one_line_each(2), image);
    const int first = kFirstBeat + 10;
    // Four beats, then the next page is opened; the drop comes in the third clock of that.
    dut.drop_busready(1, first + 4 + 2);
    bench.run_through(first + 40);
    CHECK(dut.pixel_clocks_of(1).size() >= 4);
    CHECK(dut.beats.at(first + 3).destination == 1);
    // Composer 2's first page is opened from that clock on.
    CHECK(dut.pixel_clocks_of(2).front() == first + 4 + 2 + 10);
    CHECK(sent_to(dut, 1, 0, first + 16) == [&] {
        std::vector<Pixel> pixels = segment_pixels(image, one_line_each(2)[0]);
        pixels.resize(4);
        return pixels;
    }());
}

TEST_CASE(
    "input framebuffer: on a narrow bus a beat that is moving when BUSREADY drops is the burst's last") {
    ClockedTestbench bench;
    BusSpeed narrow;
    narrow.width_bits = 16;
    InputBench two(bench, "two", input_scenario(narrow, 2));
    InputBench lone(bench, "lone", input_scenario(narrow, 2));
    InputBench early(bench, "early", input_scenario(narrow, 2));
    const PixelImage image = image_of(95);
    two.put_pair_until(kVerdict, 0, one_line_each(2), image);
    lone.put_pair_until(kVerdict, 0, one_line_each(1), image);
    early.put_pair_until(kVerdict, 0, one_line_each(2), image);
    const auto granted_at = [](int rows) { return kFrameStart + 8 * rows + 1; };
    // The first beat goes out at +3, is sampled at +4, and the answer is read at +5: the second beat moves.
    two.drop_busready(1, granted_at(2) + 5);
    lone.drop_busready(1, granted_at(1) + 5);
    early.drop_busready(1, granted_at(2) + 4);  // written before the first beat was sampled
    bench.run_through(granted_at(2) + 60);

    const int from = granted_at(2);
    CHECK(two.beats.at(from + 3).remaining == 7);
    CHECK(two.beats.at(from + 7).destination == 1);
    CHECK(two.beats.at(from + 7).remaining == 0);  // pixels that will not come are not announced
    CHECK(two.beats.at(from + 11).destination == 2);
    CHECK(two.pixel_clocks_of(1)[1] == from + 7);

    // In the clock after the second beat BUSREADY does not count it yet: the composer is passed over once.
    const int alone = granted_at(1);
    const std::vector<int> clocks = lone.pixel_clocks_of(1);
    CHECK(clocks[0] == alone + 3);
    CHECK(clocks[1] == alone + 7);
    CHECK(clocks[2] == alone + 12);
    CHECK(clocks[3] == alone + 16);

    for (int i = 0; i < 8; ++i) CHECK(early.beats.at(from + 3 + 4 * i).destination == 1);
    CHECK(early.beats.at(from + 3 + 32).destination == 2);
}

TEST_CASE(
    "input framebuffer: when no composer takes a slot the bus polls and starts in the clock that finds one") {
    ClockedTestbench bench;
    InputBench dut(bench, "dut", input_scenario({}, 2));
    dut.put_pair_until(kVerdict, 0, one_line_each(2), image_of(96));
    dut.drop_busready(1, 0, kFirstBeat + 50);
    dut.drop_busready(2, 0, kFirstBeat + 23);
    bench.run_through(kFirstBeat + 100);
    CHECK(dut.pixel_clocks_of(2).front() == kFirstBeat + 23);
    CHECK(dut.pixel_clocks_of(1).front() == kFirstBeat + 50);
    CHECK(dut.bus_counters().poll_cycles == 23 + 50 - 23 - kImageWidth);
}

// ---- arbitration on the bus ----

TEST_CASE(
    "input framebuffer: slots that their composer cannot use are recovered without a lost clock and "
    "counted") {
    ClockedTestbench bench;
    InputBench dut(bench, "dut", input_scenario({}, 3));
    const PixelImage image = image_of(97);
    dut.put_pair_until(kVerdict, 0, one_line_each(3), image);
    const int first = kFrameStart + 6 + 1;
    dut.drop_busready(2, 0, first + 40);
    bench.run_through(first + 100);
    // 1, 3, 1, 3 without a gap; then only composer 2 has anything left.
    CHECK(dut.pixel_clocks_of(1).size() == kImageWidth);
    std::vector<int> busy = dut.clocks_of(BeatKind::kPixels);
    busy.resize(2 * kImageWidth);
    CHECK(busy == clock_range(first, first + 2 * kImageWidth));
    for (int i = 0; i < 2 * kImageWidth; ++i) {
        CHECK(dut.beats.at(first + i).destination == (i / 8 % 2 == 0 ? 1 : 3));
    }
    CHECK(dut.pixel_clocks_of(2) == clock_range(first + 40, first + 40 + kImageWidth));
    // Slot 2 before each of 3's two bursts, slot 1 before 2's first, slots 3 and 1 before its second.
    CHECK(dut.bus_counters().recovered_slots == 2 + 1 + 2);
    CHECK(dut.bus_counters().bursts == 6);
}

TEST_CASE("input framebuffer: under slot-allocation an idle slot's time is lost, a burst's worth of clocks") {
    ClockedTestbench bench;
    struct Case {
        BusSpeed speed;
        int slot_clocks;
    };
    const std::vector<Case> cases = {
        {{64, 1, 8, 4096, 0}, 8}, {{16, 1, 4, 4096, 0}, 16}, {{256, 3, 8, 4096, 0}, 3}};  // beats of three
    std::vector<std::unique_ptr<InputBench>> duts;
    for (const Case& entry : cases) {
        Scenario scenario = input_scenario(entry.speed, 2);
        scenario.bus.arbitration = Arbitration::kSlotAllocation;
        duts.push_back(std::make_unique<InputBench>(bench, "dut_" + std::to_string(duts.size()), scenario));
        duts.back()->put_pair_until(kVerdict, 0, one_line_each(2), image_of(98));
        duts.back()->drop_busready(2, 0, 10'000);
    }
    bench.run_through(kFrameStart + 300);
    for (std::size_t i = 0; i < cases.size(); ++i) {
        const BusSpeed& speed = cases[i].speed;
        INFO(speed.width_bits << " bits");
        const std::vector<int> clocks = duts[i]->pixel_clocks_of(1);
        const int most = std::min(std::max(1, speed.width_bits / 64), speed.words_per_cycle);
        const int burst_beats = (speed.burst + most - 1) / most;
        const auto beat_clocks = std::max(1, 64 / speed.width_bits);
        const auto second_burst = static_cast<std::size_t>(burst_beats);
        REQUIRE(clocks.size() > second_burst);
        // From the last beat of the first burst: the lost slot, then a beat.
        CHECK(clocks[second_burst] - clocks[second_burst - 1] == cases[i].slot_clocks + beat_clocks);
        // After composer 1's last pixel every slot is lost.
        CHECK(clocks.size() == static_cast<std::size_t>(kImageWidth / speed.burst * burst_beats));
        const int from = kFrameStart + 2 * std::max(1, 128 / speed.width_bits) + 1;
        const auto busy = static_cast<std::int64_t>(clocks.size()) * beat_clocks;
        CHECK(duts[i]->bus_counters().lost_cycles == kFrameStart + 300 - from + 1 - busy);
        CHECK(duts[i]->bus_counters().poll_cycles == 0);
    }
}

// ---- lockstep ----

/// DVI input clocks after which a pair is given up: the pair times, and the vertical sync of a link that
/// comes up.
constexpr int kTimeout =
    2 * frame_clocks(kImageWidth, kImageHeight + 1) + kSyncLines * line_clocks(kImageWidth);
constexpr int kSendClocks = 2 + kImageWidth;  ///< from frame start to last beat with one_line_each(1)

TEST_CASE(
    "input framebuffer: lockstep repeats the last pair in the clock that reports the wanted one as lost") {
    ClockedTestbench bench;
    InputBench while_asking(bench, "while_asking", input_scenario({}, 1, 2));
    InputBench before(bench, "before", input_scenario({}, 1, 2));
    InputBench other(bench, "other", input_scenario({}, 1, 2));
    const PixelImage image = image_of(99);
    for (InputBench* dut : {&while_asking, &before, &other}) {
        dut->put_pair_until(kVerdict, 0, one_line_each(1), image);
    }
    const int last_beat = kFrameStart + kSendClocks;
    while_asking.pair_lost(last_beat + 200, 1);
    before.pair_lost(last_beat - 10, 1);
    other.pair_lost(last_beat + 200, 2);  // not the one that is waited for
    bench.run_through(last_beat + 300);
    CHECK(while_asking.clocks_of(BeatKind::kFrameStart) ==
          std::vector<int>{kFrameStart, last_beat + 200 + kVerdictToFrameStart});
    CHECK(before.clocks_of(BeatKind::kFrameStart) ==
          std::vector<int>{kFrameStart, last_beat + kLastBeatToFrameStart});
    CHECK(other.clocks_of(BeatKind::kFrameStart) == std::vector<int>{kFrameStart});
    for (const InputBench* dut : {&while_asking, &before}) {
        CHECK(sent_to(*dut, 1, last_beat + 1, 9999) == segment_pixels(image, one_line_each(1)[0]));
        CHECK(dut->counters().repeated_frames == 1);
        CHECK(dut->framebuffer.frame_sources()[1].pair == 0);
        CHECK_FALSE(dut->framebuffer.frame_sources()[1].fresh);
    }
}

TEST_CASE("input framebuffer: lockstep gives a pair up when its time is over, not a clock earlier or later") {
    ClockedTestbench bench;
    InputBench never(bench, "never", input_scenario({}, 2, 2));
    InputBench second(bench, "second", input_scenario({}, 1, 2));
    Scenario patient_scenario = input_scenario({}, 1, 1);
    patient_scenario.link_timeout_pairs = 2;
    InputBench patient(bench, "patient", patient_scenario);
    second.put_pair_until(kVerdict, 0, one_line_each(1), image_of(100));
    const int pair_time = 2 * frame_clocks(kImageWidth, kImageHeight + 1);
    bench.run_through(2 * kTimeout + 50);
    // The first link clock is clock 0: the timeout is over at clock kTimeout - 1. A renderer that has had no
    // pair contributes an empty table.
    const int first = kTimeout - 1 + kVerdictToFrameStart;
    CHECK(never.clocks_of(BeatKind::kFrameStart) == std::vector<int>{first, first + kTimeout});
    CHECK(never.beats.at(first).last);
    CHECK(never.clocks_of(BeatKind::kTableRow).empty());
    CHECK(never.counters().repeated_frames == 2);
    CHECK(never.framebuffer.frame_sources()[0].pair == -1);
    // The next one's time runs from the answer before it.
    CHECK(second.clocks_of(BeatKind::kFrameStart) ==
          std::vector<int>{kFrameStart, kVerdict + kTimeout + kVerdictToFrameStart});
    CHECK(second.counters().repeated_frames == 1);
    CHECK(patient.clocks_of(BeatKind::kFrameStart) ==
          std::vector<int>{kTimeout + pair_time - 1 + kVerdictToFrameStart});
}

TEST_CASE("input framebuffer: lockstep holds a pair that is ahead and repeats the one before it meanwhile") {
    ClockedTestbench bench;
    InputBench dut(bench, "dut", input_scenario({}, 1, 3));
    const PixelImage first = image_of(101);
    const PixelImage third = image_of(102);
    dut.put_pair_until(kVerdict, 0, one_line_each(1), first);
    const int last_beat = kFrameStart + kSendClocks;
    const int verdict = last_beat + 400;
    dut.put_pair_until(verdict, 2, one_line_each(1), third);
    bench.run_through(verdict + 200);
    const int repeat = verdict + kVerdictToFrameStart;
    const int repeat_end = repeat + kSendClocks;
    CHECK(dut.clocks_of(BeatKind::kFrameStart) ==
          std::vector<int>{kFrameStart, repeat, repeat_end + kLastBeatToFrameStart});
    CHECK(sent_to(dut, 1, repeat, repeat_end + 1) == segment_pixels(first, one_line_each(1)[0]));
    CHECK(sent_to(dut, 1, repeat_end + 1, 9999) == segment_pixels(third, one_line_each(1)[0]));
    CHECK(dut.counters().repeated_frames == 1);
    CHECK(dut.counters().dropped_frames == 0);
    CHECK(dut.framebuffer.frame_sources()[2].pair == 2);
    CHECK(dut.framebuffer.frame_sources()[2].fresh);
}

TEST_CASE(
    "input framebuffer: lockstep drops a pair that comes after it was given up, and frees its bank at once") {
    ClockedTestbench bench;
    InputBench dut(bench, "dut", input_scenario({}, 1, 3));
    const PixelImage first = image_of(103);
    const PixelImage third = image_of(105);
    dut.put_pair_until(kVerdict, 0, one_line_each(1), first);
    const int given_up = kVerdict + kTimeout;
    const int late = given_up + 400;
    dut.put_pair_until(late, 1, one_line_each(1), image_of(104));
    const int next = dut.put_pair(late + 1, 2, one_line_each(1), third);
    bench.run_through(next + 100);
    CHECK(dut.clocks_of(BeatKind::kFrameStart) ==
          std::vector<int>{kFrameStart, given_up + kVerdictToFrameStart, next + kVerdictToFrameStart});
    CHECK(sent_to(dut, 1, given_up, next) == segment_pixels(first, one_line_each(1)[0]));
    CHECK(sent_to(dut, 1, next, 9999) == segment_pixels(third, one_line_each(1)[0]));
    CHECK(dut.counters().dropped_frames == 1);
    CHECK(dut.counters().repeated_frames == 1);
    CHECK(dut.requests.falls().empty());
}

TEST_CASE(
    "input framebuffer: a pair that was too late starts the timeout again, since the next one comes only "
    "then") {
    ClockedTestbench bench;
    InputBench dut(bench, "dut", input_scenario({}, 1, 3));
    dut.put_pair_until(kVerdict, 0, one_line_each(1), image_of(103));
    const int given_up = kVerdict + kTimeout;
    const int late = given_up + 400;
    dut.put_pair_until(late, 1, one_line_each(1), image_of(104));
    bench.run_through(late + kTimeout + 50);
    CHECK(dut.clocks_of(BeatKind::kFrameStart) == std::vector<int>{kFrameStart,
                                                                   given_up + kVerdictToFrameStart,
                                                                   late + kTimeout + kVerdictToFrameStart});
    CHECK(dut.counters().dropped_frames == 1);
    CHECK(dut.counters().repeated_frames == 2);
}

TEST_CASE("input framebuffer: a pair that is coming in is not given up, for one pair time at most") {
    ClockedTestbench bench;
    InputBench coming(bench, "coming", input_scenario({}, 1, 2));
    InputBench stuck(bench, "stuck", input_scenario({}, 1, 2));
    const PixelImage second = image_of(126);
    for (InputBench* dut : {&coming, &stuck}) {
        dut->put_pair_until(kVerdict, 0, one_line_each(1), image_of(125));
    }
    const int given_up = kVerdict + kTimeout;
    const int pair_time = 2 * frame_clocks(kImageWidth, kImageHeight + 1);
    const int verdict = coming.put_pair(given_up - 1, 1, one_line_each(1), second);
    REQUIRE(verdict > given_up);
    stuck.put_colour(given_up - 1, 1, one_line_each(1), second);
    bench.run_through(given_up + pair_time + 50);
    CHECK(coming.clocks_of(BeatKind::kFrameStart) ==
          std::vector<int>{kFrameStart, verdict + kVerdictToFrameStart});
    CHECK(coming.counters().repeated_frames == 0);
    CHECK(sent_to(coming, 1, verdict, given_up + pair_time) == segment_pixels(second, one_line_each(1)[0]));
    CHECK(stuck.clocks_of(BeatKind::kFrameStart) ==
          std::vector<int>{kFrameStart, given_up - 1 + pair_time + kVerdictToFrameStart});
    CHECK(stuck.counters().repeated_frames == 1);
}

TEST_CASE("input framebuffer: a torn pair never shows, neither its pixels nor its table") {
    ClockedTestbench bench;
    InputBench dut(bench, "dut", input_scenario({}, 1, 3));
    const PixelImage first = image_of(106);
    const PixelImage third = image_of(108);
    const ViewportTable other = {table_row(1, {3, 2}, {5, 2}, {1, 1})};
    dut.put_pair_until(kVerdict, 0, one_line_each(1), first);
    // Pair 1: a whole colour frame with another table, half a depth frame, and the rejection.
    const int depth = dut.put_colour(kVerdict + 200, 1, other, image_of(107));
    dut.put_pixels(depth, image_of(107), FrameKind::kDepth);
    const int rejection = depth + kImageWidth * kImageHeight / 2;
    dut.event_at(rejection).rejected = true;
    dut.event_at(rejection).cause = RejectCause::kGeometry;
    dut.pair_lost(rejection, 1);
    const int verdict = dut.put_pair(rejection + 200, 2, other, third);
    bench.run_through(verdict + 100);
    CHECK(dut.clocks_of(BeatKind::kFrameStart) ==
          std::vector<int>{kFrameStart, rejection + kVerdictToFrameStart, verdict + kVerdictToFrameStart});
    CHECK(sent_to(dut, 1, rejection, verdict) == segment_pixels(first, one_line_each(1)[0]));
    CHECK(sent_to(dut, 1, verdict, 9999) == segment_pixels(third, other[0]));
    CHECK(dut.requests.falls().empty());
}

/// Plays the same pair and the same BUSREADY in each round, with a reset at a later moment each time. After the reset
/// everything must happen as in the round before.
void check_resets(const BusSpeed& speed) {
    constexpr int kRound = 700;
    constexpr int kRoundVerdict = 150;
    constexpr int kRounds = 45;
    ClockedTestbench bench;
    Scenario scenario = input_scenario(speed, 2, 3);
    scenario.link_timeout_pairs = 1000;
    scenario.composer.ready_space_pixels = 4;
    InputBench dut(bench, "dut", scenario);
    const ViewportTable table = one_line_each(2);
    const auto reset_at = [](int round) { return kRoundVerdict + 1 + 4 * round; };
    for (int round = 0; round < kRounds; ++round) {
        dut.put_pair_until(round * kRound + kRoundVerdict, 0, table, image_of(5));
        if (round < kRounds - 1) dut.core.pulse(bench.reset, round * kRound + reset_at(round));
    }
    dut.core.each_clock([&dut](int clock) {
        const int offset = clock % kRound;
        dut.busready[0]->write(offset % 11 != 4 && offset % 11 != 5);
        dut.busready[1]->write(offset % 7 != 2);
    });
    bench.run_through(kRounds * kRound);
    for (int round = 1; round < kRounds; ++round) {
        for (int clock = 0; clock < reset_at(round - 1); ++clock) {
            INFO("round " << round << ", clock " << clock);
            const int now = round * kRound + clock;
            if (clock < 2) continue;  // the bus may still have been asking in the round before
            REQUIRE(dut.beats.at(now) == dut.beats.at(now - kRound));
            REQUIRE(dut.requests.at(now) == dut.requests.at(now - kRound));
        }
    }
    const int last = (kRounds - 1) * kRound;
    for (const ViewportRow& row : table) {
        CHECK(sent_to(dut, row.dcomp, last, last + kRound) == segment_pixels(image_of(5), row));
    }
}

TEST_CASE("input framebuffer: a reset at any moment of a frame leaves what power-up leaves") {
    BusSpeed speed;
    speed.page_words = 8;
    speed.page_miss = 3;
    speed.burst = 8;
    check_resets(speed);
}
TEST_CASE("input framebuffer: a reset in the middle of a beat on a narrow bus leaves nothing of it") {
    BusSpeed speed;
    speed.width_bits = 16;
    speed.page_words = 8;
    speed.page_miss = 3;
    speed.burst = 4;
    check_resets(speed);
}

TEST_CASE("input framebuffer: after the scenario's last frame the bus stays idle") {
    ClockedTestbench bench;
    InputBench dut(bench, "dut", input_scenario({}, 1, 1));
    dut.put_pair_until(kVerdict, 0, one_line_each(1), image_of(109));
    const int verdict = dut.put_pair(kVerdict + 1, 1, one_line_each(1), image_of(110));
    bench.run_through(verdict + 300);
    CHECK(dut.clocks_of(BeatKind::kFrameStart) == std::vector<int>{kFrameStart});
    CHECK(dut.clocks_of(BeatKind::kPixels).back() == kFrameStart + kSendClocks);
    CHECK(dut.requests.falls() == std::vector<int>{verdict});  // nobody asks for it: the bank stays occupied
    CHECK(dut.requests.rises() == std::vector<int>{0});
}

// ---- free-running ----

TEST_CASE(
    "input framebuffer: free-running goes on to the newest whole pair, counts those overwritten unseen, and "
    "sends the same again when there is none") {
    ClockedTestbench bench;
    Scenario scenario = input_scenario({}, 1, 4);
    scenario.pacing = Pacing::kFreeRunning;
    InputBench dut(bench, "dut", scenario);
    const PixelImage first = image_of(111);
    const PixelImage newest = image_of(114);
    dut.put_pair_until(kVerdict, 0, one_line_each(1), first);
    int verdict = kVerdict;
    for (std::uint32_t pair = 1; pair <= 3; ++pair) {
        verdict = dut.put_pair(verdict + 1, pair, one_line_each(1), image_of(111 + pair));
    }
    // Frame 0 is held until pair 3 is whole. So pairs 1 and 2 are overwritten before frame 1 is asked for.
    const int hold = verdict + 5;
    dut.drop_busready(1, 0, hold);
    bench.run_through(hold + 200);
    const int end = hold + kImageWidth - 1;
    const int frame_1 = end + kLastBeatToFrameStart;
    const int frame_2 = frame_1 + kSendClocks + kLastBeatToFrameStart;
    const int frame_3 = frame_2 + kSendClocks + kLastBeatToFrameStart;
    CHECK(dut.clocks_of(BeatKind::kFrameStart) == std::vector<int>{kFrameStart, frame_1, frame_2, frame_3});
    CHECK(sent_to(dut, 1, 0, frame_1) == segment_pixels(first, one_line_each(1)[0]));
    CHECK(sent_to(dut, 1, frame_1, frame_2) == segment_pixels(newest, one_line_each(1)[0]));
    CHECK(sent_to(dut, 1, frame_2, frame_3) == segment_pixels(newest, one_line_each(1)[0]));
    CHECK(sent_to(dut, 1, frame_3, 9999) == segment_pixels(newest, one_line_each(1)[0]));
    CHECK(dut.counters().dropped_frames == 2);  // pairs 1 and 2
    CHECK(dut.counters().repeated_frames == 2);
}

TEST_CASE(
    "input framebuffer: free-running waits for the first pair, and repeats while the next one is half way") {
    ClockedTestbench bench;
    Scenario scenario = input_scenario({}, 1, 2);
    scenario.pacing = Pacing::kFreeRunning;
    InputBench dut(bench, "dut", scenario);
    const PixelImage first = image_of(115);
    dut.put_pair_until(kVerdict, 0, one_line_each(1), first);
    dut.put_pair(kVerdict + 1, 1, one_line_each(1), image_of(116));
    bench.run_through(kVerdict + 120);
    const int frame_1 = kFrameStart + kSendClocks + kLastBeatToFrameStart;
    REQUIRE(frame_1 < kVerdict + 2 * kImageWidth * kImageHeight);  // pair 1 is not whole yet
    CHECK(dut.clocks_of(BeatKind::kFrameStart) == std::vector<int>{kFrameStart, frame_1});
    CHECK(sent_to(dut, 1, frame_1, 9999) == segment_pixels(first, one_line_each(1)[0]));
    CHECK(dut.counters().repeated_frames == 1);
    CHECK(dut.counters().dropped_frames == 0);
}

TEST_CASE(
    "input framebuffer: free-running accepts a new pair whatever its number, after any number of repeats") {
    ClockedTestbench bench;
    Scenario scenario = input_scenario({}, 1, 8);
    scenario.pacing = Pacing::kFreeRunning;
    InputBench dut(bench, "dut", scenario);
    const PixelImage second = image_of(128);
    dut.put_pair_until(kVerdict, 0, one_line_each(1), image_of(127));
    const int verdict = dut.put_pair(kVerdict + 1, 1, one_line_each(1), second);
    bench.run_through(verdict + 200);
    std::vector<int> fresh;
    for (std::size_t i = 0; i < dut.framebuffer.frame_sources().size(); ++i) {
        if (dut.framebuffer.frame_sources()[i].fresh) fresh.push_back(static_cast<int>(i));
    }
    const std::vector<int> starts = dut.clocks_of(BeatKind::kFrameStart);
    REQUIRE(fresh.size() == 2);
    REQUIRE(fresh[1] > 2);  // frames 1 and 2, at least, were pair 0 again
    const int start = starts[static_cast<std::size_t>(fresh[1])];
    CHECK(sent_to(dut, 1, start, start + kSendClocks + 1) == segment_pixels(second, one_line_each(1)[0]));
    CHECK(dut.counters().dropped_frames == 0);
}

TEST_CASE(
    "input framebuffer: free-running waits for the pair under way once that has overwritten a newer one") {
    ClockedTestbench bench;
    Scenario scenario = input_scenario({}, 1, 2);
    scenario.pacing = Pacing::kFreeRunning;
    InputBench whole(bench, "whole", scenario);
    InputBench rejected(bench, "rejected", scenario);
    const PixelImage first = image_of(117);
    const PixelImage third = image_of(119);
    // Pair 1 is whole while frame 0 is held. Pair 2's colour frame overwrites it before frame 1 is asked for.
    int overwritten = 0;
    for (InputBench* dut : {&whole, &rejected}) {
        dut->put_pair_until(kVerdict, 0, one_line_each(1), first);
        overwritten = dut->put_pair(kVerdict + 1, 1, one_line_each(1), image_of(118)) + 1;
        dut->drop_busready(1, 0, overwritten + 5);
    }
    const int good = whole.put_pair(overwritten, 2, one_line_each(1), third);
    rejected.put_colour(overwritten, 2, one_line_each(1), third);
    const int rejection = overwritten + 90;
    rejected.event_at(rejection).rejected = true;
    rejected.pair_lost(rejection, 2);
    const int last_beat = overwritten + 5 + kImageWidth - 1;
    REQUIRE(last_beat + 3 < rejection);  // by then frame 1 has been asked for
    bench.run_through(good + 100);

    CHECK(whole.clocks_of(BeatKind::kFrameStart) ==
          std::vector<int>{kFrameStart, good + kVerdictToFrameStart});
    CHECK(sent_to(whole, 1, good, 9999) == segment_pixels(third, one_line_each(1)[0]));
    CHECK(rejected.clocks_of(BeatKind::kFrameStart) ==
          std::vector<int>{kFrameStart, rejection + kVerdictToFrameStart});
    CHECK(sent_to(rejected, 1, rejection, 9999) == segment_pixels(first, one_line_each(1)[0]));
    for (const InputBench* dut : {&whole, &rejected}) CHECK(dut->counters().dropped_frames == 1);
}

// ---- random ----

/// Follows the bus clock by clock and checks each clock against the rules, from the pins alone. On a bus without page
/// misses that moves whole pixels in a clock, each clock of the sending is a beat or a poll.
class BusMonitor {
  public:
    BusMonitor(const InputBench& dut, const PixelImage& image, ViewportTable rows, int most)
        : dut_(dut), rows_(std::move(rows)), most_(most), next_(rows_.size(), 0) {
        for (const ViewportRow& row : rows_) pixels_.push_back(segment_pixels(image, row));
    }

    void check(int first_clock) {
        for (int clock = first_clock; clock < dut_.beats.end_clock() && !done(); ++clock) {
            INFO("clock " << clock << ": " << dut_.beats.at(clock));
            check_clock(clock);
            announced_.push_back(row_ >= 0 ? left_ : 0);
        }
        REQUIRE(done());
    }

  private:
    bool done() const {
        for (std::size_t row = 0; row < rows_.size(); ++row) {
            if (next_[row] < pixels_[row].size()) return false;
        }
        return true;
    }
    bool busready(int row, int clock) const {
        return dut_.busreadies[rows_[static_cast<std::size_t>(row)].dcomp - std::size_t{1}]->at(clock);
    }
    int row_of(const BusBeat& beat) const {
        for (std::size_t row = 0; row < rows_.size(); ++row) {
            if (rows_[row].dcomp == beat.destination) return static_cast<int>(row);
        }
        return -1;
    }

    void check_clock(int clock) {
        const BusBeat& beat = dut_.beats.at(clock);
        const int passed_over = std::exchange(one_beat_row_, -1);
        // What had been announced to the composer when it wrote the BUSREADY that is read now.
        const int seen = announced_.size() >= 2 ? announced_[announced_.size() - 2] : 0;
        if (row_ >= 0 && seen > most_ && !busready(row_, clock)) {
            row_ = -1;
            announced_.back() = 0;  // of the burst that is over; the next one has announced nothing yet
        }
        if (beat.kind == BeatKind::kNone) {
            REQUIRE(row_ < 0);  // no gap in a burst
            for (int row = 0; row < static_cast<int>(rows_.size()); ++row) {
                const bool pending =
                    next_[static_cast<std::size_t>(row)] < pixels_[static_cast<std::size_t>(row)].size();
                REQUIRE_FALSE((pending && row != passed_over && busready(row, clock)));
            }
            return;
        }
        REQUIRE(beat.kind == BeatKind::kPixels);
        const int row = row_of(beat);
        REQUIRE(row >= 0);
        const auto r = static_cast<std::size_t>(row);
        const bool first_beat = row_ < 0;
        if (first_beat) {
            REQUIRE(busready(row, clock));
            REQUIRE(row != passed_over);
            row_ = row;
            left_ =
                std::min<int>(dut_.scenario.bus.burst_pixels, static_cast<int>(pixels_[r].size() - next_[r]));
        }
        REQUIRE(row == row_);
        const int count = std::min(most_, left_);
        REQUIRE(beat.count == count);
        left_ -= count;
        REQUIRE(beat == pixel_beat(rows_[r].dcomp, pixels_[r], next_[r], count, left_));
        next_[r] += static_cast<std::size_t>(count);
        if (left_ == 0) {
            one_beat_row_ = first_beat ? row : -1;
            row_ = -1;
        }
    }

    const InputBench& dut_;
    ViewportTable rows_;
    int most_;
    std::vector<std::vector<Pixel>> pixels_;
    std::vector<std::size_t> next_;
    int row_ = -1;  ///< whose burst is under way
    int left_ = 0;  ///< of it
    int one_beat_row_ = -1;
    std::vector<int> announced_;
};

TEST_CASE(
    "input framebuffer: under random BUSREADY each clock of the bus keeps the rules, for every policy with "
    "recovery") {
    const auto seed = random_seed(121);
    INFO("METABUFFER_SEED=" << seed);
    Random random(seed);
    ClockedTestbench bench;
    struct Run {
        std::unique_ptr<InputBench> dut;
        PixelImage image;
        ViewportTable table;
        int most = 1;
        int width_bits = 64;
    };
    std::vector<Run> runs;
    constexpr int kRuns = 150;
    for (int i = 0; i < kRuns; ++i) {
        Run run;
        BusSpeed speed;
        speed.width_bits = run.width_bits = 64 << random.between(0, 3);
        speed.words_per_cycle = random.between(1, 8);
        speed.burst = random.between(1, 20);
        run.most = std::min(speed.width_bits / 64, speed.words_per_cycle);
        Scenario scenario = input_scenario(speed, 4);
        scenario.bus.arbitration = static_cast<Arbitration>(random.one_in(3)   ? Arbitration::kIrsa
                                                            : random.one_in(2) ? Arbitration::kRoundRobin
                                                                               : Arbitration::kEdf);
        run.image = noise_image(random, kImageWidth, kImageHeight);
        for (int d = 1; d <= 4; ++d) {
            if (random.one_in(4)) continue;
            const int x = random.between(0, kImageWidth - 1);
            const int y = random.between(0, kImageHeight - 1);
            run.table.push_back(table_row(
                d, {x, y}, {random.between(1, kImageWidth - x), random.between(1, kImageHeight - y)}, {0, 0},
                random.between(1, 3)));
        }
        run.dut = std::make_unique<InputBench>(bench, "dut_" + std::to_string(i), scenario);
        run.dut->put_pair_until(kVerdict, 0, run.table, run.image);
        for (int d = 0; d < 4; ++d) {
            const int odds = random.between(1, 6);
            auto own = std::make_shared<Random>(random.bits());
            InputBench* const dut = run.dut.get();
            bench.core.each_clock([=](int) {
                dut->busready[static_cast<std::size_t>(d)]->write(odds == 1 || !own->one_in(odds));
            });
        }
        runs.push_back(std::move(run));
    }
    constexpr int kLastClock = kFrameStart + 900;
    bench.run_through(kLastClock);
    std::int64_t stops = 0;
    for (int i = 0; i < kRuns; ++i) {
        const Run& run = runs[static_cast<std::size_t>(i)];
        INFO("run " << i << ": beats of " << run.most << ", bursts of "
                    << run.dut->scenario.bus.burst_pixels);
        const auto rows = static_cast<int>(run.table.size());
        const int first = kFrameStart + rows * std::max(1, 128 / run.width_bits) + 1;
        BusMonitor(*run.dut, run.image, run.table, run.most).check(first);

        const BusCounters bus = run.dut->bus_counters();
        std::int64_t pixels = 0;
        for (const ViewportRow& row : run.table) pixels += std::int64_t{row.sdx} * row.sdy;
        CHECK(bus.pixels_sent == pixels);
        CHECK(bus.busy_cycles == static_cast<std::int64_t>(run.dut->clocks_of(BeatKind::kPixels).size()));
        // Every clock of the run, reset included, is exactly one of these.
        CHECK(bus.busy_cycles + bus.table_cycles + bus.page_miss_cycles + bus.poll_cycles + bus.lost_cycles +
                  bus.idle_cycles ==
              kLastClock + 1 + run.dut->core.reset_clocks());
        std::int64_t whole_bursts = 0;
        for (const ViewportRow& row : run.table) {
            const int burst = run.dut->scenario.bus.burst_pixels;
            whole_bursts += (row.sdx * row.sdy + burst - 1) / burst;
        }
        CHECK(bus.bursts >= whole_bursts);
        stops += bus.bursts - whole_bursts;
    }
    CHECK(stops > 30);  // the sample has enough stops
}

TEST_CASE(
    "input framebuffer: busy, table, page miss, poll, lost and idle clocks make up the run on a narrow bus "
    "too") {
    const auto seed = random_seed(122);
    INFO("METABUFFER_SEED=" << seed);
    Random random(seed);
    ClockedTestbench bench;
    std::vector<std::unique_ptr<InputBench>> duts;
    for (const ArbitrationRow& policy : kArbitrationTable) {
        Scenario scenario = input_scenario({16, 1, 4, 8, 3}, 3, 2);
        scenario.bus.arbitration = policy.value;
        duts.push_back(std::make_unique<InputBench>(bench, "dut_" + std::to_string(duts.size()), scenario));
        duts.back()->put_pair_until(kVerdict, 0, one_line_each(3), image_of(123));
        duts.back()->pair_lost(kVerdict + 1, 1);
        for (int d = 0; d < 3; ++d) {
            auto own = std::make_shared<Random>(random.bits());
            InputBench* const dut = duts.back().get();
            bench.core.each_clock(
                [=](int) { dut->busready[static_cast<std::size_t>(d)]->write(!own->one_in(3)); });
        }
    }
    constexpr int kLastClock = kFrameStart + 1500;
    bench.run_through(kLastClock);
    for (const auto& dut : duts) {
        const BusCounters bus = dut->bus_counters();
        CHECK(dut->clocks_of(BeatKind::kFrameStart).size() == 2);
        CHECK(bus.pixels_sent == 2 * 3 * kImageWidth);
        CHECK(bus.busy_cycles == 4 * bus.pixels_sent);
        CHECK(bus.table_cycles == 2 * (1 + 3 * 8));
        CHECK(bus.page_miss_cycles <= 3 * bus.page_misses);
        CHECK(bus.busy_cycles + bus.table_cycles + bus.page_miss_cycles + bus.poll_cycles + bus.lost_cycles +
                  bus.idle_cycles ==
              kLastClock + 1 + dut->core.reset_clocks());
        for (int d = 1; d <= 3; ++d) {
            const std::vector<Pixel> once =
                segment_pixels(image_of(123), one_line_each(3)[static_cast<std::size_t>(d - 1)]);
            std::vector<Pixel> twice = once;
            twice.insert(twice.end(), once.begin(), once.end());
            CHECK(sent_to(*dut, d, 0, kLastClock + 1) == twice);
        }
    }
}

TEST_CASE(
    "input framebuffer: the link's side sleeps when its frames are over, but not if its own link drifts") {
    ClockedTestbench bench;
    const auto with_drift = [](int renderer) {
        Scenario scenario = input_scenario({});
        Fault drift;
        drift.kind = FaultKind::kDrift;
        drift.renderer = renderer;
        drift.ppm = 1;
        scenario.faults = {drift};
        return scenario;
    };
    InputBench own(bench, "own_drifts", with_drift(0));
    InputBench other(bench, "other_drifts", with_drift(1));
    // No pair comes: each answer is that of a timeout.
    const auto timeout = static_cast<int>(link_timeout_clocks(own.scenario, own.scenario.renderers[0]));
    bench.run_through((own.scenario.frames + 1) * (timeout + 100));
    CHECK_FALSE(own.framebuffer.link_sleeps());
    CHECK(other.framebuffer.link_sleeps());
}

}  // namespace
}  // namespace metabuffer::test::input_framebuffer_test

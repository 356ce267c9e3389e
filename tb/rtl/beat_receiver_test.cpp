#include "rtl/beat_receiver.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "clocked_testbench.h"
#include "composer_scenario.h"
#include "expected_report.h"
#include "painted_raster.h"
#include "support/random_seed.h"
#include "support/traced_values.h"

namespace metabuffer::test::beat_receiver_test {
namespace {

using rtl::BeatReceiver;
using rtl::BusBeat;
using rtl::FifoRelease;
using rtl::FifoWrite;
using rtl::HeadSegment;
using rtl::PixelUse;
using rtl::SegmentProgress;
using Clocks = std::vector<int>;

constexpr Size kRaster{kWidth, kHeight};
constexpr std::int64_t kNoUse = Segment::kNoPixel;

/// The word of pixel k of the segment of a frame.
std::uint64_t word_of(int frame, std::int64_t k) {
    return 0x5A00'0000U + static_cast<std::uint64_t>(frame) * 1000 + static_cast<std::uint64_t>(k);
}

/// The receiver of a composer of display 1 between a bus, the composer's raster and its FIFO, all played by the test.
struct ReceiverBench {
    Scenario scenario;
    ClockDomain& core;
    Record record;
    sc_core::sc_signal<BusBeat> bus;
    sc_core::sc_signal<bool> busready, tableready, column_stall, start, uses, fetched;
    sc_core::sc_signal<PixelUse> use;
    sc_core::sc_signal<HeadSegment> segment;
    sc_core::sc_signal<SegmentProgress> progress;
    sc_core::sc_signal<FifoWrite> write;
    sc_core::sc_signal<FifoRelease> release;
    BeatReceiver dut;
    const Recording<bool>& busreadies;
    const Recording<bool>& tablereadies;
    const Recording<bool>& fetches;
    const Recording<HeadSegment>& segments;
    const Recording<SegmentProgress>& progresses;
    const Recording<FifoWrite>& writes;
    const Recording<FifoRelease>& releases;

    explicit ReceiverBench(ClockedTestbench& bench, Scenario with = composer_scenario(),
                           const std::string& name = "receiver")
        : scenario(std::move(with)),
          core(bench.core),
          dut(name.c_str(), scenario, 1, record),
          busreadies(core.record(busready)),
          tablereadies(core.record(tableready)),
          fetches(core.record(fetched)),
          segments(core.record(segment)),
          progresses(core.record(progress)),
          writes(core.record(write)),
          releases(core.record(release)) {
        dut.clk_i(core.clk);
        dut.reset_i(bench.reset);
        dut.bus_i(bus);
        dut.busready_o(busready);
        dut.tableready_o(tableready);
        dut.column_stall_i(column_stall);
        dut.start_i(start);
        dut.uses_i(uses);
        dut.use_i(use);
        dut.segment_o(segment);
        dut.progress_o(progress);
        dut.fetched_o(fetched);
        dut.write_o(write);
        dut.release_o(release);
        bench.trace(dut);
    }

    void put(int clock, const BusBeat& beat) {
        core.drive(bus, clock, beat);
        core.drive(bus, clock + 1, BusBeat{});
    }
    /// A frame's start at `clock` and its rows at the edges after it.
    void put_table(int clock, int frame, const ViewportTable& rows) {
        put(clock, BusBeat::frame_start(static_cast<std::uint32_t>(frame), rows.empty()));
        for (std::size_t i = 0; i < rows.size(); ++i) put_row(++clock, frame, rows, i);
    }
    void put_row(int clock, int frame, const ViewportTable& rows, std::size_t i) {
        put(clock, BusBeat::table_row(static_cast<std::uint32_t>(frame), static_cast<std::uint32_t>(i),
                                      rows[i], i + 1 == rows.size()));
    }
    static BusBeat pixels(int frame, std::int64_t first, int count, int remaining, int destination = 1) {
        BusBeat beat;
        beat.kind = BusBeat::Kind::kPixels;
        beat.frame = static_cast<std::uint32_t>(frame);
        beat.destination = static_cast<std::uint16_t>(destination);
        beat.count = static_cast<std::uint8_t>(count);
        beat.remaining = static_cast<std::uint32_t>(remaining);
        beat.first = static_cast<std::uint32_t>(first);
        for (int i = 0; i < count; ++i) beat.words[static_cast<std::size_t>(i)] = word_of(frame, first + i);
        return beat;
    }
    void put_pixels(int clock, int frame, std::int64_t first, int count, int remaining = 0,
                    int destination = 1) {
        put(clock, pixels(frame, first, count, remaining, destination));
    }
    /// Bursts of a pixel each, one a clock.
    void put_single_pixels(int clock, int frame, std::int64_t first, int count) {
        for (int i = 0; i < count; ++i) put_pixels(clock + i, frame, first + i, 1);
    }
    /// The position composited at edge `clock` is the last to need the pixels up to `last_use`.
    void use_at(int clock, std::int64_t last_use, bool ends_frame = false) {
        core.drive(use, clock, PixelUse{ends_frame, last_use});
        core.pulse(uses, clock);
    }
    /// The words that stand at the FIFO after an edge, and the address of the first.
    std::vector<std::uint64_t> words_at(int clock) const {
        const FifoWrite& beat = writes.at(clock);
        return {beat.words.begin(), beat.words.begin() + beat.count};
    }
    Clocks write_clocks() const {
        return writes.clocks_where([](const FifoWrite& beat) { return beat.count > 0; });
    }
    Clocks release_clocks() const {
        return releases.clocks_where([](const FifoRelease& release) { return release.any(); });
    }
    const ComposerCounters& counters() const { return record.counters(); }
};

TEST_CASE("beat receiver: after an edge its pixel counts as arrived and stands at the FIFO, for a clock") {
    ClockedTestbench bench;
    ReceiverBench dut(bench);
    const ViewportRow row = segment_row({3, 2}, {1, 1});
    dut.put_table(20, 0, {segment_row({1, 1}, {}, 1, 2), row});
    dut.put_single_pixels(40, 0, 0, 5);
    dut.put_pixels(60, 0, 0, 1, 0, 2);  // another composer's
    dut.put_single_pixels(70, 0, 5, 1);
    bench.run_through(44);
    CHECK(shows(dut.dut, "writes[1]=1"));
    bench.run_through(45);
    CHECK(shows(dut.dut, "writes[1]=0"));
    bench.run_through(90);
    CHECK(dut.segments.at(21) == HeadSegment{});
    CHECK(dut.segments.at(22).shown);
    CHECK(dut.segments.at(22).segment.row() == row);
    Clocks due = clock_range(40, 45);
    due.push_back(70);
    CHECK(dut.write_clocks() == due);
    for (int k = 0; k < 6; ++k) {
        const int clock = due[static_cast<std::size_t>(k)];
        CHECK(dut.words_at(clock) == std::vector<std::uint64_t>{word_of(0, k)});
        CHECK(dut.writes.at(clock).address == static_cast<std::uint32_t>(k));
        CHECK(dut.progresses.at(clock) == SegmentProgress{false, k + 1, 0});
    }
    CHECK(dut.fetches.high() == clock_range(70, 91));
    CHECK(dut.busreadies.high() == clock_range(0, 91));
    CHECK(dut.release_clocks().empty());
    CHECK(dut.counters().buffer_high_water == 6);
}

TEST_CASE("beat receiver: the frame on the raster is shown until it ends, and the next one after that edge") {
    ClockedTestbench bench;
    ReceiverBench dut(bench);
    const ViewportRow first = segment_row({2, 1});
    const ViewportRow second = segment_row({1, 3});
    dut.put_table(5, 0, {first});
    dut.put_pixels(10, 0, 0, 2);
    dut.put_table(12, 1, {second});
    dut.put_pixels(15, 1, 0, 2);
    dut.use_at(30, 1);
    dut.use_at(40, kNoUse, true);
    dut.put_table(45, 2, {});
    bench.run_through(48);
    CHECK(dut.segments.at(39).segment.row() == first);
    CHECK(dut.progresses.at(39) == SegmentProgress{false, 2, 0});
    CHECK(dut.segments.at(40).segment.row() == second);
    CHECK(dut.progresses.at(40) == SegmentProgress{false, 2, 2});
    CHECK(dut.writes.at(15).address == 2);
    CHECK(dut.fetches.at(39));
    CHECK_FALSE(dut.fetches.at(40));  // its third pixel is still to come
    CHECK(dut.tablereadies.high() == [] {
        Clocks due = clock_range(0, 12);
        for (const int clock : clock_range(40, 45)) due.push_back(clock);
        return due;
    }());
}

TEST_CASE("beat receiver: pixels are released at the edge of their last use, before the edge's beat") {
    ClockedTestbench bench;
    ReceiverBench dut(bench);  // 16 pixels
    dut.put_table(5, 0, {whole_raster()});
    dut.put_single_pixels(10, 0, 0, 16);
    dut.use_at(40, 0);
    dut.put_pixels(40, 0, 16, 1);  // there is room for it now
    dut.use_at(41, 3);
    dut.use_at(42, 2);  // has been said before
    dut.use_at(43, 4);
    bench.run_through(50);
    CHECK(dut.release_clocks() == Clocks{40, 41, 43});
    CHECK(dut.releases.at(40) == FifoRelease{1, 0});
    CHECK(dut.releases.at(41) == FifoRelease{3, 0});
    CHECK(dut.releases.at(43) == FifoRelease{1, 0});
    CHECK(dut.words_at(40) == std::vector<std::uint64_t>{word_of(0, 16)});
    CHECK(dut.writes.at(40).address == 0);  // after 15 comes 0
    CHECK(dut.counters().buffer_high_water == 16);
}

TEST_CASE(
    "beat receiver: a pixel that comes after its last use is dropped, and those after it keep their "
    "addresses") {
    ClockedTestbench bench;
    ReceiverBench dut(bench, composer_scenario({16, 8, 4}));
    dut.put_table(5, 0, {segment_row({6, 2})});
    dut.use_at(10, 0);
    dut.use_at(12, 1);
    dut.put_pixels(12, 0, 0, 4);  // the second one's last use is at this very edge
    dut.use_at(20, 7);
    dut.put_pixels(24, 0, 4, 4);  // all too late
    dut.put_pixels(26, 0, 8, 2);
    dut.use_at(30, 11, true);
    dut.put_pixels(34, 0, 10, 2);  // the frame is over
    bench.run_through(40);
    CHECK(dut.write_clocks() == Clocks{12, 26});
    CHECK(dut.words_at(12) == std::vector<std::uint64_t>{word_of(0, 2), word_of(0, 3)});
    CHECK(dut.writes.at(12).address == 2);
    CHECK(dut.words_at(26) == std::vector<std::uint64_t>{word_of(0, 8), word_of(0, 9)});
    CHECK(dut.writes.at(26).address == 8);
    CHECK(dut.release_clocks() == Clocks{20, 30});
    CHECK(dut.releases.at(20).oldest == 2);
    CHECK(dut.releases.at(30).oldest == 2);
    CHECK(dut.progresses.at(24).arrived == 8);
    CHECK(dut.counters().late_pixels == 8);
    CHECK(dut.counters().lost_pixels == 0);
}

TEST_CASE("beat receiver: a use and a start wait while COLUMNSTALL is high, the bus does not") {
    ClockedTestbench bench;
    // A source row lies so far above the raster that nothing needs it: the frame's start releases it.
    const ViewportRow row = segment_row({2, 3}, {0, -3}, 2);
    std::vector<std::unique_ptr<ReceiverBench>> duts;
    for (const StarvationMode mode : {StarvationMode::kStall, StarvationMode::kGlitch}) {
        Scenario scenario = composer_scenario({}, mode);
        scenario.composer.smoothing = Smoothing::kBilinear;
        duts.push_back(std::make_unique<ReceiverBench>(bench, scenario,
                                                       mode == StarvationMode::kStall ? "stall" : "glitch"));
        ReceiverBench& dut = *duts.back();
        dut.put_table(5, 0, {row});
        dut.put_single_pixels(10, 0, 0, 4);
        bench.core.drive(dut.column_stall, 20, true);
        bench.core.drive(dut.column_stall, 44, false);
        bench.core.drive(dut.start, 20, true);
        bench.core.drive(dut.start, 45, false);
        bench.core.drive(dut.column_stall, 50, true);
        bench.core.drive(dut.column_stall, 73, false);
        bench.core.drive(dut.use, 50, PixelUse{false, 2});
        bench.core.drive(dut.uses, 50, true);
        bench.core.drive(dut.uses, 74, false);
        dut.put_single_pixels(51, 0, 4, 2);
    }
    bench.run_through(80);
    CHECK(duts[0]->release_clocks() == Clocks{44, 73});
    CHECK(duts[1]->release_clocks() == Clocks{20, 50});  // nothing ever raises it there, so it is not read
    for (const auto& dut : duts) {
        CHECK(dut->releases.at(dut->release_clocks()[0]) == FifoRelease{2, 0});
        CHECK(dut->releases.at(dut->release_clocks()[1]) == FifoRelease{1, 0});
        CHECK(dut->progresses.at(52).arrived == 6);
    }
}

TEST_CASE(
    "beat receiver: a frame is fetched if it is empty here, or wholly here, or the buffer takes no slot") {
    ClockedTestbench bench;
    ReceiverBench empty(bench, composer_scenario(), "empty");
    ReceiverBench whole(bench, composer_scenario(), "whole");
    ReceiverBench full(bench, composer_scenario({16, 6, 1}), "full");
    empty.put_table(5, 0, {segment_row({1, 1}, {}, 1, 2), segment_row({1, 1}, {}, 1, 3)});
    whole.put_table(5, 0, {segment_row({1, 1})});
    whole.put_pixels(20, 0, 0, 1);
    full.put_table(5, 0, {whole_raster()});
    full.put_single_pixels(10, 0, 0, 11);
    full.use_at(30, 0);  // six are free again
    bench.run_through(40);
    CHECK(empty.fetches.rises() == Clocks{7});  // the table's end
    CHECK(whole.fetches.rises() == Clocks{20});
    CHECK(full.fetches.high() == clock_range(20, 30));
}

TEST_CASE(
    "beat receiver: without a burst BUSREADY says whether a slot would be taken, besides the last beat to "
    "come") {
    ClockedTestbench bench;
    ReceiverBench dut(bench, composer_scenario({16, 6, 1}));
    dut.put_table(5, 0, {whole_raster()});
    dut.put_single_pixels(10, 0, 0, 9);
    dut.put_pixels(20, 0, 9, 1, 1);  // six are free, and one is to come
    dut.put_pixels(24, 0, 10, 1, 0);
    dut.use_at(30, 0);
    dut.put_pixels(34, 0, 11, 1, 1);
    dut.use_at(40, 4);  // the burst's last pixel has never come, but nobody can know that yet
    bench.run_through(50);
    CHECK(dut.busreadies.falls() == Clocks{20, 34});
    CHECK(dut.busreadies.rises() == Clocks{0, 30, 40});
    CHECK(dut.counters().busready_drops == 0);
}

TEST_CASE("beat receiver: in a burst BUSREADY falls when the beats on their way just fit, and ends it") {
    ClockedTestbench bench;
    std::vector<std::unique_ptr<ReceiverBench>> duts;
    // The beat on its way and one more, and those that the loop of a read latency of three clocks holds.
    for (const int latency : {0, 3}) {
        Scenario scenario = composer_scenario({16, 10, 2});
        scenario.memory.read_latency_cycles = latency;
        duts.push_back(
            std::make_unique<ReceiverBench>(bench, scenario, "latency_" + std::to_string(latency)));
        ReceiverBench& dut = *duts.back();
        dut.put_table(5, 0, {whole_raster()});
        // Two pixels a clock: after n of these beats 16 - 2n are free.
        for (int beat = 0; beat < 8; ++beat) dut.put_pixels(10 + beat, 0, 2 * beat, 2, 22 - 2 * beat);
        dut.use_at(18, 15);  // all are free again
    }
    bench.run_through(40);
    // In flight are 2 beats, 4 pixels: 2 are free after the seventh beat. The eighth is the last.
    CHECK(duts[0]->busreadies.falls() == Clocks{16});
    CHECK(duts[0]->busreadies.rises() == Clocks{0, 18});
    // In flight are 5 beats, 10 pixels: 8 are free after the fourth. Four may still come, and BUSREADY stays low.
    CHECK(duts[1]->busreadies.falls() == Clocks{13});
    CHECK(duts[1]->busreadies.rises() == Clocks{0, 18});
    for (const auto& dut : duts) {
        CHECK(dut->counters().busready_drops == 1);
        CHECK(dut->counters().buffer_high_water == 16);
    }
    CHECK(duts[1]->record.first_busready_drop_cycle() == 13 + bench.core.reset_clocks());
}

TEST_CASE(
    "beat receiver: BUSREADY stays low until the last beat of a burst that it has ended can have come") {
    ClockedTestbench bench;
    Scenario scenario = composer_scenario({16, 10, 2});
    scenario.memory.read_latency_cycles = 3;
    ReceiverBench dut(bench, scenario);
    dut.put_table(5, 0, {whole_raster()});
    for (int beat = 0; beat < 4; ++beat) dut.put_pixels(10 + beat, 0, 2 * beat, 2, 22 - 2 * beat);
    dut.use_at(14, 7);  // all is free again at once, and nothing more comes
    // A loop that is longer than a block takes to sleep, and a burst that says early that it is over.
    Scenario long_way = composer_scenario({20, 18, 1});
    long_way.memory.read_latency_cycles = 8;
    long_way.bus.register_stages = 4;
    ReceiverBench far(bench, long_way, "far");
    far.put_table(5, 0, {whole_raster()});
    for (int beat = 0; beat < 3; ++beat) far.put_pixels(10 + beat, 0, beat, 1, 23 - beat);
    far.put_pixels(13, 0, 3, 1, 0);
    far.use_at(14, 3);
    bench.run_through(40);
    CHECK(dut.busreadies.falls() == Clocks{13});
    CHECK(dut.busreadies.rises() == Clocks{0, 17});
    CHECK(far.busreadies.falls() == Clocks{12});
    CHECK(far.busreadies.rises() == Clocks{0, 12 + 1 + 8 + 2 * 4});
}

TEST_CASE("beat receiver: a burst is over when no beat of it has come for the longest gap") {
    ClockedTestbench bench;
    std::vector<std::unique_ptr<ReceiverBench>> duts;
    for (const int page_miss : {6, 30}) {  // the second is longer than a block takes to sleep
        Scenario scenario = composer_scenario({16, 6, 1});
        scenario.memory.page_miss_cycles = page_miss;
        duts.push_back(
            std::make_unique<ReceiverBench>(bench, scenario, "page_miss_" + std::to_string(page_miss)));
        ReceiverBench& dut = *duts.back();
        dut.put_table(5, 0, {whole_raster()});
        dut.put_single_pixels(10, 0, 0, 9);
        dut.put_pixels(20, 0, 9, 1, 1);
        dut.put_pixels(23, 0, 0, 1, 4, 2);  // another composer's is no beat of it
    }
    bench.run_through(60);
    for (const auto& dut : duts) {
        const int gap = dut->scenario.memory.page_miss_cycles + 1;
        CHECK(dut->busreadies.falls() == Clocks{20});
        CHECK(dut->busreadies.rises() == Clocks{0, 20 + gap});
        // What counts the gap stands still then.
        const std::string bits = std::to_string(rtl::bits_for(gap));
        CHECK(shows(dut->dut, "silent_cycles[" + bits + "]=" + std::to_string(gap)));
    }
}

TEST_CASE(
    "beat receiver: the index of a beat shows pixels lost before it, and the rest of the frame is "
    "abandoned") {
    ClockedTestbench bench;
    ReceiverBench dut(bench, composer_scenario({16, 8, 2}));
    dut.put_table(5, 0, {segment_row({6, 2})});
    for (int beat = 0; beat < 3; ++beat) dut.put_pixels(10 + beat, 0, 2 * beat, 2);
    dut.use_at(20, 1);            // at the same edge
    dut.put_pixels(20, 0, 9, 2);  // 6, 7 and 8 are lost
    dut.put_pixels(24, 0, 11, 1);
    dut.use_at(30, 11, true);
    bench.run_through(40);
    CHECK(dut.releases.at(20) == FifoRelease{2, 4});
    CHECK(dut.release_clocks() == Clocks{20});
    CHECK(dut.write_clocks() == Clocks{10, 11, 12});
    CHECK_FALSE(dut.progresses.at(19).abandoned);
    CHECK(dut.progresses.at(20).abandoned);
    CHECK(dut.fetches.high() == clock_range(20, 30));  // nothing is waited for
    CHECK(dut.counters().lost_pixels == 3);
    CHECK(dut.counters().late_pixels == 0);
}

TEST_CASE("beat receiver: the next frame's beginning shows that a segment's last pixels were lost") {
    ClockedTestbench bench;
    ReceiverBench dut(bench);
    dut.put_table(5, 0, {segment_row({5, 1})});
    dut.put_single_pixels(10, 0, 0, 4);
    dut.put(20, BusBeat::frame_start(1, true));
    bench.run_through(30);
    CHECK(dut.progresses.at(20).abandoned);
    CHECK(dut.releases.at(20) == FifoRelease{0, 4});
    CHECK(dut.counters().lost_pixels == 1);
    CHECK(dut.counters().lost_tables == 0);
}

TEST_CASE(
    "beat receiver: lost rows, lost starts and lost frames show by the next beat, whichever composer it is "
    "for") {
    ClockedTestbench bench;
    const ViewportTable rows{segment_row({1, 1}, {}, 1, 2), segment_row({2, 1}, {}, 1, 1),
                             segment_row({1, 1}, {}, 1, 3)};
    std::vector<std::unique_ptr<ReceiverBench>> duts;
    for (const char* name : {"first_row", "last_row", "last_row_then_frame", "start", "frames"}) {
        duts.push_back(std::make_unique<ReceiverBench>(bench, composer_scenario(), name));
    }
    const auto& [first_row, last_row, then_frame, start, frames] =
        std::tie(*duts[0], *duts[1], *duts[2], *duts[3], *duts[4]);
    // The row before is another composer's, but it might have been this one's.
    first_row.put(10, BusBeat::frame_start(0, false));
    first_row.put_row(12, 0, rows, 1);
    first_row.put_row(13, 0, rows, 2);
    for (ReceiverBench* dut : {&last_row, &then_frame}) {
        dut->put(7, BusBeat::frame_start(0, false));
        dut->put_row(8, 0, rows, 0);
        dut->put_row(9, 0, rows, 1);
    }
    last_row.put_pixels(12, 0, 0, 1, 0, 3);
    then_frame.put(12, BusBeat::frame_start(1, true));
    start.put_row(12, 0, rows, 0);
    frames.put_pixels(12, 2, 0, 1, 0, 3);
    // Its own pixels are dropped without a word.
    for (ReceiverBench* dut : {&first_row, &last_row, &start}) dut->put_pixels(20, 0, 0, 1);
    frames.put_pixels(20, 2, 0, 1);
    for (const auto& dut : duts) dut->use_at(30, kNoUse, true);
    bench.run_through(40);
    for (const auto& dut : duts) {
        INFO(dut->dut.name());
        CHECK_FALSE(dut->progresses.at(11).abandoned);
        CHECK(dut->progresses.at(12).abandoned);
        CHECK(dut->segments.at(12) == HeadSegment{});
        CHECK(dut->fetches.rises().front() == 12);
        CHECK(dut->write_clocks().empty());
        CHECK(dut->counters().lost_tables == (dut == duts[4] ? 3 : 1));
        CHECK(dut->counters().late_pixels == 0);
    }
    CHECK(first_row.tablereadies.falls().empty());
    CHECK(then_frame.tablereadies.falls() == Clocks{12});
    CHECK(then_frame.tablereadies.rises() == Clocks{0, 30});
    CHECK_FALSE(then_frame.progresses.at(30).abandoned);  // the next frame is whole
    CHECK(frames.tablereadies.falls() == Clocks{12});
    CHECK_FALSE(frames.tablereadies.at(30));  // two of three are still to be composited
    CHECK(frames.progresses.at(30).abandoned);
}

TEST_CASE(
    "beat receiver: what a bus that breaks its protocol sends is reported, and leaves everything as it was") {
    ExpectedReport report("/metabuffer/composer/protocol");
    ClockedTestbench bench;
    const ViewportTable rows{segment_row({2, 1}, {}, 1, 2), whole_raster()};
    std::vector<std::unique_ptr<ReceiverBench>> duts;
    const auto add = [&](const char* name) -> ReceiverBench& {
        duts.push_back(std::make_unique<ReceiverBench>(bench, composer_scenario(), name));
        return *duts.back();
    };
    std::vector<int> clocks;
    const auto break_at = [&clocks](int clock) {
        clocks.push_back(clock);
        return clock;
    };
    ReceiverBench& full = add("full");
    full.put_table(2, 0, rows);
    full.put_single_pixels(10, 0, 0, 16);
    full.put_pixels(break_at(40), 0, 16, 1);
    ReceiverBench& again = add("pixel_again");
    again.put_table(2, 0, rows);
    again.put_single_pixels(10, 0, 0, 3);
    again.put_pixels(break_at(42), 0, 2, 1);
    ReceiverBench& row_again = add("row_again");
    row_again.put(2, BusBeat::frame_start(0, false));
    row_again.put_row(3, 0, rows, 0);
    row_again.put_row(break_at(44), 0, rows, 0);
    ReceiverBench& row_after = add("row_after_the_last");
    row_after.put_table(2, 0, rows);
    row_after.put_row(break_at(46), 0, rows, 1);
    ReceiverBench& begun = add("begun_again");
    begun.put_table(2, 0, rows);
    begun.put(break_at(48), BusBeat::frame_start(0, false));
    ReceiverBench& over = add("frame_before");
    over.put_table(2, 0, {});
    over.put_table(6, 1, rows);
    over.put_pixels(break_at(50), 0, 0, 1);
    ReceiverBench& third = add("third_table");
    third.put_table(2, 0, {});
    third.put_table(6, 1, rows);
    third.put(break_at(52), BusBeat::frame_start(2, true));
    ReceiverBench& no_table = add("no_table");
    no_table.use_at(4, kNoUse, true);
    no_table.put_table(2, 0, {});
    no_table.put_pixels(break_at(54), 0, 0, 1);
    ReceiverBench& ahead = add("far_ahead");
    ahead.put_table(2, 0, rows);
    ahead.put_pixels(break_at(56), 65536, 0, 1, 0, 2);
    bench.run_through(39);
    CHECK(report.count() == 0);
    for (std::size_t i = 0; i < clocks.size(); ++i) {
        INFO(duts[i]->dut.name());
        bench.run_through(clocks[i] - 1);
        CHECK(report.count() == static_cast<int>(i));
        bench.run_through(clocks[i]);
        CHECK(report.count() == static_cast<int>(i) + 1);
        const ReceiverBench& dut = *duts[i];
        CHECK(dut.words_at(clocks[i]).empty());
        CHECK(dut.progresses.at(clocks[i]) == dut.progresses.at(clocks[i] - 1));
        CHECK(dut.segments.at(clocks[i]) == dut.segments.at(clocks[i] - 1));
        CHECK(dut.tablereadies.at(clocks[i]) == dut.tablereadies.at(clocks[i] - 1));
        CHECK(dut.counters().lost_tables == 0);
        CHECK(dut.counters().lost_pixels == 0);
    }
}

TEST_CASE("beat receiver: a frame that is as far ahead as a bus can be makes up for all before it") {
    ClockedTestbench bench;
    ReceiverBench dut(bench);
    dut.put_table(2, 0, {});
    dut.put_pixels(10, 65535, 0, 1, 0, 2);
    bench.run_through(20);
    CHECK(dut.counters().lost_tables == 65535);
    CHECK_FALSE(dut.tablereadies.at(10));
}

/// From a reset that ends at edge `start` on all is as it was from power-up on, up to edge `clocks`.
void check_repeats(const ReceiverBench& dut, int start, int clocks) {
    for (int clock = -2; clock < clocks; ++clock) {
        INFO(dut.dut.name() << ", clock " << clock);
        const int now = clock + start;
        CHECK(dut.busreadies.at(now) == dut.busreadies.at(clock));
        CHECK(dut.tablereadies.at(now) == dut.tablereadies.at(clock));
        CHECK(dut.fetches.at(now) == dut.fetches.at(clock));
        CHECK(dut.segments.at(now) == dut.segments.at(clock));
        CHECK(dut.progresses.at(now) == dut.progresses.at(clock));
        CHECK(dut.writes.at(now) == dut.writes.at(clock));
    }
    CHECK(dut.counters().lost_tables == 0);
}

TEST_CASE("beat receiver: reset in a burst, a frame or a table leaves what power-up leaves") {
    ClockedTestbench bench;
    ReceiverBench in_burst(bench, composer_scenario(), "in_burst");
    ReceiverBench in_table(bench, composer_scenario(), "in_table");
    const ViewportRow row = segment_row({5, 2});
    const auto send = [&row](ReceiverBench& dut, int clock) {
        dut.put_table(clock, 0, {segment_row({1, 1}, {}, 1, 2), row});
        for (int k = 0; k < 7; ++k) dut.put_pixels(clock + 5 + k, 0, k, 1, 9 - k);
    };
    const int reset = 24;
    for (ReceiverBench* dut : {&in_burst, &in_table}) send(*dut, 10);
    in_table.put(23, BusBeat::frame_start(1, false));  // shows that the frame's end was lost
    bench.core.drive(bench.reset, reset, true);
    in_burst.put_pixels(reset, 0, 7, 1, 2);
    in_burst.use_at(reset, 3);
    bench.core.drive(bench.reset, reset + 2, false);
    for (ReceiverBench* dut : {&in_burst, &in_table}) send(*dut, 10 + reset + 2);
    bench.run_through(60);
    CHECK(in_table.progresses.at(reset - 1).abandoned);
    CHECK(in_table.release_clocks() == Clocks{23});
    CHECK(in_burst.release_clocks().empty());
    for (ReceiverBench* dut : {&in_burst, &in_table}) {
        check_repeats(*dut, reset + 2, 23);
    }
}

TEST_CASE("beat receiver: a reset wakes a block that sleeps, and leaves what power-up leaves") {
    ClockedTestbench bench;
    ReceiverBench dut(bench);
    const auto send = [&dut](int clock) {
        dut.put_table(clock, 0, {segment_row({5, 2})});
        for (int k = 0; k < 10; ++k) dut.put_pixels(clock + 5 + k, 0, k, 1, 9 - k);
    };
    const int reset = 60;
    send(10);
    bench.core.drive(bench.reset, reset, true);
    bench.core.drive(bench.reset, reset + 2, false);
    send(10 + reset + 2);
    bench.run_through(100);
    CHECK(dut.progresses.at(reset - 1).arrived == 10);
    check_repeats(dut, reset + 2, 35);
}

// ---- at random ----

/// A receiver as its header describes it, in sets and lists: what must stand after each edge.
class ReceiverModel {
  public:
    struct Due {
        bool busready = false, tableready = false, fetched = false;
        bool abandoned = false;
        int frame = 0;  ///< that is composited, or is next
        std::optional<ViewportRow> row;
        std::int64_t arrived = 0;
        std::vector<std::pair<int, std::int64_t>> written;  ///< frame and pixel
        FifoRelease released;
    };

    explicit ReceiverModel(const Scenario& scenario)
        : scenario_(scenario),
          beat_(pixels_per_beat(scenario.bus, scenario.memory)),
          loop_(scenario.memory.read_latency_cycles) {}

    int heard() const { return static_cast<int>(frames_.size()); }
    int composited() const { return composited_; }
    int free() const { return scenario_.composer.buffer_pixels - held(); }
    bool may_start() const { return composited_ < heard() && head().complete; }
    const std::optional<ViewportRow>& head_row() const { return head().row; }

    Due edge(const BusBeat& beat, bool start, const PixelUse& use) {
        due_ = Due{};
        if (start) release_through(painted(head().row).skipped - 1);
        release_through(use.last_use);
        if (use.ends_frame) ++composited_;
        const bool own = beat.kind == BusBeat::Kind::kPixels && beat.destination == 1;
        if (beat.kind != BusBeat::Kind::kNone) receive(beat);
        if (own) {
            announced_ = static_cast<int>(beat.remaining);
            silent_ = 0;
        } else if (announced_ > 0 && ++silent_ == scenario_.memory.page_miss_cycles + 1) {
            announced_ = 0;
        }
        due_.busready = busready();
        due_.tableready = heard() - composited_ < 2;
        due_.frame = composited_;
        if (composited_ < heard()) {
            due_.row = head().row;
            due_.abandoned = head().abandoned;
            due_.arrived = head().arrived;
            const bool whole = !head().row || head().abandoned || head().arrived == head().pixels();
            due_.fetched = head().complete && (whole || free() < scenario_.composer.ready_space_pixels);
        }
        return due_;
    }
    PaintedRaster painted(const std::optional<ViewportRow>& row) const {
        return {row, kRaster, scenario_.composer.smoothing};
    }

    std::int64_t late = 0, lost_pixels = 0, lost_tables = 0;

  private:
    struct Frame {
        std::optional<ViewportRow> row;
        std::uint32_t rows = 0;
        bool complete = false, abandoned = false, table_lost = false;
        std::int64_t arrived = 0, released = 0;
        std::set<std::int64_t> held;
        std::int64_t pixels() const { return row ? std::int64_t{row->sdx} * row->sdy : 0; }
    };
    const Frame& head() const { return frames_[static_cast<std::size_t>(composited_)]; }
    Frame& head() { return frames_[static_cast<std::size_t>(composited_)]; }
    int held() const {
        int pixels = 0;
        for (const Frame& frame : frames_) pixels += static_cast<int>(frame.held.size());
        return pixels;
    }
    void release_through(std::int64_t last) {
        if (composited_ == heard()) return;
        for (std::int64_t k = head().released; k <= last; ++k) {
            due_.released.oldest += static_cast<std::uint32_t>(head().held.erase(k));
            head().released = k + 1;
        }
    }
    void lose_table(Frame& frame) {
        if (frame.complete) return;
        ++lost_tables;
        frame.row.reset();
        frame.complete = frame.abandoned = frame.table_lost = true;
    }
    void lose_pixels(std::int64_t count) {
        Frame& frame = frames_.back();
        lost_pixels += count;
        frame.arrived += count;
        if (heard() == composited_) return;  // it is over: nothing of it is waited for
        due_.released.newest += static_cast<std::uint32_t>(frame.held.size());
        frame.held.clear();
        frame.abandoned = true;
    }
    void receive(const BusBeat& beat) {
        const auto number = static_cast<int>(beat.frame);
        const bool begins = beat.kind == BusBeat::Kind::kFrameStart;
        if (number >= heard()) {
            if (!frames_.empty()) {
                Frame& newest = frames_.back();
                lose_table(newest);
                if (newest.arrived < newest.pixels()) lose_pixels(newest.pixels() - newest.arrived);
            }
            while (heard() < number + (begins ? 0 : 1)) {
                frames_.emplace_back();
                lose_table(frames_.back());
            }
            if (begins) frames_.emplace_back();
        }
        Frame& frame = frames_.back();
        if (begins) {
            frame.complete = beat.last;
        } else if (beat.kind == BusBeat::Kind::kTableRow) {
            if (frame.table_lost) return;
            if (beat.first != frame.rows) return lose_table(frame);
            ++frame.rows;
            if (beat.destination == 1) frame.row = beat.row();
            frame.complete = beat.last;
        } else {
            lose_table(frame);
            if (beat.destination == 1 && !frame.table_lost) receive_pixels(frame, beat);
        }
    }
    void receive_pixels(Frame& frame, const BusBeat& beat) {
        if (beat.first > frame.arrived) lose_pixels(beat.first - frame.arrived);
        for (int i = 0; i < beat.count; ++i) {
            const std::int64_t k = frame.arrived++;
            if (frame.abandoned) continue;
            if (k < frame.released) {
                ++late;
                continue;
            }
            frame.held.insert(k);
            due_.written.emplace_back(heard() - 1, k);
        }
    }
    bool busready() {
        if (cut_ > 0 && --cut_ == 0) announced_ = 0;
        if (cut_ > 0) return false;
        if (announced_ <= beat_) return free() - announced_ >= scenario_.composer.ready_space_pixels;
        if (free() >= std::min(announced_, (2 + loop_) * beat_)) return true;
        cut_ = 1 + loop_;
        return false;
    }

    const Scenario& scenario_;
    int beat_, loop_;
    std::vector<Frame> frames_;
    int composited_ = 0;
    int announced_ = 0, silent_ = 0, cut_ = 0;
    Due due_;
};

/// A receiver on a bus that loses beats, and on a raster that does not wait for pixels, and what is due at each edge.
struct RandomTraffic {
    static constexpr int kClocks = 3000;
    ReceiverBench dut;
    ReceiverModel model;
    std::vector<ReceiverModel::Due> dues;

    RandomTraffic(ClockedTestbench& bench, Random& random, const Scenario& scenario, const std::string& name)
        : dut(bench, scenario, name), model(dut.scenario), random_(random) {
        const bool may_stall = scenario.composer.on_starvation == StarvationMode::kStall;
        for (int clock = 0; clock < kClocks; ++clock) {
            if (random.one_in(120)) pause_ = random.between(10, 30);  // long enough for the block to sleep
            pause_ = std::max(0, pause_ - 1);
            const BusBeat beat = next_beat();
            dut.core.drive(dut.bus, clock, beat);
            const bool stalls = random.one_in(5);
            dut.core.drive(dut.column_stall, clock, stalls);
            // A raster that stands still shows the same once more.
            if (!stood_) move_raster();
            dut.core.drive(dut.start, clock, start_);
            dut.core.drive(dut.uses, clock, use_.any());
            dut.core.drive(dut.use, clock, use_);
            stood_ = may_stall && stalls;
            dues.push_back(model.edge(beat, start_ && !stood_, stood_ ? PixelUse{} : use_));
        }
    }

    void check() const {
        std::map<int, std::uint32_t>
            bases;  // by frame: the address of its pixel 0, by the first that is stored
        const auto addresses =
            static_cast<std::uint32_t>(buffer_addresses(dut.scenario.composer.buffer_pixels));
        for (int clock = 0; clock < kClocks; ++clock) {
            INFO(dut.dut.name() << ", clock " << clock);
            const ReceiverModel::Due& due = dues[static_cast<std::size_t>(clock)];
            REQUIRE(dut.busreadies.at(clock) == due.busready);
            REQUIRE(dut.tablereadies.at(clock) == due.tableready);
            REQUIRE(dut.fetches.at(clock) == due.fetched);
            REQUIRE(dut.releases.at(clock) == due.released);
            REQUIRE(dut.segments.at(clock).shown == due.row.has_value());
            if (due.row) REQUIRE(dut.segments.at(clock).segment.row() == *due.row);
            const SegmentProgress& progress = dut.progresses.at(clock);
            REQUIRE(progress.abandoned == due.abandoned);
            if (due.row && !due.abandoned) REQUIRE(progress.arrived == due.arrived);
            const std::vector<std::uint64_t> words = dut.words_at(clock);
            REQUIRE(words.size() == due.written.size());
            for (std::size_t i = 0; i < words.size(); ++i) {
                const auto& [of, k] = due.written[i];
                REQUIRE(words[i] == word_of(of, k));
                const auto address =
                    (dut.writes.at(clock).address + static_cast<std::uint32_t>(i)) % addresses;
                const auto base =
                    (address + addresses - static_cast<std::uint32_t>(k) % addresses) % addresses;
                REQUIRE(bases.emplace(of, base).first->second == base);
            }
            const auto base = bases.find(due.frame);
            if (due.row && !due.abandoned && base != bases.end())
                REQUIRE(progress.base_address == base->second);
        }
        CHECK(dut.counters().late_pixels == model.late);
        CHECK(dut.counters().lost_pixels == model.lost_pixels);
        CHECK(dut.counters().lost_tables == model.lost_tables);
    }

  private:
    BusBeat next_beat() {
        if (pause_ > 0 || !random_.one_in(pace_)) return {};
        if (next_ == planned_.size()) {
            if (model.heard() - model.composited() >= 2 || random_.one_in(2)) return {};
            plan_frame();
        }
        const BusBeat& beat = planned_[next_];
        if (beat.kind == BusBeat::Kind::kPixels && model.free() < beat.count) return {};
        ++next_;
        return random_.one_in(120) ? BusBeat{} : beat;
    }
    void plan_frame() {
        planned_.clear();
        next_ = 0;
        pace_ = random_.between(1, 4);
        const auto number = static_cast<std::uint32_t>(frame_++);
        ViewportTable rows;
        std::int64_t pixels = 0;
        for (int display = 1; display <= 3; ++display) {
            if (random_.one_in(5)) continue;
            ViewportRow row = dut.scenario.composer.smoothing == Smoothing::kBilinear
                                  ? random_smoothed_row(random_, kRaster, 5)
                                  : random_valid_row(random_, kRaster, 5);
            row.dcomp = static_cast<std::uint16_t>(display);
            rows.push_back(row);
            if (display == 1) pixels = std::int64_t{row.sdx} * row.sdy;
        }
        shuffle_rows(random_, rows);
        planned_.push_back(BusBeat::frame_start(number, rows.empty()));
        for (std::size_t i = 0; i < rows.size(); ++i) {
            planned_.push_back(
                BusBeat::table_row(number, static_cast<std::uint32_t>(i), rows[i], i + 1 == rows.size()));
        }
        const int lanes = pixels_per_beat(dut.scenario.bus, dut.scenario.memory);
        for (std::int64_t first = 0; first < pixels;) {
            auto burst = static_cast<int>(std::min<std::int64_t>(random_.between(1, 12), pixels - first));
            while (burst > 0) {
                const int count = std::min(burst, random_.between(1, lanes));
                burst -= count;
                planned_.push_back(ReceiverBench::pixels(static_cast<int>(number), first, count, burst));
                first += count;
            }
            if (random_.one_in(3))
                planned_.push_back(ReceiverBench::pixels(static_cast<int>(number), 0, 1, 3, 2));
        }
    }
    void move_raster() {
        use_ = PixelUse{};
        if (start_) {
            start_ = false;
            position_ = 0;
        } else if (position_ >= 0) {
            position_ = position_ + 1 < kPixels ? position_ + 1 : -1;
        }
        if (position_ >= 0) {
            const auto n = static_cast<std::size_t>(position_);
            const std::int64_t before = n == 0 ? raster_->skipped : raster_->released[n - 1];
            if (raster_->released[n] > before) use_.last_use = raster_->released[n] - 1;
            use_.ends_frame = position_ + 1 == kPixels;
        } else if (pause_ == 0 && model.may_start() && random_.one_in(8)) {
            start_ = true;
            raster_ = model.painted(model.head_row());
        }
    }

    Random& random_;
    std::vector<BusBeat> planned_;
    std::size_t next_ = 0;
    int frame_ = 0;
    int pace_ = 1;  ///< clocks to a beat
    int pause_ = 0;
    bool start_ = false, stood_ = false;
    PixelUse use_;
    int position_ = -1;
    std::optional<PaintedRaster> raster_;
};

TEST_CASE("beat receiver: under random traffic, with beats lost, every output is due at its clock") {
    const auto seed = random_seed(2221);
    INFO("METABUFFER_SEED=" << seed);
    Random random(seed);
    ClockedTestbench bench;
    std::vector<std::unique_ptr<RandomTraffic>> runs;
    for (int i = 0; i < 8; ++i) {
        const int beat = i % 2 == 0 ? 1 : 4;
        Scenario scenario = composer_scenario({20, 4 * beat, beat},
                                              i % 4 < 2 ? StarvationMode::kGlitch : StarvationMode::kStall);
        if (i >= 4) scenario.composer.smoothing = Smoothing::kBilinear;
        if (i % 3 == 1) scenario.memory.read_latency_cycles = 2;
        runs.push_back(
            std::make_unique<RandomTraffic>(bench, random, scenario, "composer_" + std::to_string(i)));
    }
    bench.run_through(RandomTraffic::kClocks - 1);
    std::int64_t late = 0, lost_pixels = 0, lost_tables = 0, drops = 0;
    for (const auto& run : runs) {
        run->check();
        late += run->model.late;
        lost_pixels += run->model.lost_pixels;
        lost_tables += run->model.lost_tables;
        drops += run->dut.counters().busready_drops;
    }
    CHECK(late > 0);
    CHECK(lost_pixels > 0);
    CHECK(lost_tables > 0);
    CHECK(drops > 0);
}

}  // namespace
}  // namespace metabuffer::test::beat_receiver_test

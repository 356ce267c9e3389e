#include <catch2/catch.hpp>
#include <cstddef>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "composer_wave.h"
#include "expected_report.h"

namespace metabuffer::test::composer_timing_test {
namespace {

using rtl::BusBeat;
using rtl::Composer;

TEST_CASE("composer: timing: pixel read from the bus to its first use") {
    LockstepBench bench;
    ComposerWave dut(bench, "composer", composer_of(wave_scenario(4)));
    // Pixel b comes at the edge before it is composited, pixel c only at that edge.
    dut.drive("..FRa..b.c......", &Composer::bus_i, beats(segment_row({3, 1})));
    dut.drive("______-_________", &Composer::startframe_i);
    dut.drive(".......0123.....", &Composer::pipe_i, pixels());
    dut.check("........ab23....", &Composer::pipe_o, pixels());
    run({&dut});
}

TEST_CASE(
    "composer: timing: STARTFRAME in to STARTFRAME out and pixel in to pixel out STARTFRAME ahead of raster "
    "pixel 0 a frame in glitch mode") {
    LockstepBench bench;
    ComposerWave dut(bench, "composer", composer_of(wave_scenario(3, 2)));
    dut.drive("..E...............", &Composer::bus_i, beats({}));
    dut.drive("______-___________", &Composer::startframe_i);
    dut.check("_______-__________", &Composer::startframe_o);
    dut.drive(".......0123456....", &Composer::pipe_i, pixels());
    dut.check("........012345....", &Composer::pipe_o, pixels());
    run({&dut});
}

TEST_CASE(
    "composer: timing: prefetched or a beat that shows the loss of a table and PIPEREADY from below own "
    "PIPEREADY written at the edge that reads both") {
    LockstepBench bench;
    ComposerWave fetched_last(bench, "fetched_last", composer_of(wave_scenario(4)));
    fetched_last.drive("..FR..a.b..", &Composer::bus_i, beats(segment_row({2, 1})));
    fetched_last.drive("---------__", &Composer::pipeready_i);
    fetched_last.check("_________--", &Composer::pipeready_o);
    ComposerWave below_last(bench, "below_last", composer_of(wave_scenario(4)));
    below_last.drive("..E........", &Composer::bus_i, beats({}));
    below_last.drive("______-____", &Composer::pipeready_i);
    below_last.check("_______----", &Composer::pipeready_o);
    ComposerWave lost(bench, "lost", composer_of(wave_scenario(4)));
    lost.drive("......R....", &Composer::bus_i, beats(segment_row({2, 1})));  // without a frame start
    lost.drive("-----------", &Composer::pipeready_i);
    lost.check("_______----", &Composer::pipeready_o);
    run({&fetched_last, &below_last, &lost});
}

TEST_CASE("composer: timing: PIPEMASTER own PIPEREADY to STARTFRAME") {
    LockstepBench bench;
    Scenario scenario = wave_scenario(2);
    scenario.displays.background[1] = 22;
    auto letters = pixels();
    letters['#'] = {Pixel(0, 22, 0, 0, 0xFFFF), true, false};
    ComposerWave dut(bench, "composer", composer_of(scenario));
    dut.in(&Composer::pipemaster_i) = true;
    dut.drive("..E...........", &Composer::bus_i, beats({}));
    dut.drive("____-_________", &Composer::pipeready_i);
    dut.check("_____-________", &Composer::pipeready_o);
    dut.drive("---_-_--------", &Composer::startframe_i);  // not read
    dut.check("______-_______", &Composer::startframe_o);
    dut.drive("01234567890123", &Composer::pipe_i, pixels());
    dut.check(".......##.....", &Composer::pipe_o, letters);
    run({&dut});
}

TEST_CASE(
    "composer: timing: STARTFRAME read clears PIPEREADY at that edge the earliest new one is read below one "
    "clock after the last pixel of the frame") {
    LockstepBench bench;
    ComposerWave always(bench, "always", composer_of(wave_scenario(3)));
    always.drive("..EG..........", &Composer::bus_i, beats({}));
    always.drive("______-_______", &Composer::startframe_i);
    always.drive("--------------", &Composer::pipeready_i);
    always.check("___----____---", &Composer::pipeready_o);
    ComposerWave with_the_last(bench, "with_the_last", composer_of(wave_scenario(3)));
    with_the_last.drive("..EG..........", &Composer::bus_i, beats({}));
    with_the_last.drive("______-_______", &Composer::startframe_i);
    with_the_last.drive("_________-____", &Composer::pipeready_i);
    with_the_last.check("______________", &Composer::pipeready_o);
    run({&always, &with_the_last});
}

TEST_CASE("composer: timing: missing pixel STALL written one edge before the one that would have used it") {
    LockstepBench bench;
    const auto row = segment_row({4, 1});
    ComposerWave waits(bench, "waits", composer_of(wave_scenario(4, 1, StarvationMode::kStall)));
    // Pixel b is due at edge 8 and comes at edge 10; c and d come at the last edge at which nothing waits for them.
    waits.drive("..FRa.....bcd....", &Composer::bus_i, beats(row));
    waits.drive("______-__________", &Composer::startframe_i);
    waits.check("_______-_________", &Composer::startframe_o);
    waits.check("________---______", &Composer::stall_o);
    waits.drive("________---______", &Composer::column_stall_i);
    waits.drive(".......0111123...", &Composer::pipe_i, pixels());
    waits.check("........aaaabcd..", &Composer::pipe_o, pixels());
    run({&waits});
}

TEST_CASE(
    "composer: timing: margin of BUSREADY in a burst the beat on its way and one more and those that fit the "
    "loop") {
    LockstepBench bench;
    const auto row = segment_row({16, 1});
    Scenario scenario = wave_scenario(16);
    // Seven pixels are held after edge 10: there is no room for two beats any more.
    scenario.composer.buffer_pixels = 8;
    ComposerWave plain(bench, "plain", composer_of(scenario));
    plain.drive("..FRabcdefgh...................", &Composer::bus_i, burst(row, 11));
    plain.check("_----------____________________", &Composer::busready_o);
    // A loop of four clocks: no room for six.
    scenario.memory.read_latency_cycles = 2;
    scenario.bus.register_stages = 1;
    scenario.composer.buffer_pixels = 12;
    scenario.composer.ready_space_pixels = 6;
    ComposerWave loop(bench, "loop", composer_of(scenario));
    loop.drive("..FRabcdefghijkl...............", &Composer::bus_i, burst(row, 15));
    loop.check("_----------____________________", &Composer::busready_o);
    // The whole rest has room. After edge 14 one pixel is to come: BUSREADY is about a further slot.
    ComposerWave rest(bench, "rest", composer_of(scenario));
    rest.drive("..FRabcdefghijkl...............", &Composer::bus_i, burst(row, 11));
    rest.check("_--------------________________", &Composer::busready_o);
    // A loop of seven clocks and beats of four: no room for three.
    scenario.memory.read_latency_cycles = 3;
    scenario.bus.register_stages = 2;
    scenario.bus.width_bits = 16;
    scenario.composer.buffer_pixels = 6;
    scenario.composer.ready_space_pixels = 3;
    ComposerWave narrow(bench, "narrow", composer_of(scenario));
    narrow.drive("..FRa...b...c...d...e...f......", &Composer::bus_i, burst(row, 15));
    narrow.check("_----------------______________", &Composer::busready_o);
    run({&plain, &loop, &rest, &narrow});
}

TEST_CASE("composer: timing: fall of BUSREADY in a burst to the last edge that may bring a beat of it") {
    LockstepBench bench;
    const auto row = segment_row({16, 1});
    Scenario scenario = wave_scenario(16);
    scenario.composer.buffer_pixels = 8;
    // From edge 11 on a pixel is released at each edge: there is room for a slot at once, or long before it is said.
    ComposerWave plain(bench, "plain", composer_of(scenario));
    plain.drive("..FRabcdefg.......", &Composer::bus_i, burst(row, 11));
    plain.drive("__________-_______", &Composer::startframe_i);
    plain.check("_----------_------", &Composer::busready_o);
    scenario.memory.read_latency_cycles = 2;
    scenario.bus.register_stages = 1;
    scenario.composer.buffer_pixels = 12;
    scenario.composer.ready_space_pixels = 6;
    ComposerWave loop(bench, "loop", composer_of(scenario));
    loop.drive("..FRabcdefg.......", &Composer::bus_i, burst(row, 15));
    loop.drive("__________-_______", &Composer::startframe_i);
    loop.check("_----------_____--", &Composer::busready_o);
    run({&plain, &loop});
}

TEST_CASE(
    "composer: timing: a beat or table that shows a loss read from the bus STALL for a lost pixel falls to "
    "the "
    "first pixel marked as lost") {
    LockstepBench bench;
    const auto row = segment_row({6, 1});
    const auto glitch = composer_of(wave_scenario(6));
    const std::string start = "______-_________";
    const std::string above = ".......012345...";
    const std::string below =
        "........ab2DEF..";  // position 2 is composited at the edge that brings the beat
    ComposerWave pixel(bench, "pixel", glitch);
    pixel.drive("..FRab...d......", &Composer::bus_i, beats(row));
    ComposerWave table(bench, "table", glitch);
    table.drive("..FRab...G......", &Composer::bus_i, beats(row));
    ComposerWave lost_table(bench, "lost_table", glitch);
    lost_table.drive("..FRab...S......", &Composer::bus_i, beats(row));
    for (ComposerWave* dut : {&pixel, &table, &lost_table}) {
        dut->drive(start, &Composer::startframe_i);
        dut->drive(above, &Composer::pipe_i, pixels());
        dut->check(below, &Composer::pipe_o, pixels());
    }
    ComposerWave stalls(bench, "stalls", composer_of(wave_scenario(6, 1, StarvationMode::kStall)));
    stalls.drive("..FRa.....c.....", &Composer::bus_i, beats(row));
    stalls.drive("______-_________", &Composer::startframe_i);
    stalls.check("________---_____", &Composer::stall_o);
    stalls.drive("________---_____", &Composer::column_stall_i);
    stalls.drive(".......011112345", &Composer::pipe_i, pixels());
    stalls.check("........aaaaBCDE", &Composer::pipe_o, pixels());
    run({&pixel, &table, &lost_table, &stalls});
}

TEST_CASE(
    "composer: timing: a burst of which nothing more comes is over its last beat to BUSREADY for another") {
    LockstepBench bench;
    Scenario page_miss = wave_scenario(4);
    page_miss.composer.buffer_pixels = 4;
    page_miss.composer.ready_space_pixels = 3;  // no room for a slot beside the pixel that is still to come
    page_miss.memory.page_miss_cycles = 2;
    Scenario refresh = page_miss;
    refresh.memory.precharge_cycles = 1;
    refresh.memory.refresh_cycles = 3;
    refresh.memory.refresh_interval_cycles = 1000;
    Scenario shared = refresh;
    shared.memory.ports = MemoryPorts::kShared;
    shared.memory.write_block_words = 4;
    const auto row = segment_row({2, 1});
    std::vector<std::unique_ptr<ComposerWave>> duts;
    for (const auto& [scenario, gap] : {std::pair{page_miss, 2 + 1}, std::pair{refresh, 2 + 3 + 1 + 1},
                                        std::pair{shared, 2 + 3 + 1 + 3 * (2 + 4 + 2) + 1}}) {
        const auto wait = static_cast<std::size_t>(gap) - 1;
        const std::string rest(40 - wait, '_');
        for (const bool comes : {false, true}) {
            duts.push_back(std::make_unique<ComposerWave>(
                bench, ("composer_" + std::to_string(duts.size())).c_str(), composer_of(scenario)));
            ComposerWave& dut = *duts.back();
            dut.drive("..FRa" + std::string(wait, '.') + (comes ? "b" : ".") + std::string(rest.size(), '.'),
                      &Composer::bus_i, burst(row, 1));
            dut.check("_----" + std::string(wait, '_') + "_" + (comes ? rest : std::string(rest.size(), '-')),
                      &Composer::busready_o);
        }
    }
    for (const auto& dut : duts) leave(*dut);
    duts.front()->run();
}

TEST_CASE("composer: pixels of an abandoned frame are dropped without a report though the buffer is full") {
    LockstepBench bench;
    Scenario scenario = wave_scenario(20);
    scenario.composer.buffer_pixels = 4;
    scenario.bus.width_bits = 512;
    scenario.memory.words_per_cycle = 8;
    auto letters = beats(segment_row({4, 1}));
    letters['S'] = BusBeat::table_row(1, 0, segment_row({20, 1}), true);
    letters['J'] = BusBeat::frame_start(1, false);
    letters['y'] = burst_beat(1, 8, 8);
    letters['z'] = burst_beat(9, 16, 8);
    letters['y'].frame = letters['z'].frame = 1;
    // The first frame fills the buffer. Of the second one the first pixel is lost, and more come than the buffer's memory
    // has words.
    ComposerWave dut(bench, "composer", composer_of(scenario));
    dut.drive("..FRabcdJSyz......", &Composer::bus_i, letters);
    dut.drive("____________-_____", &Composer::startframe_i);
    dut.drive(".............0123.", &Composer::pipe_i, pixels());
    dut.check("..............abcd", &Composer::pipe_o, pixels());
    run({&dut});
}

TEST_CASE("composer: a beat that no bus may send is reported at the edge that reads it") {
    struct Beats {
        const char* name;
        std::string sent;  ///< the last one is wrong
        bool reported;
    };
    const std::vector<Beats> cases{
        {"a_pixel_for_a_full_buffer", "FRabcde", true},
        {"a_pixel_for_the_last_space", "FRabcd", false},
        {"a_pixel_again", "FRaba", true},
        {"a_pixel_without_a_table", "n", true},
        {"a_row_again", "FTT", true},
        {"a_row_after_the_last", "FRT", true},
        {"a_third_frame", "EGH", true},
        {"a_frame_again", "EE", true},
        {"a_beat_of_the_frame_before", "EGa", true},
        {"the_farthest_frame", "EY", false},
        {"a_frame_beyond", "EZ", true},
    };
    const ViewportRow row = segment_row({6, 1});
    auto letters = beats(row);
    letters['n'] = letters['a'];
    letters['n'].frame = static_cast<std::uint32_t>(-1);  // as before the first frame
    letters['T'] = BusBeat::table_row(0, 0, segment_row({6, 1}, {}, 1, 2), false);
    letters['Y'] = BusBeat::frame_start(65535, true);
    letters['Z'] = BusBeat::frame_start(65536, true);
    Scenario scenario = wave_scenario(8);
    scenario.composer.buffer_pixels = 4;
    LockstepBench bench;
    ExpectedReport report("/metabuffer/composer/protocol");
    constexpr int kFirst = 10;
    const int clocks = kFirst + static_cast<int>(cases.size()) + 1;
    std::vector<std::unique_ptr<ComposerWave>> duts;
    for (std::size_t i = 0; i < cases.size(); ++i) {
        std::string wave(static_cast<std::size_t>(clocks), '.');
        wave.replace(kFirst + i + 1 - cases[i].sent.size(), cases[i].sent.size(), cases[i].sent);
        duts.push_back(std::make_unique<ComposerWave>(bench, cases[i].name, composer_of(scenario)));
        duts.back()->drive(wave, &Composer::bus_i, letters);
        leave(*duts.back());
    }
    int reports = 0;
    for (std::size_t i = 0; i < cases.size(); ++i) {
        INFO(cases[i].name);
        // By the composer with clock gating and by the one without.
        if (cases[i].reported) reports += 2;
        bench.run(kFirst + static_cast<int>(i) + 1);
        CHECK(report.count() == reports);
    }
    bench.run(clocks);
    CHECK(report.count() == reports);
}

}  // namespace
}  // namespace metabuffer::test::composer_timing_test

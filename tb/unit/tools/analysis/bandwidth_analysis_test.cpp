#include "tools/analysis/bandwidth_analysis.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cstddef>
#include <string>
#include <vector>

#include "datapath/segment.h"
#include "formats/viewport_splitter.h"
#include "support/random_seed.h"
#include "support/scenarios.h"
#include "tools/analysis/analysis_report.h"

using namespace metabuffer;
using namespace metabuffer::analysis;

namespace {

/// A machine of one renderer, its image somewhere on the wall.
Scenario machine(const DisplayConfig& displays, int image, const Viewport& viewport) {
    Scenario scenario = test::with_renderer(
        Scenario(), test::renderer_of({PixelImage(image, image)}, {viewport}, displays.wall()));
    scenario.name = "test";
    scenario.displays = displays;
    scenario.renderers.front().name = "view";
    return scenario;
}

DisplayConfig wall_of(int columns, int rows, int size) {
    DisplayConfig displays;
    displays.columns = columns;
    displays.rows = rows;
    displays.width_pixels = size;
    displays.height_pixels = size;
    return displays;
}

Scenario paper_case(int number) {
    constexpr int kSize = 100;
    switch (number) {
        case 1:
            return machine(wall_of(2, 2, kSize), kSize, {0, 0, 1});
        case 2:
            return machine(wall_of(2, 2, kSize), kSize, {25, 25, 1});
        case 3:
            return machine(wall_of(2, 2, kSize), kSize, {0, 0, 2});
        default:
            return machine(wall_of(3, 3, kSize), kSize, {40, 60, 2});
    }
}

}  // namespace

TEST_CASE(
    "the four cases need one pixel a clock in sum, the ready space and for replicated rows a source row but "
    "a pixel",
    "[analysis]") {
    for (int number = 1; number <= 4; ++number) {
        INFO("case " << number);
        const Analysis analysis = analyze(paper_case(number));
        REQUIRE(analysis.tables.size() == 1);
        const Demand& demand = analysis.tables.front().demand;
        CHECK(demand.sum == Approx(1.0));
        CHECK(demand.most_at_once == Approx(1.0));
        CHECK(demand.mean == Approx(1.0));
        CHECK(demand.pixels == 10'000);
        // Replicated rows begin together: cases 3 and 4 need it all in every second raster row.
        CHECK(demand.busiest_row == Approx(number <= 2 ? 1.0 : 2.0));
    }
    for (int number = 1; number <= 4; ++number) {
        INFO("case " << number);
        const Analysis analysis = analyze(paper_case(number));
        const int ready = 32;
        for (const ComposerAnalysis& composer : analysis.tables.front().composers) {
            const int row = composer.row.dmultiple > 1 ? composer.row.sdx - 1 : 0;
            CHECK(composer.least_buffer_pixels == ready + row);
            CHECK(composer.whole_buffer_pixels ==
                  std::max<std::int64_t>(ready + row, composer.pixels + ready - 1));
        }
        CHECK(analysis.least_buffer_pixels == (number <= 2 ? ready : ready + 49));
    }
}

TEST_CASE("demand is what a raster painted pixel by pixel shows", "[analysis][random]") {
    test::Random random(test::random_seed(3));
    for (int round = 0; round < 60; ++round) {
        const DisplayConfig displays =
            wall_of(random.between(1, 3), random.between(1, 3), random.between(5, 24));
        const int image = random.between(40, 60);
        const Scenario scenario = machine(
            displays, image, {random.between(-30, 40), random.between(-30, 40), random.between(1, 4)});
        const Analysis analysis = analyze(scenario);
        const Demand& demand = analysis.tables.front().demand;
        const int size = displays.width_pixels;
        const ViewportTable& table = scenario.renderers.front().frames.front().table;
        double most = 0.0;
        double busiest = 0.0;
        std::int64_t pixels = 0;
        for (int y = 0; y < size; ++y) {
            double rate = 0.0;
            int first_shown = 0;
            for (const ViewportRow& row : table) {
                const Segment segment(row, size, size);
                bool covered = false;
                for (std::int64_t k = 0; k < segment.pixels(); ++k) {
                    first_shown += segment.first_use(k) / size == y ? 1 : 0;
                    covered =
                        covered || (segment.first_use(k) / size <= y && y <= segment.last_use(k) / size);
                }
                rate += covered ? static_cast<double>(row.sdx) / (row.dmultiple * size) : 0.0;
            }
            most = std::max(most, rate);
            busiest = std::max(busiest, static_cast<double>(first_shown) / size);
            pixels += first_shown;
        }
        CHECK(demand.most_at_once == Approx(most).margin(1e-9));
        CHECK(demand.busiest_row == Approx(busiest).margin(1e-9));
        CHECK(demand.pixels == pixels);
        CHECK(demand.mean == Approx(static_cast<double>(pixels) / (size * size)).margin(1e-9));
    }
}

TEST_CASE("a bus that is too slow falls short by the pixels that a frame has too many", "[analysis]") {
    Scenario scenario = paper_case(3);
    scenario.memory.page_miss_cycles = 0;
    scenario.bus.width_bits = 32;  // a pixel in two clocks
    Analysis analysis = analyze(scenario);
    const TableAnalysis& table = analysis.tables.front();
    CHECK(table.supply.raw == Approx(0.5));
    CHECK(table.supply.sustained == Approx(0.5));
    CHECK(table.supply.burst_cycles == 20'000);
    CHECK(table.supply.table_cycles == 1 + 4 * 4);
    CHECK(table.most_pixels_short(analysis.period_cycles) == Approx(10'000 - 0.5 * (10'000 - 17)));
    CHECK(table.least_pixels_short(analysis.period_cycles) == Approx(table.most_pixels_short(10'000)));
    CHECK(table.load == Approx(2.0).epsilon(0.01));
    CHECK(analysis.sustained_frame_rate_hz == Approx(100e6 / 20'017));
    const std::string text = analysis_text(analysis, true);
    CHECK(text.find("the bus cannot carry them with any buffer") != std::string::npos);
    CHECK(text.find("5009  pixels or more") != std::string::npos);

    analysis = analyze(scenario, {std::nullopt, 1000.0});
    CHECK(analysis.period_cycles == Approx(100'000.0));
    CHECK(analysis.tables.front().most_pixels_short(analysis.period_cycles) == 0.0);
    CHECK(analysis_text(analysis, true).find("the rate asked for can be carried") != std::string::npos);
    analysis = analyze(scenario, {std::nullopt, 6000.0});
    CHECK(analysis_text(analysis, true).find("the rate asked for cannot be held") != std::string::npos);
}

TEST_CASE("the answer comes first, and the tables in full only if asked for", "[analysis]") {
    const Analysis analysis = analyze(paper_case(4));
    const std::string text = analysis_text(analysis, false);
    const std::size_t rates = text.find("frame rate, in frames/s:\n");
    const std::size_t buffers = text.find("composer buffers, of all renderers, in pixels:\n");
    const std::size_t buses = text.find("buses, in % of a frame's 10000 clocks:\n");
    REQUIRE(buses != std::string::npos);
    CHECK(rates < buffers);
    CHECK(buffers < buses);
    CHECK(text.find("slot table") == text.rfind("slot table"));  // in the line that says where it is
    CHECK(analysis_text(analysis, true).rfind(text.substr(0, text.rfind("(--details")), 0) == 0);
    CHECK(text.find("  with on_starvation: stall ") != std::string::npos);
}

TEST_CASE(
    "the bottleneck is the slowest part, and the memory rather than the bus if the memory alone is slower",
    "[analysis]") {
    Scenario scenario = paper_case(3);
    scenario.clocks.dvi_in_mhz = scenario.clocks.dvi_out_mhz = 10'000.0;
    scenario.memory.page_miss_cycles = 0;
    const auto slowest = [&scenario] { return rates_of_parts(analyze(scenario)).front(); };
    const auto raw = [&scenario] {
        const std::string text = analysis_text(analyze(scenario), true);
        const std::size_t at = text.find("  raw ");
        return text.substr(at, text.find('\n', at) - at);
    };
    scenario.bus.width_bits = 32;
    scenario.memory.words_per_cycle = 1;
    CHECK(slowest().part == "bus");
    CHECK(slowest().frames_per_second == Approx(100e6 / 20'017));
    CHECK(raw() == "  raw                            0.500  of the bus; its memory could read 1");
    scenario.bus.width_bits = 256;
    CHECK(raw() ==
          "  raw                            1.000  of the memory (memory.words_per_cycle); its bus could "
          "carry 4");
    scenario.memory.page_miss_cycles = 6;
    CHECK(slowest().part == "memory");
    scenario.memory.words_per_cycle = 8;
    scenario.bus.width_bits = 512;
    scenario.clocks.core_mhz = 1'000.0;
    scenario.clocks.dvi_out_mhz = 100.0;
    CHECK(slowest().part == "displays");
    scenario.clocks.dvi_in_mhz = 50.0;
    CHECK(slowest().part == "links");
    CHECK(raw() == "  raw                            8.000  bus and memory alike");
}

TEST_CASE("displays, links and raster that are too slow for a frame rate are named", "[analysis]") {
    Scenario scenario = paper_case(1);  // displays of 100 x 100, a raster of 10,000 clocks
    scenario.bus.width_bits = 512;
    scenario.memory.words_per_cycle = 8;
    scenario.memory.page_miss_cycles = 0;
    const auto verdict = [&scenario](double frame_rate_hz) {
        const std::string text = analysis_text(analyze(scenario, {std::nullopt, frame_rate_hz}), true);
        const std::size_t at = text.find("the rate asked for");
        return text.substr(at, text.find('\n', at) - at);
    };
    const std::string cannot = "the rate asked for cannot be held with any buffer: too slow for it: ";
    scenario.clocks.dvi_in_mhz = 10'000.0;
    CHECK(analyze(scenario).limits.refresh_hz == Approx(100e6 / (180 * 115)));  // 4,831
    CHECK(verdict(4830.0) == "the rate asked for can be carried");
    CHECK(verdict(4833.0) == "the rate asked for can be carried");  // within a thousandth
    CHECK(verdict(4900.0) == cannot + "the displays");
    CHECK(verdict(10'100.0) == cannot + "the raster and the displays");
    scenario.clocks.dvi_out_mhz = 10'000.0;
    CHECK(analyze(scenario).limits.refreshes_per_frame() == 49);
    CHECK(verdict(9'800.0) == "the rate asked for can be carried");
    scenario.clocks.dvi_in_mhz = 25.0;
    const double pairs = analyze(scenario).limits.slowest_pairs_per_second();
    CHECK(verdict(pairs) == "the rate asked for can be carried");
    CHECK(verdict(pairs * 1.01) == cannot + "the links");
    CHECK(analyze(scenario).most_frame_rate_hz() == Approx(pairs));
    const std::string text = analysis_text(analyze(scenario), true);
    CHECK(text.find(", a new frame every 49 times: the raster takes longer than a refresh\n") !=
          std::string::npos);
    CHECK(text.find(" pairs a second\n") != std::string::npos);
    CHECK(analysis_json(analyze(scenario)).find("\"pairs_per_second\": [") != std::string::npos);
}

TEST_CASE("what a frame lacks lies between each page opened once and every miss counted", "[analysis]") {
    Scenario scenario = paper_case(3);  // a pixel a clock, 20 pages of 512 words
    scenario.memory.words_per_cycle = 1;
    const Analysis analysis = analyze(scenario);
    const TableAnalysis& table = analysis.tables.front();
    CHECK(table.supply.least_burst_cycles == 10'000 + 20 * 6);
    CHECK(table.supply.burst_cycles > table.supply.least_burst_cycles);
    CHECK(table.least_pixels_short(10'000) < table.most_pixels_short(10'000));
    CHECK(table.least_pixels_short(10'000) > 0.0);
    CHECK(analysis.best_frame_rate_hz > analysis.sustained_frame_rate_hz);
    CHECK(analysis.best_frame_rate_hz == Approx(100e6 / (10'000 + 20 * 6 + 1 + 4 * 2)));
}

TEST_CASE("each different table of the run stands once with its frames and rejected rows", "[analysis]") {
    Scenario scenario = paper_case(1);
    scenario.frames = 4;
    Renderer& renderer = scenario.renderers.front();
    RendererFrame moved = renderer.frames.front();
    moved.table.front().sdx = 60;
    moved.table.push_back({9, 0, 0, 10, 10, 0, 0, 1});
    renderer.frames.push_back(moved);
    renderer.frames.push_back(renderer.frames.front());
    const Analysis all = analyze(scenario);
    REQUIRE(all.tables.size() == 2);
    CHECK(all.tables[0].frames == std::vector<int>{0, 2});
    CHECK(all.tables[1].frames == std::vector<int>{1});
    REQUIRE(all.tables[1].rejected.size() == 1);
    CHECK(all.tables[1].rejected.front().defect == RowDefect::kDisplay);
    CHECK(analysis_text(all, true).find("row 1 rejected (display): Dcomp 9") != std::string::npos);
    // Without details a line for the renderer, of the table of most work; what is rejected is reported in any case.
    const std::string answer = analysis_text(all, false);
    CHECK(answer.find("frames 0, 2, the most of 2 tables") != std::string::npos);
    CHECK(answer.find("row 1 rejected (display): Dcomp 9") != std::string::npos);

    const Analysis second = analyze(scenario, {1, std::nullopt});
    REQUIRE(second.tables.size() == 1);
    CHECK(second.tables.front().tasks.front().data_pixels == 60);
    CHECK(second.safe_buffer_pixels == all.safe_buffer_pixels);
    // The last entry repeats.
    CHECK(analyze(scenario, {3, std::nullopt}).tables.front().tasks.front().data_pixels == 100);
}

TEST_CASE("a row that buffers are too small for is still analyzed, and without slots there is no slot table",
          "[analysis]") {
    Scenario scenario = paper_case(3);
    scenario.composer.buffer_pixels = 40;
    const Analysis analysis = analyze(scenario);
    CHECK(analysis.tables.front().rejected.size() == 4);
    CHECK(analysis.tables.front().composers.size() == 4);
    CHECK_FALSE(analysis.scenario_is_safe);
    CHECK(analysis.safe_buffer_pixels >= 82);
    scenario = paper_case(2);
    CHECK(analyze(scenario).tables.front().slot_displays == std::vector<int>{1, 3, 2, 1, 3, 4, 1, 3});
    scenario.bus.arbitration = Arbitration::kRoundRobin;
    CHECK(analyze(scenario).tables.front().slot_displays == std::vector<int>{1, 2, 3, 4});
    scenario.bus.arbitration = Arbitration::kEdf;
    CHECK(analyze(scenario).tables.front().slot_displays.empty());
}

TEST_CASE("without a bound a line says so and the JSON has none", "[analysis]") {
    Analysis analysis = analyze(paper_case(4));
    CHECK(analysis_text(analysis, true).find("no bound") == std::string::npos);
    analysis.safe_buffer_pixels.reset();
    analysis.safe_buffer_is_legal.reset();
    analysis.scenario_is_safe = false;
    const std::string text = analysis_text(analysis, true);
    CHECK(text.find("  never starves with          no bound  nothing is proved of irsa\n") !=
          std::string::npos);
    CHECK(text.find("  this scenario                   1024  may starve\n") != std::string::npos);
    const std::string json = analysis_json(analysis);
    CHECK(json.find("\"safe_pixels\": null") != std::string::npos);
    CHECK(json.find("\"safe_is_legal\": null") != std::string::npos);
}

TEST_CASE("a frame takes longer by the clocks of its refreshes", "[analysis]") {
    Scenario scenario = paper_case(3);
    scenario.memory.page_miss_cycles = 0;
    scenario.bus.width_bits = 32;  // a pixel in two clocks
    scenario.memory.refresh_interval_cycles = 100;
    scenario.memory.refresh_cycles = 20;
    const Analysis analysis = analyze(scenario);
    const TableAnalysis& table = analysis.tables.front();
    CHECK(table.supply.refresh_share == Approx(0.2));
    CHECK(table.supply.frame_cycles() == 25'022);  // (20,000 + 17) / 0.8
    CHECK(table.load == Approx(2.5).epsilon(0.01));
    CHECK(table.most_pixels_short(10'000) == Approx(10'000 - 0.5 * (8'000 - 17)));
    const std::string text = analysis_text(analysis, true);
    CHECK(text.find("a refresh counts 20 clocks in every 100, with those to open the burst's page again\n") !=
          std::string::npos);
    CHECK(text.find("  refreshes                     20.0 %  of the clocks at most\n") != std::string::npos);
    CHECK(analysis_text(analyze(paper_case(4)), true).find("refresh") == std::string::npos);
}

TEST_CASE("a frame takes longer by the link's words: those of a pair, or of a link that always sends",
          "[analysis]") {
    Scenario scenario = paper_case(4);
    scenario.memory.ports = MemoryPorts::kShared;
    scenario.memory.words_per_cycle = 4;
    scenario.memory.write_block_words = 125;  // 80 blocks of 32 clocks and two page misses
    scenario.memory.page_words = 500;
    scenario.clocks.dvi_in_mhz = 10'000.0;  // a pair in 418 clocks
    const auto supply = [&scenario] { return analyze(scenario).tables.front().supply; };
    const std::int64_t own_cycles = supply().table_cycles + supply().burst_cycles;
    CHECK(supply().frame_cycles() == own_cycles + 2 * 80 * 44);
    // Twice 80 blocks in the 41,760 clocks of a pair.
    scenario.clocks.dvi_in_mhz = 100.0;
    const double share = 2.0 * 80 * 44 / (2 * 180 * 116);
    CHECK(supply().writes.share == Approx(share).epsilon(0.001));
    CHECK(supply().frame_cycles() == Approx(static_cast<double>(own_cycles) / (1.0 - share)).epsilon(0.001));
    CHECK(supply().writes.in(10'000) == Approx(10'000 * share).epsilon(0.001));
    const std::string text = analysis_text(analyze(scenario), true);
    CHECK(
        text.find("a write of the link counts 44 clocks for every 125 words, with those to open its page and "
                  "the burst's again\n") != std::string::npos);
    CHECK(text.find("  writes of the link            16.9 %  of the clocks at most\n") != std::string::npos);
    CHECK(analysis_text(analyze(paper_case(4)), true).find("of the link") == std::string::npos);
}

TEST_CASE("a bus with delays waits after each burst of the composer that is done last", "[analysis]") {
    Scenario scenario = paper_case(4);
    scenario.memory.read_latency_cycles = 3;
    scenario.bus.register_stages = 1;
    const TableAnalysis table = analyze(scenario).tables.front();
    std::int64_t most_bursts = 0;
    for (const ComposerAnalysis& composer : table.composers)
        most_bursts = std::max(most_bursts, composer.bursts);
    CHECK(table.supply.idle_cycles == 6 * most_bursts);
    CHECK(table.supply.frame_cycles() ==
          table.supply.table_cycles + table.supply.burst_cycles + table.supply.idle_cycles);
    scenario.bus.slot_table = SlotTableMaker::kBuilt;
    const TableAnalysis built = analyze(scenario).tables.front();
    CHECK(built.supply.idle_cycles ==
          table.supply.idle_cycles + static_cast<std::int64_t>(built.slot_displays.size()));
}

TEST_CASE("JSON has the figures of the text", "[analysis]") {
    const Analysis analysis = analyze(paper_case(4));
    const std::string json = analysis_json(analysis);
    CHECK(json.find("\"task\": \"3b\"") != std::string::npos);
    CHECK(json.find("\"safe_pixels\": " + std::to_string(*analysis.safe_buffer_pixels)) != std::string::npos);
    CHECK(json.find("\"asked_frame_rate_hz\": null") != std::string::npos);
    const std::string text = analysis_text(analysis, true);
    CHECK(text.find("3b          20       200       200  6") != std::string::npos);
    CHECK(text.find(std::to_string(*analysis.safe_buffer_pixels)) != std::string::npos);
}

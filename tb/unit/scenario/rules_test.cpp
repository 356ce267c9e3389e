#include <catch2/catch.hpp>
#include <functional>
#include <memory>
#include <optional>
#include <regex>
#include <string>

#include "host/text.h"
#include "scenario/fault_keys.h"
#include "scenario/names.h"
#include "support/random_seed.h"
#include "support/scenarios.h"
#include "unit/scenario/scenario_fixture.h"

namespace metabuffer::test {
namespace {

/// A good scenario built in C++, as testbenches do.
Scenario built() {
    Scenario scenario =
        with_renderer(small_scenario(16, 8), renderer_of({PixelImage(16, 8)}, {segment_row({16, 8})}));
    scenario.name = "built";
    scenario.renderers.front().name = "ball";
    return scenario;
}

void set_image(Scenario& scenario, const PixelImage& image) {
    scenario.renderers[0].images[0] = std::make_shared<const StoredImage>(image);
}

using Change = std::function<void(Scenario&)>;

std::string error_after(const Change& corrupt) {
    Scenario scenario = built();
    corrupt(scenario);
    return input_error_of([&] { check_scenario(scenario); });
}

}  // namespace

TEST_CASE("rules: settings") {
    CHECK_NOTHROW(check_scenario(built()));
    CHECK(error_after([](auto& s) { s.composer.buffer_pixels = 1; }).empty());
    CHECK(error_after([](auto& s) { s.name = "../elsewhere"; }) ==
          "name: '../elsewhere' is a path; use a plain name, without slashes");
    CHECK(error_after([](auto& s) {
              s.faults = {{0, 1, FaultKind::kNumber, FrameKind::kColour, 0},
                          {0, 1, FaultKind::kNumber, FrameKind::kDepth, 0}};
          }) ==
          "faults[0].kind: number on both frames of a pair can make it a good pair of another number; use "
          "one of them on one frame");
    check_refusals<Change>(error_after)({
        {[](auto& s) { s.displays.columns = 0; }, "displays.columns: 0 is out of range; use 1 to 64"},
        {[](auto& s) { s.displays.rows = 65; }, "displays.rows: 65 is out of range; use 1 to 64"},
        {[](auto& s) { s.displays.width_pixels = 0; }, "displays.width: 0 is out of range; use 1 to 4096"},
        {[](auto& s) { s.displays.height_pixels = 2'000'000'000; },
         "displays.height: 2000000000 is out of range; use 1 to 4096"},
        {[](auto& s) { s.displays.supersample = 3; },
         "displays.supersample: 3 is not a supersampling; use 1, 2 or 4"},
        {[](auto& s) { s.image_reading.near = 100.0; },
         "depth_range: near and far are both 100; use two different depths"},
        {[](auto& s) { s.image_reading.far = std::numeric_limits<double>::quiet_NaN(); },
         "depth_range: nan is out of range; use -1e+30 to 1e+30"},
        {[](auto& s) { s.clocks.core_mhz = 0.0; }, "clocks.core_mhz: 0 is out of range; use 0.001 to 10000"},
        {[](auto& s) { s.clocks.dvi_in_mhz = -1.0; },
         "clocks.dvi_in_mhz: -1 is out of range; use 0.001 to 10000"},
        {[](auto& s) { s.clocks.dvi_out_mhz = 1e5; },
         "clocks.dvi_out_mhz: 1e+05 is out of range; use 0.001 to 10000"},
    });
    const auto shown_at = [](double refresh_hz, double mhz) {
        return [refresh_hz, mhz](Scenario& s) {
            s.clocks.given_dvi_out_refresh_hz = refresh_hz;
            s.clocks.dvi_out_mhz = mhz;
        };
    };
    const double mode_clocks = static_cast<double>(built().displays.timing().frame_clocks());
    check_refusals<Change>(error_after)({
        {shown_at(1000.0, mode_clocks / 1000.0), ""},
        {shown_at(1000.0, 3.5), "clocks.dvi_out_mhz: 3.5 is not what dvi_out_refresh_hz needs, " +
                                    text::number(mode_clocks / 1000.0) + "; use one of the two"},
        {shown_at(1e8, 100.0), "clocks.dvi_out_refresh_hz: 1e+08 frames of ..."},
        {[](auto& s) {
             s.clocks.given_dvi_in_refresh_hz = 100.0;
             s.clocks.dvi_in_mhz = 50.0;
         },
         "clocks.dvi_in_mhz: 50 is not what dvi_in_refresh_hz needs, ..."},
        {[](auto& s) { s.memory.page_words = 0; }, "memory.page_words: 0 is out of range; use 1 to 16777216"},
        {[](auto& s) { s.memory.page_miss_cycles = -1; },
         "memory.page_miss_cycles: -1 is out of range; use 0 to 1000000"},
        {[](auto& s) { s.memory.banks = 3; }, "memory.banks: 3 is not a number of banks; use 1, 2, 4 or 8"},
        {[](auto& s) { s.memory.precharge_cycles = 7; },
         "memory.precharge_cycles: 7 is out of range; use 0 to 4"},
        {[](auto& s) {
             s.memory.page_miss_cycles = 3;
             s.memory.precharge_cycles = 4;
         },
         "memory.precharge_cycles: 4 is more than page_miss_cycles, 3, which counts it; use 3 or less"},
        {[](auto& s) {
             s.memory.precharge_cycles = 2;
             s.memory.given_activate_cycles = 3;
         },
         "memory.page_miss_cycles: 6 is not precharge_cycles + activate_cycles, 2 + 3; use 5, or "
         "activate_cycles: "
         "4"},
        {[](auto& s) {
             s.memory.precharge_cycles = 2;
             s.memory.given_activate_cycles = 3;
             s.memory.page_miss_cycles = 5;
         },
         ""},
        {[](auto& s) {
             s.memory.precharge_cycles = 2;
             s.memory.given_activate_cycles = 4;
         },
         ""},
        {[](auto& s) { s.memory.refresh_cycles = 5; },
         "memory.refresh_cycles: 5 without refresh_interval_cycles; use one of 12 or more, or neither"},
        {[](auto& s) { s.memory.refresh_interval_cycles = 50; },
         "memory.refresh_interval_cycles: 50 without refresh_cycles; use both, or neither"},
    });
    const auto refreshed = [](int interval_cycles) {
        return [interval_cycles](Scenario& s) {
            s.memory.page_miss_cycles = 6;
            s.memory.refresh_cycles = 5;
            s.memory.refresh_interval_cycles = interval_cycles;
        };
    };
    CHECK(error_after(refreshed(11)) ==
          "memory.refresh_interval_cycles: 11 leaves no cycle for a beat besides refresh_cycles and "
          "page_miss_cycles; use 12 or more");
    CHECK(error_after(refreshed(12)).empty());
    // The pair of an image of one line is judged a line after it, about 100 clocks later.
    const auto shared = [](int block_words, int refresh_interval) {
        return [block_words, refresh_interval](Scenario& s) {
            s.clocks = {100.0, 50.0, 50.0};
            s.memory.page_words = 64;
            s.memory.page_miss_cycles = 6;
            s.memory.words_per_cycle = 2;
            s.memory.ports = MemoryPorts::kShared;
            s.memory.write_block_words = block_words;
            s.memory.refresh_interval_cycles = refresh_interval;
            s.memory.refresh_cycles = refresh_interval > 0 ? 5 : 0;
        };
    };
    check_refusals<Change>(error_after)({
        {shared(48, 0),
         "memory.write_block_words: 48 does not divide page_words, 64; use 32 or another divisor of it"},
        {shared(32, 0), ""},
        {shared(65, 0),
         "memory.write_block_words: 65 does not divide page_words, 64; use 64 or another divisor of it"},
        // Three clocks to cross, a page that is being opened, 6 + 4 to write, and the page again.
        {shared(8, 0),
         "memory.write_block_words: 8 words of renderers[0] come in 16 core cycles, and until they are "
         "written and the bus has its page open again 25 may pass; use core_mhz 156.238 or more, dvi_in_mhz "
         "32 or "
         "less, more words_per_cycle or larger blocks"},
        {shared(16, 0), ""},
        // After the last pixel the last block is written, however many there are before it.
        {[&shared](Scenario& s) {
             shared(16, 0)(s);
             s.renderers[0] = renderer_of({PixelImage(16, 128)}, {segment_row({16, 8})});
         },
         ""},
        {shared(16, 100),
         "memory.write_block_words: 16 words of renderers[0] come in 32 core cycles, and until they are "
         "written and the bus has its page open again 48 may pass; use ..."},
    });
    // That must be over when the pair is judged: 3 clocks to cross, 3 pages to open, 64 + 64 to write.
    const auto judged_early = [&shared](int page_miss) {
        return [&shared, page_miss](Scenario& s) {
            shared(128, 0)(s);
            s.memory.page_words = 128;
            s.memory.page_miss_cycles = page_miss;
            s.renderers[0] = renderer_of({PixelImage(16, 128)}, {segment_row({16, 8})});
        };
    };
    CHECK(error_after(judged_early(20)).empty());
    CHECK(error_after(judged_early(21)) ==
          "memory.write_block_words: 128 words may be written as late as 194 core cycles after the last "
          "pixel of renderers[0] whose pair is judged after 192; use core_mhz 101.046 or more, dvi_in_mhz "
          "49.484 or "
          "less, more words_per_cycle or smaller blocks");
    // An image of 112 words has no full block: 3 + 3 * 23 + 64 + 56 are the 192 clocks to the clock.
    const auto one_block = [&judged_early](int page_miss) {
        return [&judged_early, page_miss](Scenario& s) {
            judged_early(page_miss)(s);
            s.renderers[0] = renderer_of({PixelImage(16, 7)}, {segment_row({16, 7})});
        };
    };
    CHECK(error_after(one_block(23)).empty());
    CHECK(error_after(one_block(24)).find(" as late as 195 core cycles") != std::string::npos);
    // A link that a fault makes a tenth faster brings 16 words in 29 clocks, and 29 clocks are needed.
    const auto drifting = [&](int page_miss) {
        return [&shared, page_miss](Scenario& s) {
            shared(16, 0)(s);
            s.memory.page_miss_cycles = page_miss;
            Fault drift;
            drift.kind = FaultKind::kDrift;
            drift.ppm = 100'000;
            s.faults.push_back(drift);
        };
    };
    check_refusals<Change>(error_after)({
        {drifting(6), ""},
        {drifting(7),
         "memory.write_block_words: 16 words of renderers[0], with the drift of its link, come in 29 core "
         "cycles, and until they are written and the bus has its page open again 32 may pass; use ..."},
        {shared(32, 61),
         "memory.refresh_interval_cycles: 61 leaves no cycle for a beat besides refresh_cycles, "
         "page_miss_cycles and two blocks of the link's words; use 62 or more"},
        // 2 * (6 + 16) to write two blocks, 2 * 6 to open the page twice, 5 to refresh and one to read.
        {shared(32, 62), ""},
        {[](auto& s) { s.memory.words_per_cycle = 9; },
         "memory.words_per_cycle: 9 is out of range; use 1 to 8"},
        {[](auto& s) { s.bus.width_bits = 48; },
         "bus.width_bits: 48 is not a bus width; use 16, 32, 64, 128, 256 or 512"},
        {[](auto& s) { s.bus.burst_pixels = 0; }, "bus.burst_pixels: 0 is out of range; use 1 to 65535"},
        {[](auto& s) { s.composer.buffer_pixels = (1 << 24) + 1; },
         "composer.buffer_pixels: 16777217 is out of range; use 1 to 16777216"},
        {[](auto& s) { s.composer.ready_space_pixels = 1; },
         "composer.ready_space_pixels: 1 is less than the 2 pixels that can be in flight; use 2 or more"},
        {[](auto& s) {
             s.bus.width_bits = 512;
             s.memory.words_per_cycle = 8;
             s.composer.ready_space_pixels = 15;
         },
         "composer.ready_space_pixels: 15 is less than the 16 pixels that can be in flight; use 16 or more"},
        {[](auto& s) { s.link_timeout_pairs = 0; },
         "link_timeout_pairs: 0 is out of range; use 1 to 1000000"},
        {[](auto& s) { s.watchdog_cycles = -1; },
         "watchdog_cycles: -1 is out of range; use 0 to 1000000000000000"},
        {[](auto& s) { s.frames = 0; }, "frames: 0 is out of range; use 1 to 1000000"},
    });
}

/// The number that a refusal names with a key; none if it names none.
std::optional<double> named(const std::string& message, const std::string& key) {
    std::smatch match;
    if (!std::regex_search(message, match, std::regex(key + " ([0-9.e+-]+) or (more|less)")))
        return std::nullopt;
    return std::stod(match[1]);
}

/// With shared ports: a link of that clock, perhaps one that drifts, beside a slower or smaller one.
Scenario random_shared_ports(Random& random) {
    Scenario scenario =
        with_renderer(built(), renderer_of({PixelImage(16, random.between(1, 40))}, {segment_row({16, 1})}));
    scenario.renderers.back().name = "sea";
    scenario.clocks = {random.between(20, 4000) / 10.0, random.between(20, 4000) / 10.0, 50.0};
    MemoryConfig& memory = scenario.memory;
    memory.ports = MemoryPorts::kShared;
    memory.page_words = 256;
    memory.write_block_words = 1 << random.between(2, 8);
    memory.words_per_cycle = random.between(1, 4);
    memory.page_miss_cycles = random.between(0, 12);
    scenario.composer.ready_space_pixels = default_ready_space_pixels(scenario.bus, memory);
    for (int renderer = 0; renderer < 2; ++renderer) {
        Fault drift;
        drift.kind = FaultKind::kDrift;
        drift.renderer = renderer;
        drift.ppm = random.between(-100'000, 100'000);
        if (random.one_in(3)) scenario.faults.push_back(drift);
    }
    return scenario;
}

TEST_CASE("rules: a clock that a refusal names is accepted, and one that is a thousandth worse is not") {
    const std::uint64_t seed = random_seed(17);
    INFO("METABUFFER_SEED=" << seed);
    Random random(seed);
    int core_clocks = 0;
    int link_clocks = 0;
    int rates = 0;
    const auto accepted = [](const Scenario& scenario) {
        return input_error_of([&] { check_scenario(scenario); }).empty();
    };
    for (int i = 0; i < 300; ++i) {
        const Scenario scenario = random_shared_ports(random);
        const std::string message = input_error_of([&] { check_scenario(scenario); });
        if (message.empty()) continue;
        INFO(message);
        Scenario changed = scenario;
        if (const auto core_mhz = named(message, "core_mhz")) {
            ++core_clocks;
            changed.clocks.core_mhz = *core_mhz;
            CHECK(accepted(changed));
            changed.clocks.core_mhz = *core_mhz - 0.001;
            CHECK_FALSE(accepted(changed));
        }
        changed = scenario;
        if (const auto link_mhz = named(message, "dvi_in_mhz")) {
            ++link_clocks;
            changed.clocks.dvi_in_mhz = *link_mhz;
            CHECK(accepted(changed));
            changed.clocks.dvi_in_mhz = *link_mhz + 0.001;
            CHECK_FALSE(accepted(changed));
        }
        // The same as a refresh rate, which is for images of one size.
        changed = scenario;
        changed.renderers.resize(1);
        changed.faults.clear();
        const auto set_rate = [&changed](double refresh_hz) {
            changed.clocks.given_dvi_in_refresh_hz = refresh_hz;
            changed.clocks.dvi_in_mhz = mhz_of_refresh(refresh_hz, changed.renderers[0].timing());
        };
        set_rate(scenario.clocks.dvi_in_mhz / mhz_of_refresh(1.0, changed.renderers[0].timing()));
        const auto rate = named(input_error_of([&] { check_scenario(changed); }), "dvi_in_refresh_hz");
        if (!rate) continue;
        ++rates;
        set_rate(*rate);
        CHECK(accepted(changed));
        set_rate(*rate + 0.001);
        // A clock is made of whole picoseconds, so a thousandth may change nothing.
        if (clock_period_picoseconds(changed.clocks.dvi_in_mhz) !=
            clock_period_picoseconds(mhz_of_refresh(*rate, changed.renderers[0].timing()))) {
            CHECK_FALSE(accepted(changed));
        }
    }
    CHECK(core_clocks > 20);
    CHECK(link_clocks > 20);
    CHECK(rates > 20);
}

TEST_CASE("rules: renderers, faults, images and tables") {
    check_refusals<Change>(error_after)({
        {[](auto& s) { s.renderers.clear(); }, "renderers: has no entries; use at least one renderer"},
        {[](auto& s) { s.renderers[0].name.clear(); }, "renderers[0].name: is empty; use a name"},
        {[](auto& s) { s.renderers.push_back(s.renderers[0]); },
         "renderers[1].name: 'ball' is taken by an earlier renderer; use a name of its own"},
        {[](auto& s) { s.renderers[0].frames.clear(); },
         "renderers[0].frames: has no entries; use at least one frame"},
        {[](auto& s) {
             s.displays.columns = s.displays.rows = 64;
             const Renderer one = s.renderers[0];
             for (int i = 1; i < 17; ++i) {
                 s.renderers.push_back(one);
                 s.renderers.back().name += std::to_string(i);
             }
         },
         "renderers: 17 renderers on 4096 displays need 69632 composers; use at most 65536, which is 16 "
         "renderers"},
        {[](auto& s) {
             s.faults.push_back({1, 0, FaultKind::kCrc});
         },
         "faults[0].renderer: 1 is not a renderer's index; use 0 to 0"},
        {[](auto& s) {
             s.faults.push_back({-1, 0, FaultKind::kCrc});
         },
         "faults[0].renderer: -1 is not a renderer's index; use 0 to 0"},
        {[](auto& s) {
             s.faults.push_back({0, 0, FaultKind::kDelay});
         },
         "faults[0].delay_pairs: 0 is out of range; use 1 to 1000000"},
        {[](auto& s) {
             s.faults.push_back({0, 0, FaultKind::kCrc, FrameKind::kDepth, 1});
         },
         "faults[0].delay_pairs: does not go with kind crc; use it with kind delay only"},
    });
    check_refusals<Change>(error_after)({
        {[](auto& s) { s.renderers[0].image_width_pixels = 0; },
         "renderers[0].frames: 0 is out of range; use 1 to 8192"},
        {[](auto& s) { s.renderers[0].image_height_pixels = 8193; },
         "renderers[0].frames: 8193 is out of range; use 1 to 8192"},
        {[](auto& s) { s.renderers[0].frames[0].image = 1; },
         "renderers[0].frames[0].image: 1 is not an image's index; ..."},
        {[](auto& s) { s.renderers[0].images[0].reset(); },
         "renderers[0].frames[0].image: 0 has no image; ..."},
        {[](auto& s) { set_image(s, PixelImage(16, 9)); },
         "renderers[0].frames[0].image: the image has 16 x 9 pixels, and the renderer's first 16 x 8 "
         "pixels; use images of one size, the renderer's DVI mode"},
    });
    PixelImage pixel_short(16, 8);
    pixel_short.values.pop_back();
    CHECK(error_after([&](Scenario& s) { set_image(s, pixel_short); }) ==
          "renderers[0].frames[0].image: the image holds 127 pixels; use width x height");
    PixelImage deep(16, 8);
    deep.values[5] = Pixel(0, 0, 0, 0, 0x10000);
    CHECK(error_after([&](Scenario& s) { set_image(s, deep); }) ==
          "renderers[0].frames[0].image: the image has a Z beyond the far plane of a8z16; use 0 to 65535");
    CHECK(error_after([&](Scenario& s) {
              s.depth_format = DepthFormat::kZ24;
              set_image(s, deep);
          }).empty());
    CHECK(error_after([](auto& s) {
              ViewportTable& table = s.renderers[0].frames[0].table;
              table.push_back(table[0]);
          }) ==
          "renderers[0].frames[0].table: the table of 2 rows needs 50 bytes and the control scanline of an "
          "image 16 pixels wide has 48; use fewer rows or an image at least 17 pixels wide");
}

TEST_CASE("rules: a fault's keys go with its kind and lie within its image and the displays") {
    const auto error_of = [](Fault fault) {
        return error_after([&fault](Scenario& s) { s.faults.assign(1, fault); });
    };
    const auto kind = [](FaultKind value) {
        Fault fault;
        fault.kind = value;
        return fault;
    };
    Fault fault = kind(FaultKind::kShortFrame);
    fault.lines = 8;  // all but the control scanline
    CHECK(error_of(fault).empty());
    fault.lines = 9;
    CHECK(error_of(fault) == "faults[0].lines: 9 is out of range; use 1 to 8, the lines of the image");
    fault.lines = 0;
    CHECK(error_of(fault) == "faults[0].lines: 0 is out of range; use 1 to 8192");
    fault = kind(FaultKind::kLongFrame);
    fault.lines = 9;
    CHECK(error_of(fault) == "faults[0].lines: 9 is out of range; use 1 to 8, the lines of the image");

    fault = kind(FaultKind::kControlByte);
    CHECK(error_of(fault) == "faults[0].bits: 0 is out of range; use 1 to 255");
    fault.bits = 256;
    CHECK(error_of(fault) == "faults[0].bits: 256 is out of range; use 1 to 255");
    fault.bits = 255;
    fault.byte = 47;
    CHECK(error_of(fault).empty());
    fault.byte = 48;
    CHECK(error_of(fault) ==
          "faults[0].byte: 48 is out of range; use 0 to 47, the bytes of the control scanline");

    fault = kind(FaultKind::kPixelBits);
    fault.bits = 0xFFFFFF;
    fault.x = 15;
    fault.y = 7;
    CHECK(error_of(fault).empty());
    fault.x = 16;
    CHECK(error_of(fault) == "faults[0].x: 16 is out of range; use 0 to 15, the columns of the image");
    fault.x = 0;
    fault.y = 8;
    CHECK(error_of(fault) == "faults[0].y: 8 is out of range; use 0 to 7, the rows of the image");
    fault.bits = 0x1000000;
    CHECK(error_of(fault) == "faults[0].bits: 16777216 is out of range; use 1 to 16777215");

    fault = kind(FaultKind::kDrift);
    CHECK(error_of(fault).empty());  // back to normal
    fault.ppm = -100'001;
    CHECK(error_of(fault) == "faults[0].ppm: -100001 is out of range; use -100000 to 100000");

    fault = kind(FaultKind::kLostBeat);
    CHECK(error_of(fault) == "faults[0].display: 0 is out of range; use 1 to 4096");
    fault.display = 1;
    CHECK(error_of(fault).empty());
    fault.cycles = 5;
    CHECK(error_of(fault) ==
          "faults[0].cycles: does not go with kind lost_beat; its keys are renderer, kind, display, "
          "from_cycle, beats and of");
    fault.cycles.reset();
    fault.display = 2;
    CHECK(error_of(fault) == "faults[0].display: 2 is out of range; use 1 to 1");
    fault.display = 1;
    fault.pair = 3;
    CHECK(error_of(fault) ==
          "faults[0].pair: does not go with kind lost_beat; its keys are renderer, kind, display, "
          "from_cycle, beats and of");
    fault.pair = 0;
    fault.of = LostBeats::kAny;
    CHECK(error_of(fault).empty());

    fault = kind(FaultKind::kCrc);
    fault.of = LostBeats::kTable;
    CHECK(error_of(fault) == "faults[0].of: does not go with kind crc; use it with kind lost_beat only");

    fault = kind(FaultKind::kRandomStalls);
    CHECK(error_of(fault) == "faults[0].percent: 0 is out of range; use 1 to 99");
    fault.percent = 100;
    CHECK(error_of(fault) == "faults[0].percent: 100 is out of range; use 1 to 99");
    fault.percent = 99;
    CHECK(error_of(fault).empty());
    fault.seed = ~std::uint64_t{0};
    CHECK(error_of(fault) == "faults[0].seed: -1 is out of range; use 0 to 1000000000000000");
}

TEST_CASE("rules: a reset lasts for two of the slowest clock at least, and not for ever") {
    const auto error_of = [](std::optional<std::int64_t> cycles) {
        return error_after([cycles](Scenario& s) {
            s.clocks = {100.0, 100.0, 50.0};
            Fault reset;
            reset.kind = FaultKind::kReset;
            reset.cycles = cycles;
            s.faults = {reset};
        });
    };
    CHECK(error_of({}) == "faults[0].cycles: is missing; use how long the reset lasts");
    CHECK(error_of(3).find("3 core cycles are less than two of the slowest clock; use 4 or more") !=
          std::string::npos);
    CHECK(error_of(4).empty());
}

TEST_CASE("rules: faults that undo each other, or make a good pair of two pairs' halves, are refused") {
    const auto fault = [](FaultKind kind, FrameKind frame = FrameKind::kColour, std::uint32_t pair = 1) {
        Fault made;
        made.kind = kind;
        made.frame = frame;
        made.pair = pair;
        return made;
    };
    const auto error_of = [](const std::vector<Fault>& faults) {
        return error_after([&faults](Scenario& s) { s.faults = faults; });
    };
    constexpr FrameKind kDepth = FrameKind::kDepth;
    check_refusals<std::vector<Fault>>(error_of)({
        {{fault(FaultKind::kShortFrame), fault(FaultKind::kLongFrame)},
         "faults[1].kind: long_frame does not go together with the short_frame of faults[0] in the same "
         "frame; use one of them"},
        {{fault(FaultKind::kLongLine), fault(FaultKind::kShortLine)}, "faults[1].kind: ..."},
        {{fault(FaultKind::kShortFrame), fault(FaultKind::kLongFrame, kDepth)}, ""},
        {{fault(FaultKind::kShortFrame), fault(FaultKind::kShortLine)}, ""},
        {{fault(FaultKind::kMissing), fault(FaultKind::kMissing)}, "faults[1].kind: ..."},
        {{fault(FaultKind::kMissing), fault(FaultKind::kMissing, FrameKind::kColour, 2)}, ""},
    });

    Fault byte = fault(FaultKind::kControlByte);
    byte.bits = 1;
    byte.byte = 12;
    CHECK(error_of({byte, fault(FaultKind::kMagic)}).empty());
    Fault first_byte = byte;
    first_byte.byte = 0;
    CHECK(error_of({first_byte, fault(FaultKind::kMagic)})
              .rfind("faults[1].kind: magic does not go together", 0) == 0);
    CHECK(error_of({byte, fault(FaultKind::kCrc)}).rfind("faults[1].kind: crc does not go together", 0) == 0);
    CHECK(error_of({byte, byte}).rfind("faults[1].kind: control_byte does not go together", 0) == 0);
    Fault other_byte = byte;
    other_byte.byte = 13;
    CHECK(error_of({byte, other_byte}).empty());

    Fault pixel = fault(FaultKind::kPixelBits);
    pixel.bits = 1;
    CHECK(error_of({pixel, pixel}).rfind("faults[1].kind: pixel_bits does not go together", 0) == 0);
    Fault other_pixel = pixel;
    other_pixel.x = 1;
    check_refusals<std::vector<Fault>>(error_of)({
        {{pixel, other_pixel}, ""},
        {{fault(FaultKind::kNumber), fault(FaultKind::kOtherPair, kDepth)},
         "faults[0].kind: number and other_pair in one pair can make it a good pair of another number; use "
         "one of them on one frame"},
        {{fault(FaultKind::kOtherPair), fault(FaultKind::kOtherPair, kDepth)}, "faults[0].kind..."},
        {{fault(FaultKind::kOtherPair), fault(FaultKind::kNumber)}, "faults[0].kind..."},
        {{fault(FaultKind::kNumber), fault(FaultKind::kNumber, kDepth, 2)}, ""},
        {{fault(FaultKind::kNumber), fault(FaultKind::kMissing, kDepth)}, ""},
        // The depth frame of the first pair has come, so the second pair's has nothing to go with.
        {{fault(FaultKind::kNumber, kDepth), fault(FaultKind::kMissing, FrameKind::kColour, 2)}, ""},
        {{fault(FaultKind::kNumber), fault(FaultKind::kMissing, FrameKind::kColour, 2)}, ""},
        {{fault(FaultKind::kNumber), fault(FaultKind::kMissing, kDepth),
          fault(FaultKind::kMissing, FrameKind::kColour, 2)},
         "faults[0].kind: with the next two frames missing, number makes one good pair of halves of two; "
         "let one of those frames come"},
    });
}

TEST_CASE("rules: faults of a link's characters need links that have them, and each a character of its own") {
    Fault fault;
    fault.kind = FaultKind::kTmdsBits;
    fault.bits = 0x3FF;
    const auto error_of = [&fault](LinkLayer layer) {
        return error_after([&](Scenario& s) {
            s.links.layer = layer;
            s.faults = {fault};
        });
    };
    CHECK(error_of(LinkLayer::kPixel) ==
          "faults[0].kind: tmds_bits is in the characters of a link, which has none; use links.layer: tmds");
    CHECK(error_of(LinkLayer::kTmds).empty());
    fault.bits = 0x400;
    CHECK(error_of(LinkLayer::kTmds) == "faults[0].bits: 1024 is out of range; use 1 to 1023");
    fault.bits = 1;
    // The image has 16 x 8 pixels: 9 active lines and 15 blank ones, of 80 blank clocks.
    fault.at_line = 23;
    fault.at_clock = 95;
    CHECK(error_of(LinkLayer::kTmds).empty());
    fault.at_line = 24;
    CHECK(error_of(LinkLayer::kTmds) ==
          "faults[0].at_line: 24 is out of range; use 0 to 23, the lines of the link's mode");
    fault.at_line = 0;
    fault.at_clock = 96;
    CHECK(error_of(LinkLayer::kTmds) ==
          "faults[0].at_clock: 96 is out of range; use 0 to 95, the clocks of its lines");
    fault.at_clock = 0;
    fault.late_bits = 1;
    CHECK(error_of(LinkLayer::kTmds) ==
          "faults[0].late_bits: does not go with kind tmds_bits; use it with kind tmds_slip only");
    fault.bits = 0;
    fault.kind = FaultKind::kTmdsSlip;
    fault.late_bits = 10;
    CHECK(error_of(LinkLayer::kTmds) == "faults[0].late_bits: 10 is out of range; use 0 to 9");
    fault.late_bits = 0;
    fault.kind = FaultKind::kTmdsSkew;
    fault.late_characters = 5;
    CHECK(error_of(LinkLayer::kTmds) == "faults[0].late_characters: 5 is out of range; use 0 to 4");
    fault.late_characters = 4;
    CHECK(error_of(LinkLayer::kTmds).empty());
    fault = Fault();
    fault.kind = FaultKind::kTmdsNoise;
    fault.per_billion = 1;
    CHECK(error_of(LinkLayer::kPixel) ==
          "faults[0].kind: tmds_noise is in the characters of a link, which has none; use links.layer: tmds");
    CHECK(error_of(LinkLayer::kTmds).empty());
    const auto error_with = [](const std::function<void(Fault&)>& change) {
        return error_after([&](Scenario& s) {
            s.links.layer = LinkLayer::kTmds;
            Fault fault;
            fault.kind = FaultKind::kTmdsBits;
            fault.bits = 1;
            s.faults = {fault, fault};
            change(s.faults[1]);
        });
    };
    CHECK(error_with([](Fault&) {}) ==
          "faults[1].kind: tmds_bits does not go together with the tmds_bits of faults[0] in the same frame; "
          "use one of them");
    CHECK(error_with([](auto& f) { f.channel = TmdsChannel::kRed; }).empty());
    CHECK(error_with([](auto& f) { f.at_line = 1; }).empty());
    CHECK(error_with([](auto& f) { f.at_clock = 1; }).empty());
    CHECK(error_with([](auto& f) { f.pair = 1; }).empty());
    CHECK(error_with([](auto& f) {
              f.kind = FaultKind::kTmdsSlip;
              f.bits = 0;
          }).empty());
}

TEST_CASE("rules: a level without clocks refuses faults that happen clock by clock and says where they are") {
    Scenario scenario = built();
    CHECK_NOTHROW(refuse_faults_of_level_rtl(scenario, "tlm"));
    for (const auto& kind : EnumNames<FaultKind>::kTable) {
        INFO(kind.name);
        Fault fault;
        fault.kind = kind.value;
        scenario.faults = {Fault{}, fault};
        const std::string error = input_error_of([&] { refuse_faults_of_level_rtl(scenario, "tlm"); });
        const std::string wanted = std::string(".kind: ") + kind.name +
                                   " happens clock by clock, which level tlm does not know; use --level rtl";
        CHECK(error == (fault_traits(kind.value).only_at_level_rtl() ? "faults[1]" + wanted : ""));
        if (error.empty()) continue;
        scenario.faults[1].where = "file.yaml:7: faults[1]";
        CHECK(input_error_of([&] { refuse_faults_of_level_rtl(scenario, "tlm"); }) ==
              "file.yaml:7: faults[1]" + wanted);
    }
}

}  // namespace metabuffer::test

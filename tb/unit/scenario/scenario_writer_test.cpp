#include "scenario/scenario_writer.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <fstream>
#include <iterator>
#include <memory>
#include <string>
#include <utility>

#include "host/errors.h"
#include "images/image_codec.h"
#include "scenario/fault_keys.h"
#include "scenario/scenario_loader.h"
#include "support/scenario_difference.h"
#include "unit/scenario/scenario_fixture.h"

namespace metabuffer::test {
namespace {

/// Every channel value at least once, alphas of 0 with colour among them.
PixelImage every_value(int width, int height, std::uint32_t far) {
    PixelImage image(width, height);
    std::uint32_t n = 1;
    for (Pixel& pixel : image.values) {
        const auto byte = [n](std::uint32_t step) { return static_cast<std::uint8_t>(n * step); };
        pixel = Pixel(byte(1), byte(7), byte(13), n % 3 == 0 ? 0 : byte(3), (n * 0x9E3779B1U) & far);
        ++n;
    }
    image.values.front() = Pixel(255, 255, 255, 0, far);
    image.values.back() = Pixel(1, 0, 255, 0, 0);
    return image;
}

/// No key has its default.
Scenario unusual_scenario(DepthFormat format) {
    Scenario scenario;
    scenario.name = "it's: {unusual} #1 \xc3\xa4";
    scenario.displays.columns = 3;
    scenario.displays.rows = 2;
    scenario.displays.gap = {2, 5};
    scenario.displays.width_pixels = 21;
    scenario.displays.height_pixels = 9;
    scenario.displays.supersample = 2;
    scenario.displays.background[0] = 1;
    scenario.displays.background[1] = 254;
    scenario.displays.background[2] = 77;
    scenario.composition = Composition::kOver;
    scenario.depth_format = format;
    scenario.image_reading.near = -0.1;
    scenario.image_reading.far = 1e25;
    scenario.clocks = {66.6, 1.0 / 3.0, 10000.0};
    scenario.memory = {17, 8, 2, 11, 3, 5, 400, 20, MemoryPorts::kShared, 17, std::nullopt};
    scenario.bus = {256, 65535, Arbitration::kEdf, 3, SlotTableMaker::kBuilt, 2};
    scenario.composer = {1 << 24, 41, StarvationMode::kStall};
    scenario.links.layer = LinkLayer::kTmds;
    scenario.pacing = Pacing::kFreeRunning;
    scenario.link_timeout_pairs = 7;
    scenario.watchdog_cycles = 123'456'789'012;
    scenario.frames = 5;
    const auto shared = std::make_shared<const StoredImage>(every_value(60, 20, far_z(format)));
    for (const char* name : {"123", "it's", "- {x: y}", " # "}) {
        Renderer renderer;
        renderer.name = name;
        renderer.image_width_pixels = 60;
        renderer.image_height_pixels = 20;
        renderer.images = {std::make_shared<const StoredImage>(PixelImage(60, 20, Pixel(9, 9, 9, 9, 9))),
                           shared};
        RendererFrame viewport;
        viewport.image = 1;
        viewport.viewport = Viewport{-5, 30, 2};
        viewport.table = split_viewport(*viewport.viewport, 60, 20, scenario.displays.wall());
        RendererFrame table;
        table.table = {{1, 2, 3, 4, 5, -6, -32768, 8}, {65535, 65535, 65535, 0, 0, 32767, 0, 0}};
        RendererFrame empty;
        empty.image = 1;
        table.slots = {1, 65535, 1};
        empty.slots.emplace();
        RendererFrame sent;
        sent.controls = sent_controls(encode_control_scanline({FrameKind::kColour, 9, table.table, {}}, 60),
                                      std::vector<std::uint32_t>(60, 0xFEDCBA));
        sent.table = sent.controls->table;
        renderer.frames = {viewport, table, sent, empty};
        scenario.renderers.push_back(std::move(renderer));
    }
    // Each key of each kind has a value of its own; the first of a kind has only what it must have.
    int number = 1;
    for (const auto& kind : EnumNames<FaultKind>::kTable) {
        for (const bool required_only : {true, false}) {
            Fault fault;
            fault.renderer = fault_traits(kind.value).names_renderer() ? number % 4 : 0;
            fault.kind = kind.value;
            for (const FaultKeyUse& use : fault_keys_of(kind.value)) {
                if (required_only && !use.required) continue;
                if (use.rule.type == ValueRule::Type::kWholeNumber) {
                    const bool slow = kind.value == FaultKind::kReset;  // the clocks are far apart
                    const std::int64_t value = ++number % 6 + (slow ? 1000 : 1);
                    use.key->set(fault, std::min(value, use.rule.whole.high));
                } else {
                    use.key->set(fault, use.rule.choices.at(1));
                }
            }
            fault.pair += fault.pair == 0 ? 0 : static_cast<std::uint32_t>(10 * number);
            scenario.faults.push_back(fault);
        }
    }
    scenario.faults.push_back({0, 4294967295U, FaultKind::kCrc, FrameKind::kDepth, 0});
    check_scenario(scenario);
    return scenario;
}

Scenario round_trip(const Scenario& scenario, const std::filesystem::path& directory) {
    write_scenario(scenario, directory);
    return load_scenario(directory / "scenario.yaml");
}

std::size_t files_in(const std::filesystem::path& directory) {
    const std::filesystem::directory_iterator files(directory);
    return static_cast<std::size_t>(std::distance(begin(files), end(files)));
}

std::string content_of(const std::filesystem::path& file) {
    std::ifstream stream(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
}

}  // namespace

TEST_CASE("a scenario with no default in it is read back as it was written", "[scenario][writer]") {
    for (const DepthLayout& layout : kDepthFormatTable) {
        const DepthFormat format = layout.value;
        INFO(to_string(format));
        const ScratchDirectory directory;
        const Scenario scenario = unusual_scenario(format);
        const Scenario loaded = round_trip(scenario, directory / "deep/down");
        CHECK(scenario_difference(scenario, loaded).empty());
        // Two different images in two files each, whoever shows them.
        CHECK(files_in(directory / "deep/down") == 1 + 2 * 5);
        CHECK(loaded.renderers[0].images[0] == loaded.renderers[1].images[0]);
        // What has been read is written the same.
        CHECK(scenario_difference(loaded, round_trip(loaded, directory / "again")).empty());
        CHECK(content_of(directory / "deep/down/scenario.yaml") ==
              content_of(directory / "again/scenario.yaml"));
    }
}

TEST_CASE("pixels keep every bit that a link carries, in images of one row and of one pixel, too",
          "[scenario][writer]") {
    const ScratchDirectory directory;
    Scenario scenario = unusual_scenario(DepthFormat::kA8Z16);
    CHECK(round_trip(scenario, directory / "a8z16").renderers[0].image_of_pair(0) ==
          scenario.renderers[0].image_of_pair(0));

    scenario = unusual_scenario(DepthFormat::kZ24);
    const PixelImage loaded = round_trip(scenario, directory / "z24").renderers[0].image_of_pair(0);
    const PixelImage& written = scenario.renderers[0].image_of_pair(0);
    for (std::size_t i = 0; i < written.values.size(); ++i) {
        CHECK(loaded.values[i].rgb() == written.values[i].rgb());
        CHECK(loaded.values[i].z() == written.values[i].z());
        CHECK(loaded.values[i].a() == 255);
    }
    for (const DepthLayout& layout : kDepthFormatTable) {
        const DepthFormat format = layout.value;
        for (const std::pair<int, int>& size : {std::pair(40, 1), std::pair(6, 1), std::pair(6, 40)}) {
            INFO(to_string(format) << " " << size.first << "x" << size.second);
            const ScratchDirectory directory;
            Scenario scenario = unusual_scenario(format);
            scenario.faults.clear();
            scenario.renderers.resize(1);
            Renderer& renderer = scenario.renderers[0];
            renderer.image_width_pixels = size.first;
            renderer.image_height_pixels = size.second;
            renderer.images = {
                std::make_shared<const StoredImage>(every_value(size.first, size.second, far_z(format)))};
            renderer.frames = {RendererFrame{}};
            check_scenario(scenario);
            CHECK(scenario_difference(scenario, round_trip(scenario, directory.path())).empty());
        }
    }
}

TEST_CASE("a table that is not its viewport's split is written as a table", "[scenario][writer]") {
    const ScratchDirectory directory;
    Scenario scenario = unusual_scenario(DepthFormat::kA8Z16);
    RendererFrame& frame = scenario.renderers[0].frames[0];
    frame.table.pop_back();
    const RendererFrame loaded = round_trip(scenario, directory.path()).renderers[0].frames[0];
    CHECK(loaded.table == frame.table);
    CHECK_FALSE(loaded.viewport.has_value());
}

TEST_CASE("names that no file can hold are refused", "[scenario][writer]") {
    const ScratchDirectory directory;
    for (const std::string& name : {std::string(), std::string("two\nlines"), std::string("a\tb")}) {
        Scenario scenario = unusual_scenario(DepthFormat::kZ24);
        scenario.name = name;
        CHECK_FALSE(input_error_of([&] { write_scenario(scenario, directory / "out"); }).empty());
    }
    Scenario scenario = unusual_scenario(DepthFormat::kZ24);
    scenario.renderers[1].name = "a\x7f";
    CHECK_FALSE(input_error_of([&] { write_scenario(scenario, directory / "out"); }).empty());
    CHECK_FALSE(std::filesystem::exists(directory / "out"));
}

TEST_CASE("a folder that cannot be written is reported in one line", "[scenario][writer]") {
    const ScratchDirectory directory;
    const Scenario scenario = unusual_scenario(DepthFormat::kZ24);
    const auto error_of = [&scenario](const std::filesystem::path& folder) {
        try {
            write_scenario(scenario, folder);
        } catch (const OutputError& error) {
            return std::string(error.what());
        }
        return std::string();
    };
    directory.write("file", "");
    CHECK(error_of(directory / "file/below").find("file/below") != std::string::npos);
    std::filesystem::create_directories(directory / "images/image_1.tif/in the way");
    const std::string image = error_of(directory / "images");
    CHECK(image.find("image_1.tif") != std::string::npos);
    CHECK(image.find('\n') == std::string::npos);
    std::filesystem::create_directories(directory / "text/scenario.yaml/in the way");
    CHECK(error_of(directory / "text").find("scenario.yaml") != std::string::npos);
}

TEST_CASE("a write that fails leaves no earlier scenario beside its images", "[scenario][writer]") {
    const ScratchDirectory directory;
    const Scenario scenario = unusual_scenario(DepthFormat::kZ24);
    write_scenario(scenario, directory.path());
    std::filesystem::remove(directory / "depth_2.tif");
    std::filesystem::create_directories(directory / "depth_2.tif/in the way");
    CHECK_THROWS_AS(write_scenario(scenario, directory.path()), OutputError);
    CHECK_FALSE(std::filesystem::exists(directory / "scenario.yaml"));
}

}  // namespace metabuffer::test

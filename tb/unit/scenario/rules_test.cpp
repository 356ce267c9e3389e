#include <catch2/catch.hpp>
#include <functional>
#include <memory>
#include <string>

#include "unit/scenario/scenario_fixture.h"

namespace metabuffer::test {
namespace {

/// A good scenario built in C++, as testbenches do.
Scenario built() {
    Scenario scenario;
    scenario.name = "built";
    scenario.displays.width_pixels = 16;
    scenario.displays.height_pixels = 8;
    Renderer renderer;
    renderer.name = "ball";
    renderer.image_width_pixels = 16;
    renderer.image_height_pixels = 8;
    renderer.images.push_back(std::make_shared<const PixelImage>(16, 8));
    renderer.frames.push_back({0, {{1, 0, 0, 16, 8, 0, 0, 1}}, std::nullopt, 0});
    scenario.renderers.push_back(renderer);
    return scenario;
}

void set_image(Scenario& scenario, const PixelImage& image) {
    scenario.renderers[0].images[0] = std::make_shared<const PixelImage>(image);
}

std::string error_after(const std::function<void(Scenario&)>& spoil) {
    Scenario scenario = built();
    spoil(scenario);
    return input_error_of([&] { check_scenario(scenario); });
}

}  // namespace

TEST_CASE("rules: a scenario's name is no path, and a pair's number is spoilt in one frame only") {
    CHECK(error_after([](Scenario& s) { s.name = "../elsewhere"; }) ==
          "name: '../elsewhere' is a path; use a plain name, without slashes");
    CHECK(error_after([](Scenario& s) {
              s.faults = {{0, 1, FaultKind::kNumber, FrameKind::kColour, 0},
                          {0, 1, FaultKind::kNumber, FrameKind::kDepth, 0}};
          }) ==
          "faults[0].kind: number on both frames of a pair makes it a good pair of another number; use it "
          "on one");
}

TEST_CASE("rules: a scenario built in C++ passes") {
    CHECK_NOTHROW(check_scenario(built()));
    CHECK(error_after([](Scenario& s) { s.composer.buffer_pixels = 1; }).empty());
}

TEST_CASE("rules: settings") {
    CHECK(error_after([](Scenario& s) { s.displays.columns = 0; }) ==
          "displays.columns: 0 is out of range; use 1 to 64");
    CHECK(error_after([](Scenario& s) { s.displays.rows = 65; }) ==
          "displays.rows: 65 is out of range; use 1 to 64");
    CHECK(error_after([](Scenario& s) { s.displays.width_pixels = 0; }) ==
          "displays.width: 0 is out of range; use 1 to 4096");
    CHECK(error_after([](Scenario& s) { s.displays.height_pixels = 2'000'000'000; }) ==
          "displays.height: 2000000000 is out of range; use 1 to 4096");
    CHECK(error_after([](Scenario& s) { s.displays.supersample = 3; }) ==
          "displays.supersample: 3 is not a supersampling; use 1, 2 or 4");
    CHECK(error_after([](Scenario& s) { s.depth_near = 100.0; }) ==
          "depth_range: near 100 is not below far 100; use [near, far] with near < far");
    CHECK(error_after([](Scenario& s) { s.depth_far = std::numeric_limits<double>::quiet_NaN(); }) ==
          "depth_range: nan is out of range; use -1e+30 to 1e+30");
    CHECK(error_after([](Scenario& s) { s.clocks.core_mhz = 0.0; }) ==
          "clocks.core_mhz: 0 is out of range; use 0.001 to 10000");
    CHECK(error_after([](Scenario& s) { s.clocks.dvi_in_mhz = -1.0; }) ==
          "clocks.dvi_in_mhz: -1 is out of range; use 0.001 to 10000");
    CHECK(error_after([](Scenario& s) { s.clocks.dvi_out_mhz = 1e5; }) ==
          "clocks.dvi_out_mhz: 1e+05 is out of range; use 0.001 to 10000");
    CHECK(error_after([](Scenario& s) { s.memory.page_words = 0; }) ==
          "memory.page_words: 0 is out of range; use 1 to 16777216");
    CHECK(error_after([](Scenario& s) { s.memory.page_miss_cycles = -1; }) ==
          "memory.page_miss_cycles: -1 is out of range; use 0 to 1000000");
    CHECK(error_after([](Scenario& s) { s.memory.words_per_cycle = 9; }) ==
          "memory.words_per_cycle: 9 is out of range; use 1 to 8");
    CHECK(error_after([](Scenario& s) { s.bus.width_bits = 48; }) ==
          "bus.width_bits: 48 is not a bus width; use 16, 32, 64, 128, 256 or 512");
    CHECK(error_after([](Scenario& s) { s.bus.burst_pixels = 0; }) ==
          "bus.burst_pixels: 0 is out of range; use 1 to 65535");
    CHECK(error_after([](Scenario& s) { s.composer.buffer_pixels = (1 << 24) + 1; }) ==
          "composer.buffer_pixels: 16777217 is out of range; use 1 to 16777216");
    CHECK(error_after([](Scenario& s) { s.composer.ready_space_pixels = 1; }) ==
          "composer.ready_space_pixels: 1 is less than the 2 pixels that can be in flight; use 2 or more");
    CHECK(error_after([](Scenario& s) {
              s.bus.width_bits = 512;
              s.memory.words_per_cycle = 8;
              s.composer.ready_space_pixels = 15;
          }) ==
          "composer.ready_space_pixels: 15 is less than the 16 pixels that can be in flight; use 16 or more");
    CHECK(error_after([](Scenario& s) { s.link_timeout_pairs = 0; }) ==
          "link_timeout_pairs: 0 is out of range; use 1 to 1000000");
    CHECK(error_after([](Scenario& s) { s.watchdog_cycles = -1; }) ==
          "watchdog_cycles: -1 is out of range; use 0 to 1000000000000000");
    CHECK(error_after([](Scenario& s) { s.frames = 0; }) == "frames: 0 is out of range; use 1 to 1000000");
}

TEST_CASE("rules: renderers and faults") {
    CHECK(error_after([](Scenario& s) { s.renderers.clear(); }) ==
          "renderers: has no entries; use at least one renderer");
    CHECK(error_after([](Scenario& s) { s.renderers[0].name.clear(); }) ==
          "renderers[0].name: is empty; use a name");
    CHECK(error_after([](Scenario& s) { s.renderers.push_back(s.renderers[0]); }) ==
          "renderers[1].name: 'ball' is taken by an earlier renderer; use a name of its own");
    CHECK(error_after([](Scenario& s) { s.renderers[0].frames.clear(); }) ==
          "renderers[0].frames: has no entries; use at least one frame");
    CHECK(error_after([](Scenario& s) {
              s.displays.columns = s.displays.rows = 64;
              const Renderer one = s.renderers[0];
              for (int i = 1; i < 17; ++i) {
                  s.renderers.push_back(one);
                  s.renderers.back().name += std::to_string(i);
              }
          }) == "renderers: 17 renderers on 4096 displays need 69632 composers; use at most 65536");
    CHECK(error_after([](Scenario& s) {
              s.faults.push_back({1, 0, FaultKind::kCrc});
          }) == "faults[0].renderer: 1 is not a renderer's index; use 0 to 0");
    CHECK(error_after([](Scenario& s) {
              s.faults.push_back({-1, 0, FaultKind::kCrc});
          }) == "faults[0].renderer: -1 is not a renderer's index; use 0 to 0");
    CHECK(error_after([](Scenario& s) {
              s.faults.push_back({0, 0, FaultKind::kDelay});
          }) == "faults[0].delay_pairs: 0 is out of range; use 1 to 1000000");
    CHECK(error_after([](Scenario& s) {
              s.faults.push_back({0, 0, FaultKind::kCrc, FrameKind::kDepth, 1});
          }) == "faults[0].delay_pairs: does not go with kind crc; use it with kind delay only");
}

TEST_CASE("rules: images and tables") {
    CHECK(error_after([](Scenario& s) { s.renderers[0].image_width_pixels = 0; }) ==
          "renderers[0].frames: 0 is out of range; use 1 to 8192");
    CHECK(error_after([](Scenario& s) { s.renderers[0].image_height_pixels = 8193; }) ==
          "renderers[0].frames: 8193 is out of range; use 1 to 8192");
    CHECK(error_after([](Scenario& s) {
              s.renderers[0].frames[0].image = 1;
          }).rfind("renderers[0].frames[0].image: 1 is not an image's index; ", 0) == 0);
    CHECK(error_after([](Scenario& s) {
              s.renderers[0].images[0].reset();
          }).rfind("renderers[0].frames[0].image: 0 has no image; ", 0) == 0);
    CHECK(error_after([](Scenario& s) { set_image(s, PixelImage(16, 9)); }) ==
          "renderers[0].frames[0].image: the image has 16 x 9 pixels, and the renderer's first 16 x 8 "
          "pixels; use "
          "images of one size, the renderer's DVI mode");
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
    CHECK(error_after([](Scenario& s) {
              ViewportTable& table = s.renderers[0].frames[0].table;
              table.push_back(table[0]);
          }) ==
          "renderers[0].frames[0].table: the table of 2 rows needs 50 bytes and the control scanline of an "
          "image 16 "
          "pixels wide has 48; use fewer rows or an image at least 17 pixels wide");
}

}  // namespace metabuffer::test

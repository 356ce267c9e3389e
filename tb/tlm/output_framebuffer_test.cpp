#include "tlm/output_framebuffer.h"

#include <array>
#include <catch2/catch.hpp>
#include <cstdint>
#include <utility>
#include <vector>

#include "socket_bench.h"
#include "support/images.h"
#include "support/scenarios.h"

namespace metabuffer::test::output_framebuffer_test {
namespace {

constexpr int kWidth = 3;
constexpr int kHeight = 4;
constexpr int kSupersample = 2;
constexpr int kFrames = 3;
constexpr std::int64_t kRasterPixels = std::int64_t{kWidth} * kHeight * kSupersample * kSupersample;
constexpr std::int64_t kReadyCycle = 2;   // the first clock without reset
constexpr std::int64_t kPeriod = 10'000;  // of both clocks, in picoseconds
/// From PIPEREADY to STARTFRAME, by frame: the second one is done while the first is being shown, the third after that.
constexpr std::array<std::int64_t, kFrames> kClocksToStart{3, 3, 2'000};
/// From a swap to the clock that reads the vertical sync after the frame.
constexpr std::int64_t kClocksShown = (6 + kHeight + 1) * (kWidth + 80) + 1;

struct Shown {
    int frame = 0;
    std::int64_t picoseconds = 0;
    std::vector<std::uint32_t> colours;
};

/// Raster rows of a picture whose pixels are all that a pixel of the display is averaged of.
PixelPlanes raster_rows(const PixelImage& picture, int first_row, int rows) {
    PixelPlanes planes(kWidth * kSupersample, rows);
    for (int y = 0; y < rows; ++y) {
        for (int x = 0; x < planes.width_pixels; ++x) {
            const Pixel pixel = picture.at(x / kSupersample, (first_row + y) / kSupersample);
            planes.argb[planes.index(x, y)] = static_cast<std::uint32_t>(pixel.word());
        }
    }
    return planes;
}

TEST_CASE(
    "output framebuffer: a frame comes in bands of raster rows and is shown once it has been on the link") {
    Scenario scenario = small_scenario(kWidth, kHeight);
    scenario.displays.supersample = kSupersample;
    scenario.frames = kFrames;
    const tlm::ClockDomain clock(kPeriod);
    tlm::ColumnTime column(1, kRasterPixels, false);
    tlm::SwapLock lock("swap_lock", scenario, kReadyCycle, kReadyCycle);
    Initiator<tlm::PipelineFrame> composer("composer");
    tlm::OutputFramebuffer dut("dut", scenario, 1, column, lock, kReadyCycle);
    Target<tlm::ShownFrame> display("display");
    composer.socket.bind(dut.pipe_socket);
    dut.dvi_socket.bind(display.socket);
    std::vector<std::pair<int, std::int64_t>> ready;  // PIPEREADY: for which frame, and its clock
    composer.on_notice = [&ready](::tlm::tlm_generic_payload& payload, const ::tlm::tlm_phase& phase) {
        CHECK(phase == tlm::pipeready_phase);
        const auto& notice = tlm::content_of<tlm::PipelineFrame>(payload);
        ready.emplace_back(notice.frame, notice.cycle);
    };
    std::vector<Shown> shown;
    display.on_transport = [&shown](::tlm::tlm_generic_payload& payload) {
        const auto& frame = tlm::content_of<tlm::ShownFrame>(payload);
        shown.push_back({frame.frame, tlm::now_picoseconds(), frame.image->values});
    };
    elaborate();
    CHECK(ready == std::vector<std::pair<int, std::int64_t>>{{0, kReadyCycle}});
    CHECK(dut.pixels_taken(1'000) == 0);

    Random random(1);
    tlm::Message<tlm::PipelineFrame> band;
    std::vector<std::vector<std::uint32_t>> pictures;
    for (int frame = 0; frame < kFrames; ++frame) {
        INFO("frame " << frame);
        const std::int64_t start = lock.pipeready_cycle() + kClocksToStart[static_cast<std::size_t>(frame)];
        column.start(frame, start);
        // Raster pixel 0 is read two clocks after the composer's STARTFRAME.
        for (const std::int64_t taken : {std::int64_t{0}, std::int64_t{1}, kRasterPixels}) {
            CHECK(dut.pixels_taken(start + 1 + taken) == frame * kRasterPixels + taken);
        }
        CHECK(dut.pixels_taken(start) == frame * kRasterPixels);
        sc_core::sc_start(clock.until(start + 1 + kRasterPixels));
        const PixelImage picture = noise_image(random, kWidth, kHeight);
        band->frame = frame;
        band->first_row = 0;
        for (const int rows : {2, 4, 2}) {
            CHECK(lock.swaps() == frame);
            PixelPlanes raster = raster_rows(picture, band->first_row, rows);
            band->rows = rows;
            band->raster = &raster;
            CHECK(composer.send(band.payload()) == ::tlm::TLM_OK_RESPONSE);
            band->first_row += rows;
        }
        REQUIRE(lock.swaps() == frame + 1);
        CHECK(ready.back() == std::pair<int, std::int64_t>{frame + 1, lock.pipeready_cycle()});
        pictures.emplace_back();
        for (const Pixel& pixel : picture.values) {
            pictures.back().push_back(pixel.rgb());
        }
    }
    sc_core::sc_start(clock.until(clock.edge_at(lock.end_picoseconds()) + 1));
    REQUIRE(shown.size() == kFrames);
    for (int frame = 0; frame < kFrames; ++frame) {
        INFO("frame " << frame);
        const Shown& one = shown[static_cast<std::size_t>(frame)];
        CHECK(one.frame == frame);
        CHECK(one.picoseconds == lock.swap_to(frame).picoseconds + kClocksShown * kPeriod);
        CHECK(one.colours == pictures[static_cast<std::size_t>(frame)]);
    }
    CHECK(report_of_empty_payload(composer) == kExtensionReport);
}

}  // namespace
}  // namespace metabuffer::test::output_framebuffer_test

#include "rtl/frame_averager.h"

#include <array>
#include <catch2/catch.hpp>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "expected_report.h"
#include "lockstep/lockstep.h"
#include "support/colour_tables.h"
#include "support/images.h"
#include "support/scenarios.h"

namespace metabuffer::test::frame_averager_test {
namespace {

using rtl::DisplayWrite;
using rtl::FrameAverager;
using rtl::PipePixel;

constexpr int kWidth = 4;
constexpr int kHeight = 3;

/// Three displays, of which the first two have a table each.
Scenario averager_scenario(Random& random, int supersample, StarvationMode mode) {
    Scenario scenario = small_scenario(kWidth, kHeight, 3);
    scenario.displays.supersample = supersample;
    scenario.composer.on_starvation = mode;
    for (const int display : {1, 2}) {
        DisplayCorrection correction;
        correction.display = display;
        correction.lut = std::make_shared<const ColourTable>(random_colour_table(random));
        scenario.displays.correction.push_back(correction);
    }
    return scenario;
}

/// A frame averager between a pipeline and a display's timing. The raster is kept as a picture.
class Framebuffer final : public Lockstep<FrameAverager> {
  public:
    /// bubbles: counts the missing pixels that blocks report.
    Framebuffer(LockstepBench& bench, const std::string& name, const Scenario& scenario, int display,
                int& bubbles)
        : Lockstep(bench, name,
                   [&scenario, display](const char* dut, rtl::ClockGating) {
                       return std::make_unique<FrameAverager>(dut, scenario, display);
                   }),
          bubbles_(bubbles),
          supersample_(scenario.displays.supersample),
          may_stall_(scenario.composer.on_starvation == StarvationMode::kStall),
          table_(display == 3 ? nullptr
                              : scenario.displays.correction.at(static_cast<std::size_t>(display) - 1).lut) {}

    void stimulate() override {
        if (dut().waiting_for() != waits())
            fail("\"" + dut().waiting_for() + "\" is not \"" + waits() + "\"");
        if (dut().pixels_taken() != taken_) fail("the count of pixels is wrong");
        if (dut().stalled_cycles() != stalled_) fail("the count of stalled clocks is wrong");
        Random& random = bench_.random;
        // In a pause the pixels of a frame go on coming, and now and then a wire changes alone.
        const int alone = random.between(0, 40);
        const auto comes = [&](int wire, int clocks) {
            return bench_.pausing() ? alone == wire : random.one_in(clocks);
        };
        if (comes(0, 5)) stall_ = !stall_;
        startframe_ = pipeready_due_ && comes(1, 10);
        // What is no pixel of a frame may be one all the same.
        const bool valid = receiving_ ? !random.one_in(300) : random.one_in(2);
        pipe_ = PipePixel{noise_pixel(random), valid, random.one_in(lossy_ ? 20 : 2000)};
        if (swapped_ ? !framedone_due_ && comes(2, 6) : framedone_due_ && comes(2, 20)) {
            swapped_ = !swapped_;
            if (swapped_) skipped_ = random.one_in(3);
        } else if (!swapped_ && random.one_in(10)) {
            skipped_ = !skipped_;
        }
    }
    void expect() override {
        pipeready_ = pipeready_due_;
        framedone_ = framedone_due_;
        framebad_ = framebad_due_;
        writes_ = writes_due_;
        write_ = write_due_;
    }
    void edge() override {
        // The swap crosses two registers: what one edge has captured the next one sees.
        const bool seen = captured_;
        captured_ = swapped_;
        if (seen && !seen_) {
            whole_ = framebad_due_ = false;
            if (!skipped_) back_ = !back_;
            ++bench_.happened[skipped_ ? "a frame was skipped" : "a frame was shown"];
        }
        seen_ = seen;
        const bool stands = may_stall_ && stall_;
        stalled_ += stands ? 1 : 0;
        writes_due_ = false;
        if (!stands && receiving_) {
            if (pipe_->valid) {
                take();
            } else {
                bubbles_ += 2;  // there are two of each
            }
        } else if (!stands && startframe_) {
            receiving_ = true;
            lossy_ = bench_.random.one_in(2);
            received_.clear();
            bench_.happened["a frame began while the swap before was reported"] += seen ? 1 : 0;
        }
        framedone_due_ = whole_ && !seen;
        pipeready_due_ = !receiving_ && !whole_;
    }
    void reset() override {
        bench_.happened["reset in a frame"] += receiving_ ? 1 : 0;
        captured_ = seen_ = receiving_ = whole_ = back_ = false;
        pipeready_due_ = framedone_due_ = framebad_due_ = writes_due_ = false;
        write_due_ = {};
        frames_ = 0;
        received_.clear();
        swapped_ = false;
    }

  private:
    int raster_width() const { return kWidth * supersample_; }
    std::size_t raster_pixels() const {
        return static_cast<std::size_t>(raster_width() * kHeight * supersample_);
    }

    void take() {
        ++taken_;
        const int x = static_cast<int>(received_.size()) % raster_width();
        const int y = static_cast<int>(received_.size()) / raster_width();
        received_.push_back(pipe_->pixel);
        framebad_due_ = framebad_due_ || pipe_->lost;
        writes_due_ = (x + 1) % supersample_ == 0 && (y + 1) % supersample_ == 0;
        if (writes_due_) {
            const int column = x / supersample_;
            const int row = y / supersample_;
            write_due_ =
                DisplayWrite{back_, static_cast<std::uint32_t>(row * kWidth + column), shown(column, row)};
        }
        if (received_.size() < raster_pixels()) return;
        receiving_ = false;
        whole_ = true;
        ++frames_;
    }
    /// The mean of a display pixel's block, halves up, and what the table makes of it.
    std::uint32_t shown(int column, int row) const {
        std::array<int, 3> sums{};
        for (int y = row * supersample_; y < (row + 1) * supersample_; ++y) {
            for (int x = column * supersample_; x < (column + 1) * supersample_; ++x) {
                const Pixel& pixel = received_.at(static_cast<std::size_t>(y * raster_width() + x));
                sums[0] += pixel.r();
                sums[1] += pixel.g();
                sums[2] += pixel.b();
            }
        }
        ColourImage picture(1, 1);
        for (const int sum : sums) {
            const double mean = static_cast<double>(sum) / (supersample_ * supersample_);
            picture.values[0] = picture.values[0] * 256 + static_cast<std::uint32_t>(mean + 0.5);
        }
        return (table_ == nullptr ? picture : naive_correction(*table_, picture)).values[0];
    }
    std::string waits() const {
        if (receiving_) {
            return "waits for raster pixel " + std::to_string(received_.size()) + " of frame " +
                   std::to_string(frames_);
        }
        if (whole_) return "waits for SWAPLOCK to show frame " + std::to_string(frames_ - 1);
        return "waits for STARTFRAME of frame " + std::to_string(frames_);
    }

    int& bubbles_;
    int supersample_;
    bool may_stall_;
    std::shared_ptr<const ColourTable> table_;
    Input<bool>& startframe_ = in(&FrameAverager::startframe_i);
    Input<PipePixel>& pipe_ = in(&FrameAverager::pipe_i);
    Input<bool>& stall_ = in(&FrameAverager::column_stall_i);
    Output<bool>& pipeready_ = out(&FrameAverager::pipeready_o);
    Output<bool>& framedone_ = out(&FrameAverager::framedone_o);
    Output<bool>& framebad_ = out(&FrameAverager::framebad_o);
    Output<bool>& writes_ = out(&FrameAverager::writes_o);
    Output<DisplayWrite>& write_ = out(&FrameAverager::write_o);
    Input<bool>& swapped_ = in(&FrameAverager::swapped_i);
    Input<bool>& skipped_ = in(&FrameAverager::skipped_i);
    bool lossy_ = false;  ///< in the stimulus: pixels of the frame are lost
    // The reference's registers.
    bool captured_ = false, seen_ = false;  ///< the swap on its way
    bool receiving_ = false, whole_ = false, back_ = false;
    std::vector<Pixel> received_;  ///< of the frame under way, or the last one
    int frames_ = 0;
    bool pipeready_due_ = false, framedone_due_ = false, framebad_due_ = false, writes_due_ = false;
    DisplayWrite write_due_;
    std::int64_t taken_ = 0, stalled_ = 0;
};

TEST_CASE("frame averager: in lockstep with its reference") {
    const ExpectedReport report("/metabuffer/output_framebuffer/bubble");
    LockstepBench bench(2211);
    int bubbles = 0;
    std::vector<std::unique_ptr<Scenario>> scenarios;
    std::vector<std::unique_ptr<Framebuffer>> framebuffers;
    for (const StarvationMode mode : {StarvationMode::kGlitch, StarvationMode::kStall}) {
        for (const auto& [supersample, first_display] : {std::pair{1, 1}, {2, 2}, {4, 3}}) {
            scenarios.push_back(
                std::make_unique<Scenario>(averager_scenario(bench.random, supersample, mode)));
            for (int display = first_display; display <= 3; ++display) {
                framebuffers.push_back(
                    std::make_unique<Framebuffer>(bench, "framebuffer_" + std::to_string(framebuffers.size()),
                                                  *scenarios.back(), display, bubbles));
            }
        }
    }
    bench.clocks_to_reset = 1000;
    bench.run(20'000, {{"a frame was shown", 200},
                       {"a frame was skipped", 100},
                       {"a frame began while the swap before was reported", 20},
                       {"reset in a frame", 10},
                       {LockstepBench::kAsleep, 1000}});
    CHECK(bubbles > 20);
    CHECK(report.count() == bubbles);
}

}  // namespace
}  // namespace metabuffer::test::frame_averager_test

#include "rtl/raster_walker.h"

#include <catch2/catch.hpp>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "composer_scenario.h"
#include "lockstep/lockstep.h"
#include "support/painted_segment.h"
#include "support/traced_values.h"

namespace metabuffer::test::raster_walker_test {
namespace {

using rtl::HeadSegment;
using rtl::PixelUse;
using rtl::RasterWalker;

constexpr Size kRaster{kWidth, kHeight};

Scenario walker_scenario(StarvationMode mode, Smoothing smoothing = Smoothing::kReplicate) {
    Scenario scenario = composer_scenario({}, mode);
    scenario.composer.smoothing = smoothing;
    scenario.frames = 1000;  // enough for any number that a waveform may show
    return scenario;
}

/// A walk over the raster as it is painted, of segments that come and go at any time.
class Walker final : public Lockstep<RasterWalker> {
  public:
    Walker(LockstepBench& bench, const std::string& name, const Scenario& scenario)
        : Lockstep(bench, name,
                   [scenario](const char* dut, rtl::ClockGating) {
                       return std::make_unique<RasterWalker>(dut, scenario);
                   }),
          scenario_(scenario) {
        wires_.add(start_, 6);
        wires_.add(stall_, 5);
    }

    void stimulate() override {
        constexpr int kClocksToSegment = 15;
        wires_.stimulate(bench_);
        if (bench_.random.one_in(kClocksToSegment)) {
            shown_ = bench_.random.one_in(6) ? std::nullopt : std::optional(random_segment());
            segment_ =
                shown_ ? HeadSegment{true, Segment(*shown_, kWidth, kHeight, smoothing())} : HeadSegment{};
            next_ = PaintedSegment(shown_, kRaster, smoothing());
        }
    }
    void expect() override {
        running_ = runs();
        if (runs()) {
            ahead_ = position_ + 1 < kPixels ? walked_.steps[at() + 1] : RasterStep{};
        } else {
            ahead_ = next_.steps[0];
        }
        const PixelUse use{position_ == kPixels - 1, last_use()};
        uses_ = use.ends_frame || use.last_use != Segment::kNoPixel;
        use_ = use;
        if (!uses_) use_.ignore();
    }
    void edge() override {
        if (scenario_.composer.on_starvation == StarvationMode::kStall && stall_) return;
        if (runs()) {
            if (++position_ == kPixels) position_ = kIdle;
        } else if (start_) {
            position_ = 0;
            row_ = shown_;
            walked_ = next_;
            ++frames_;
            ++bench_.happened[!row_ ? "a frame without a segment" : smooths() ? "smoothed" : "replicated"];
        }
    }
    void reset() override {
        position_ = kIdle;
        frames_ = 0;
    }
    /// A waveform shows the number of the frame.
    void check_waveform() const {
        const int bits = 1 + rtl::bits_for(scenario_.frames);
        const std::int64_t number = (frames_ - 1) & ((1 << bits) - 1);
        INFO(dut().name() << ", frame " << number);
        CHECK(shows(dut(), "frame[" + std::to_string(bits) + "]=" + std::to_string(number)));
    }

  private:
    static constexpr int kIdle = -1;

    Smoothing smoothing() const { return scenario_.composer.smoothing; }
    bool smooths() const { return smoothing() == Smoothing::kBilinear && row_->dmultiple > 1; }
    bool runs() const { return position_ != kIdle; }
    std::size_t at() const { return static_cast<std::size_t>(position_); }
    ViewportRow random_segment() const {
        constexpr int kLargestMultiple = 7;
        return smoothing() == Smoothing::kBilinear
                   ? random_smoothed_row(bench_.random, kRaster, kLargestMultiple)
                   : random_valid_row(bench_.random, kRaster, kLargestMultiple);
    }
    /// Each position says what it releases. A smoothed one says again what another position of its source column has
    /// released in the same raster row.
    std::int64_t last_use() const {
        if (!runs() || !row_) return Segment::kNoPixel;
        const auto released_before = [this](int position) {
            return position == 0 ? walked_.skipped : walked_.released[static_cast<std::size_t>(position - 1)];
        };
        const std::int64_t released = walked_.released[at()];
        const RasterStep& step = walked_.steps[at()];
        const bool again = smooths() && step.covered && step.pixel % row_->sdx == released % row_->sdx &&
                           released > released_before(position_ - position_ % kWidth);
        return released > released_before(position_) || again ? released - 1 : Segment::kNoPixel;
    }

    Scenario scenario_;
    Input<bool>& stall_ = in(&RasterWalker::column_stall_i);
    Input<bool>& start_ = in(&RasterWalker::start_i);
    Input<HeadSegment>& segment_ = in(&RasterWalker::segment_i);
    Output<bool>& running_ = out(&RasterWalker::running_o);
    Output<RasterStep>& ahead_ = out(&RasterWalker::ahead_o);
    Output<bool>& uses_ = out(&RasterWalker::uses_o);
    Output<PixelUse>& use_ = out(&RasterWalker::use_o);
    FreeWires wires_;
    std::optional<ViewportRow> shown_, row_;  ///< at segment_i, and of the frame that runs
    PaintedSegment next_{std::nullopt, kRaster}, walked_{std::nullopt, kRaster};
    int position_ = kIdle;  ///< composited at the next edge
    int frames_ = 0;        ///< since the last reset
};

TEST_CASE("raster walker: in lockstep with its reference") {
    LockstepBench bench(2217);
    const Walker replicates(bench, "replicates", walker_scenario(StarvationMode::kStall));
    const Walker smooths(bench, "smooths", walker_scenario(StarvationMode::kStall, Smoothing::kBilinear));
    const Walker glitch(bench, "glitch", walker_scenario(StarvationMode::kGlitch));
    constexpr int kClocks = 20'000;
    for (int clock = kClocks / 40; clock < kClocks; clock += kClocks / 40) {
        bench.run(clock);
        for (const Walker* walker : {&replicates, &smooths, &glitch}) walker->check_waveform();
    }
    bench.run(kClocks, {{"a frame without a segment", 50}, {"smoothed", 100}, {"replicated", 200}});
}

}  // namespace
}  // namespace metabuffer::test::raster_walker_test

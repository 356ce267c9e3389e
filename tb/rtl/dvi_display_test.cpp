#include "rtl/dvi_display.h"

#include <catch2/catch.hpp>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "dvi_waveform.h"
#include "expected_report.h"
#include "lockstep/lockstep.h"

namespace metabuffer::test::dvi_display_test {
namespace {

using rtl::DviDisplay;
using rtl::DviLink;

/// What each display has captured at the last edge.
struct Captures {
    std::deque<std::vector<ColourImage>> of_display;
};

/// A display, gated and not, that is shown a waveform, or pictures whole and broken. Nothing of it is a pin: half a clock
/// after each edge what it has captured and reported at the edge is compared.
class Display final : private Captures, public Lockstep<DviDisplay> {
  public:
    explicit Display(LockstepBench& bench, const Waveform& wave = {})
        : Lockstep(bench, "dvi_display",
                   [this](const char* dut, rtl::ClockGating) {
                       auto display = std::make_unique<DviDisplay>(dut);
                       std::vector<ColourImage>& images = of_display.emplace_back();
                       display->on_frame([&images](const ColourImage& image) { images.push_back(image); });
                       return display;
                   }),
          script_(wave.begin(), wave.end()),
          made_up_(wave.empty()) {}

    void stimulate() override {
        compare();
        if (bench_.pausing() && !link_->de) return;
        if (script_.empty() && made_up_) add_picture();
        if (script_.empty()) return;
        link_ = script_.front();
        script_.pop_front();
    }
    void expect() override {}
    void edge() override {
        if (following_ && link_->de) line_.push_back(link_->data);
        if (following_ && was_.de && !link_->de) lines_.push_back(std::exchange(line_, {}));
        if (link_->vsync && !was_.vsync) {
            if (!lines_.empty()) judge_picture();
            following_ = true;
            lines_.clear();
            line_.clear();
        }
        was_ = link_;
    }
    void reset() override {
        following_ = false;
        was_ = {};
        lines_.clear();
        line_.clear();
    }
    void check() {
        compare();
        CHECK(wrong_clock_ == std::nullopt);
        CHECK(frames_captured() == static_cast<std::int64_t>(capture_clocks.size()));
    }

    std::int64_t frames_captured() const { return dut().frames_captured(); }

    std::vector<int> capture_clocks, report_clocks;

  private:
    // ---- the stimulus ----

    void push(DviLink link, int clocks = 1) {
        for (; clocks > 0; --clocks) {
            link.vsync = vsync_left_-- > 0;
            script_.push_back(link);
        }
    }
    void add_picture() {
        Random& random = bench_.random;
        const int width = random.between(1, 40);
        const int height = random.between(random.one_in(8) ? 0 : 1, 5);
        const int ragged = random.one_in(6) ? random.between(0, 4) : -1;
        // Some lines have one colour, in which a display sleeps.
        for (int y = 0; y < height; ++y) {
            push({random.one_in(3) ? 0xABU : 0U, false, random.one_in(2), false}, random.between(1, 12));
            const bool flat = random.one_in(2);
            DviLink link{0x112233, true, false, false};
            for (int x = y == ragged ? -1 : 0; x < width; ++x) {
                if (!flat) link.data = static_cast<std::uint32_t>(random.bits() & 0xFF'FFFFU);
                push(link);
            }
        }
        if (vsync_left_ > 0) push({}, vsync_left_ + 1);
        if (random.one_in(2)) push({}, random.between(1, 30));
        // Pixels of a line up to the one with which VSYNC rises.
        const int broken_off = random.one_in(8) ? random.between(1, 4) : 0;
        for (int x = 1; x < broken_off; ++x) push({7, true, false, false});
        if (!random.one_in(12)) vsync_left_ = random.one_in(6) ? 60 : random.between(1, 15);
        if (broken_off > 0) push({7, true, false, false}, 3);
        push({});
    }

    // ---- the reference ----

    void judge_picture() {
        bool equal = line_.empty();  // else its last line is broken off
        for (const auto& line : lines_) equal = equal && line.size() == lines_.front().size();
        if (!equal) {
            report_clocks.push_back(bench_.clock());
            return;
        }
        capture_clocks.push_back(bench_.clock());
        ColourImage image;
        image.width_pixels = static_cast<int>(lines_.front().size());
        image.height_pixels = static_cast<int>(lines_.size());
        for (const auto& line : lines_) image.values.insert(image.values.end(), line.begin(), line.end());
        due_ = image;
    }
    void compare() {
        bool right = report_.count() == static_cast<int>(of_display.size() * report_clocks.size());
        for (auto& images : of_display) {
            right = right && images.size() == (due_ ? 1U : 0U);
            if (due_ && right) {
                right = images[0].width_pixels == due_->width_pixels &&
                        images[0].height_pixels == due_->height_pixels && images[0].values == due_->values;
            }
            images.clear();
        }
        due_.reset();
        if (!right && !wrong_clock_) wrong_clock_ = bench_.clock();
    }

    ExpectedReport report_{"/metabuffer/dvi_display/geometry"};
    Input<DviLink>& link_ = in(&DviDisplay::link_i);
    // The link.
    std::deque<DviLink> script_;
    bool made_up_;
    int vsync_left_ = 0;  ///< clocks
    // The picture under way.
    bool following_ = false;  ///< its beginning has been seen
    DviLink was_;
    std::vector<std::uint32_t> line_;
    LinkLines lines_;
    std::optional<ColourImage> due_;  ///< at the last edge
    std::optional<int> wrong_clock_;
};

TEST_CASE("dvi display: in lockstep with its reference") {
    LockstepBench bench(3309);
    Display display(bench);
    bench.run(60'000);
    display.check();
    CHECK(display.capture_clocks.size() > 150);
    CHECK(display.report_clocks.size() > 50);
}

/// A vertical sync, two lines of 3 and of 2 or 3 pixels, a vertical sync.
struct TwoLines {
    LockstepBench bench;
    Waveform wave;
    int vsync = 0;  ///< clock at which it rises

    explicit TwoLines(std::size_t second) {
        append_line(wave, 0, {}, true);
        for (const std::size_t pixels : {std::size_t{3}, second}) {
            append_line(wave, 0, std::vector<std::uint32_t>(pixels, 7), false);
        }
        vsync = static_cast<int>(wave.size()) - 1;  // clock -1 shows the first one
        append_line(wave, 0, {}, true);
    }
};

TEST_CASE("dvi display: timing: VSYNC high after a frame read to its capture") {
    TwoLines link(3);
    const Display display(link.bench, link.wave);
    link.bench.run(link.vsync);
    CHECK(display.frames_captured() == 0);
    link.bench.run(link.vsync + 1);
    CHECK(display.frames_captured() == 1);
}

TEST_CASE(
    "dvi display: a frame of unequal lines causes a warning at the edge that reads VSYNC high after it") {
    TwoLines link(2);
    const ExpectedReport report("/metabuffer/dvi_display/geometry");
    const Display display(link.bench, link.wave);
    link.bench.run(link.vsync);
    CHECK(report.count() == 0);
    link.bench.run(link.vsync + 1);
    CHECK(report.count() == 2);  // one of each display
}

}  // namespace
}  // namespace metabuffer::test::dvi_display_test

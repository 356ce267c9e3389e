#include "rtl/dvi_output.h"

#include <catch2/catch.hpp>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "dvi_waveform.h"
#include "lockstep/lockstep.h"
#include "lockstep/waveform_case.h"
#include "support/scenarios.h"

namespace metabuffer::test::dvi_output_test {
namespace {

using rtl::DisplayRead;
using rtl::DviLink;
using rtl::DviOutput;

/// A display's timing by the rules of the header, from the waveform of a whole frame. The memory answers with noise at
/// every clock.
class Timing final : public Lockstep<DviOutput> {
  public:
    Timing(LockstepBench& bench, int width, int height)
        : Lockstep(bench, "output_" + std::to_string(width) + "x" + std::to_string(height),
                   [width, height](const char* dut, rtl::ClockGating) {
                       return std::make_unique<DviOutput>(dut, small_scenario(width, height));
                   }) {
        append_frame(frame_, width,
                     LinkLines(static_cast<std::size_t>(height),
                               std::vector<std::uint32_t>(static_cast<std::size_t>(width))));
        first_clock_ = frame_.size() - static_cast<std::size_t>(kSyncLines * line_clocks(width));
        reset();
    }

    void stimulate() override {
        check_report();
        bench_.clocks_to_reset = reads_due_ ? 100 : 10'000;  // by the block that was made last
        Random& random = bench_.random;
        data_ = static_cast<std::uint32_t>(random.bits() & 0xFF'FFFFU);
        // SWAPLOCK stands until the swap has been seen, and does not rise again until that has been seen to end.
        const bool around_frame_start = (at_ + 3) % frame_.size() < 4;
        if (bench_.in_reset()) {
            swaplock_ = false;
        } else if (swaplock_ == swapped_ && random.one_in(around_frame_start ? 4 : 2000)) {
            swaplock_ = !swaplock_;
        } else if (swaplock_) {
            return;  // SWAPSKIP is stable
        }
        swapskip_ = random.one_in(3);
    }
    void expect() override {
        swapped_ = swapped_due_;
        skipped_ = skipped_due_;
        if (!swapped_due_ && !was_reset_) skipped_.ignore();
        reads_ = reads_due_;
        read_ = read_due_;
        link_ = link_due_;
    }
    void edge() override {
        was_reset_ = false;
        const bool seen = captured_;
        captured_ = swaplock_;
        if (!seen) swapped_due_ = false;
        if (at_ == 0) {
            next_address_ = 0;
            if (seen && !swapped_due_) swap();
        }
        bench_.happened["SWAPLOCK is seen a clock too late"] += at_ == 1 && seen && !was_seen_ ? 1 : 0;
        was_seen_ = seen;
        link_due_ = frame_[at_];
        if (link_due_.de && pictures_ > 0) link_due_.data = data_;
        reads_due_ = pictures_ > 0 && at_ + 2 < frame_.size() && frame_[at_ + 2].de;
        if (reads_due_) read_due_ = {pictures_ % 2 == 0, next_address_++};
        at_ = (at_ + 1) % frame_.size();
    }
    void reset() override {
        bench_.happened["a reset while a pixel is read"] += reads_due_ ? 1 : 0;
        was_reset_ = true;
        captured_ = was_seen_ = swapped_due_ = skipped_due_ = reads_due_ = false;
        read_due_ = {};
        link_due_ = {};
        at_ = first_clock_;
        pictures_ = 0;
        swaps_.clear();
    }

  private:
    void swap() {
        swapped_due_ = true;
        skipped_due_ = swapskip_;
        pictures_ += skipped_due_ ? 0 : 1;
        kept_frames_ += skipped_due_ ? 1 : 0;
        swaps_.push_back({static_cast<std::int64_t>(sc_core::sc_time_stamp().value()), skipped_due_});
        bench_.happened["a swap"] += 1;
        bench_.happened["a swap that keeps the picture"] += skipped_due_ && pictures_ > 0 ? 1 : 0;
        bench_.happened["a swap that keeps black"] += skipped_due_ && pictures_ == 0 ? 1 : 0;
        bench_.happened["SWAPLOCK is seen just in time"] += was_seen_ ? 0 : 1;
    }
    void check_report() {
        bool right = dut().swaps().size() == swaps_.size() && dut().kept_frames() == kept_frames_ &&
                     dut().front_frame() == static_cast<int>(swaps_.size()) - 1;
        if (right && !swaps_.empty()) {
            const Swap& last = dut().swaps().back();
            right = last.picoseconds == swaps_.back().picoseconds && last.kept == swaps_.back().kept;
        }
        if (!right) fail("its report of the swaps is wrong");
    }

    Input<bool>& swaplock_ = in(&DviOutput::swaplock_i);
    Input<bool>& swapskip_ = in(&DviOutput::swapskip_i);
    Output<bool>& swapped_ = out(&DviOutput::swapped_o);
    Output<bool>& skipped_ = out(&DviOutput::skipped_o);
    Output<bool>& reads_ = out(&DviOutput::reads_o);
    Output<DisplayRead>& read_ = out(&DviOutput::read_o);
    Input<std::uint32_t>& data_ = in(&DviOutput::data_i);
    Output<DviLink>& link_ = out(&DviOutput::link_o);
    Waveform frame_;
    std::size_t first_clock_ = 0;  ///< after reset: the first frame is preceded by its vertical sync
    std::size_t at_ = 0;           ///< clock of the frame that comes next
    bool was_reset_ = true;
    bool captured_ = false, was_seen_ = false;  ///< SWAPLOCK
    int pictures_ = 0;  ///< so many have been shown, from picture 0 of the memory on in turn
    std::uint32_t next_address_ = 0;
    bool swapped_due_ = false, skipped_due_ = false, reads_due_ = false;
    DisplayRead read_due_;
    DviLink link_due_;
    std::vector<Swap> swaps_;
    std::int64_t kept_frames_ = 0;
};

TEST_CASE("dvi output: in lockstep with its reference") {
    LockstepBench bench(2213);
    const Timing narrow(bench, 1, 3);
    const Timing low(bench, 4, 1);
    const Timing high(bench, 9, 4);
    bench.run(100'000, {{"a swap", 40},
                        {"a swap that keeps the picture", 6},
                        {"a swap that keeps black", 2},
                        {"SWAPLOCK is seen just in time", 5},
                        {"SWAPLOCK is seen a clock too late", 3},
                        {"a reset while a pixel is read", 2}});
}

// ---- the timing table ----

constexpr int kWidth = 2;
constexpr int kLine = kWidth + 8 + 32 + 40;
constexpr int kFrame = (6 + 1 + 1 + 8) * kLine;
constexpr int kFrame1 = 8 * kLine + kFrame;  ///< its first clock

/// What its edges sample, of an output for one line.
struct Waves {
    std::string swaplock, swapskip, swapped, skipped, link;
};
constexpr int kClocks = kFrame1 + kFrame + 4;

void check_waves(const std::vector<Waves>& cases) {
    LockstepBench bench;
    std::vector<std::unique_ptr<WaveformCase<DviOutput>>> duts;
    for (const Waves& waves : cases) {
        duts.push_back(std::make_unique<WaveformCase<DviOutput>>(
            bench, "output_" + std::to_string(duts.size()), [](const char* name, rtl::ClockGating) {
                return std::make_unique<DviOutput>(name, small_scenario(kWidth, 1));
            }));
        WaveformCase<DviOutput>& dut = *duts.back();
        dut.drive(waves.swaplock, &DviOutput::swaplock_i);
        dut.drive(waves.swapskip, &DviOutput::swapskip_i);
        dut.check(waves.swapped, &DviOutput::swapped_o);
        dut.check(waves.skipped, &DviOutput::skipped_o);
        dut.check(waves.link, &DviOutput::link_o,
                  {{'d', {0, true, false, false}},
                   {'h', {0, false, true, false}},
                   {'v', {0, false, false, true}},
                   {'b', {0, false, true, true}}});
        dut.leave(&DviOutput::reads_o, &DviOutput::read_o, &DviOutput::data_i);
    }
    duts.front()->run();
}

/// A wire that the edges from `clock` on sample high.
std::string from(int clock) {
    return std::string(static_cast<std::size_t>(clock), '_') +
           std::string(static_cast<std::size_t>(kClocks - clock), '-');
}
const std::string kNever(kClocks, '_');
const std::string kAny(kClocks, '?');

TEST_CASE(
    "output framebuffer: timing: SWAPLOCK to swap registers of the DVI clock then the next DVI frames first "
    "clock") {
    check_waves({{from(kFrame1 - 1), kNever, from(kFrame1 + 1), kNever, kAny},
                 {from(kFrame1), kNever, from(kFrame1 + kFrame + 1), kNever, kAny}});
}

TEST_CASE(
    "output framebuffer: timing: SWAPSKIP is read at the edge that sees SWAPLOCK without registers of its "
    "own") {
    check_waves({{from(kFrame1 - 1), from(kFrame1), from(kFrame1 + 1), from(kFrame1 + 1), kAny},
                 {from(kFrame1 - 1), from(kFrame1 + 1), from(kFrame1 + 1), kNever, kAny}});
}

/// `h` and `v` are HSYNC and VSYNC, `b` is both.
std::string lines(int count, char active, char blank, char sync) {
    std::string all;
    for (; count > 0; --count) {
        all += std::string(kWidth, active) + std::string(8, blank) + std::string(32, sync) +
               std::string(40, blank);
    }
    return all;
}

TEST_CASE("output framebuffer: timing: blanking a line a frame") {
    const std::string vsync = lines(8, 'v', 'v', 'b');
    const std::string frame =
        lines(6, '.', '.', 'h') + lines(1, 'd', '.', 'h') + lines(1, '.', '.', 'h') + vsync;
    check_waves({{kNever, kNever, kNever, kNever, "." + vsync + frame + frame + "..."}});
}

}  // namespace
}  // namespace metabuffer::test::dvi_output_test

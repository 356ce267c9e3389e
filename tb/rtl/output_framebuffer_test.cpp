#include "rtl/output_framebuffer.h"

#include <array>
#include <catch2/catch.hpp>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "clocked_testbench.h"
#include "dvi_waveform.h"
#include "lockstep/waveform_case.h"
#include "support/colour_tables.h"
#include "support/images.h"
#include "support/scenarios.h"

namespace metabuffer::test::output_framebuffer_test {
namespace {

using rtl::DviLink;
using rtl::OutputFramebuffer;
using rtl::PipePixel;

constexpr int kWidth = 6;
constexpr int kHeight = 2;
constexpr int kDisplay = 2;  ///< its number

struct Dut {
    OutputFramebuffer block;
    sc_core::sc_signal<bool> pipeready, framedone, framebad;
    sc_core::sc_signal<DviLink> link;

    Dut(const char* name, const Scenario& scenario) : block(name, scenario, kDisplay) {}
};

/// An output framebuffer between a random pipeline, a random second display and its DVI link, and its reference. The
/// reference keeps whole pictures instead of a memory. At each edge of either clock the outputs must be those of the
/// reference. The framebuffer is there twice, with clock gating and without.
class RandomFramebuffer final : public sc_core::sc_module {
  public:
    RandomFramebuffer(const sc_core::sc_module_name& name, ClockedTestbench& bench, ClockDomain& dvi,
                      Scenario scenario, Random& random)
        : sc_core::sc_module(name),
          bench_(bench),
          dvi_(dvi),
          scenario_(std::move(scenario)),
          random_(random) {
        duts_[0] = std::make_unique<Dut>("gated", scenario_);
        duts_[0]->block.clk_i(bench.core.gated_clk);
        duts_[0]->block.dvi_clk_i(dvi.gated_clk);
        duts_[1] = std::make_unique<Dut>("ungated", scenario_);
        duts_[1]->block.clk_i(bench.core.clk);
        duts_[1]->block.dvi_clk_i(dvi.clk);
        for (const auto& dut : duts_) connect(*dut);
        bench.trace(duts_[0]->block);
        SC_METHOD(core_edge);
        sensitive << bench.core.clk.posedge_event();
        dont_initialize();
        SC_METHOD(dvi_edge);
        sensitive << dvi.clk.posedge_event();
        dont_initialize();
        bench.core.each_clock([this](int clock) {
            check_core(clock - 1);
            drive();
        });
        dvi.each_clock([this](int clock) { check_link(clock - 1); });
    }
    SC_HAS_PROCESS(RandomFramebuffer);

    bool receiving() const { return receiving_; }
    void check() const {
        INFO(name());
        if (!failure_.empty()) FAIL(failure_);
        for (const auto& dut : duts_) {
            CHECK(dut->block.stalled_cycles() == stalled_clocks_);
            CHECK(dut->block.pixels_taken() == pixels_);
            CHECK(dut->block.kept_frames() == kept_frames_);
            CHECK(dut->block.front_frame() == swaps_ - 1);
            CHECK(dut->block.swaps().size() == static_cast<std::size_t>(swaps_));
        }
        // Else the stimulus is too tame.
        CHECK(shown_frames_ >= 2);
        CHECK(kept_frames_ >= 2);
        CHECK(lost_frames_ >= 1);
    }

  private:
    void connect(Dut& dut) {
        dut.block.reset_i(bench_.reset);
        dut.block.startframe_i(startframe_);
        dut.block.pipe_i(pipe_);
        dut.block.column_stall_i(column_stall_);
        dut.block.pipeready_o(dut.pipeready);
        dut.block.framedone_o(dut.framedone);
        dut.block.framebad_o(dut.framebad);
        dut.block.swaplock_i(swaplock_);
        dut.block.swapskip_i(swapskip_);
        dut.block.link_o(dut.link);
    }
    bool may_stall() const { return scenario_.composer.on_starvation == StarvationMode::kStall; }
    std::size_t raster_pixels() const {
        const int s = scenario_.displays.supersample;
        return static_cast<std::size_t>(kWidth * kHeight * s * s);
    }

    // ---- the stimulus, half a core clock before an edge ----

    void drive() {
        if (!(may_stall() && column_stall_.read())) {  // else the pipeline's registers stand still
            const bool starts = pipeready_ && random_.one_in(clocks_to_start_);
            startframe_.write(starts);
            if (starts) {
                clocks_to_stall_ = one_of(random_, std::array{2, 20, 2000});
                clocks_to_other_ = one_of(random_, std::array{1, 300, 30'000});
                clocks_to_start_ = one_of(random_, std::array{1, 40, 1000});
            }
            // What stands there between frames must not count.
            const int odds = receiving_ ? 2 * static_cast<int>(raster_pixels()) : 2;
            pipe_.write(PipePixel{noise_pixel(random_, 0xFFFF), receiving_ || random_.one_in(2),
                                  random_.one_in(odds)});
        }
        column_stall_.write(random_.one_in(clocks_to_stall_));
        // The other display's frame may be whole later, and may be bad.
        if (!framedone_) {
            other_done_ = other_bad_ = false;
        } else if (!other_done_ && random_.one_in(clocks_to_other_)) {
            other_done_ = true;
            other_bad_ = random_.one_in(4);
        }
        swaplock_.write(framedone_ && other_done_);
        swapskip_.write(framebad_ || other_bad_);
    }

    // ---- the reference ----

    void core_edge() {
        if (bench_.reset.read()) {
            receiving_ = whole_ = swap_captured_ = swap_seen_ = false;
            pipeready_ = framedone_ = framebad_ = false;
            return;
        }
        const bool swap_seen = swap_captured_;
        swap_captured_ = swapped_.read();
        if (swap_seen && !swap_seen_) whole_ = framebad_ = false;
        swap_seen_ = swap_seen;
        if (may_stall() && column_stall_.read()) {
            ++stalled_clocks_;
        } else if (receiving_) {
            receive(pipe_.read());
        } else if (startframe_.read()) {
            receiving_ = true;
            raster_.clear();
        }
        framedone_ = whole_ && !swap_seen;
        pipeready_ = !receiving_ && !whole_;
    }
    void receive(const PipePixel& pixel) {
        ++pixels_;
        raster_.push_back(pixel.pixel);
        framebad_ = framebad_ || pixel.lost;
        if (raster_.size() < raster_pixels()) return;
        receiving_ = false;
        whole_ = true;
        lost_frames_ += framebad_ ? 1 : 0;
    }
    void dvi_edge() {
        if (bench_.reset.read()) {
            swaplock_captured_ = false;
            swapped_.write(false);
            swaps_ = 0;
            frame_ = frame_of(ColourImage(kWidth, kHeight));
            at_ = frame_.size() - static_cast<std::size_t>(kSyncLines * line_clocks(kWidth));
            link_ = {};
            return;
        }
        const bool seen = swaplock_captured_;
        swaplock_captured_ = swaplock_.read();
        if (!seen) swapped_.write(false);
        if (at_ == 0 && seen && !swapped_.read()) swap();
        link_ = frame_[at_];
        at_ = (at_ + 1) % frame_.size();
    }
    void swap() {
        const bool kept = swapskip_.read();
        swapped_.write(true);
        ++swaps_;
        kept_frames_ += kept ? 1 : 0;
        if (kept) return;
        ++shown_frames_;
        frame_ = frame_of(picture());
    }
    /// Of each channel and block the mean, halves up. Then the display's own table.
    ColourImage picture() const {
        ColourImage means(kWidth, kHeight);
        const int s = scenario_.displays.supersample;
        for (int i = 0; i < kWidth * kHeight; ++i) {
            std::array<double, 3> mean{0.5, 0.5, 0.5};
            for (int j = 0; j < s * s; ++j) {
                const int x = i % kWidth * s + j % s;
                const int y = i / kWidth * s + j / s;
                const Pixel& pixel = raster_[static_cast<std::size_t>(y * kWidth * s + x)];
                mean[0] += pixel.r() / static_cast<double>(s * s);
                mean[1] += pixel.g() / static_cast<double>(s * s);
                mean[2] += pixel.b() / static_cast<double>(s * s);
            }
            std::uint32_t& colour = means.values[static_cast<std::size_t>(i)];
            for (const double channel : mean) colour = colour * 256 + static_cast<std::uint32_t>(channel);
        }
        for (const DisplayCorrection& correction : scenario_.displays.correction) {
            if (correction.display == kDisplay) return naive_correction(*correction.lut, means);
        }
        return means;
    }
    static Waveform frame_of(const ColourImage& picture) {
        LinkLines lines;
        for (int y = 0; y < kHeight; ++y) {
            const auto first = picture.values.begin() + y * kWidth;
            lines.emplace_back(first, first + kWidth);
        }
        Waveform wave;
        append_frame(wave, kWidth, lines);
        return wave;
    }

    // ---- the judge, half a clock after each edge ----

    void check_core(int clock) {
        for (const auto& dut : duts_) {
            compare(*dut, "PIPEREADY", dut->pipeready.read(), pipeready_, clock);
            compare(*dut, "FRAMEDONE", dut->framedone.read(), framedone_, clock);
            compare(*dut, "FRAMEBAD", dut->framebad.read(), framebad_, clock);
        }
    }
    void check_link(int clock) {
        for (const auto& dut : duts_) compare(*dut, "DVI", dut->link.read(), link_, clock);
    }
    template <typename Value>
    void compare(const Dut& dut, const char* what, const Value& is, const Value& due, int clock) {
        if (is == due || !failure_.empty()) return;
        std::ostringstream text;
        text << dut.block.name() << ": after clock " << clock << ' ' << what << " is " << is << " for "
             << due;
        failure_ = text.str();
        sc_core::sc_stop();
    }

    ClockedTestbench& bench_;
    ClockDomain& dvi_;
    Scenario scenario_;
    Random& random_;
    std::array<std::unique_ptr<Dut>, 2> duts_;
    std::string failure_;
    // The inputs, and what the stimulus is about.
    sc_core::sc_signal<bool> startframe_, column_stall_, swaplock_, swapskip_;
    sc_core::sc_signal<PipePixel> pipe_;
    bool other_done_ = false, other_bad_ = false;
    int clocks_to_start_ = 1000, clocks_to_stall_ = 1000, clocks_to_other_ = 1000;  // once in so many
    // In core clocks.
    bool pipeready_ = false, framedone_ = false, framebad_ = false;
    bool receiving_ = false;
    bool whole_ = false;  ///< the raster, which waits for its swap
    bool swap_captured_ = false, swap_seen_ = false;
    std::vector<Pixel> raster_;
    // In DVI clocks. What goes to the core is a signal, so that an edge of both reads what was there before it.
    sc_core::sc_signal<bool> swapped_;
    bool swaplock_captured_ = false;
    Waveform frame_;      ///< under way
    std::size_t at_ = 0;  ///< clock of it that comes next
    DviLink link_;
    int swaps_ = 0;  ///< since the last reset
    // What a report says, and how often it happened.
    std::int64_t stalled_clocks_ = 0, pixels_ = 0, kept_frames_ = 0;
    int shown_frames_ = 0, lost_frames_ = 0;
};

Scenario random_scenario(Random& random, int supersample, StarvationMode mode, bool corrected) {
    Scenario scenario = small_scenario(kWidth, kHeight, 2);
    scenario.displays.supersample = supersample;
    scenario.composer.on_starvation = mode;
    for (const int display : {1, kDisplay}) {
        if (display == kDisplay && !corrected) continue;
        DisplayCorrection correction;
        correction.display = display;
        correction.lut = std::make_shared<const ColourTable>(random_colour_table(random));
        scenario.displays.correction.push_back(correction);
    }
    return scenario;
}

TEST_CASE("output framebuffer: at each edge of two clocks of any ratio its outputs are its reference's") {
    const auto seed = random_seed(2215);
    INFO("METABUFFER_SEED=" << seed);
    Random random(seed);
    ClockedTestbench bench;
    struct Case {
        std::int64_t dvi_picoseconds;
        int supersample;
        StarvationMode mode;
        bool corrected;
    };
    // The first one has the core's period. In a clock of the last one a whole frame may come.
    const std::vector<Case> cases{{10'000, 1, StarvationMode::kStall, false},
                                  {7'300, 4, StarvationMode::kStall, true},
                                  {10'010, 1, StarvationMode::kGlitch, true},
                                  {23'700, 2, StarvationMode::kGlitch, false},
                                  {130'000, 1, StarvationMode::kGlitch, false}};
    std::vector<std::unique_ptr<RandomFramebuffer>> framebuffers;
    for (const Case& one : cases) {
        const std::string name = "dvi_" + std::to_string(one.dvi_picoseconds);
        ClockDomain& dvi = bench.add_clock((name + "_clock").c_str(), one.dvi_picoseconds);
        framebuffers.push_back(std::make_unique<RandomFramebuffer>(
            name.c_str(), bench, dvi, random_scenario(random, one.supersample, one.mode, one.corrected),
            random));
    }
    constexpr int kClocks = 300'000;
    // Each reset cuts a frame of one of them, and is so long that the slowest clock sees it.
    int resets = 0, next_reset = 20'000, reset_ends = -1;
    bench.core.each_clock([&](int clock) {
        if (clock == reset_ends) bench.reset.write(false);
        const auto any = static_cast<std::size_t>(random.between(0, static_cast<int>(cases.size()) - 1));
        if (clock < next_reset || !framebuffers[any]->receiving()) return;
        bench.reset.write(true);
        ++resets;
        reset_ends = clock + random.between(27, 50);
        next_reset = clock + (random.one_in(2) ? 100 : random.between(20'000, 60'000));
    });
    bench.run_through(kClocks);
    for (const auto& framebuffer : framebuffers) framebuffer->check();
    CHECK(resets >= 4);
}

// ---- the timing table ----

/// What an edge of either clock samples, the two being one. `p` is a pixel, `L` one that is marked as lost.
struct Waves {
    std::string startframe, pipe, pipeready, framedone, framebad, swaplock;
};

/// Framebuffers of a display of one line.
void check_waves(int pixels, const std::vector<Waves>& cases) {
    LockstepBench bench;
    std::vector<std::unique_ptr<WaveformCase<OutputFramebuffer>>> duts;
    for (const Waves& waves : cases) {
        duts.push_back(std::make_unique<WaveformCase<OutputFramebuffer>>(
            bench, "framebuffer_" + std::to_string(duts.size()),
            [&bench, pixels](const char* name, rtl::ClockGating) {
                auto dut = std::make_unique<OutputFramebuffer>(name, small_scenario(pixels, 1), 1);
                dut->dvi_clk_i(bench.clk);
                return dut;
            }));
        WaveformCase<OutputFramebuffer>& dut = *duts.back();
        dut.drive(waves.startframe, &OutputFramebuffer::startframe_i);
        dut.drive(waves.pipe, &OutputFramebuffer::pipe_i, {{'p', {{}, true}}, {'L', {{}, true, true}}});
        dut.check(waves.pipeready, &OutputFramebuffer::pipeready_o);
        dut.check(waves.framedone, &OutputFramebuffer::framedone_o);
        dut.check(waves.framebad, &OutputFramebuffer::framebad_o);
        dut.drive(waves.swaplock, &OutputFramebuffer::swaplock_i);
        dut.leave(&OutputFramebuffer::column_stall_i, &OutputFramebuffer::swapskip_i,
                  &OutputFramebuffer::link_o);
    }
    duts.front()->run();
}

const std::string kLow = "___________";

TEST_CASE("output framebuffer: timing: STARTFRAME read to raster pixel 0 read") {
    // The lost pixels before and after the frame do not belong to it.
    check_waves(3, {{"__-________", "..LpppL....", "_--________", "______-----", kLow, kLow},
                    {"__-________", "...Lpp.....", "_--________", "______-----", "____-------", kLow}});
}

TEST_CASE("output framebuffer: timing: last raster pixel read FRAMEDONE written at that edge") {
    check_waves(3, {{"__-________", "...ppp.....", "_--________", "______-----", kLow, kLow}});
}

TEST_CASE(
    "output framebuffer: timing: first pixel marked as lost read FRAMEBAD written at that edge at the latest "
    "with FRAMEDONE") {
    check_waves(3, {{"__-________", "...pLL.....", "_--________", "______-----", "_____------", kLow},
                    {"__-________", "...ppL.....", "_--________", "______-----", "______-----", kLow}});
}

TEST_CASE(
    "output framebuffer: timing: swap to FRAMEDONE and FRAMEBAD low and PIPEREADY high registers of the core "
    "clock") {
    // Edge 648 is the first one of a DVI frame and swaps; edge 650 sees it.
    const std::string wait(640, '_');
    const std::string done(640, '-');
    check_waves(1, {{"__-_" + wait + "__________", "...L" + std::string(640, '.') + "..........",
                     "_--_" + wait + "_______---", "____" + done + "-------___", "____" + done + "-------___",
                     "____" + done + "-------___"}});
}

}  // namespace
}  // namespace metabuffer::test::output_framebuffer_test

#include "rtl/merge_stage.h"

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "composer_scenario.h"
#include "expected_report.h"
#include "lockstep/lockstep.h"
#include "lockstep/waveform_case.h"
#include "support/images.h"
#include "support/naive_pixels.h"
#include "support/painted_segment.h"
#include "support/traced_values.h"

namespace metabuffer::test::merge_stage_test {
namespace {

using rtl::FifoRead;
using rtl::FifoWrite;
using rtl::MergeStage;
using rtl::PipePixel;
using rtl::SegmentProgress;

constexpr Size kRaster{14, 6};
constexpr int kPositions = kRaster.width * kRaster.height;

struct Variant {
    StarvationMode mode = StarvationMode::kGlitch;
    Smoothing smoothing = Smoothing::kReplicate;
    Composition composition = Composition::kZ;
    DepthFormat depth_format = DepthFormat::kA8Z16;
};

Scenario merge_scenario(const Variant& variant) {
    const bool smooths = variant.smoothing == Smoothing::kBilinear;
    // Two source rows and a pixel fit.
    Scenario scenario = composer_scenario({smooths ? 32 : 16, 6, 1}, variant.mode);
    scenario.displays.width_pixels = kRaster.width;
    scenario.displays.height_pixels = kRaster.height;
    scenario.composer.smoothing = variant.smoothing;
    scenario.composition = variant.composition;
    scenario.depth_format = variant.depth_format;
    scenario.displays.background[0] = 10;
    scenario.displays.background[1] = 20;
    scenario.displays.background[2] = 30;
    return scenario;
}

/// A merge stage among the composer's other parts, as far as it sees them: the walker, the receiver and the FIFO. The
/// pixels of up to two frames come in order, at any time and in beats of any length. One that comes late is written, too.
class Stage final : public Lockstep<MergeStage> {
  public:
    Stage(LockstepBench& bench, const std::string& name, const Variant& variant)
        : Lockstep(bench, name,
                   [variant](const char* dut, rtl::ClockGating) {
                       return std::make_unique<MergeStage>(dut, merge_scenario(variant));
                   }),
          variant_(variant),
          memory_(static_cast<std::size_t>(merge_scenario(variant).composer.buffer_pixels)) {
        words_[0][0] = &in(&MergeStage::word_i);
        reads_[0] = &out(&MergeStage::read_o);
        if (!smooths()) return;
        words_[0][1] =
            &in_part<std::uint64_t>([](MergeStage & dut) -> auto& { return dut.second_row->next_word_i; });
        words_[1][0] =
            &in_part<std::uint64_t>([](MergeStage & dut) -> auto& { return dut.second_row->row_word_i; });
        words_[1][1] = &in_part<std::uint64_t>(
            [](MergeStage & dut) -> auto& { return dut.second_row->row_next_word_i; });
        reads_[1] = &out_part<FifoRead>([](MergeStage & dut) -> auto& { return dut.second_row->row_read_o; });
    }

    void stimulate() override {
        Random& random = bench_.random;
        const auto now = [this](int clocks) {
            constexpr int kSlower = 40;
            return bench_.random.one_in(bench_.pausing() ? kSlower * clocks : clocks);
        };
        // A frame's table comes when nothing more is to come of the frame before.
        if ((frames_.empty() || (frames_.size() == 1 && frames_.front().is_over())) && now(6)) add_frame();
        if (!frames_.empty() && !frames_.front().is_whole() && now(150)) frames_.front().abandoned = true;
        beat_ = Beat{};
        if (now(20)) pace_ = random.between(1, 12);
        if (!frames_.empty() && !frames_.back().is_over() && now(pace_)) send_beat();
        starts_ = !frames_.empty() && now(6);

        write_ = beat_.write;
        progress_ = frames_.empty() ? SegmentProgress{} : frames_.front().progress();
        running_ = runs();
        ahead_ = ahead();
        pipe_ = PipePixel{corner_pixel(random), runs() || random.one_in(2), random.one_in(runs() ? 10 : 2)};
        if (random.one_in(20)) pipemaster_ = !pipemaster_;
        column_stall_ = due_stall() || now(5);
    }
    void expect() override {
        pipe_out_ = leaving_;
        missing_out_ = runs() && missing();
        stall_ = due_stall();
        for (std::size_t row = 0; row < lines(); ++row) *reads_[row] = due_read(row);
    }
    void edge() override {
        const bool moves = !may_stall() || !column_stall_;
        bench_.happened["another composer stalls"] +=
            may_stall() && runs() && column_stall_ && !stall_ ? 1 : 0;
        if (moves) {
            starved_ = false;
            leaving_ = runs() ? composited() : PipePixel{};
        }
        use_fifo(moves ? ahead_.value() : step_);
        if (!moves) return;
        step_ = ahead_;
        if (runs()) {
            if (++position_ < kPositions) return;
            position_ = kIdle;
            frames_.pop_front();
            at_hand_ = {};  // nothing of the next frame is at hand
        } else if (starts_) {
            position_ = 0;
        }
    }
    void reset() override {
        frames_.clear();
        position_ = kIdle;
        step_ = RasterStep{};
        leaving_ = PipePixel{};
        starved_ = false;
        at_hand_ = {};
        is_master_ = pipemaster_;
    }
    /// A waveform shows whether the pixel that has just left starved, and what is at hand for the next ones.
    void check_waveform() const {
        if (!frames_.empty() && frames_.front().abandoned) return;  // then nothing that is at hand is used
        const int bits = rtl::segment_pixel_bits(merge_scenario(variant_));
        const std::string begin = std::string(dut().name()) + ".";
        std::vector<std::string> due{begin + "starved[1]=" + (starved_ ? "1" : "0")};
        const auto add = [&](const std::string& name, std::int64_t pixel) {
            const std::int64_t value = pixel == kNone ? (std::int64_t{1} << bits) - 1 : pixel;
            due.push_back(begin + name + "[" + std::to_string(bits) + "]=" + std::to_string(value));
        };
        for (std::size_t row = 0; row < lines(); ++row) {
            for (std::size_t column = 0; column < lines(); ++column) {
                const std::string place =
                    smooths() ? "_" + std::to_string(row) + "_" + std::to_string(column) : "";
                add("word_pixel" + place, at_hand_[row][column].fifo);
                add("bypass_pixel" + place, at_hand_[row][column].kept);
            }
        }
        std::vector<std::string> shown;
        for (const std::string& value : traced_values(dut())) {
            const auto is = [&](const char* name) { return value.rfind(begin + name, 0) == 0; };
            if (is("starved") || is("word_pixel") || is("bypass_pixel")) shown.push_back(value);
        }
        CHECK(shown == due);
    }

  private:
    static constexpr int kIdle = -1;
    static constexpr std::int64_t kNone = PaintedSegment::kNone;

    struct Frame {
        PaintedSegment painted;
        std::vector<Pixel> pixels;
        std::uint32_t base_address;
        std::size_t arrived = 0;
        bool abandoned = false;

        bool is_whole() const { return arrived == pixels.size(); }
        bool is_over() const { return is_whole() || abandoned; }
        SegmentProgress progress() const {
            return {abandoned, static_cast<std::int64_t>(arrived), base_address};
        }
    };
    /// On its way into the FIFO.
    struct Beat {
        FifoWrite write;
        bool of_head = false;  ///< of the frame that runs, or is next
        std::int64_t first = 0;
        bool has(std::int64_t pixel) const {
            return of_head && pixel >= first && pixel < first + write.count;
        }
    };
    /// Pixels of a source row, in their order; kNone: none.
    using Row = std::array<std::int64_t, 2>;
    /// Where a pixel is at hand, for one column of one row of the window.
    struct Hand {
        std::int64_t fifo = kNone;  ///< at the FIFO's output
        std::int64_t kept = kNone;  ///< in a register
    };

    bool smooths() const { return variant_.smoothing == Smoothing::kBilinear; }
    bool may_stall() const { return variant_.mode == StarvationMode::kStall; }
    std::size_t lines() const { return smooths() ? 2 : 1; }
    bool runs() const { return position_ != kIdle; }

    // ---- the other parts ----

    void add_frame() {
        Random& random = bench_.random;
        constexpr int kLargestMultiple = 6;
        std::optional<ViewportRow> row;
        if (!random.one_in(8)) {
            row = smooths() ? random_smoothed_row(random, kRaster, kLargestMultiple)
                            : random_valid_row(random, kRaster, kLargestMultiple);
        }
        Frame frame{PaintedSegment(row, kRaster, variant_.smoothing), {}, write_address_};
        for (int k = 0; row && k < row->sdx * row->sdy; ++k) frame.pixels.push_back(corner_pixel(random));
        if (!row && random.one_in(3)) frame.abandoned = true;  // its table was lost
        frames_.push_back(frame);
    }
    void send_beat() {
        Random& random = bench_.random;
        Frame& frame = frames_.back();
        const auto addresses = static_cast<std::uint32_t>(memory_.size());
        const int most = random.one_in(2) ? random.between(1, rtl::kMaximumBeatPixels) : 1;
        beat_ = {{0, write_address_}, frames_.size() == 1, static_cast<std::int64_t>(frame.arrived)};
        for (std::uint64_t& word : beat_.write.words) word = random.bits();
        while (beat_.write.count < most && !frame.is_whole() &&
               held() < static_cast<std::int64_t>(addresses)) {
            beat_.write.words[beat_.write.count++] = frame.pixels[frame.arrived++].word();
            write_address_ = (write_address_ + 1) % addresses;
        }
    }
    /// Pixels that must not be written over.
    std::int64_t held() const {
        std::int64_t held = 0;
        for (const Frame& frame : frames_)
            held += frame.abandoned ? 0 : static_cast<std::int64_t>(frame.arrived);
        if (position_ <= 0 || frames_.front().abandoned) return held;
        const Frame& head = frames_.front();
        return held - std::min(static_cast<std::int64_t>(head.arrived),
                               head.painted.released[static_cast<std::size_t>(position_ - 1)]);
    }
    RasterStep ahead() const {
        if (frames_.empty() || position_ + 1 == kPositions) return {};
        return frames_.front().painted.steps[static_cast<std::size_t>(position_ + 1)];
    }

    // ---- what is due ----

    bool missing() const {
        if (!step_.covered || progress_->abandoned) return false;
        const std::vector<std::int64_t> parts = PaintedSegment::parts(step_);
        return *std::max_element(parts.begin(), parts.end()) >= progress_->arrived;
    }
    bool due_stall() const { return may_stall() && runs() && missing(); }
    PipePixel composited() {
        const Pixel background(10, 20, 30, 0, far_z(variant_.depth_format));
        starved_ = missing();
        PipePixel out = is_master_ ? PipePixel{background, true, false} : pipe_.value();
        out.lost = out.lost || progress_->abandoned;
        if (starved_) {
            ++bench_.happened["a pixel starved"];
        } else if (step_.covered && !progress_->abandoned) {
            const std::vector<Pixel>& pixels = frames_.front().pixels;
            std::vector<Pixel> of;
            for (const std::int64_t k : PaintedSegment::parts(step_))
                of.push_back(pixels[static_cast<std::size_t>(k)]);
            const Pixel local =
                smooths() ? naive_mixture({of[0], of[1], of[2], of[3]}, step_.weight_x, step_.weight_y,
                                          variant_.composition, far_z(variant_.depth_format))
                          : of[0];
            out.pixel = naive_blend(variant_.composition, local, out.pixel);
            ++bench_.happened[beat_.has(step_.pixel) ? "a pixel came past the FIFO" : "a pixel was shown"];
        }
        return out;
    }
    /// The pixels of a row of the window at a position: its own source row, or the one across.
    Row row_of(std::size_t row, const RasterStep& step) const {
        if (!step.covered || (row == 1 && step.across == 0)) return {kNone, kNone};
        const std::int64_t pixel = step.pixel + (row == 1 ? step.across : 0);
        if (!smooths() || step.beside == 0) return {pixel, kNone};
        return {std::min(pixel, pixel + step.beside), std::max(pixel, pixel + step.beside)};
    }
    FifoRead due_read(std::size_t row) const {
        const Row pixels = row_of(row, ahead_);
        if (pixels[0] == kNone) return {};
        FifoRead read;
        read.address = static_cast<std::uint32_t>((progress_->base_address + pixels[0]) %
                                                  static_cast<std::int64_t>(memory_.size()));
        for (std::size_t column = 0; column < lines(); ++column) {
            const Hand& hand = at_hand_[row][column];
            const bool has_come = pixels[column] != kNone && pixels[column] < progress_->arrived;
            if (has_come && hand.fifo != pixels[column] && hand.kept != pixels[column]) read.enable = true;
        }
        read.enable = read.enable && !progress_->abandoned;
        return read;
    }
    /// The edge at the FIFO, and what is then at hand. next: of the edge after this one.
    void use_fifo(const RasterStep& next) {
        for (std::uint32_t i = 0; i < write_->count; ++i) {
            memory_[(write_->address + i) % memory_.size()] = write_->words[i];
        }
        for (std::size_t row = 0; row < lines(); ++row) {
            const FifoRead& read = *reads_[row];
            for (std::size_t column = 0; column < lines(); ++column) {
                Hand& hand = at_hand_[row][column];
                const std::int64_t before = hand.fifo;
                if (read.enable) {
                    *words_[row][column] = memory_[(read.address + column) % memory_.size()];
                    hand.fifo = row_of(row, ahead_)[0] + static_cast<std::int64_t>(column);
                    if (hand.fifo >= progress_->arrived) hand.fifo = kNone;
                }
                const std::int64_t wanted = row_of(row, next)[column];
                if (wanted == kNone || wanted == hand.fifo || wanted == hand.kept) continue;
                if (wanted == before || beat_.has(wanted)) hand.kept = wanted;
            }
        }
    }

    Variant variant_;
    Input<bool>& pipemaster_ = in(&MergeStage::pipemaster_i);
    Input<PipePixel>& pipe_ = in(&MergeStage::pipe_i);
    Output<PipePixel>& pipe_out_ = out(&MergeStage::pipe_o);
    Input<bool>& column_stall_ = in(&MergeStage::column_stall_i);
    Output<bool>& stall_ = out(&MergeStage::stall_o);
    Input<bool>& running_ = in(&MergeStage::running_i);
    Input<RasterStep>& ahead_ = in(&MergeStage::ahead_i);
    Input<SegmentProgress>& progress_ = in(&MergeStage::progress_i);
    Output<bool>& missing_out_ = out(&MergeStage::missing_o);
    Input<FifoWrite>& write_ = in(&MergeStage::write_i);
    // By row of the window, and column.
    std::array<std::array<Input<std::uint64_t>*, 2>, 2> words_{};
    std::array<Output<FifoRead>*, 2> reads_{};

    std::vector<std::uint64_t> memory_;
    std::uint32_t write_address_ = 0;
    std::deque<Frame> frames_;  ///< the one that runs, or is next, and the one after it
    Beat beat_;
    int pace_ = 1;          ///< clocks from beat to beat
    bool starts_ = false;   ///< the coming edge sees the start of a frame
    int position_ = kIdle;  ///< composited at the next edge

    bool is_master_ = false;
    RasterStep step_;
    PipePixel leaving_;
    std::array<std::array<Hand, 2>, 2> at_hand_;
    bool starved_ = false;
};

TEST_CASE("merge stage: in lockstep with its reference") {
    constexpr auto kStall = StarvationMode::kStall;
    constexpr auto kGlitch = StarvationMode::kGlitch;
    LockstepBench bench(2219);
    bench.clocks_to_reset = 200;
    const Stage plain(bench, "plain", {kGlitch});
    const Stage stalls(bench, "stalls", {kStall, Smoothing::kReplicate, Composition::kOver});
    const Stage smooths(bench, "smooths",
                        {kGlitch, Smoothing::kBilinear, Composition::kZAlphaKey, DepthFormat::kZ24});
    const Stage both(bench, "both", {kStall, Smoothing::kBilinear, Composition::kZ});
    constexpr int kClocks = 30'000;
    for (int clock = kClocks / 40; clock < kClocks; clock += kClocks / 40) {
        bench.run(clock);
        for (const Stage* stage : {&plain, &stalls, &smooths, &both}) stage->check_waveform();
    }
    bench.run(kClocks, {{"a pixel starved", 100},
                        {"a pixel came past the FIFO", 100},
                        {"a pixel was shown", 1000},
                        {"another composer stalls", 100}});
}

TEST_CASE("merge stage: a pixel that has come and is neither in the FIFO nor in the beat is reported") {
    ExpectedReport report("/metabuffer/merge_stage/pixel");
    LockstepBench bench;
    const Scenario scenario = merge_scenario({});
    WaveformCase<MergeStage> dut(bench, "merge_stage", [&](const char* name, rtl::ClockGating) {
        return std::make_unique<MergeStage>(name, scenario);
    });
    RasterStep step;
    step.covered = true;
    dut.drive("____", &MergeStage::pipemaster_i);
    dut.drive("____", &MergeStage::column_stall_i);
    dut.drive("s...", &MergeStage::ahead_i, {{'s', step}});
    dut.drive("_-__", &MergeStage::running_i);
    dut.drive(".p..", &MergeStage::progress_i, {{'p', SegmentProgress{false, 1, 1}}});
    dut.drive(".w..", &MergeStage::write_i, {{'w', FifoWrite{1, 0, {}}}});  // to the address before it
    dut.drive("....", &MergeStage::word_i);
    dut.drive("....", &MergeStage::pipe_i);
    dut.check("..?.", &MergeStage::pipe_o);
    dut.check("____", &MergeStage::stall_o);
    dut.check("____", &MergeStage::missing_o);
    dut.check("....", &MergeStage::read_o);
    dut.run();
    CHECK(report.count() == 2);  // with clock gating and without
}

}  // namespace
}  // namespace metabuffer::test::merge_stage_test

#include "rtl/dvi_decoder.h"

#include <array>
#include <catch2/catch.hpp>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "dvi_waveform.h"
#include "lockstep/lockstep.h"
#include "support/rows.h"

namespace metabuffer::test::dvi_decoder_test {
namespace {

using rtl::DecodedPixel;
using rtl::DecoderEvent;
using rtl::DviDecoder;
using rtl::DviLink;

/// Its verdict is known from how it was made.
struct ControlLine {
    ControlScanline content;
    std::vector<std::uint32_t> pixels;
    std::optional<RejectCause> defect;
};

ViewportRow any_row(Random& random) {
    const auto any = [&random] { return random.between(0, 0xFFFF); };
    return table_row(any(), {any(), any()}, {any(), any()}, {any(), any()}, any());
}

ControlLine any_control_line(Random& random, int width, FrameKind kind, std::uint32_t number) {
    ControlLine line;
    ControlScanline& content = line.content;
    content.kind = kind;
    content.frame_number = number;
    const int most_rows = (3 * width - 18) / 16;
    const int rows = random.one_in(2) ? most_rows : random.between(0, most_rows);
    for (int row = 0; row < rows; ++row) content.table.push_back(any_row(random));
    const auto fixed_bytes = static_cast<int>(control_scanline_bytes(content));
    content.payload.resize(static_cast<std::size_t>(random.between(0, 3 * width - fixed_bytes)));
    for (std::uint8_t& byte : content.payload) byte = static_cast<std::uint8_t>(random.bits());
    const int bytes = fixed_bytes + static_cast<int>(content.payload.size());
    const auto break_byte = [&](int first, int last) {
        const int offset = random.between(first, last);
        line.pixels.at(static_cast<std::size_t>(offset / 3)) ^= static_cast<unsigned>(random.between(1, 0xFF))
                                                                << (16 - 8 * (offset % 3));
    };

    constexpr int kOneDefect = 4;
    const int defect = random.one_in(4) ? random.between(0, kOneDefect + 1) : -1;
    if (defect == 0) content.kind = static_cast<FrameKind>(random.between(2, 0xFF));
    line.pixels = encode_control_scanline(content, width);
    if (defect == 0) line.defect = RejectCause::kKind;
    if (defect == 1 && bytes < 3 * width) break_byte(bytes, 3 * width - 1);  // none: behind the content
    // A defect is found before one that stands behind it.
    if (defect == 2 || (defect > kOneDefect && random.one_in(2))) {
        break_byte(5, bytes - 1);
        line.defect = RejectCause::kCrc;
    }
    if (defect == 3 || (defect > kOneDefect && random.one_in(2))) {
        break_byte(4, 4);
        line.defect = RejectCause::kVersion;
    }
    if (defect >= kOneDefect) {
        break_byte(0, 3);
        line.defect = RejectCause::kMagic;
    }
    return line;
}

/// A link of frames good and bad, and what a decoder must find in it.
class Decoder final : public Lockstep<DviDecoder> {
  public:
    Decoder(LockstepBench& bench, const char* name, int width, int lines)
        : Lockstep(bench, name,
                   [timing = DviTiming{width, lines}](const char* dut, rtl::ClockGating) {
                       return std::make_unique<DviDecoder>(dut, timing);
                   }),
          width_(width),
          lines_(lines) {}

    void stimulate() override {
        constexpr int kClocksToLoneChange = 12;
        if (bench_.pausing() && !link_->de) {
            DviLink resting = link_;
            if (bench_.random.one_in(kClocksToLoneChange)) resting.hsync = !resting.hsync;
            link_ = resting;
            return;
        }
        if (script_.empty()) add_frame();
        link_ = script_.front();
        script_.pop_front();
    }
    void expect() override {
        pixel_ = pixel_due_;
        event_ = event_due_;
    }
    void edge() override {
        event_due_ = {};
        pixel_due_.valid = false;
        if (!rows_.empty()) {
            event_due_.row = true;
            event_due_.table_row = rows_.front();
            rows_.pop_front();
            bench_.happened["a row beside a pixel"] += link_->de ? 1 : 0;
        }
        if (following_ && link_->de) take_pixel();
        if (following_ && was_de_ && !link_->de) end_line();
        if (link_->vsync && !was_vsync_) end_frame();
        was_de_ = link_->de;
        was_vsync_ = link_->vsync;
    }
    void reset() override {
        following_ = was_de_ = was_vsync_ = false;
        pair_ = Pair::kNone;
        rows_.clear();
        bench_.happened["a reset behind an event"] += event_due_ == DecoderEvent{} ? 0 : 1;
        event_due_ = {};
        pixel_due_ = {};
    }
    void check_counts() const { CHECK(dut().rejected_frames() == rejected_); }

  private:
    enum class Pair : std::uint8_t { kNone, kOpen, kWhole };

    // ---- the stimulus ----

    void push(const std::optional<std::uint32_t>& pixel) {
        Random& random = bench_.random;
        DviLink link = script_.empty() ? link_.value() : script_.back();
        link.de = pixel.has_value();
        if (pixel) link.data = *pixel;
        if (!pixel && random.one_in(6)) link.data = static_cast<std::uint32_t>(random.bits() & 0xFF'FFFFU);
        if (random.one_in(16)) link.hsync = !link.hsync;
        link.vsync = vsync_left_-- > 0;
        script_.push_back(link);
    }
    void blank(int clocks) {
        while (clocks-- > 0) push(std::nullopt);
    }
    /// The next frame of a good pair, most of the time.
    void add_frame() {
        constexpr std::array<std::uint32_t, 4> kCorners{0, 1, 0x8000'0000U, 0xFFFF'FFFFU};
        Random& random = bench_.random;
        if (!random.one_in(8)) {
            sent_kind_ = sent_kind_ == FrameKind::kColour ? FrameKind::kDepth : FrameKind::kColour;
            if (sent_kind_ == FrameKind::kColour) ++sent_number_;
        }
        if (sent_kind_ == FrameKind::kColour && random.one_in(8)) sent_number_ = one_of(random, kCorners);
        const int shift = random.one_in(6) ? random.between(-1, 1) : 0;
        control_ =
            any_control_line(random, width_, sent_kind_, sent_number_ + static_cast<std::uint32_t>(shift));
        int lines = lines_;
        if (random.one_in(12)) lines = random.between(0, lines_ + 1);
        const int odd_line = random.one_in(12) ? random.between(0, lines_ - 1) : -1;
        for (int line = 0; line < lines; ++line) {
            std::vector<std::uint32_t> pixels = control_.pixels;
            if (line > 0) {
                for (auto& pixel : pixels) pixel = static_cast<std::uint32_t>(random.bits() & 0xFF'FFFFU);
            }
            if (line == odd_line) pixels.resize(pixels.size() + (random.one_in(2) ? 1 : -1));
            blank(random.between(1, random.one_in(3) ? 30 : 4));
            for (const std::uint32_t pixel : pixels) push(pixel);
        }
        if (vsync_left_ > 0) blank(vsync_left_ + 1);
        if (random.one_in(3)) blank(random.between(1, 20));
        if (!random.one_in(20)) vsync_left_ = random.one_in(8) ? 4 * width_ : random.between(1, 12);
        blank(1);
    }

    // ---- the reference ----

    void reject(RejectCause cause) {
        following_ = false;
        ++rejected_.at(static_cast<std::size_t>(cause));
        bench_.happened["rejected for cause " + std::to_string(static_cast<int>(cause))] += 1;
        event_due_.rejected = true;
        event_due_.cause = cause;
        if (pair_ == Pair::kOpen) lose(number_);
        pair_ = Pair::kNone;
    }
    void lose(std::uint32_t number) {
        event_due_.pair_lost = true;
        event_due_.lost_number = number;
    }
    void take_pixel() {
        if (x_ == width_ || line_ == lines_) {
            reject(RejectCause::kGeometry);
            return;
        }
        if (line_ == 0) {
            control_seen_.push_back(link_->data);
            if (pair_ == Pair::kOpen) pass_payload();
        } else {
            pixel_due_ = {true, kind_, static_cast<std::uint32_t>((line_ - 1) * width_ + x_), link_->data};
        }
        ++x_;
    }
    /// By the counts as they stand in the line, which may be wrong.
    void pass_payload() {
        const auto byte = [this](int offset) {
            return static_cast<int>(
                control_seen_[static_cast<std::size_t>(offset / 3)] >> (16 - 8 * (offset % 3)) & 0xFFU);
        };
        for (int offset = 3 * x_; offset < 3 * x_ + 3; ++offset) {
            if (offset < 18) continue;
            const int length_at = 16 + 16 * (byte(6) + 256 * byte(7));
            const int first = length_at + 2;
            if (offset < first || offset >= first + byte(length_at) + 256 * byte(length_at + 1)) continue;
            event_due_.payload.at(event_due_.payload_bytes++) = static_cast<std::uint8_t>(byte(offset));
            bench_.happened["payload behind more than 255 rows"] += length_at > 256 * 16 ? 1 : 0;
            bench_.happened["payload behind its byte 255"] += offset >= first + 256 ? 1 : 0;
        }
    }
    void end_line() {
        if (x_ != width_) {
            reject(RejectCause::kGeometry);
            return;
        }
        if (line_ == 0) judge_control_line();
        x_ = 0;
        ++line_;
    }
    void judge_control_line() {
        // Another line of the frame, where a reset or a missing VSYNC makes it the first, has no magic.
        const bool control = control_seen_ == control_.pixels;
        if (!control || control_.defect) {
            reject(control ? *control_.defect : RejectCause::kMagic);
            return;
        }
        kind_ = control_.content.kind;
        const std::uint32_t number = control_.content.frame_number;
        const bool same = number == number_;
        if (kind_ == FrameKind::kColour) {
            if (pair_ == Pair::kOpen) {
                reject(RejectCause::kPair);
                if (same) {  // the colour frame is sent again
                    event_due_.pair_lost = false;
                    event_due_.lost_number = 0;
                }
                following_ = true;
            }
            pair_ = Pair::kOpen;
            number_ = event_due_.number = number;
            event_due_.colour_start = true;
            rows_.assign(control_.content.table.begin(), control_.content.table.end());
            return;
        }
        switch (std::exchange(pair_, same && pair_ == Pair::kOpen ? Pair::kOpen : Pair::kNone)) {
            case Pair::kNone:  // its colour frame was rejected or never seen
                following_ = false;
                lose(number);
                bench_.happened["a depth frame alone"] += 1;
                break;
            case Pair::kOpen:
                if (same) break;
                reject(RejectCause::kPair);
                lose(number - number_ < 0x8000'0000U ? number_ : number);  // the earlier one
                break;
            case Pair::kWhole:
                reject(RejectCause::kPair);
                if (!same) lose(number);
                bench_.happened["a depth frame sent again"] += same ? 1 : 0;
                break;
        }
    }
    void end_frame() {
        if (following_ && line_ > 0) {
            if (line_ < lines_) {
                reject(RejectCause::kGeometry);
            } else if (kind_ == FrameKind::kDepth) {
                event_due_.pair_good = true;
                event_due_.number = number_;
                pair_ = Pair::kWhole;
                bench_.happened["a good pair"] += 1;
            }
        }
        following_ = true;
        x_ = line_ = 0;
        control_seen_.clear();
    }

    int width_, lines_;
    Input<DviLink>& link_ = in(&DviDecoder::link_i);
    Output<DecodedPixel>& pixel_ = out(&DviDecoder::pixel_o);
    Output<DecoderEvent>& event_ = out(&DviDecoder::event_o);
    // The link.
    std::deque<DviLink> script_;
    ControlLine control_;  ///< of the frame under way
    FrameKind sent_kind_ = FrameKind::kDepth;
    std::uint32_t sent_number_ = 0;
    int vsync_left_ = 0;  ///< clocks
    // What the decoder knows of it.
    bool following_ = false;  ///< the frame under way: a VSYNC has been seen, and nothing wrong since
    bool was_de_ = false, was_vsync_ = false;
    int x_ = 0, line_ = 0;
    std::vector<std::uint32_t> control_seen_;
    FrameKind kind_ = FrameKind::kColour;
    Pair pair_ = Pair::kNone;
    std::uint32_t number_ = 0;  ///< of the pair
    std::deque<ViewportRow> rows_;
    DecoderEvent event_due_;
    DecodedPixel pixel_due_;
    std::array<std::int64_t, kRejectCauseCount> rejected_{};
};

TEST_CASE("dvi decoder: in lockstep with its reference") {
    LockstepBench bench(3301);
    const Decoder narrow(bench, "narrow", 20, 3);
    const Decoder wide(bench, "wide", 1500, 2);  // room for more than 255 rows
    bench.clocks_to_reset = 300;
    bench.run(120'000);
    bench.clocks_to_reset = 40'000;
    bench.run(300'000, {{"a good pair", 100},
                        {"a reset behind an event", 3},
                        {"a row beside a pixel", 20},
                        {"payload behind more than 255 rows", 1},
                        {"payload behind its byte 255", 20},
                        {"a depth frame alone", 20},
                        {"a depth frame sent again", 2},
                        {"rejected for cause 0", 8},
                        {"rejected for cause 1", 8},
                        {"rejected for cause 2", 8},
                        {"rejected for cause 3", 8},
                        {"rejected for cause 4", 8},
                        {"rejected for cause 5", 8}});
    narrow.check_counts();
    wide.check_counts();
}

}  // namespace
}  // namespace metabuffer::test::dvi_decoder_test

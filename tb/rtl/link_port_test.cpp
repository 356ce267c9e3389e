#include "rtl/link_port.h"

#include <catch2/catch.hpp>
#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <vector>

#include "dvi_waveform.h"
#include "lockstep/lockstep.h"
#include "support/scenarios.h"

// PairKeeper's unit tests check which pair is answered when, in every order of events. The input framebuffer's tests
// check what the core sees of it at its pins. These tests check the port's own pins, at the link's clock.
namespace metabuffer::test::link_port_test {
namespace {

using rtl::DecodedPixel;
using rtl::DecoderEvent;
using rtl::LinkPort;
using rtl::MemoryWrite;

constexpr int kPairClocks = 2 * frame_clocks(1, 2);
constexpr int kTimeoutClocks = 2 * kPairClocks + kSyncLines * line_clocks(1);

Scenario port_scenario(Pacing pacing, DepthFormat format) {
    Scenario scenario = with_renderer(small_scenario(64, 64), renderer_of({PixelImage(1, 1)}));
    scenario.pacing = pacing;
    scenario.depth_format = format;
    scenario.link_timeout_pairs = 2;
    return scenario;
}

/// What each port has recorded, with clock gating and without.
struct Records {
    std::deque<std::vector<std::uint32_t>> accepted;
    std::deque<int> dropped;
};

/// A port between a decoder, which tells of pairs good and lost, and a bus side, which asks again when it is answered.
class Port final : private Records, public Lockstep<LinkPort> {
  public:
    Port(LockstepBench& bench, const char* name, const Scenario& scenario)
        : Lockstep(bench, name,
                   [this, &scenario](const char* dut, rtl::ClockGating) {
                       std::vector<std::uint32_t>& pairs = accepted.emplace_back();
                       int& count = dropped.emplace_back(0);
                       return std::make_unique<LinkPort>(
                           dut, scenario, scenario.renderers.front(),
                           LinkPort::Records{[&pairs](std::uint32_t pair) { pairs.push_back(pair); },
                                             [&count](int more) { count += more; }});
                   }),
          scenario_(scenario) {}

    void stimulate() override {
        const FrameSource& source = dut().front_source();
        // A pixel that wakes the port comes half a clock behind an edge here.
        const bool right =
            source.pair == source_.pair && source.last_pixel_picoseconds / kPeriodPicoseconds ==
                                               source_.last_pixel_picoseconds / kPeriodPicoseconds;
        wrong_records_ += right ? 0 : 1;
        Random& random = bench_.random;
        if (random.one_in(6000)) silent_clocks_ = random.between(1, 3 * kTimeoutClocks);
        const bool silent = --silent_clocks_ > 0 || bench_.pausing();
        if (!silent && random.one_in(3)) {
            pixel_ = {random.one_in(2), random.one_in(2) ? FrameKind::kColour : FrameKind::kDepth,
                      static_cast<std::uint32_t>(random.between(0, 15)),
                      static_cast<std::uint32_t>(random.bits() & 0xFF'FFFFU)};
        } else if (pixel_->valid && (silent || random.one_in(3))) {
            pixel_ = DecodedPixel{};
        }
        event_ = !silent && random.one_in(40) ? next_event() : DecoderEvent{};
        if (bench_.in_reset()) {
            request_ = false;
        } else if (!asked_ && !request_on_its_way() && random.one_in(silent ? 15 : 30)) {
            request_ = !request_;
        }
    }
    void expect() override {
        pair_request_ = pair_request_due_;
        answer_ = answer_due_;
        fresh_ = fresh_due_;
        front_ = front_due_;
        write_ = write_due_;
    }
    void edge() override {
        const int now = bench_.clock();
        write_due_ = pixel_->valid ? written() : MemoryWrite{};
        if (pixel_->valid) {
            ++pixels_;
            // It was on the link at the edge before.
            last_pixel_picoseconds_ = (now + 1) * kPeriodPicoseconds;
        }
        take_event(now);
        // A question is seen behind two registers.
        if (stable_ != captured_) asked_ = true;
        stable_ = captured_;
        captured_ = request_;
        if (asked_) {
            if (const std::optional<bool> fresh = answer(now)) give(*fresh, now);
        }
        pair_request_due_ = back_ != Back::kWhole;
    }
    void reset() override {
        captured_ = stable_ = asked_ = false;
        pair_request_due_ = answer_due_ = fresh_due_ = front_due_ = front_valid_ = overwritten_ = false;
        write_due_ = {};
        back_ = Back::kFree;
        lost_.reset();
        wanted_ = announced_ = 0;
        waits_since_ = bench_.clock();
        source_ = {};
    }
    void check_records() const {
        CHECK(wrong_records_ == 0);
        for (const auto& pairs : accepted) CHECK(pairs == accepted_due_);
        for (const int count : dropped) CHECK(count == dropped_due_);
        CHECK(dut().link_pixels() == pixels_);
    }

  private:
    static constexpr std::int64_t kPeriodPicoseconds = 10'000;
    enum class Back : std::uint8_t { kFree, kFilling, kWhole };

    // ---- the stimulus ----

    bool request_on_its_way() const { return captured_ != request_ || stable_ != captured_; }
    DecoderEvent next_event() {
        Random& random = bench_.random;
        DecoderEvent event;
        if (filling() && !random.one_in(4)) {
            event.pair_good = random.one_in(2);
            event.rejected = !event.pair_good;
        } else {
            // The wanted pair, most of the time, and others near to it.
            announced_ = wanted_ + static_cast<std::uint32_t>(random.one_in(3) ? random.between(-1, 2) : 0);
            event.colour_start = !random.one_in(6);
            event.rejected = random.one_in(6);
            event.pair_lost = !event.colour_start;
        }
        event.pair_lost = event.pair_lost || (event.rejected && random.one_in(2));
        event.number = event.lost_number = announced_;
        return event;
    }
    bool filling() const { return back_ == Back::kFilling; }

    // ---- the reference ----

    MemoryWrite written() const {
        MemoryWrite write{true, static_cast<std::uint8_t>(front_due_ ? 0 : 1), pixel_->address, pixel_->data,
                          0x07};
        if (pixel_->kind == FrameKind::kColour) return write;
        const std::uint64_t link = pixel_->data;
        const bool z24 = scenario_.depth_format == DepthFormat::kZ24;
        const std::uint64_t alpha = z24 ? 0xFF : link >> 16;
        const std::uint64_t z = z24 ? link : link & 0xFFFF;
        write.data = z << 32 | alpha << 24;
        write.byte_mask = 0xF8;
        return write;
    }
    void take_event(int now) {
        if (event_->rejected && filling()) back_ = Back::kFree;
        if (event_->pair_lost) lost_ = event_->lost_number;
        if (event_->colour_start) {
            if (back_ == Back::kWhole) {
                ++dropped_due_;
                overwritten_ = true;
            }
            back_ = Back::kFilling;
            filling_since_ = now;
        }
        if (!event_->pair_good) return;
        if (scenario_.pacing == Pacing::kLockstep && event_->number - wanted_ >= 0x8000'0000U) {  // too late
            ++dropped_due_;
            back_ = Back::kFree;
            waits_since_ = now;
            return;
        }
        back_ = Back::kWhole;
        back_number_ = event_->number;
        accepted_due_.push_back(back_number_);
    }
    /// Whether it is fresh; nothing while the bus side has to wait.
    std::optional<bool> answer(int now) const {
        const bool coming = filling() && now < filling_since_ + kPairClocks;
        const bool timeout = now >= waits_since_ + kTimeoutClocks && !coming;
        if (scenario_.pacing == Pacing::kLockstep) {
            if (back_ == Back::kWhole) return back_number_ == wanted_;
            return timeout || lost_ == wanted_ ? std::optional(false) : std::nullopt;
        }
        if (back_ == Back::kWhole) return true;
        if (overwritten_ && coming) return std::nullopt;
        return timeout || front_valid_ ? std::optional(false) : std::nullopt;
    }
    void give(bool fresh, int now) {
        bench_.happened[fresh ? "a fresh pair" : "the front pair again"] += 1;
        bench_.happened["an answer at the timeout"] += now == waits_since_ + kTimeoutClocks ? 1 : 0;
        asked_ = false;
        answer_due_ = !answer_due_;
        fresh_due_ = fresh;
        waits_since_ = now;
        ++wanted_;
        if (!fresh) return;
        front_due_ = !front_due_;
        front_valid_ = true;
        overwritten_ = false;
        back_ = Back::kFree;
        source_.pair = static_cast<int>(back_number_);
        source_.last_pixel_picoseconds = last_pixel_picoseconds_;
    }

    const Scenario& scenario_;
    Input<DecodedPixel>& pixel_ = in(&LinkPort::pixel_i);
    Input<DecoderEvent>& event_ = in(&LinkPort::event_i);
    Input<bool>& request_ = in(&LinkPort::request_i);
    Output<bool>& pair_request_ = out(&LinkPort::pair_request_o);
    Output<bool>& answer_ = out(&LinkPort::answer_o);
    Output<bool>& fresh_ = out(&LinkPort::fresh_o);
    Output<bool>& front_ = out(&LinkPort::front_o);
    Output<MemoryWrite>& write_ = out(&LinkPort::write_o);
    int silent_clocks_ = 0;
    std::uint32_t announced_ = 0;  ///< the pair that the decoder reports
    // The reference's registers.
    bool captured_ = false, stable_ = false;  ///< the question on its way
    bool asked_ = false;
    bool pair_request_due_ = false, answer_due_ = false, fresh_due_ = false, front_due_ = false;
    MemoryWrite write_due_;
    Back back_ = Back::kFree;
    std::uint32_t back_number_ = 0, wanted_ = 0;
    std::optional<std::uint32_t> lost_;
    bool front_valid_ = false;
    bool overwritten_ = false;  ///< a whole pair that is newer than the front one
    int filling_since_ = 0, waits_since_ = 0;
    // What it records.
    FrameSource source_;
    std::int64_t last_pixel_picoseconds_ = 0, pixels_ = 0;
    std::vector<std::uint32_t> accepted_due_;
    int dropped_due_ = 0, wrong_records_ = 0;
};

TEST_CASE("link port: in lockstep with its reference") {
    LockstepBench bench(3310);
    const Scenario asked = port_scenario(Pacing::kLockstep, DepthFormat::kA8Z16);
    const Scenario free = port_scenario(Pacing::kFreeRunning, DepthFormat::kZ24);
    const Port asked_port(bench, "asked", asked);
    const Port free_port(bench, "free", free);
    bench.clocks_to_reset = 500;
    bench.run(30'000);
    bench.clocks_to_reset = 20'000;
    bench.run(200'000,
              {{"a fresh pair", 200}, {"the front pair again", 100}, {"an answer at the timeout", 3}});
    asked_port.check_records();
    free_port.check_records();
}

}  // namespace
}  // namespace metabuffer::test::link_port_test

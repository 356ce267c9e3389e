#include "rtl/tmds_decoder.h"

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <string>
#include <vector>

#include "clocked_testbench.h"
#include "lockstep/lockstep.h"
#include "lockstep/waveform_case.h"
#include "support/tmds_flow_chart.h"

namespace metabuffer::test::tmds_decoder_test {
namespace {

using rtl::DviLink;
using rtl::TmdsDecoder;
using rtl::TmdsLink;

/// By the two bits that they carry, C1 the higher.
constexpr std::array<TmdsCharacter, 4> kControls{0b1101010100, 0b0010101011, 0b0101010100, 0b1010101011};
constexpr int kMostSkew = 4;

bool is_control(TmdsCharacter character) {
    return std::find(kControls.begin(), kControls.end(), character) != kControls.end();
}

/// A channel of the link: what an encoder sends, some bits late.
class Wire {
  public:
    void send(const DviLink& link, unsigned channel) {
        TmdsCharacter character = kControls[0];
        if (link.de) {
            chart_.encode(link.data >> (8 * channel) & 0xFFU);
            character = chart_.character();
        } else {
            chart_.cnt = 0;
            if (channel == 0) character = kControls.at((link.hsync ? 1U : 0U) + (link.vsync ? 2U : 0U));
        }
        for (unsigned i = 0; i < 10; ++i) bits_.push_back((character >> i & 1U) != 0);
        bits_.erase(bits_.begin(), bits_.begin() + 10);
    }
    TmdsCharacter word(int late_bits) const {
        unsigned word = 0;
        const std::size_t first = bits_.size() - 10 - static_cast<std::size_t>(late_bits);
        for (unsigned i = 0; i < 10; ++i) word |= (bits_.at(first + i) ? 1U : 0U) << i;
        return static_cast<TmdsCharacter>(word);
    }

  private:
    TmdsFlowChart chart_;
    std::deque<bool> bits_ = std::deque<bool>(60);
};

/// What a decoder knows of a channel: where its characters begin, and its lines.
struct Channel {
    std::deque<bool> bits;  ///< of the last two words
    unsigned tried = 0;     ///< bit of a word
    int run = 0;            ///< control characters in a row from there
    bool found = false;
    unsigned begin = 0;
    int pause = 0;           ///< control characters in a row
    int line_start = -1000;  ///< clock of the last one
    int measured = 0, skew = 0;
    std::deque<TmdsCharacter> characters;  ///< the last five, the oldest first

    Channel() : characters(1 + kMostSkew, kControls[0]) { add(kControls[0]); }
    void add(TmdsCharacter word) {
        for (unsigned i = 0; i < 10; ++i) bits.push_back((word >> i & 1U) != 0);
        if (bits.size() > 20) bits.erase(bits.begin(), bits.begin() + 10);
    }
    TmdsCharacter character_at(unsigned first) const {
        unsigned character = 0;
        for (unsigned i = 0; i < 10; ++i) character |= (bits.at(first + i) ? 1U : 0U) << i;
        return static_cast<TmdsCharacter>(character);
    }
    void take(TmdsCharacter word, int clock) {
        add(word);
        // Another phase is tried with each word, and kept while it gives control characters.
        if (is_control(character_at(tried))) {
            ++run;
        } else {
            tried = (tried + 1) % 10;
            run = 0;
        }
        if (run >= 12) {
            found = true;
            begin = tried;
        }
        const TmdsCharacter character = character_at(begin);
        characters.push_back(character);
        characters.pop_front();
        if (is_control(character)) {
            ++pause;
        } else {
            if (pause >= 8) line_start = clock;
            pause = 0;
        }
    }
    TmdsCharacter in_step() const { return characters.at(static_cast<std::size_t>(skew)); }
};

/// A link on which characters come late, by bits and by channels, and are wrong now and then.
class Decoder final : public Lockstep<TmdsDecoder> {
  public:
    explicit Decoder(LockstepBench& bench)
        : Lockstep(bench, "tmds_decoder",
                   [](const char* dut, rtl::ClockGating) { return std::make_unique<TmdsDecoder>(dut); }) {}

    void stimulate() override {
        wrong_reports_ += dut().waiting_for() == (found() ? "" : kReport) ? 0 : 1;
        Random& random = bench_.random;
        if (bench_.pausing() && !sent_.de) {
            if (random.one_in(40)) sent_.hsync = !sent_.hsync;
        } else {
            send_next();
        }
        if (random.one_in(1500)) late_bits_.at(any_channel()) = random.between(0, 49);
        if (random.one_in(4000)) late_bits_ = {0, 0, 0};
        if (random.one_in(3000)) noise_left_ = random.between(1, 200);
        if (noise_left_ == 0) noisy_ = any_channel();
        noise_left_ = std::max(noise_left_ - 1, 0);
        TmdsLink tmds;
        for (unsigned channel = 0; channel < 3; ++channel) {
            wires_.at(channel).send(sent_, channel);
            tmds.channels.at(channel) = wires_.at(channel).word(late_bits_.at(channel));
        }
        TmdsCharacter& noisy = tmds.channels.at(noisy_);
        if (noise_left_ > 0) noisy = static_cast<TmdsCharacter>(random.between(0, 0x3FF));
        if (random.one_in(150))
            noisy ^= static_cast<TmdsCharacter>(1U << static_cast<unsigned>(random.between(0, 9)));
        if (random.one_in(300)) noisy = kControls.at(static_cast<std::size_t>(random.between(0, 3)));
        tmds_ = tmds;
        history_.push_front(sent_);
        if (history_.size() > 20) history_.pop_back();
    }
    void expect() override { link_ = due_; }
    void edge() override {
        for (std::size_t i = 0; i < 3; ++i) channels_.at(i).take(tmds_->channels.at(i), bench_.clock());
        measure_skew();
        due_ = found() ? decoded() : DviLink{};
        const int earliest = *std::min_element(late_bits_.begin(), late_bits_.end()) / 10;
        const bool right = due_.de && due_ == history_.at(static_cast<std::size_t>(earliest) + 5);
        const bool in_step =
            late_bits_[0] / 10 == late_bits_[1] / 10 && late_bits_[1] / 10 == late_bits_[2] / 10;
        bench_.happened["a right pixel of channels out of step"] += right && !in_step ? 1 : 0;
        bench_.happened["a wrong pixel"] += due_.de && !right ? 1 : 0;
    }
    void reset() override {
        channels_ = {};
        due_ = {};
    }
    void check_reports() const { CHECK(wrong_reports_ == 0); }

  private:
    static constexpr const char* kReport = "waits for control characters on every channel";

    std::size_t any_channel() { return static_cast<std::size_t>(bench_.random.between(0, 2)); }
    /// Lines and pauses of any length, some of them shorter than the eight characters that a line counts behind.
    void send_next() {
        Random& random = bench_.random;
        if (left_ == 0) {
            sent_.de = !sent_.de;
            left_ = sent_.de ? random.between(1, 12)
                             : random.between(random.one_in(4) ? 1 : 8, random.one_in(3) ? 40 : 10);
        }
        --left_;
        sent_.data = sent_.de ? static_cast<std::uint32_t>(random.bits() & 0xFF'FFFFU) : 0;
        if (!sent_.de && random.one_in(8)) sent_.hsync = !sent_.hsync;
        if (!sent_.de && random.one_in(20)) sent_.vsync = !sent_.vsync;
    }
    bool found() const { return channels_[0].found && channels_[1].found && channels_[2].found; }
    /// As the line of the channel that comes first began four clocks ago, and those of the others since.
    void measure_skew() {
        int first = bench_.clock();
        for (const Channel& channel : channels_) first = std::min(first, channel.line_start);
        if (first != bench_.clock() - kMostSkew) return;
        bool again = true;
        for (Channel& channel : channels_) {
            again = again && channel.measured == channel.line_start - first;
            channel.measured = channel.line_start - first;
        }
        if (!again) return;  // a single line may be wrong
        for (Channel& channel : channels_) {
            bench_.happened["a new skew"] += channel.skew != channel.measured ? 1 : 0;
            channel.skew = channel.measured;
        }
    }
    DviLink decoded() const {
        DviLink link = due_;
        int controls = 0;
        link.data = 0;
        for (std::size_t i = 0; i < 3; ++i) {
            const TmdsCharacter character = channels_.at(i).in_step();
            controls += is_control(character) ? 1 : 0;
            link.data |= tmds_byte(character) << (8 * i);
        }
        link.de = controls < 2;
        if (link.de) return link;
        link.data = 0;
        const TmdsCharacter blue = channels_[0].in_step();
        if (!is_control(blue)) return link;
        link.hsync = blue == kControls[1] || blue == kControls[3];
        link.vsync = blue == kControls[2] || blue == kControls[3];
        return link;
    }

    Input<TmdsLink>& tmds_ = in(&TmdsDecoder::tmds_i);
    Output<DviLink>& link_ = out(&TmdsDecoder::link_o);
    // The link.
    DviLink sent_;
    int left_ = 20;  ///< clocks of the line or the pause
    std::array<Wire, 3> wires_;
    std::array<int, 3> late_bits_{};
    std::size_t noisy_ = 0;                                  ///< channel
    int noise_left_ = 0;                                     ///< clocks
    std::deque<DviLink> history_ = std::deque<DviLink>(20);  ///< what was sent, the newest first
    // What the decoder makes of it.
    std::array<Channel, 3> channels_;
    DviLink due_;
    int wrong_reports_ = 0;
};

TEST_CASE("tmds decoder: in lockstep with its reference") {
    LockstepBench bench(3306);
    bench.clocks_to_reset = 150;
    const Decoder decoder(bench);
    bench.run(10'000);
    bench.clocks_to_reset = 3000;
    bench.run(40'000,
              {{"a right pixel of channels out of step", 2000}, {"a wrong pixel", 1000}, {"a new skew", 30}});
    decoder.check_reports();
}

// ---- timing ----

/// The characters of a byte at the beginning of a line.
TmdsCharacter first_character(unsigned byte) {
    TmdsFlowChart chart;
    chart.encode(byte);
    return chart.character();
}

constexpr std::uint32_t kPixel = 0xA1'B2'C3;

/// Lines of one pixel, of which green comes a character later: `x` has blue and red, `y` green. `p` is the pixel, `w` the
/// pixel with a green byte that is none.
struct SkewedCase {
    LockstepBench bench;
    WaveformCase<TmdsDecoder> dut{bench, "tmds_decoder", [](const char* name, rtl::ClockGating) {
                                      return std::make_unique<TmdsDecoder>(name);
                                  }};

    void run(const std::string& tmds, const std::string& link) {
        TmdsLink ahead, behind;
        ahead.channels = {first_character(0xC3), kControls[0], first_character(0xA1)};
        behind.channels = {kControls[0], first_character(0xB2), kControls[0]};
        const DviLink wrong{0xA1'00'C3 | tmds_byte(kControls[0]) << 8U, true, false, false};
        dut.drive(tmds, &TmdsDecoder::tmds_i, {{'x', ahead}, {'y', behind}});
        dut.check(link, &TmdsDecoder::link_o, {{'p', {kPixel, true, false, false}}, {'w', wrong}});
        dut.run();
    }
};

// clang-format off
TEST_CASE("tmds decoder: timing: characters on the wire of the channel that comes first to pixel on the link") {
    SkewedCase().run("............xy........xy........xy........",
                     "?????????????????????????????????.....p.??");
}
TEST_CASE("tmds decoder: timing: a new skew to its removal") {
    SkewedCase().run("............xy........xy........xy........",
                     "..................w.........p.........p...");
}
// clang-format on

TEST_CASE("tmds decoder: timing: beginning of a pause to the beginning of characters found") {
    constexpr int kBefore = 7;  // words of a line
    ClockedTestbench bench;
    struct Receiver {
        sc_core::sc_signal<TmdsLink> tmds;
        sc_core::sc_signal<DviLink> link;
        TmdsDecoder decoder{sc_core::sc_gen_unique_name("decoder")};
        std::vector<TmdsCharacter> words;
        int known_from = 0;  ///< the first edge that knows where characters begin
    };
    std::deque<Receiver> receivers;
    // With another beginning of the characters in each, any number of phases is tried before the right one.
    for (unsigned late_bits = 0; late_bits < 10; ++late_bits) {
        Receiver& receiver = receivers.emplace_back();
        receiver.decoder.clk_i(bench.core.clk);
        receiver.decoder.reset_i(bench.reset);
        receiver.decoder.tmds_i(receiver.tmds);
        receiver.decoder.link_o(receiver.link);
        std::vector<TmdsCharacter> stream(kBefore, first_character(0x55));
        stream.resize(100, kControls[0]);
        receiver.words = late_words(stream, late_bits);
        bench.core.each_clock([&receiver](int clock) {
            if (!receiver.decoder.waiting_for().empty()) receiver.known_from = clock + 1;
            const TmdsCharacter word = receiver.words.at(static_cast<std::size_t>(clock));
            receiver.tmds.write({{word, word, word}});
        });
    }
    bench.run_through(90);
    int latest = 0;
    for (const Receiver& receiver : receivers) latest = std::max(latest, receiver.known_from);
    CHECK(latest == kBefore + 22);
}

}  // namespace
}  // namespace metabuffer::test::tmds_decoder_test

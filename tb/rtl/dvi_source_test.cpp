#include "rtl/dvi_source.h"

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "dvi_waveform.h"
#include "lockstep/lockstep.h"
#include "support/images.h"
#include "support/scenarios.h"

namespace metabuffer::test::dvi_source_test {
namespace {

using rtl::DviLink;
using rtl::DviSource;

constexpr int kWidth = 12;  // room for a control scanline with one row
constexpr int kHeight = 3;
constexpr int kFirstSync = kSyncLines * line_clocks(kWidth);
constexpr int kFrame = frame_clocks(kWidth, kHeight + 1);

/// A scenario of three frames, shown over and over at the end, with faults of every kind.
class FaultyScenario {
  public:
    explicit FaultyScenario(Random& random) : random_(random) {}

    Scenario make(Pacing pacing, DepthFormat format) {
        Scenario scenario = small_scenario(8, 8);
        scenario.pacing = pacing;
        scenario.depth_format = format;
        scenario.links.layer = LinkLayer::kTmds;
        scenario.frames = 5;
        std::vector<PixelImage> images(3);
        for (PixelImage& image : images) image = noise_image(random_, kWidth, kHeight, far_z(format));
        Renderer renderer = renderer_of(images);
        for (RendererFrame& frame : renderer.frames) {
            frame.table = {random_valid_row(random_, {8, 8}, 3)};
            frame.slots = {1};
        }
        scenario.renderers.push_back(renderer);
        constexpr std::uint32_t kPairs = 5;
        for (std::uint32_t pair = 0; pair < kPairs; ++pair) {
            for (const FrameKind frame : {FrameKind::kColour, FrameKind::kDepth}) {
                add_faults(scenario.faults, pair, frame);
            }
        }
        return scenario;
    }

  private:
    void add_faults(std::vector<Fault>& faults, std::uint32_t pair, FrameKind frame) {
        constexpr std::array kOfFrame{FaultKind::kMagic,       FaultKind::kVersion,   FaultKind::kCrc,
                                      FaultKind::kKind,        FaultKind::kNumber,    FaultKind::kOtherPair,
                                      FaultKind::kControlByte, FaultKind::kShortLine, FaultKind::kLongLine,
                                      FaultKind::kShortFrame,  FaultKind::kLongFrame, FaultKind::kPixelBits,
                                      FaultKind::kMissing};
        constexpr std::array kOfCharacters{FaultKind::kTmdsBits, FaultKind::kTmdsSlip, FaultKind::kTmdsSkew};
        Fault fault;
        fault.pair = pair;
        fault.frame = frame;
        const auto add = [&](FaultKind kind, int most_bits = 0) {
            fault.kind = kind;
            if (most_bits > 0) fault.bits = static_cast<std::uint32_t>(random_.between(1, most_bits));
            faults.push_back(fault);
        };
        if (frame == FrameKind::kColour && random_.one_in(3)) {
            fault.ppm = random_.between(-300, 300);
            add(FaultKind::kDrift);
        }
        if (!random_.one_in(3)) {
            const FaultKind kind = kOfFrame.at(of_frame_++ % kOfFrame.size());
            fault.lines = random_.between(1, kHeight);
            fault.byte = random_.between(0, 3 * kWidth - 1);
            fault.x = random_.between(0, kWidth - 1);
            fault.y = random_.between(0, kHeight - 1);
            add(kind, kind == FaultKind::kControlByte ? 0xFF : 0xFF'FFFF);
            if (kind == FaultKind::kMissing) return;
        }
        if (random_.one_in(4)) add(FaultKind::kRepeated);
        fault.delay_pairs = random_.between(1, 2);
        if (random_.one_in(5)) add(FaultKind::kDelay);
        for (int count = random_.between(0, 2); count > 0; --count) {
            fault.channel = static_cast<TmdsChannel>(random_.between(0, 2));
            fault.at_line = random_.between(0, kFrame / line_clocks(kWidth) - 1);
            fault.at_clock = random_.between(0, line_clocks(kWidth) - 1);
            if (random_.one_in(3)) {  // the frame's last one
                fault.at_line = kFrame / line_clocks(kWidth) - 1;
                fault.at_clock = line_clocks(kWidth) - 1;
            }
            fault.late_bits = random_.between(0, 9);
            fault.late_characters = random_.between(0, kMostTmdsSkew);
            add(kOfCharacters.at(of_characters_++ % kOfCharacters.size()), 0x3FF);
        }
    }

    Random& random_;
    std::size_t of_frame_ = 0, of_characters_ = 0;
};

/// A renderer's link by the scenario: what is sent is made frame by frame, as whole waveforms.
class Source final : public Lockstep<DviSource> {
  public:
    Source(LockstepBench& bench, const char* name, const Scenario& scenario)
        : Lockstep(bench, name,
                   [&scenario](const char* dut, rtl::ClockGating) {
                       return std::make_unique<DviSource>(dut, scenario, 0);
                   }),
          scenario_(scenario) {
        wires_.add(request_, 1000);
    }

    void stimulate() override { wires_.stimulate(bench_); }
    void expect() override {
        link_ = link_due_;
        clock_ppm_ = ppm_due_;
        disturbance_ = disturbance_due_;
    }
    void edge() override {
        disturbance_due_.flips.fill(0);
        link_due_ = {};
        if (first_sync_left_ > 0) {
            --first_sync_left_;
            link_due_.vsync = true;
            return;
        }
        while (at_ == part_.clocks.size()) {
            if (parts_.empty() && !begin_pair()) {
                ++idle_clocks_;
                return;
            }
            part_ = std::move(parts_.front());
            parts_.pop_front();
            at_ = 0;
            injected_ += part_.faults;
        }
        for (const Fault& fault : part_.of_characters) {
            if (static_cast<int>(at_) == fault.at_line * line_clocks(kWidth) + fault.at_clock) {
                disturb(fault);
            }
        }
        link_due_ = part_.clocks[at_++];
    }
    void reset() override {
        first_sync_left_ = kFirstSync;
        part_ = {};
        parts_.clear();
        at_ = 0;
        next_pair_ = 0;
        link_due_ = {};
        ppm_due_ = 0;
        disturbance_due_ = {};
    }
    void check_counts() const { CHECK(dut().injected_faults() == injected_); }

  private:
    /// A frame or a silence; none if the frame is missing.
    struct Part {
        Waveform clocks;
        int faults = 0;
        std::vector<Fault> of_characters;
    };

    bool begin_pair() {
        if (scenario_.pacing == Pacing::kLockstep &&
            (!request_ || next_pair_ == static_cast<std::uint32_t>(scenario_.frames))) {
            return false;
        }
        constexpr int kIdleEdges = rtl::Clocked::kIdleEdges;
        bench_.happened["a pair after a sleep"] += std::exchange(idle_clocks_, 0) > kIdleEdges ? 1 : 0;
        const std::uint32_t pair = next_pair_++;
        for (const FrameKind kind : {FrameKind::kColour, FrameKind::kDepth}) add_frame(pair, kind);
        return true;
    }
    void add_frame(std::uint32_t pair, FrameKind kind) {
        const bool colour = kind == FrameKind::kColour;
        const Renderer& renderer = scenario_.renderers.front();
        Part part;
        int sendings = 1;
        int delay_pairs = 0;
        const Fault* of_frame = nullptr;
        for (const Fault& fault : scenario_.faults) {
            if (fault.pair != pair || fault.frame != kind) continue;
            bench_.happened["fault of kind " + std::to_string(static_cast<int>(fault.kind))] += 1;
            switch (fault.kind) {
                case FaultKind::kDrift:
                    ppm_due_ = fault.ppm;
                    ++injected_;
                    break;
                case FaultKind::kDelay:
                    delay_pairs = fault.delay_pairs;
                    break;
                case FaultKind::kRepeated:
                    sendings = 2;
                    break;
                case FaultKind::kTmdsBits:
                case FaultKind::kTmdsSlip:
                case FaultKind::kTmdsSkew:
                    part.of_characters.push_back(fault);
                    break;
                default:
                    of_frame = &fault;
                    part.faults = 1;
                    break;
            }
        }
        const auto has = [of_frame](FaultKind one) { return of_frame != nullptr && of_frame->kind == one; };
        if (delay_pairs > 0) {
            parts_.push_back({Waveform(static_cast<std::size_t>(2 * kFrame * delay_pairs)), 1, {}});
        }
        if (!has(FaultKind::kMissing)) {
            const std::uint32_t shown = pair + (has(FaultKind::kOtherPair) ? 1 : 0);
            const RendererFrame& frame = renderer.frames.at(std::min<std::uint32_t>(shown, 2));
            LinkLines lines =
                image_lines(renderer.images.at(frame.image)->pixels(), kind, scenario_.depth_format);
            lines.insert(lines.begin(),
                         control_line(kWidth, has(FaultKind::kKind) ? static_cast<FrameKind>(2) : kind,
                                      shown + (has(FaultKind::kNumber) ? 1 : 0),
                                      colour ? frame.table : ViewportTable{},
                                      colour ? std::vector<std::uint8_t>{} : kOneSlotOfRow0));
            if (of_frame != nullptr) corrupt(lines, *of_frame);
            append_frame(part.clocks, kWidth, lines);
        }
        parts_.push_back(part);
        part.faults = 1;
        if (sendings > 1) parts_.push_back(part);
    }
    static void corrupt(LinkLines& lines, const Fault& fault) {
        const auto flip = [&lines](int byte, std::uint32_t bits) {
            lines.front().at(static_cast<std::size_t>(byte / 3)) ^= bits << (16 - 8 * (byte % 3));
        };
        const auto fault_lines = static_cast<std::size_t>(fault.lines);
        switch (fault.kind) {
            case FaultKind::kMagic:
                return flip(0, 0xFF);
            case FaultKind::kVersion:
                return flip(4, 0xFF);
            case FaultKind::kCrc:
                return flip(12, 0xFF);
            case FaultKind::kControlByte:
                return flip(fault.byte, fault.bits);
            case FaultKind::kShortLine:
                return lines.back().pop_back();
            case FaultKind::kLongLine:
                return lines.back().push_back(0);
            case FaultKind::kShortFrame:
                return lines.resize(lines.size() - fault_lines);
            case FaultKind::kLongFrame:
                return lines.resize(lines.size() + fault_lines,
                                    std::vector<std::uint32_t>(std::size_t{kWidth}));
            case FaultKind::kPixelBits:
                lines.at(static_cast<std::size_t>(fault.y) + 1).at(static_cast<std::size_t>(fault.x)) ^=
                    fault.bits;
                return;
            default:
                return;
        }
    }
    void disturb(const Fault& fault) {
        const auto channel = static_cast<std::size_t>(fault.channel);
        ++injected_;
        if (fault.kind == FaultKind::kTmdsBits) {
            disturbance_due_.flips.at(channel) = static_cast<TmdsCharacter>(fault.bits);
        } else if (fault.kind == FaultKind::kTmdsSlip) {
            disturbance_due_.late_bits.at(channel) = static_cast<std::uint8_t>(fault.late_bits);
        } else {
            disturbance_due_.late_characters.at(channel) = static_cast<std::uint8_t>(fault.late_characters);
        }
    }

    static inline const std::vector<std::uint8_t> kOneSlotOfRow0{'S', 1, 1, 0, 0};
    const Scenario& scenario_;
    Input<bool>& request_ = in(&DviSource::pair_request_i);
    Output<DviLink>& link_ = out(&DviSource::link_o);
    Output<int>& clock_ppm_ = out(&DviSource::clock_ppm_o);
    Output<TmdsDisturbance>& disturbance_ = out(&DviSource::disturbance_o);
    FreeWires wires_;
    int first_sync_left_ = kFirstSync;  ///< clocks
    Part part_;                         ///< under way
    std::size_t at_ = 0;                ///< clock of it that comes next
    std::deque<Part> parts_;            ///< the rest of the pair
    std::uint32_t next_pair_ = 0;
    int idle_clocks_ = 0;
    DviLink link_due_;
    int ppm_due_ = 0;
    TmdsDisturbance disturbance_due_;
    std::int64_t injected_ = 0;
};

TEST_CASE("dvi source: in lockstep with its reference") {
    LockstepBench bench(3302);
    bench.clocks_to_reset = 5000;
    FaultyScenario faulty(bench.random);
    std::vector<Scenario> scenarios;
    for (const Pacing pacing : {Pacing::kLockstep, Pacing::kFreeRunning}) {
        scenarios.push_back(faulty.make(pacing, DepthFormat::kA8Z16));
        scenarios.push_back(faulty.make(pacing, DepthFormat::kZ24));
    }
    const Source asked(bench, "asked", scenarios[0]);
    const Source asked_z24(bench, "asked_z24", scenarios[1]);
    const Source free(bench, "free", scenarios[2]);
    const Source free_z24(bench, "free_z24", scenarios[3]);
    std::map<std::string, std::int64_t> least{{"a pair after a sleep", 4}};
    for (int kind = 0; kind <= static_cast<int>(FaultKind::kTmdsSkew); ++kind) {
        const bool on_link =
            kind <= static_cast<int>(FaultKind::kDrift) || kind >= static_cast<int>(FaultKind::kTmdsBits);
        if (on_link) least["fault of kind " + std::to_string(kind)] = 1;
    }
    bench.run(40'000);
    bench.clocks_to_reset = 30'000;
    bench.run(200'000, least);
    for (const Source* const source : {&asked, &asked_z24, &free, &free_z24}) source->check_counts();
}

}  // namespace
}  // namespace metabuffer::test::dvi_source_test

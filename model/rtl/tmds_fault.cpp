#include "rtl/tmds_fault.h"

#include <utility>

#include "rtl/mixed_bits.h"

namespace metabuffer::rtl {

TmdsFault::TmdsFault(const sc_core::sc_module_name& name, const Scenario& scenario,
                     std::vector<std::size_t> noise, FaultTally& tally)
    : Block(name),
      scenario_(scenario),
      noise_(std::move(noise)),
      tally_(tally),
      core_period_picoseconds_(clock_period_picoseconds(scenario.clocks.core_mhz)) {
    SC_METHOD(clock_edge);
    sensitive << clk_i.port().pos();
    dont_initialize();
    SC_METHOD(follow);
    sensitive << tmds_i << clocked_;
}

/// The encoder samples a pixel at the edge at which this block samples what goes wrong with it.
void TmdsFault::clock_edge() {
    ++edge_;
    if (reset_i.read()) {
        registers_.reset();
    } else {
        before_.shift(disturbed());
        TmdsDisturbance disturbance = disturbance_i.read();
        for (const std::size_t fault : noise_) {
            if (!scenario_.faults[fault].lasts_at(clock_edge_number(core_period_picoseconds_))) {
                continue;
            }
            for (std::size_t channel = 0; channel < kTmdsChannels; ++channel) {
                const TmdsCharacter flips = noise_of(fault, channel);
                disturbance.flips[channel] ^= flips;
                if (flips != 0) {
                    tally_.add(fault);
                }
            }
        }
        disturbance_ = disturbance;
    }
    clocked_.notify(sc_core::SC_ZERO_TIME);
}

TmdsCharacter TmdsFault::noise_of(std::size_t fault, std::size_t channel) const {
    constexpr std::uint64_t kBillion = 1'000'000'000;
    const Fault& cause = scenario_.faults[fault];
    std::uint64_t word = mixed_bits(cause.seed);
    word = mixed_bits(word ^ static_cast<std::uint64_t>(cause.renderer));
    word = mixed_bits(word ^ channel);
    word = mixed_bits(word ^ static_cast<std::uint64_t>(edge_));
    unsigned flips = 0;
    for (unsigned bit = 0; bit < unsigned{kTmdsCharacterBits}; ++bit) {
        word = mixed_bits(word);
        if (word % kBillion < static_cast<std::uint64_t>(cause.per_billion)) {
            flips |= 1U << bit;
        }
    }
    return static_cast<TmdsCharacter>(flips);
}

/// The encoder's characters as they leave, before any of them comes late.
TmdsLink TmdsFault::disturbed() const {
    TmdsLink tmds = tmds_i.read();
    for (std::size_t channel = 0; channel < kTmdsChannels; ++channel) {
        tmds.channels[channel] ^= disturbance_.value().flips[channel];
    }
    return tmds;
}

void TmdsFault::follow() {
    const TmdsDisturbance& disturbance = disturbance_;
    const TmdsLink now = disturbed();
    TmdsLink tmds;
    for (std::size_t channel = 0; channel < kTmdsChannels; ++channel) {
        const int late = disturbance.late_characters[channel];
        const TmdsCharacter word = late == 0 ? now.channels[channel] : before_.stage(late).channels[channel];
        const TmdsCharacter word_before = before_.stage(late + 1).channels[channel];
        tmds.channels[channel] =
            tmds_character(word_before, word, unsigned{kTmdsCharacterBits} - disturbance.late_bits[channel]);
    }
    tmds_o.write(tmds);
}

void TmdsFault::trace(sc_core::sc_trace_file* file) const {
    sc_trace(file, tmds_i.read(), path("TMDS_in"));
    sc_trace(file, tmds_o.read(), path("TMDS"));
    registers_.trace(file, path(""));
}

}  // namespace metabuffer::rtl

#include "rtl/tmds_encoder.h"

#include <array>
#include <catch2/catch.hpp>
#include <cstdint>
#include <memory>

#include "lockstep/lockstep.h"
#include "lockstep/waveform_case.h"
#include "support/tmds_flow_chart.h"

namespace metabuffer::test::tmds_encoder_test {
namespace {

using rtl::DviLink;
using rtl::TmdsEncoder;
using rtl::TmdsLink;

constexpr TmdsCharacter kControl = 0b1101010100;  ///< with both of its bits 0

/// The three channels by DVI's flow chart.
class Encoder final : public Lockstep<TmdsEncoder> {
  public:
    explicit Encoder(LockstepBench& bench)
        : Lockstep(bench, "tmds_encoder",
                   [](const char* dut, rtl::ClockGating) { return std::make_unique<TmdsEncoder>(dut); }) {}

    /// Lines and pauses of any length.
    void stimulate() override {
        Random& random = bench_.random;
        DviLink link = link_;
        if (!bench_.pausing() || link.de) link.de = link.de ? !random.one_in(10) : random.one_in(10);
        if (link.de || random.one_in(20)) link.data = static_cast<std::uint32_t>(random.bits() & 0xFF'FFFFU);
        if (random.one_in(20)) link.hsync = !link.hsync;
        if (random.one_in(40)) link.vsync = !link.vsync;
        link_ = link;
    }
    void expect() override { tmds_ = due_; }
    void edge() override {
        for (unsigned channel = 0; channel < 3; ++channel) {
            TmdsFlowChart& chart = charts_.at(channel);
            if (link_->de) {
                chart.encode(link_->data >> (8 * channel) & 0xFFU);
                due_.channels.at(channel) = chart.character();
            } else {
                chart.cnt = 0;
                due_.channels.at(channel) = kControl;
            }
        }
        if (link_->de) return;
        if (link_->vsync) {
            due_.channels[0] = link_->hsync ? 0b1010101011 : 0b0101010100;
        } else if (link_->hsync) {
            due_.channels[0] = 0b0010101011;
        }
    }
    void reset() override {
        charts_ = {};
        due_.channels = {kControl, kControl, kControl};
    }

  private:
    Input<DviLink>& link_ = in(&TmdsEncoder::link_i);
    Output<TmdsLink>& tmds_ = out(&TmdsEncoder::tmds_o);
    std::array<TmdsFlowChart, 3> charts_;
    TmdsLink due_;
};

TEST_CASE("tmds encoder: in lockstep with its reference") {
    LockstepBench bench(3307);
    const Encoder encoder(bench);
    bench.run(20'000);
}

TEST_CASE("tmds encoder: timing: pixel on the link to its characters on the wire") {
    LockstepBench bench;
    WaveformCase<TmdsEncoder> dut(bench, "tmds_encoder", [](const char* name, rtl::ClockGating) {
        return std::make_unique<TmdsEncoder>(name);
    });
    TmdsFlowChart blue;
    blue.encode(0x5A);
    TmdsFlowChart others;
    others.encode(0);
    dut.drive("..a..", &TmdsEncoder::link_i, {{'a', {0x5A, true, false, false}}});
    dut.check("...A.", &TmdsEncoder::tmds_o,
              {{'A', {{blue.character(), others.character(), others.character()}}}});
    dut.run();
}

}  // namespace
}  // namespace metabuffer::test::tmds_encoder_test

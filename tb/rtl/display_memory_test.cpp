#include "rtl/display_memory.h"

#include <catch2/catch.hpp>
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <utility>

#include "expected_report.h"
#include "lockstep/lockstep.h"
#include "lockstep/waveform_case.h"

namespace metabuffer::test::display_memory_test {
namespace {

using rtl::DisplayMemory;
using rtl::DisplayRead;
using rtl::DisplayWrite;

constexpr std::uint32_t kPixels = 12;

Lockstep<DisplayMemory>::Factory memory_with(sc_core::sc_clock& dvi_clock, rtl::GatedClock& gated_dvi_clock) {
    return [&](const char* name, rtl::ClockGating gating) {
        auto memory = std::make_unique<DisplayMemory>(name, kPixels);
        if (gating == rtl::ClockGating::kOn) {
            memory->dvi_clk_i(gated_dvi_clock);
        } else {
            memory->dvi_clk_i(dvi_clock);
        }
        return memory;
    };
}

/// The memory as a map. The inputs change half a core clock before an edge of it, and the DVI clock has edges at any time
/// from there to the next change.
struct GatedDviClock {
    rtl::GatedClock gated_dvi_clock_{sc_core::sc_gen_unique_name("gated_dvi_clock")};
};
class Memory final : GatedDviClock, public Lockstep<DisplayMemory> {
  public:
    Memory(LockstepBench& bench, sc_core::sc_clock& dvi_clock)
        : Lockstep(bench, std::string(dvi_clock.basename()) + "_memory",
                   memory_with(dvi_clock, gated_dvi_clock_)),
          dvi_clock_(dvi_clock) {
        gated_dvi_clock_.clk_i(dvi_clock);
    }

    void stimulate() override {
        // An edge at this very time samples what stands now, for it changes after it.
        read_before(sc_core::sc_time_stamp() + sc_core::sc_get_time_resolution());
        in_reset_ = bench_.in_reset();
        Random& random = bench_.random;
        const auto comes = [&](bool came) {
            if (bench_.pausing()) return random.one_in(20);
            return random.one_in(4) ? !came : came;
        };
        writes_ = comes(writes_);
        reads_ = comes(reads_);
        if (random.one_in(3)) write_ = DisplayWrite{random.one_in(2), address(), colour()};
        if (random.one_in(3)) read_ = DisplayRead{random.one_in(2), address()};
        if (random.one_in(5)) read_ = DisplayRead{write_->picture, write_->address};
    }
    void expect() override {
        read_before(sc_core::sc_time_stamp());
        data_ = data_due_;
    }
    void edge() override {
        if (writes_) pixels_[{write_->picture, write_->address}] = write_->colour;
    }
    void reset() override { edge(); }

  private:
    std::uint32_t address() const {
        return static_cast<std::uint32_t>(bench_.random.between(0, kPixels - 1));
    }
    std::uint32_t colour() const { return static_cast<std::uint32_t>(bench_.random.bits()) & 0xFF'FFFFU; }
    /// The DVI clock's edges before then, which all sample what stands now.
    void read_before(const sc_core::sc_time& end) {
        for (; next_edge_ < end; next_edge_ += dvi_clock_.period()) {
            const bool comes =
                writes_ && write_->picture == read_->picture && write_->address == read_->address;
            if (in_reset_) {
                data_due_ = 0;
            } else if (reads_) {
                data_due_ = comes ? write_->colour : pixels_[{read_->picture, read_->address}];
                bench_.happened["a pixel was read as it came"] += comes ? 1 : 0;
            }
        }
    }

    sc_core::sc_clock& dvi_clock_;
    Input<bool>& writes_ = in(&DisplayMemory::writes_i);
    Input<DisplayWrite>& write_ = in(&DisplayMemory::write_i);
    Input<bool>& reads_ = in(&DisplayMemory::reads_i);
    Input<DisplayRead>& read_ = in(&DisplayMemory::read_i);
    Output<std::uint32_t>& data_ = out(&DisplayMemory::data_o);
    bool in_reset_ = true;
    std::map<std::pair<bool, std::uint32_t>, std::uint32_t> pixels_;  ///< by picture and address
    std::uint32_t data_due_ = 0;
    sc_core::sc_time next_edge_;
};

TEST_CASE("display memory: in lockstep with a map at any ratio of the clocks") {
    LockstepBench bench(2209);
    sc_core::sc_clock faster("faster", sc_core::sc_time(1.6, sc_core::SC_NS));
    sc_core::sc_clock nearly("nearly", sc_core::sc_time(10.016, sc_core::SC_NS));
    sc_core::sc_clock slower("slower", sc_core::sc_time(33.3, sc_core::SC_NS));
    const Memory at_the_core_clock(bench, bench.clk);
    const Memory of_faster(bench, faster);
    const Memory of_nearly(bench, nearly);
    const Memory of_slower(bench, slower);
    bench.run(20'000, {{"a pixel was read as it came", 1000}, {LockstepBench::kAsleep, 100}});
}

TEST_CASE("display memory: a write to or a read of an address that it has not is reported at its edge") {
    const ExpectedReport report("/metabuffer/display_memory/address");
    LockstepBench bench;
    WaveformCase<DisplayMemory> dut(bench, "memory", memory_with(bench.clk, bench.gated_clk));
    dut.drive("_--____", &DisplayMemory::writes_i);
    dut.drive(".lx....", &DisplayMemory::write_i,
              {{'l', {false, kPixels - 1, 0}}, {'x', {true, kPixels, 0}}});
    dut.drive("____--_", &DisplayMemory::reads_i);
    dut.drive("....lx.", &DisplayMemory::read_i, {{'l', {true, kPixels - 1}}, {'x', {false, kPixels}}});
    dut.leave(&DisplayMemory::data_o);
    for (const auto& [clocks, reports] : {std::pair{2, 0}, {3, 1}, {5, 1}, {6, 2}, {7, 2}}) {
        bench.run(clocks);
        CHECK(report.count() == 2 * reports);  // there are two of each
    }
}

}  // namespace
}  // namespace metabuffer::test::display_memory_test

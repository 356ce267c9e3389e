#include "rtl/bus_registers.h"

#include <catch2/catch.hpp>
#include <cstddef>
#include <deque>
#include <memory>
#include <string>
#include <vector>

#include "lockstep/lockstep.h"
#include "lockstep/waveform_case.h"

namespace metabuffer::test::bus_registers_test {
namespace {

using rtl::BusBeat;
using rtl::BusRegisters;

constexpr std::size_t kComposers = 2;

/// Everything comes out as it went in, so many clocks later.
class Registers final : public Lockstep<BusRegisters> {
  public:
    Registers(LockstepBench& bench, const std::string& name, int stages)
        : Lockstep(bench, name,
                   [stages](const char* dut, rtl::ClockGating) {
                       return std::make_unique<BusRegisters>(dut, stages, kComposers);
                   }),
          stages_(static_cast<std::size_t>(stages)) {
        for (std::size_t i = 0; i < kComposers; ++i) {
            add(in(&BusRegisters::busready_i, i), out(&BusRegisters::busready_o, i));
            add(in(&BusRegisters::tableready_i, i), out(&BusRegisters::tableready_o, i));
        }
        reset();
    }

    void stimulate() override {
        constexpr int kClocksToBeat = 3;
        constexpr int kClocksToLoneBeat = 30;
        wires_.stimulate(bench_);
        BusBeat beat;
        if (bench_.random.one_in(bench_.pausing() ? kClocksToLoneBeat : kClocksToBeat)) {
            beat.kind = BusBeat::Kind::kPixels;
            beat.words[0] = bench_.random.bits();
        }
        bus_in_ = beat;
    }
    void expect() override {
        bus_out_ = beats_.front();
        for (Wire& wire : ready_) *wire.out = wire.values.front();
    }
    void edge() override {
        beats_.push_back(bus_in_);
        beats_.pop_front();
        for (Wire& wire : ready_) {
            wire.values.push_back(*wire.in);
            wire.values.pop_front();
        }
        bench_.happened["a beat"] += bus_in_->kind == BusBeat::Kind::kNone ? 0 : 1;
    }
    void reset() override {
        beats_.assign(stages_, BusBeat{});
        for (Wire& wire : ready_) wire.values.assign(stages_, false);
    }

  private:
    struct Wire {
        Input<bool>* in;
        Output<bool>* out;
        std::deque<bool> values;
    };
    void add(Input<bool>& from, Output<bool>& to) {
        constexpr int kClocksToChange = 4;
        ready_.push_back({&from, &to, {}});
        wires_.add(from, kClocksToChange);
    }

    std::size_t stages_;
    Input<BusBeat>& bus_in_ = in(&BusRegisters::bus_i);
    Output<BusBeat>& bus_out_ = out(&BusRegisters::bus_o);
    std::vector<Wire> ready_;
    std::deque<BusBeat> beats_;
    FreeWires wires_;
};

TEST_CASE("bus registers: in lockstep with its reference") {
    LockstepBench bench(3307);
    const Registers one(bench, "one", 1);
    const Registers four(bench, "four", 4);
    bench.run(20'000, {{"a beat", 1000}});
}

TEST_CASE("bus registers: timing: a beat on its way to the composers BUSREADY TABLEREADY on their way back") {
    LockstepBench bench;
    WaveformCase<BusRegisters> dut(bench, "three", [](const char* name, rtl::ClockGating) {
        return std::make_unique<BusRegisters>(name, 3, 1);
    });
    BusBeat beat;
    beat.kind = BusBeat::Kind::kPixels;
    dut.drive("..A.....", &BusRegisters::bus_i, {{'A', beat}});
    dut.check(".....A..", &BusRegisters::bus_o, {{'A', beat}});
    dut.drive("__-_____", &BusRegisters::busready_i, 0);
    dut.check("_____-__", &BusRegisters::busready_o, 0);
    dut.drive("___--___", &BusRegisters::tableready_i, 0);
    dut.check("______--", &BusRegisters::tableready_o, 0);
    dut.run();
}

}  // namespace
}  // namespace metabuffer::test::bus_registers_test

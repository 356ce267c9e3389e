#pragma once

#include <algorithm>
#include <catch2/catch.hpp>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "formats/control_scanline.h"
#include "machine_run.h"
#include "monitors/swap_lock_monitor.h"
#include "monitors/violation.h"
#include "rtl/metabuffer.h"
#include "rtl/wires.h"
#include "rule_table.h"
#include "scenario/scenario_loader.h"
#include "support/scenarios.h"

namespace metabuffer::test {

constexpr std::int64_t kPeriodPicoseconds = 10'000;  ///< of all clocks

constexpr int kAlteredFrames = 3;
constexpr int kAlteredWidth = 8;
constexpr int kAlteredHeight = 6;

/// Two displays, and two renderers that cover the first one. All pixels of renderer 1 are at Z = 50; every other pixel
/// of renderer 2 is nearer. Each pair has its own image, without black pixels.
inline Scenario altered_scenario() {
    Scenario scenario = small_scenario(kAlteredWidth, kAlteredHeight, 2);
    scenario.frames = kAlteredFrames;
    for (int r = 0; r < 2; ++r) {
        std::vector<PixelImage> images;
        for (int pair = 0; pair < kAlteredFrames; ++pair) {
            PixelImage image(24, kAlteredHeight);  // wide enough for the control scanline
            for (int i = 0; i < static_cast<int>(image.values.size()); ++i) {
                const std::uint32_t z = r == 0 ? 50 : 40 + 20 * (i % 2);
                image.values[static_cast<std::size_t>(i)] =
                    Pixel(static_cast<std::uint8_t>(10 + 100 * r), static_cast<std::uint8_t>(1 + pair),
                          static_cast<std::uint8_t>(1 + i), 255, z);
            }
            images.push_back(image);
        }
        Renderer renderer =
            renderer_of(images, {table_row(1, {0, 0}, {kAlteredWidth, kAlteredHeight}, {0, 0}),
                                 table_row(2, {8, 0}, {kAlteredWidth, kAlteredHeight}, {0, 0})});
        renderer.name = r == 0 ? "plane" : "comb";
        scenario.renderers.push_back(renderer);
    }
    check_scenario(scenario);
    return scenario;
}

/// A machine of which several rows of a table alter the wires.
struct WatchedMachine {
    Scenario scenario;
    rtl::Metabuffer machine;

    WatchedMachine(const std::string& name, const Scenario& of)
        : scenario(of), machine(name.c_str(), scenario) {}
};

/// The bench of a row: a second set of a machine's wires, to which monitors bind instead. At each falling edge of the
/// clock it copies the machine's wires. A row may then change one of them, so that a run by the rules shows one mistake.
/// All clocks of the machine must be equal.
class AlteredBench : public RuleBench {
  public:
    /// edge: the rising edge that will sample what is written.
    using Alter = std::function<void(std::int64_t edge, rtl::Wires& real)>;

    AlteredBench(const sc_core::sc_module_name& name, WatchedMachine& watched)
        : RuleBench(name),
          scenario(watched.scenario),
          machine(watched.machine),
          wires(scenario.renderers.size(), static_cast<std::size_t>(scenario.displays.count())) {
        SC_METHOD(copy);
        sensitive << machine.core_clk().negedge_event();
        dont_initialize();
    }
    SC_HAS_PROCESS(AlteredBench);
    std::int64_t clock_zero() const override { return edge; }
    void bind_swap_lock(monitors::SwapLockMonitor& monitor) {
        monitor.clk_i(machine.core_clk());
        monitor.dvi_clk_i(machine.dvi_out_clk());
        monitor.reset_i(machine.reset());
        monitor.swaplock_i(wires.swaplock);
        monitor.swapskip_i(wires.swapskip);
        for (std::size_t d = 0; d < monitor.link_i.size(); ++d) {
            monitor.framedone_i[d](wires.framedone[d]);
            monitor.framebad_i[d](wires.framebad[d]);
            monitor.link_i[d](wires.link_out[d]);
        }
    }

    const Scenario& scenario;
    rtl::Metabuffer& machine;
    rtl::Wires wires;
    Alter alter;
    std::int64_t edge = -1;  ///< the first that samples an alteration

  private:
    template <typename Bank>
    void copy(Bank rtl::Wires::*bank) {
        Bank& from = machine.wires().*bank;
        for (std::size_t i = 0; i < from.size(); ++i) (wires.*bank)[i].write(from[i].read());
    }
    void copy() {
        rtl::Wires& real = machine.wires();
        copy(&rtl::Wires::link_in);
        copy(&rtl::Wires::event);
        copy(&rtl::Wires::bus);
        copy(&rtl::Wires::pipe);
        copy(&rtl::Wires::column_stall);
        copy(&rtl::Wires::framedone);
        copy(&rtl::Wires::framebad);
        copy(&rtl::Wires::link_out);
        wires.swaplock.write(real.swaplock.read());
        wires.swapskip.write(real.swapskip.read());
        const auto now = static_cast<std::int64_t>(sc_core::sc_time_stamp().value());
        if (alter) alter(now / kPeriodPicoseconds + 1, real);
    }
};

template <typename Bench>
class AlteredRuleTable : public RuleTable<Bench> {
  public:
    /// The benches of the rows from here on share a machine.
    template <typename... Args>
    void of(const Scenario& scenario, const Args&... args) {
        machines_.push_back(
            std::make_unique<WatchedMachine>("machine_" + std::to_string(machines_.size()), scenario));
        RuleTable<Bench>::of(std::ref(*machines_.back()), args...);
    }
    void run_and_check() {
        REQUIRE(simulate_until([this] {
            return std::all_of(machines_.begin(), machines_.end(),
                               [](const auto& watched) { return watched->machine.finished(); });
        }));
        this->check();
    }

  private:
    std::vector<std::unique_ptr<WatchedMachine>> machines_;
};

/// The position in a DVI link's frame, from its signals: clocks and lines since VSYNC fell last.
class LinkPosition {
  public:
    explicit LinkPosition(const DviTiming& timing) : timing_(timing) {}

    /// Call once a clock. False before the first frame.
    bool step(const rtl::DviLink& link) {
        if (vsync_ && !link.vsync) {
            clock_ = 0;
            ++frame_;
        } else if (clock_ >= 0) {
            ++clock_;
        }
        vsync_ = link.vsync;
        return clock_ >= 0;
    }
    int frame() const { return frame_; }  ///< from 0
    int x() const { return static_cast<int>(clock_ % timing_.line_clocks()); }
    int line() const { return static_cast<int>(clock_ / timing_.line_clocks()); }

  private:
    DviTiming timing_;
    bool vsync_ = false;
    std::int64_t clock_ = -1;
    int frame_ = -1;
};

}  // namespace metabuffer::test

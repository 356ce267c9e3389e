#pragma once

#include <catch2/catch.hpp>
#include <cstdint>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "formats/control_scanline.h"
#include "machine_run.h"
#include "monitors/violation.h"
#include "rtl/metabuffer.h"
#include "rtl/wires.h"
#include "scenario/scenario_loader.h"
#include "support/scenarios.h"

namespace metabuffer::test {

constexpr std::int64_t kPeriodPicoseconds = 10'000;  ///< of all clocks

/// A second set of a machine's wires, to which monitors bind instead. At each falling edge of the clock it copies the
/// machine's wires. A test may then change one of them, so that a legal run shows one mistake. All clocks of the
/// machine must be equal.
class AlteredWires final : public sc_core::sc_module {
  public:
    /// edge: the rising edge that will sample what is written.
    using Alter = std::function<void(std::int64_t edge, rtl::Wires& wires)>;

    AlteredWires(const sc_core::sc_module_name& name, rtl::Metabuffer& machine, std::size_t renderers,
                 std::size_t displays)
        : sc_core::sc_module(name), wires(renderers, displays), real_(machine.wires()) {
        SC_METHOD(copy);
        sensitive << machine.core_clk().negedge_event();
        dont_initialize();
    }
    SC_HAS_PROCESS(AlteredWires);

    rtl::Wires wires;
    Alter alter;

  private:
    template <typename Bank>
    static void copy_bank(Bank& from, Bank& to) {
        for (std::size_t i = 0; i < from.size(); ++i) to[i].write(from[i].read());
    }
    void copy() {
        copy_bank(real_.link_in, wires.link_in);
        copy_bank(real_.event, wires.event);
        copy_bank(real_.bus, wires.bus);
        copy_bank(real_.pipe, wires.pipe);
        copy_bank(real_.column_stall, wires.column_stall);
        copy_bank(real_.framedone, wires.framedone);
        copy_bank(real_.framebad, wires.framebad);
        copy_bank(real_.link_out, wires.link_out);
        wires.swaplock.write(real_.swaplock.read());
        wires.swapskip.write(real_.swapskip.read());
        if (!alter) return;
        const auto now = static_cast<std::int64_t>(sc_core::sc_time_stamp().value());
        alter(now / kPeriodPicoseconds + 1, real_);
    }

    rtl::Wires& real_;
};

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

/// A machine whose wires a test alters before monitors see them, and what these report.
class AlteredMachine {
  public:
    explicit AlteredMachine(Scenario scenario)
        : scenario_(std::move(scenario)),
          machine("machine", scenario_),
          altered("altered", machine, scenario_.renderers.size(),
                  static_cast<std::size_t>(scenario_.displays.count())) {
        log.on_violation([this](const monitors::Violation& violation) { violations.push_back(violation); });
    }

    const Scenario& scenario() const { return scenario_; }
    rtl::Wires& wires() { return altered.wires; }
    void run() {
        REQUIRE(simulate_until([this] { return machine.finished(); }));
    }
    /// The first violation is this one.
    void check_first(const std::string& rule, const std::string& signal, const std::string& clock,
                     std::int64_t cycle, std::int64_t frame) const {
        std::string text;
        for (const monitors::Violation& violation : violations) text += to_string(violation) + "\n";
        INFO(text);
        REQUIRE_FALSE(violations.empty());
        CHECK(violations[0].rule == rule);
        CHECK(violations[0].signal == signal);
        CHECK(violations[0].clock == clock);
        CHECK(violations[0].cycle == cycle);
        CHECK(violations[0].frame == frame);
        CHECK_FALSE(violations[0].detail.empty());
    }

  private:
    Scenario scenario_;

  public:
    rtl::Metabuffer machine;
    AlteredWires altered;
    monitors::ViolationLog log;
    std::vector<monitors::Violation> violations;
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

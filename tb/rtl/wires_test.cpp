#include "rtl/wires.h"

#include <catch2/catch.hpp>
#include <set>
#include <string>

#include "rtl/metabuffer.h"
#include "support/images.h"
#include "support/scenarios.h"

namespace metabuffer::test::wires_test {
namespace {

using rtl::Wires;

constexpr std::size_t kRenderers = 2;
constexpr std::size_t kDisplays = 3;

TEST_CASE(
    "wires: a composer sees its renderer's bus until it gets its own, and the others keep the renderer's") {
    Wires wires(kRenderers, kDisplays);
    for (std::size_t i = 0; i < kRenderers * kDisplays; ++i) {
        CHECK(&wires.bus_seen_by(i) == &wires.bus[i / kDisplays]);
    }
    const std::size_t composer = 1 * kDisplays + 1;  // of renderer 2 and display 2
    sc_core::sc_signal<rtl::BusBeat>& own = wires.own_bus(composer);
    CHECK(&wires.own_bus(composer) == &own);
    for (std::size_t i = 0; i < kRenderers * kDisplays; ++i) {
        INFO("composer " << i);
        CHECK(&wires.bus_seen_by(i) == (i == composer ? &own : &wires.bus[i / kDisplays]));
    }
    sc_core::sc_signal<rtl::BusBeat>& neighbour = wires.own_bus(composer + 1);
    CHECK(&neighbour != &own);
    CHECK(&wires.own_bus(composer) == &own);
}

TEST_CASE("wires: an input framebuffer has its composers' bus") {
    Wires direct(kRenderers, kDisplays);
    CHECK(&direct.bus_driven(1) == &direct.bus[1]);
    CHECK(&direct.busready_read(4) == &direct.busready[4]);
    CHECK(&direct.tableready_read(4) == &direct.tableready[4]);
}

TEST_CASE("wires: with registers between, an input framebuffer has a bus of its own") {
    Wires registered(kRenderers, kDisplays, true);
    std::set<const void*> distinct;
    for (std::size_t i = 0; i < kRenderers * kDisplays; ++i) {
        distinct.insert({&registered.busready[i], &registered.busready_read(i), &registered.tableready[i],
                         &registered.tableready_read(i)});
    }
    for (std::size_t r = 0; r < kRenderers; ++r) {
        distinct.insert({&registered.bus[r], &registered.bus_driven(r)});
    }
    CHECK(distinct.size() == 4 * kRenderers * kDisplays + 2 * kRenderers);
}

TEST_CASE("wires: with a single renderer too, the bus before the registers is not the one behind them") {
    Wires registered(1, 1, true);
    const std::set<const void*> distinct{&registered.bus[0],        &registered.bus_driven(0),
                                         &registered.busready[0],   &registered.busready_read(0),
                                         &registered.tableready[0], &registered.tableready_read(0)};
    CHECK(distinct.size() == 6);
}

TEST_CASE("wires: asking for a composer's FIFO gives the wires of that composer and of no other") {
    Scenario scenario = small_scenario(8, 4, 3);
    for (int r = 0; r < 2; ++r) add_renderer(scenario, renderer_of({PixelImage(8, 4)}));
    rtl::Metabuffer machine("machine", scenario);
    for (std::size_t r = 0; r < kRenderers; ++r) {
        for (std::size_t d = 0; d < kDisplays; ++d) {
            const std::string composer =
                "machine.composer_" + std::to_string(r + 1) + "_" + std::to_string(d + 1);
            rtl::FifoWires* const wires = machine.fifo_wires(r, d);
            REQUIRE(wires != nullptr);
            CHECK(wires->free.name() == composer + ".fifo_free");
        }
    }
}

TEST_CASE("wires: each is named by its renderer and display counted from 1") {
    Wires wires(kRenderers, kDisplays);
    CHECK(std::string(wires.bus[1].name()) == "BUS_2");
    CHECK(std::string(wires.busready[kDisplays + 2].name()) == "BUSREADY_2_3");
    CHECK(std::string(wires.pipe[2 * kDisplays].name()) == "PIPE_3_1");
    CHECK(std::string(wires.framedone[2].name()) == "FRAMEDONE_3");
    CHECK(std::string(wires.own_bus(kDisplays + 2).name()) == "BUS_2_3");
    CHECK(std::string(wires.own_bus(2).name()) == "BUS_1_3");
    std::set<const void*> distinct;
    for (std::size_t i = 0; i < wires.pipe.size(); ++i) distinct.insert(&wires.pipe[i]);
    CHECK(distinct.size() == (kRenderers + 1) * kDisplays);
}

}  // namespace
}  // namespace metabuffer::test::wires_test

#include "report/machine_cost.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string>

#include "report/report.h"
#include "report/synthesis_table.h"
#include "support/scenarios.h"

namespace metabuffer {
namespace {

/// Two renderers of 40 x 30 and 20 x 10 pixels on three displays of 100 x 80.
Scenario machine() {
    Scenario scenario = test::small_scenario(100, 80, 3);
    scenario.bus.width_bits = 128;
    scenario.composer.buffer_pixels = 1000;
    test::add_renderer(scenario, test::renderer_of({PixelImage(40, 30)}));
    test::add_renderer(scenario, test::renderer_of({PixelImage(20, 10)}));
    return scenario;
}

/// The composer of a row of the tables of synthesis.
template <typename Row>
void set_composer(Scenario& scenario, const Row& row) {
    scenario.composer.buffer_pixels = row.buffer_pixels;
    scenario.bus.width_bits = row.bus_bits;
    scenario.composer.smoothing = row.window_rows > 1 ? Smoothing::kBilinear : Smoothing::kReplicate;
}

TEST_CASE("machine cost: bits, wires, pins and tables by the machine's shape") {
    const MachineCost cost = machine_cost(machine());
    CHECK(cost.buffer_bits == 6 * 1000 * 64);
    CHECK(cost.input_framebuffer_bits == 2 * (40 * 30 + 20 * 10) * 64);
    CHECK(cost.output_framebuffer_bits == 3 * 2 * 100 * 80 * 24);
    CHECK(cost.bus_wires == 2 * (128 + 103 + 3 * 2));
    CHECK(cost.pipeline_wires == 6 * 70);
    CHECK(cost.dvi_pins == 5 * 28);
    CHECK(cost.memory_devices == 4);
    CHECK(cost.memory_pins == 2 * (64 + 8 + 3 + 11) + 2 * (64 + 8 + 3 + 8));
    CHECK(cost.memory_megabytes_per_second == Approx(4 * 8 * 100.0));
    CHECK(machine_cost(machine()).correction_bits == 0);
    Scenario scenario = machine();
    for (const int display : {1, 3}) scenario.displays.correction.emplace_back().display = display;
    CHECK(machine_cost(scenario).correction_bits == 2 * 6144);
    CHECK(machine_cost(scenario).weighted() - machine_cost(machine()).weighted() == Approx(12.288));
    scenario = machine();
    const MachineCost replicated = machine_cost(scenario);
    scenario.composer.smoothing = Smoothing::kBilinear;
    const MachineCost smoothed = machine_cost(scenario);
    CHECK(smoothed.buffer_bits == 2 * replicated.buffer_bits);
    CHECK(smoothed.lookup_tables > replicated.lookup_tables);
    // Three multiplications a channel, and those of the two counters.
    CHECK(smoothed.multipliers >= replicated.multipliers + 6 * 12);
    CHECK(smoothed.composer_mhz < replicated.composer_mhz);
    const auto rams = [](int pixels) {
        Scenario scenario = machine();
        scenario.composer.buffer_pixels = pixels;
        return machine_cost(scenario).block_rams;
    };
    CHECK(rams(1) == 0);
    CHECK(rams(synthesis::kFirstBlockRamPixels / 2) == 0);
    CHECK(rams(synthesis::kFirstBlockRamPixels / 2 + 1) == 6 * 8);
    CHECK(rams(4096) == 6 * 8);
    CHECK(rams(4097) == 6 * 16);
}

TEST_CASE("machine cost: memories side by side are more devices, and a shared one is half as many") {
    Scenario scenario = machine();
    scenario.memory.words_per_cycle = 4;
    MachineCost cost = machine_cost(scenario);
    CHECK(cost.memory_devices == 16);
    CHECK(cost.memory_pins == 8 * (64 + 8 + 3 + 9) + 8 * (64 + 8 + 3 + 6));
    CHECK(cost.weighted() > machine_cost(machine()).weighted() + 12 * 50.0);
    scenario.memory.ports = MemoryPorts::kShared;
    scenario.memory.write_block_words = 32;
    cost = machine_cost(scenario);
    CHECK(cost.memory_devices == 8);
    CHECK(cost.input_framebuffer_bits == 2 * (40 * 30 + 32 + 20 * 10 + 32) * 64);
}

TEST_CASE("machine cost: the fits of cells and clocks are as close to each row of the tables as they say") {
    for (const synthesis::ComposerRow& row : synthesis::kComposers) {
        INFO(row.buffer_pixels << " pixels, " << row.bus_bits << " bits, " << row.window_rows << " rows");
        const auto fit = static_cast<std::size_t>(row.window_rows) - 1;
        Scenario scenario = machine();
        scenario.displays.columns = 2;
        scenario.renderers.resize(1);
        set_composer(scenario, row);
        const MachineCost two = machine_cost(scenario);
        scenario.displays.rows = 2;  // two composers more, and a larger arbiter
        Scenario twice = scenario;
        twice.renderers.push_back(scenario.renderers.front());
        const MachineCost four = machine_cost(scenario);
        const MachineCost eight = machine_cost(twice);
        CHECK(eight.lookup_tables == 2 * four.lookup_tables);
        // With two displays the arbiter is a row of its own table.
        const double arbiter_tables = synthesis::kArbiters.front().lookup_tables;
        const double arbiter_error = synthesis::kArbiterLookupTables.largest_error * arbiter_tables;
        const double tables = (static_cast<double>(two.lookup_tables) - arbiter_tables) / 2.0;
        CHECK(std::abs(tables - row.lookup_tables) <=
              synthesis::kComposerLookupTables.at(fit).largest_error * row.lookup_tables +
                  arbiter_error / 2.0 + 1.0);
        const double arbiter_registers = synthesis::kArbiters.front().registers;
        const double registers = (static_cast<double>(two.registers) - arbiter_registers) / 2.0;
        CHECK(std::abs(registers - row.registers) <=
              synthesis::kComposerRegisters.at(fit).largest_error * row.registers +
                  synthesis::kArbiterRegisters.largest_error * arbiter_registers / 2.0 + 1.0);
        CHECK(two.block_rams == 2 * row.block_rams);
        CHECK(two.multipliers == 2 * row.multipliers);
    }
    // The cells of a machine with so many displays; its composers are all the same.
    const auto cells = [](int displays, auto member) {
        Scenario scenario = machine();
        scenario.renderers.resize(1);
        scenario.displays.columns = displays;
        return static_cast<double>(machine_cost(scenario).*member);
    };
    const auto fit = [](const synthesis::Fit<3>& of, int displays) {
        const double slot_bits = (256.0 + displays) * std::ceil(std::log2(displays));
        return of.coefficients[0] + of.coefficients[1] * displays + of.coefficients[2] * slot_bits;
    };
    const double composer_tables =
        (cells(2, &MachineCost::lookup_tables) - std::round(fit(synthesis::kArbiterLookupTables, 2))) / 2.0;
    const double composer_registers =
        (cells(2, &MachineCost::registers) - std::round(fit(synthesis::kArbiterRegisters, 2))) / 2.0;
    for (const synthesis::ArbiterRow& row : synthesis::kArbiters) {
        INFO(row.displays << " displays");
        const double tables =
            cells(row.displays, &MachineCost::lookup_tables) - row.displays * composer_tables;
        const double registers =
            cells(row.displays, &MachineCost::registers) - row.displays * composer_registers;
        CHECK(std::abs(tables - row.lookup_tables) <=
              synthesis::kArbiterLookupTables.largest_error * row.lookup_tables + 1.0);
        CHECK(std::abs(registers - row.registers) <=
              synthesis::kArbiterRegisters.largest_error * row.registers + 1.0);
    }
    for (const synthesis::ComposerClock& row : synthesis::kComposerClocks) {
        Scenario scenario = machine();
        set_composer(scenario, row);
        const double period = 1000.0 / machine_cost(scenario).composer_mhz;
        const auto fit = static_cast<std::size_t>(row.window_rows) - 1;
        CHECK(std::abs(period * row.mhz / 1000.0 - 1.0) <=
              synthesis::kComposerPeriod.at(fit).largest_error + 1e-6);
    }
    for (const synthesis::ArbiterClock& row : synthesis::kArbiterClocks) {
        Scenario scenario = machine();
        scenario.displays.columns = row.displays;
        const double period = 1000.0 / machine_cost(scenario).arbiter_mhz;
        CHECK(std::abs(period * row.mhz / 1000.0 - 1.0) <= synthesis::kArbiterPeriod.largest_error + 1e-6);
    }
}

TEST_CASE(
    "machine cost: the weights make one number; report and summary have each item and an unreachable clock") {
    MachineCost cost;
    CHECK(cost.weighted() == 0.0);
    cost.buffer_bits = 10'000;
    cost.bus_wires = 7;
    cost.memory_devices = 2;
    CHECK(cost.weighted() == Approx(10.0 + 7.0 + 100.0));
    RunReport report;
    CHECK(nlohmann::ordered_json::parse(report_json(report))["cost"].is_null());
    report.cost = cost;
    const auto json = nlohmann::ordered_json::parse(report_json(report))["cost"];
    CHECK(json["cost"] == 117.0);
    CHECK(json["buffer_bits"] == 10'000);
    CHECK(json["buffer_bits"].is_number_integer());
    for (const CostItem& item : cost_items()) CHECK(json.contains(item.name));
    report = RunReport();
    report.scenario = "fast";
    report.level = "tlm";
    report.core_mhz = 100.0;
    report.cost = machine_cost(machine());
    report.cost->composer_mhz = 64.4;
    report.cost->arbiter_mhz = 70.0;
    const std::string text = report_summary(report);
    CHECK(text.find("cost        ") != std::string::npos);
    CHECK(text.find(
              "clock       100 MHz asked for; in cells of 0.18 um, without wires, a composer reaches 64\n") !=
          std::string::npos);
    report.core_mhz = 64.0;
    CHECK(report_summary(report).find("asked for") == std::string::npos);
    CHECK(report_summary(report).find("cost        ") != std::string::npos);
}

}  // namespace
}  // namespace metabuffer

// Runs a scenario at level rtl with its own monitor on the first bus.
#include <rtl/metabuffer.h>
#include <rtl/run.h>
#include <rtl/wires.h>
#include <scenario/scenario_loader.h>

#include <iostream>

using namespace metabuffer;

SC_MODULE(BusWatcher) {
    sc_core::sc_in<bool> core_clk{"core_clk"};
    sc_core::sc_in<rtl::BusBeat> bus_i{"bus_i"};
    long pixels = 0;
    SC_CTOR(BusWatcher) {
        SC_METHOD(watch);
        sensitive << core_clk.pos();
        dont_initialize();
    }
    void watch() {
        const rtl::BusBeat& beat = bus_i.read();
        if (beat.kind == rtl::BusBeat::Kind::kPixels) pixels += beat.count;
    }
};

int sc_main(int argc, char* argv[]) {
    const Scenario scenario = load_scenario(argc > 1 ? argv[1] : "scenario.yaml");
    std::unique_ptr<BusWatcher> watcher;
    rtl::RunOptions options;
    options.on_built = [&](rtl::Metabuffer& machine) {
        watcher = std::make_unique<BusWatcher>("watcher");
        watcher->core_clk(machine.core_clk());
        watcher->bus_i(machine.wires().bus[0]);
    };
    const rtl::RunResult result = rtl::run(scenario, options);
    std::cout << watcher->pixels << " pixels seen, " << result.report.renderers[0].bus.pixels_sent
              << " counted\n";
    return watcher->pixels == result.report.renderers[0].bus.pixels_sent ? 0 : 1;
}

#include "banked_memory.h"

#include <cstdio>
#include <cstdlib>
#include <iostream>
#include <string>

#include "host/errors.h"
#include "scenario/scenario_loader.h"
#include "tlm/metabuffer.h"

// The architect's own memory in the machine: what do more banks save?

namespace metabuffer::examples {
namespace {

constexpr int kLargestBankCount = 1024;

void print(const char* what, const RunReport& report) {
    const BusCounters bus = report.total_bus();
    std::printf("%-16s %8lld page misses, %8lld clocks waiting for pages, %6lld pixels starved\n", what,
                static_cast<long long>(bus.page_misses), static_cast<long long>(bus.page_miss_cycles),
                static_cast<long long>(report.total_starved_pixels()));
}

int compare_memories(int argc, char** argv) {
    const int banks = argc == 3 ? std::atoi(argv[2]) : 0;
    if (banks < 1 || banks > kLargestBankCount) {
        std::cerr << "usage: banked_memory SCENARIO.yaml BANKS    BANKS is 1 to " << kLargestBankCount
                  << '\n';
        return 2;
    }
    try {
        const Scenario scenario = load_scenario(argv[1], {});
        tlm::Metabuffer own("own", scenario, with_banks(1));
        tlm::Metabuffer banked("banked", scenario, with_banks(banks));
        int running = 2;
        const auto stop = [&running] {
            if (--running == 0) {
                sc_core::sc_pause();
            }
        };
        own.on_finished(stop);
        banked.on_finished(stop);
        sc_core::sc_start();
        print("one open page", own.report());
        print((std::to_string(banks) + " banks").c_str(), banked.report());
    } catch (const InputError& error) {
        std::cerr << error.what() << '\n';
        return 2;
    }
    return 0;
}

}  // namespace
}  // namespace metabuffer::examples

int sc_main(int argc, char** argv) { return metabuffer::examples::compare_memories(argc, argv); }

int main(int argc, char** argv) {
    setenv("SYSTEMC_DISABLE_COPYRIGHT_MESSAGE", "1", 0);
    return sc_core::sc_elab_and_sim(argc, argv);
}

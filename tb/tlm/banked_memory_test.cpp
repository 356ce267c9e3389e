#include "examples/banked_memory.h"

#include <catch2/catch.hpp>
#include <memory>
#include <string>

#include "memory_bench.h"
#include "report/report.h"
#include "scenario/scenario_loader.h"
#include "tlm/metabuffer.h"

namespace metabuffer::test {
namespace {

using examples::BankedMemory;

struct BankedMemoryBench {
    MemoryUser user;
    BankedMemory memory;

    explicit BankedMemoryBench(int banks) : memory("banked_memory", memory_config(16, 6), banks) {
        user.initiator.socket.bind(memory.socket);
        elaborate();
    }
};

TEST_CASE("banked memory: pages are dealt out to the banks in turn and one is open in each") {
    BankedMemoryBench dut(4);
    constexpr Access kOpens{true, 6, 1};
    constexpr Access kOpen{false, 0, 1};
    for (int page = 0; page < 4; ++page) CHECK(dut.user.access(16 * page, 1, page == 0) == kOpens);
    for (int page = 0; page < 4; ++page) CHECK(dut.user.access(16 * page + 15, 1) == kOpen);
    CHECK(dut.user.access(16 * 5, 1) == kOpens);  // closes page 1 and no other
    CHECK(dut.user.access(16 * 0, 1) == kOpen);
    CHECK(dut.user.access(16 * 2, 1) == kOpen);
    CHECK(dut.user.access(16 * 3, 1) == kOpen);
    CHECK(dut.user.access(16 * 1, 1) == kOpens);
    CHECK(dut.user.all_ok);
}

TEST_CASE("banked memory: words follow up to the page's end even if the next page is open") {
    BankedMemoryBench dut(2);
    dut.user.access(16, 1, true);
    CHECK(dut.user.access(10, 20) == Access{true, 6, 6});
    CHECK(dut.user.access(16, 20) == Access{false, 0, 16});
}

TEST_CASE("banked memory: a new frame closes every bank and asking ahead changes none") {
    BankedMemoryBench dut(2);
    dut.user.access(0, 1, true);
    dut.user.access(16, 1);
    CHECK(dut.user.peek(32, 1) == Access{true, 6, 1});
    CHECK(dut.user.peek(48, 1) == Access{true, 6, 1});
    CHECK(dut.user.access(0, 1) == Access{false, 0, 1});
    CHECK(dut.user.access(16, 1) == Access{false, 0, 1});
    CHECK(dut.user.access(0, 1, true) == Access{true, 6, 1});
    CHECK(dut.user.access(16, 1) == Access{true, 6, 1});
}

TEST_CASE("banked memory: an access without its extension is an error of the model") {
    BankedMemoryBench dut(2);
    CHECK(report_of_empty_payload(dut.user.initiator) == kExtensionReport);
}

// ---- in the machine ----

Scenario scenario_of(const std::string& name) {
    return load_scenario(std::string(METABUFFER_SCENARIO_DIRECTORY) + "/" + name + ".yaml", {});
}

TEST_CASE("banked memory: with one bank the machine reports what it does with its own memory") {
    const Scenario scenario = scenario_of("paper-figure-starved");
    tlm::Metabuffer::Options own_options;
    own_options.images = false;
    tlm::Metabuffer own("own", scenario, own_options);
    tlm::Metabuffer one_bank("one_bank", scenario, examples::with_banks(1));
    tlm::Metabuffer four_banks("four_banks", scenario, examples::with_banks(4));
    int running = 3;
    for (tlm::Metabuffer* const machine : {&own, &one_bank, &four_banks}) {
        machine->on_finished([&running] {
            if (--running == 0) sc_core::sc_pause();
        });
    }
    sc_core::sc_start();
    REQUIRE(running == 0);
    CHECK(report_json(one_bank.report()) == report_json(own.report()));
    const BusCounters single = own.report().total_bus();
    const BusCounters banked = four_banks.report().total_bus();
    CHECK(single.page_misses > 0);
    CHECK(banked.page_misses < single.page_misses);
    CHECK(banked.page_miss_cycles == banked.page_misses * scenario.memory.page_miss_cycles);
    CHECK(four_banks.report().total_starved_pixels() < own.report().total_starved_pixels());
}

}  // namespace
}  // namespace metabuffer::test

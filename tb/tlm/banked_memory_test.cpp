#include "examples/banked_memory.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <functional>
#include <memory>
#include <string>
#include <utility>

#include "memory_bench.h"
#include "report/report.h"
#include "scenario/scenario_loader.h"
#include "tlm/metabuffer.h"

namespace metabuffer::test::banked_memory_test {
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

TEST_CASE("banked memory: a new frame closes every bank") {
    BankedMemoryBench dut(2);
    dut.user.access(0, 1, true);
    dut.user.access(16, 1);
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
    return load_scenario(std::string(METABUFFER_SOURCE_DIRECTORY) + "/scenarios/" + name + ".yaml", {});
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

/// A memory without page misses, whose answers are corrupted.
class CorruptMemory final : public sc_core::sc_module {
  public:
    using Corrupt = std::function<void(tlm::MemoryAccess& access)>;
    tlm::TargetSocket<CorruptMemory, tlm::MemoryAccess> socket{"socket"};

    CorruptMemory(const sc_core::sc_module_name& name, Corrupt corrupt)
        : sc_core::sc_module(name), corrupt_(std::move(corrupt)) {
        socket.register_b_transport(this, &CorruptMemory::b_transport);
    }

  private:
    void b_transport(::tlm::tlm_generic_payload& payload, sc_core::sc_time& /*delay*/) {
        auto& access = tlm::content_of<tlm::MemoryAccess>(payload);
        access.words = static_cast<int>(payload.get_data_length() / tlm::kBytesPerWord);
        corrupt_(access);
        payload.set_response_status(::tlm::TLM_OK_RESPONSE);
    }

    Corrupt corrupt_;
};

/// What the machine reports about such a memory; empty if the run ends well.
std::string complaint_about(const CorruptMemory::Corrupt& corrupt,
                            const Scenario& scenario = scenario_of("case-2")) {
    tlm::Metabuffer::Options options;
    options.images = false;
    options.make_memory = [corrupt](const char* name, const Scenario& /*scenario*/, int /*renderer*/) {
        auto memory = std::make_unique<CorruptMemory>(name, corrupt);
        tlm::Metabuffer::Memory made;
        made.socket = &memory->socket;
        made.module = std::move(memory);
        return made;
    };
    tlm::Metabuffer machine("machine", scenario, options);
    machine.on_finished([] { sc_core::sc_pause(); });
    try {
        sc_core::sc_start();
    } catch (const sc_core::sc_report& report) {
        CHECK(std::string(report.get_msg_type()) == "/metabuffer/input_framebuffer/memory");
        return report.get_msg();
    }
    return {};
}

TEST_CASE("own memory: a run with one that always has its words ends well") {
    CHECK(complaint_about([](tlm::MemoryAccess&) {}).empty());
}

TEST_CASE(
    "own memory: with shared ports it hears of a block in time and by when its place is settled, which then "
    "holds") {
    Scenario scenario = scenario_of("case-2");
    scenario.memory.ports = MemoryPorts::kShared;
    scenario.frames = 3;
    std::int64_t settled_before = 0;
    std::int64_t last_access_cycle = 0;
    std::int64_t newest_block_cycle = 0;
    int blocks = 0;
    int accesses_before = 0;
    int late_blocks = 0;
    const auto record = [&](const tlm::MemoryAccess& access) {
        if (access.write) {
            ++blocks;
            accesses_before += access.settled_before < settled_before ? 1 : 0;
            settled_before = access.settled_before;
            // An access comes after the blocks up to its clock and one more, unless the next one is of another frame.
            const bool same_frame =
                access.cycle - newest_block_cycle <= 2 * scenario.memory.write_block_words;
            late_blocks += same_frame && last_access_cycle >= newest_block_cycle ? 1 : 0;
            newest_block_cycle = access.cycle;
        } else {
            accesses_before += access.cycle < settled_before ? 1 : 0;
            last_access_cycle = std::max(last_access_cycle, access.cycle);
        }
    };
    CHECK(complaint_about(record, scenario).empty());
    CHECK(blocks > 0);
    CHECK(accesses_before == 0);
    CHECK(late_blocks == 0);
    // A memory may forget the blocks before it, so it must not lag behind for ever.
    CHECK(settled_before > last_access_cycle / 2);
}

TEST_CASE("own memory: one that has no word for a burst is reported, since the run would never end") {
    CHECK(complaint_about([](tlm::MemoryAccess& access) { access.words = 0; }).find(" 0 of ") !=
          std::string::npos);
}

TEST_CASE("own memory: a wait of less than no clocks is reported") {
    CHECK(complaint_about([](tlm::MemoryAccess& access) {
              access.wait_cycles = -1;
          }).find("after -1 clocks") != std::string::npos);
}

TEST_CASE("own memory: one whose next refresh begins before the words can be read is reported") {
    CHECK_FALSE(complaint_about([](tlm::MemoryAccess& access) {
                    access.wait_cycles = 4;
                    access.beats_before = access.cycle + 4;
                }).empty());
}

}  // namespace
}  // namespace metabuffer::test::banked_memory_test

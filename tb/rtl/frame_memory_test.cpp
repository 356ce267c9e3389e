#include "rtl/frame_memory.h"

#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "clocked_testbench.h"
#include "expected_report.h"
#include "support/random_seed.h"

namespace metabuffer::test::frame_memory_test {
namespace {

using rtl::FrameMemory;
using rtl::MemoryCommand;
using rtl::MemoryData;
using rtl::MemoryWrite;
using Kind = MemoryCommand::Kind;

constexpr int kWords = 64;

MemoryConfig pages_of(int words, int miss_cycles = 6, int words_per_cycle = 1) {
    MemoryConfig config;
    config.page_words = words;
    config.page_miss_cycles = miss_cycles;
    config.words_per_cycle = words_per_cycle;
    return config;
}

struct MemoryBench {
    MemoryConfig config;
    ClockDomain& core;
    ClockDomain& link;
    sc_core::sc_signal<MemoryWrite> write;
    sc_core::sc_signal<bool> front;
    sc_core::sc_signal<MemoryCommand> command;
    sc_core::sc_signal<MemoryData> data;
    sc_core::sc_signal<MemoryData> write_data;
    FrameMemory dut;
    const Recording<MemoryData>& sampled;  ///< what each core edge samples

    MemoryBench(ClockedTestbench& bench, const MemoryConfig& with, ClockDomain* link_domain = nullptr)
        : config(with),
          core(bench.core),
          link(link_domain != nullptr ? *link_domain : bench.core),
          dut("memory", with, kWords),
          sampled(core.record_sampled(data)) {
        dut.clk_i(core.clk);
        dut.reset_i(bench.reset);
        dut.write_clk_i(link.clk);
        dut.write_i(write);
        dut.front_i(front);
        dut.command_i(command);
        dut.data_o(data);
        for (auto& port : dut.write_data_i) port(write_data);
        bench.trace(dut);
    }
    /// Link edge `clock` stores a word, or half of it.
    void store(int clock, int device, int address, std::uint64_t word, std::uint8_t byte_mask = 0xFF) {
        link.drive(write, clock,
                   MemoryWrite{true, static_cast<std::uint8_t>(device), static_cast<std::uint32_t>(address),
                               word, byte_mask});
        link.drive(write, clock + 1, MemoryWrite{});
    }
    void send(int clock, const MemoryCommand& what) {
        core.drive(command, clock, what);
        core.drive(command, clock + 1, MemoryCommand{});
    }
    void activate(int clock, int page) { send(clock, make(Kind::kActivate, page)); }
    void precharge(int clock, int page = 0) { send(clock, make(Kind::kPrecharge, page)); }
    void precharge_all(int clock) { send(clock, make(Kind::kPrechargeAll, 0)); }
    void refresh(int clock) { send(clock, make(Kind::kRefresh, 0)); }
    void read(int clock, const std::vector<int>& addresses) {
        MemoryCommand what = make(Kind::kRead, addresses.front() / config.page_words);
        for (const int address : addresses) {
            what.columns[what.count++] =
                static_cast<std::uint32_t>(address - static_cast<int>(what.row) * config.page_words);
        }
        send(clock, what);
    }
    /// Consecutive words of the link for one page; of each the mask's bytes are stored.
    void write_words(int clock, int address, const std::vector<std::uint64_t>& words,
                     std::uint8_t byte_mask = 0xFF) {
        MemoryCommand what = make(Kind::kWrite, address / config.page_words);
        MemoryData brought;
        what.byte_mask = byte_mask;
        for (const std::uint64_t word : words) {
            what.columns[what.count++] = static_cast<std::uint32_t>(address++ % config.page_words);
            brought.words[brought.count++] = word;
        }
        core.drive(write_data, clock, brought);
        send(clock, what);
    }
    std::vector<std::uint64_t> words_at(int clock) const {
        const MemoryData& put_out = sampled.at(clock);
        return {put_out.words.begin(), put_out.words.begin() + put_out.count};
    }

    MemoryCommand make(Kind kind, int page) const {
        MemoryCommand what;
        what.kind = kind;
        what.bank = static_cast<std::uint8_t>(page % config.banks);
        what.row = static_cast<std::uint32_t>(page);
        return what;
    }
};

using Words = std::vector<std::uint64_t>;

TEST_CASE(
    "frame memory: a read puts the words of the open page out in its own clock, and nothing in others") {
    ClockedTestbench bench;
    MemoryBench dut(bench, pages_of(16, 6, 4));
    for (int address = 0; address < kWords; ++address) {
        dut.store(address, 0, address, 1000U + static_cast<unsigned>(address));
    }
    dut.activate(70, 1);
    dut.read(76, {16});
    dut.read(77, {17, 20, 31, 18});
    dut.read(79, {19, 19});
    bench.run_through(82);
    CHECK(dut.words_at(75).empty());
    CHECK(dut.words_at(76) == Words{1016});
    CHECK(dut.words_at(77) == Words{1017, 1020, 1031, 1018});
    CHECK(dut.words_at(78).empty());
    CHECK(dut.words_at(79) == Words{1019, 1019});
    CHECK(dut.words_at(80).empty());
}

TEST_CASE("frame memory: the byte mask lets colour half and depth half of a word be written on their own") {
    ClockedTestbench bench;
    MemoryBench dut(bench, pages_of(16));
    dut.store(1, 0, 3, 0xFFFF'FFFF'FF11'2233U, MemoryWrite::kColourBytes);
    dut.store(2, 0, 3, 0x0000'BEEF'44FF'FFFFU, MemoryWrite::kDepthBytes);
    dut.store(3, 0, 4, 0x0000'CAFE'55FF'FFFFU, MemoryWrite::kDepthBytes);
    dut.store(4, 0, 4, 0xFFFF'FFFF'FF66'7788U, MemoryWrite::kColourBytes);
    dut.activate(6, 0);
    for (int i = 0; i < 3; ++i) dut.read(12 + i, {3 + i});
    bench.run_through(16);
    CHECK(dut.words_at(12) == Words{0x0000'BEEF'4411'2233U});
    CHECK(dut.words_at(13) == Words{0x0000'CAFE'5566'7788U});
    CHECK(dut.words_at(14) == Words{0});
}

TEST_CASE("frame memory: the bus reads the front device while the link fills the other one") {
    ClockedTestbench bench;
    MemoryBench dut(bench, pages_of(kWords));
    for (int address = 0; address < kWords; ++address) {
        dut.store(address, 0, address, static_cast<unsigned>(address));
    }
    dut.activate(kWords, 0);
    for (int address = 0; address < kWords; ++address) {
        const int clock = kWords + 1 + address;
        dut.store(clock, 1, address, 1000U + static_cast<unsigned>(address));
        dut.read(clock, {address});
    }
    const int swap = 2 * kWords + 2;
    dut.core.drive(dut.front, swap, true);
    dut.read(swap + 1, {7});
    dut.core.drive(dut.front, swap + 2, false);
    dut.read(swap + 3, {7});
    bench.run_through(swap + 5);
    for (int address = 0; address < kWords; ++address) {
        CHECK(dut.words_at(kWords + 1 + address) == Words{static_cast<unsigned>(address)});
    }
    CHECK(dut.words_at(swap + 1) == Words{1007});
    CHECK(dut.words_at(swap + 3) == Words{7});  // the other device has kept its pair
}

TEST_CASE("frame memory: writes come at the link's clock, slower or faster than the core's") {
    ClockedTestbench bench;
    ClockDomain& link = bench.add_clock("link", 7'000);
    MemoryBench dut(bench, pages_of(kWords), &link);
    for (int address = 0; address < kWords; ++address) {
        dut.store(2 * address, 0, address, 500U + static_cast<unsigned>(address));
    }
    dut.activate(100, 0);
    for (int address = 0; address < kWords; ++address) dut.read(101 + address, {address});
    bench.run_through(101 + kWords);
    for (int address = 0; address < kWords; ++address) {
        CHECK(dut.words_at(101 + address) == Words{500U + static_cast<unsigned>(address)});
    }
}

TEST_CASE("frame memory: one page is open at a time, and a read of another is reported and opens it") {
    ExpectedReport report("/metabuffer/frame_memory/page");
    ClockedTestbench bench;
    MemoryBench dut(bench, pages_of(16));
    dut.read(2, {0});  // no page is open at first
    bench.run_through(3);
    CHECK(report.count() == 1);
    dut.activate(5, 1);
    dut.read(11, {31});
    dut.read(12, {16});
    bench.run_through(13);
    CHECK(report.count() == 1);
    dut.read(15, {32});
    bench.run_through(16);
    CHECK(report.count() == 2);
    dut.activate(18, 2);
    dut.read(24, {40});
    bench.run_through(25);
    CHECK(report.count() == 2);
    dut.read(27, {31});
    bench.run_through(28);
    CHECK(report.count() == 3);
}

TEST_CASE("frame memory: a precharge closes the page, and so does a reset, while what is stored stays") {
    ExpectedReport report("/metabuffer/frame_memory/page");
    ClockedTestbench bench;
    MemoryBench dut(bench, pages_of(16));
    dut.store(1, 0, 5, 77);
    dut.activate(2, 0);
    dut.precharge(10);
    dut.read(12, {5});
    bench.run_through(13);
    CHECK(report.count() == 1);
    dut.activate(15, 0);
    bench.core.pulse(bench.reset, 20);
    dut.read(22, {5});
    bench.run_through(23);
    CHECK(report.count() == 2);
    CHECK(dut.words_at(22) == Words{77});
}

TEST_CASE("frame memory: a reset wakes a memory that sleeps, and closes its page") {
    ExpectedReport report("/metabuffer/frame_memory/page");
    ClockedTestbench bench;
    MemoryBench dut(bench, pages_of(16));
    dut.activate(2, 0);
    bench.core.pulse(bench.reset, 40);
    dut.read(50, {5});
    bench.run_through(51);
    CHECK(report.count() == 1);
}

MemoryConfig banks_of(int banks, int precharge_cycles, int activate_cycles) {
    MemoryConfig config = pages_of(16, precharge_cycles + activate_cycles);
    config.banks = banks;
    config.precharge_cycles = precharge_cycles;
    return config;
}

TEST_CASE("frame memory: each bank has its own open page until it is precharged") {
    ExpectedReport report("/metabuffer/frame_memory/page");
    ClockedTestbench bench;
    MemoryBench dut(bench, banks_of(2, 2, 3));
    dut.activate(2, 0);
    dut.activate(3, 1);
    dut.read(6, {5});
    dut.read(7, {16});
    dut.read(8, {6});
    dut.precharge(10, 0);
    dut.read(12, {31});
    bench.run_through(13);
    CHECK(report.count() == 0);
    dut.read(15, {5});
    bench.run_through(16);
    CHECK(report.count() == 1);
    dut.precharge_all(20);
    dut.activate(22, 2);
    dut.activate(23, 3);
    dut.read(26, {32});
    dut.read(27, {48});
    bench.run_through(28);
    CHECK(report.count() == 1);
}

TEST_CASE("frame memory: a bank that must be precharged accepts no activate before") {
    ExpectedReport report("/metabuffer/frame_memory/page");
    ClockedTestbench bench;
    MemoryBench dut(bench, banks_of(1, 1, 3));
    dut.activate(2, 0);
    dut.activate(6, 1);
    bench.run_through(7);
    CHECK(report.count() == 1);
    dut.precharge(10, 1);
    dut.activate(12, 2);
    bench.run_through(13);
    CHECK(report.count() == 1);
}

TEST_CASE("frame memory: a bank that is timed takes nothing before its precharge and its activate are over") {
    ExpectedReport timing("/metabuffer/frame_memory/timing");
    ExpectedReport page("/metabuffer/frame_memory/page");
    ClockedTestbench bench;
    MemoryBench dut(bench, banks_of(2, 2, 3));  // activated in three clocks, precharged in two
    dut.activate(2, 0);
    dut.activate(3, 1);  // the other bank counts for itself
    dut.read(5, {0});
    dut.read(6, {16});
    dut.precharge(8, 0);
    dut.activate(10, 2);
    bench.run_through(11);
    CHECK(timing.count() == 0);
    dut.precharge(20, 2);
    dut.activate(22, 0);
    dut.read(24, {0});  // a clock too soon
    dut.read(25, {0});
    bench.run_through(26);
    CHECK(timing.count() == 1);
    dut.precharge(30, 0);
    dut.activate(31, 2);  // a clock too soon
    bench.run_through(32);
    CHECK(timing.count() == 2);
    dut.precharge_all(40);
    dut.activate(41, 3);  // every bank's precharge counts
    bench.run_through(42);
    CHECK(timing.count() == 3);
    CHECK(page.count() == 0);
}

TEST_CASE(
    "frame memory: a bank may be precharged while its page is being activated, and a reset ends its wait") {
    ExpectedReport timing("/metabuffer/frame_memory/timing");
    ClockedTestbench bench;
    MemoryBench dut(bench, banks_of(1, 2, 3));
    dut.activate(2, 0);
    dut.precharge(3, 0);
    dut.activate(5, 1);
    bench.core.pulse(bench.reset, 6);
    dut.activate(7, 2);
    dut.read(10, {32});
    bench.run_through(12);
    CHECK(timing.count() == 0);
}

TEST_CASE("frame memory: without precharge_cycles a page counts as open from its activate on") {
    ExpectedReport timing("/metabuffer/frame_memory/timing");
    ClockedTestbench bench;
    MemoryBench dut(bench, banks_of(1, 0, 3));
    dut.activate(2, 0);
    dut.read(3, {0});
    bench.run_through(4);
    CHECK(timing.count() == 0);
}

MemoryConfig refreshed() {
    MemoryConfig config = banks_of(2, 2, 3);
    config.refresh_interval_cycles = 20;
    config.refresh_cycles = 5;
    return config;
}

TEST_CASE("frame memory: a refresh closes all banks, and none takes a command until it is over") {
    ExpectedReport page("/metabuffer/frame_memory/page");
    ExpectedReport busy("/metabuffer/frame_memory/refresh");
    ClockedTestbench bench;
    MemoryBench dut(bench, refreshed());
    dut.activate(2, 0);
    dut.activate(3, 1);
    dut.refresh(20);
    dut.activate(25, 0);
    dut.read(30, {5});
    bench.run_through(31);
    CHECK(page.count() == 0);
    dut.read(33, {16});
    bench.run_through(34);
    CHECK(page.count() == 1);
    CHECK(busy.count() == 0);
    dut.refresh(40);
    dut.precharge_all(41);
    dut.activate(44, 0);
    bench.run_through(45);
    CHECK(busy.count() == 2);
}

TEST_CASE("frame memory: a refresh that is overdue is reported at each clock until it comes") {
    ExpectedReport report("/metabuffer/frame_memory/refresh");
    ClockedTestbench bench;
    MemoryBench dut(bench, refreshed());
    dut.refresh(23);
    dut.refresh(43);  // counted from the one before
    bench.run_through(62);
    CHECK(report.count() == 3);
    bench.run_through(63);
    CHECK(report.count() == 4);
}

TEST_CASE("frame memory: reset starts the count of clocks to the first refresh again") {
    ExpectedReport report("/metabuffer/frame_memory/refresh");
    ClockedTestbench bench;
    MemoryBench dut(bench, refreshed());
    dut.refresh(20);
    dut.core.pulse(bench.reset, 22);
    dut.activate(23, 0);  // the refresh has been forgotten too
    dut.refresh(23 + 20);
    bench.run_through(62);
    CHECK(report.count() == 0);
    bench.run_through(63);
    CHECK(report.count() == 1);
}

TEST_CASE("frame memory: a memory that needs no refresh accepts none") {
    ExpectedReport report("/metabuffer/frame_memory/refresh");
    ClockedTestbench bench;
    MemoryBench dut(bench, banks_of(2, 2, 3));
    dut.refresh(20);
    bench.run_through(21);
    CHECK(report.count() == 1);
}

TEST_CASE("frame memory: an activate of a page in another bank is reported") {
    ExpectedReport report("/metabuffer/frame_memory/address");
    ClockedTestbench bench;
    MemoryBench dut(bench, banks_of(2, 0, 3));
    MemoryCommand wrong = dut.make(Kind::kActivate, 2);
    wrong.bank = 1;
    dut.send(2, wrong);
    bench.run_through(3);
    CHECK(report.count() == 1);
}

TEST_CASE(
    "frame memory: without activate cycles a read opens its page itself, once the one before is closed") {
    ExpectedReport report("/metabuffer/frame_memory/page");
    ClockedTestbench bench;
    MemoryBench dut(bench, banks_of(1, 2, 0));
    dut.read(2, {0});
    dut.precharge(4);
    dut.read(6, {20});
    bench.run_through(7);
    CHECK(report.count() == 0);
    dut.read(9, {0});
    bench.run_through(10);
    CHECK(report.count() == 1);
}

TEST_CASE("frame memory: if a page miss takes no clocks, a read opens its page itself") {
    ExpectedReport report("/metabuffer/frame_memory/page");
    ClockedTestbench bench;
    MemoryBench dut(bench, pages_of(16, 0));
    for (int clock = 2; clock < 20; ++clock) dut.read(clock, {(clock * 23) % kWords});
    bench.run_through(22);
    CHECK(report.count() == 0);
}

TEST_CASE(
    "frame memory: a word outside of the memory, and more words than it gives in a clock, are reported") {
    ExpectedReport address("/metabuffer/frame_memory/address");
    ExpectedReport width("/metabuffer/frame_memory/width");
    ClockedTestbench bench;
    MemoryBench dut(bench, pages_of(16, 6, 2));
    dut.activate(1, 3);
    dut.read(7, {62, 63});
    bench.run_through(8);
    CHECK(address.count() == 0);
    CHECK(width.count() == 0);
    dut.activate(10, 2);
    dut.read(16, {47, 48});  // the column is not in the page
    bench.run_through(17);
    CHECK(address.count() == 1);
    dut.activate(19, 4);
    dut.read(25, {64});  // nor is the page in the device
    bench.run_through(26);
    CHECK(address.count() == 2);
    CHECK(dut.words_at(25) == Words{0});
    dut.activate(29, 3);
    dut.read(35, {61, 62, 63});
    bench.run_through(36);
    CHECK(width.count() == 1);
}

TEST_CASE("frame memory: a wrong command is reported at each clock that it stands") {
    ExpectedReport report("/metabuffer/frame_memory/page");
    ClockedTestbench bench;
    MemoryBench dut(bench, banks_of(1, 2, 3));
    dut.activate(2, 0);
    dut.core.drive(dut.command, 20, dut.make(Kind::kActivate, 1));
    dut.core.drive(dut.command, 32, MemoryCommand{});
    bench.run_through(40);
    CHECK(report.count() == 12);
}

TEST_CASE("frame memory: the report names the memory, the command, and why the memory cannot accept it") {
    ClockedTestbench bench;
    MemoryBench dut(bench, pages_of(16));
    dut.activate(2, 1);
    dut.read(10, {35, 36});
    std::string message;
    try {
        bench.run_through(12);
    } catch (const sc_core::sc_report& report) {
        message = report.get_msg();
    }
    CHECK(message == "memory was sent the command \"read 2 from word 3 of page 2\", but page 1 is open");
}

TEST_CASE("frame memory: the report on a page in another bank says in which it lies") {
    ClockedTestbench bench;
    MemoryBench dut(bench, banks_of(4, 0, 3));
    MemoryCommand wrong = dut.make(Kind::kActivate, 7);
    wrong.bank = 1;
    dut.send(2, wrong);
    std::string message;
    try {
        bench.run_through(3);
    } catch (const sc_core::sc_report& report) {
        message = report.get_msg();
    }
    CHECK_THAT(message, Catch::EndsWith(", but the page lies in bank 3"));
}

TEST_CASE("frame memory: random reads give what was written last") {
    Random random(random_seed(191));
    ClockedTestbench bench;
    MemoryBench dut(bench, pages_of(16, 1, 4));
    std::vector<Words> stored(2, Words(kWords, 0));
    std::vector<std::pair<int, Words>> wanted;
    int page = -1;
    int pause = 0;
    for (int clock = 1; clock < 3000; ++clock) {
        if (random.one_in(100)) pause = random.between(0, 20);  // long enough for the clock gates to close
        if (pause-- > 0) continue;
        // The link writes device 1 and the bus reads device 0, so the words read are known.
        const int address = random.between(0, kWords - 1);
        const std::uint64_t word = random.bits();
        if (clock < 1000) {
            const bool half = random.one_in(2);
            const std::uint8_t mask = half ? MemoryWrite::kColourBytes : MemoryWrite::kDepthBytes;
            const std::uint64_t bits = half ? 0xFF'FFFFU : ~std::uint64_t{0xFF'FFFFU};
            dut.store(clock, 0, address, word, mask);
            std::uint64_t& kept = stored[0][static_cast<std::size_t>(address)];
            kept = (kept & ~bits) | (word & bits);
            continue;
        }
        if (clock == 1000) continue;
        dut.store(clock, 1, address, word);
        if (page < 0 || random.one_in(8)) {
            page = random.between(0, kWords / 16 - 1);
            dut.activate(clock, page);
            continue;
        }
        std::vector<int> addresses;
        Words words;
        for (int i = random.between(1, 4); i > 0; --i) {
            addresses.push_back(page * 16 + random.between(0, 15));
            words.push_back(stored[0][static_cast<std::size_t>(addresses.back())]);
        }
        dut.read(clock, addresses);
        wanted.emplace_back(clock, words);
    }
    bench.run_through(3001);
    CHECK(wanted.size() > 1000);
    for (const auto& [clock, words] : wanted) REQUIRE(dut.words_at(clock) == words);
}

// ---- read latency ----

MemoryConfig late_pages(int latency_cycles, int words_per_cycle = 1) {
    MemoryConfig config = pages_of(16, 6, words_per_cycle);
    config.read_latency_cycles = latency_cycles;
    return config;
}

void check_latency(int latency) {
    ClockedTestbench bench;
    MemoryBench dut(bench, late_pages(latency, 2));
    for (int address = 0; address < 16; ++address) {
        dut.store(address, 0, address, 100U + static_cast<unsigned>(address));
    }
    dut.activate(30, 0);
    dut.read(36, {4});
    dut.read(37, {5, 9});
    dut.read(39, {6});
    dut.precharge(40);  // closes the page after the last read, whose words are on their way
    bench.run_through(60);
    const auto stand = dut.sampled.clocks_where([](const MemoryData& put_out) { return put_out.count > 0; });
    CHECK(stand == std::vector<int>{36 + latency, 37 + latency, 39 + latency});
    CHECK(dut.words_at(36 + latency) == Words{104});
    CHECK(dut.words_at(37 + latency) == Words{105, 109});
    CHECK(dut.words_at(39 + latency) == Words{106});
}

TEST_CASE("frame memory: with read latency the words of a read stand a clock later, one read a clock") {
    check_latency(1);
}

TEST_CASE("frame memory: with the longest read latency there may be a read a clock all the same") {
    check_latency(8);
}

TEST_CASE("frame memory: words on their way out are those of the device that was read") {
    ClockedTestbench bench;
    MemoryBench dut(bench, late_pages(4));
    dut.store(0, 0, 3, 1);
    dut.store(1, 1, 3, 2);
    dut.activate(10, 0);
    dut.read(16, {3});
    dut.core.drive(dut.front, 17, true);
    dut.read(17, {3});
    bench.run_through(24);
    CHECK(dut.words_at(20) == Words{1});
    CHECK(dut.words_at(21) == Words{2});
}

TEST_CASE("frame memory: reset drops words on their way out") {
    ClockedTestbench bench;
    MemoryBench dut(bench, late_pages(4));
    dut.store(0, 0, 3, 7);
    dut.activate(10, 0);
    dut.read(16, {3});
    dut.core.drive(bench.reset, 18, true);
    dut.core.drive(bench.reset, 19, false);
    bench.run_through(30);
    CHECK(dut.sampled.clocks_where([](const MemoryData& put_out) { return put_out.count > 0; }).empty());
}

TEST_CASE("frame memory: in reset no words stand at the output, even if they stood there before") {
    ClockedTestbench bench;
    MemoryBench dut(bench, late_pages(4));
    dut.store(0, 0, 3, 7);
    dut.activate(10, 0);
    constexpr int kReset = 24;
    for (int clock = 16; clock < kReset; ++clock) dut.read(clock, {3});
    bench.core.drive(bench.reset, kReset, true);
    bench.core.drive(bench.reset, kReset + 6, false);
    bench.run_through(kReset + 20);
    CHECK(dut.words_at(kReset) == Words{7});
    for (int clock = kReset + 1; clock < kReset + 20; ++clock) {
        INFO("clock " << clock);
        CHECK(dut.sampled.at(clock).count == 0);
    }
}

// ---- shared ports ----

MemoryConfig shared_pages_of(int words) {
    MemoryConfig config = pages_of(words, 6, 2);
    config.ports = MemoryPorts::kShared;
    return config;
}

TEST_CASE("frame memory: with shared ports a write stores words of the link, half by half, for later reads") {
    ClockedTestbench bench;
    MemoryBench dut(bench, shared_pages_of(16));
    dut.activate(2, 1);
    dut.write_words(8, 16, {0x1122334455667788U, 5});
    dut.write_words(9, 17, {0xFFFFFFFFFFFFFFFFU}, MemoryWrite::kDepthBytes);
    dut.read(10, {16, 17});
    dut.write_words(11, 16, {0}, MemoryWrite::kColourBytes);
    dut.read(12, {16});
    bench.run_through(14);
    CHECK(dut.words_at(10) == Words{0x1122334455667788U, 0xFFFFFFFFFF000005U});
    CHECK(dut.words_at(11).empty());
    CHECK(dut.words_at(12) == Words{0x1122334455000000U});
}

TEST_CASE(
    "frame memory: with shared ports it has room for two images, and the wires of front and link are "
    "ignored") {
    ClockedTestbench bench;
    MemoryBench dut(bench, shared_pages_of(16));
    dut.store(1, 0, 3, 77);
    dut.activate(2, 4);  // the second image's first page: word 64
    dut.write_words(8, 64, {9, 10});
    dut.core.drive(dut.front, 9, true);
    dut.read(10, {64, 65});
    dut.core.drive(dut.front, 11, false);
    dut.read(12, {64, 65});
    dut.activate(14, 0);
    dut.read(20, {3});
    bench.run_through(22);
    CHECK(dut.words_at(10) == Words{9, 10});
    CHECK(dut.words_at(12) == Words{9, 10});
    CHECK(dut.words_at(20) == Words{0});
}

TEST_CASE("frame memory: a write needs its page open, must fit the pins, and must stay within the memory") {
    ExpectedReport page("/metabuffer/frame_memory/page");
    ExpectedReport width("/metabuffer/frame_memory/width");
    ExpectedReport address("/metabuffer/frame_memory/address");
    ClockedTestbench bench;
    MemoryBench dut(bench, shared_pages_of(16));
    dut.write_words(2, 0, {1});
    dut.write_words(4, 1, {1, 2});  // the write before has opened the page: the model goes on
    bench.run_through(5);
    CHECK(page.count() == 1);
    dut.write_words(8, 2, {1, 2, 3});
    bench.run_through(10);
    CHECK(width.count() == 1);
    CHECK(page.count() == 1);
    CHECK(address.count() == 0);
}

TEST_CASE("frame memory: without shared ports a write from the bus's side is reported at each clock") {
    ExpectedReport report("/metabuffer/frame_memory/ports");
    ClockedTestbench bench;
    MemoryConfig config = pages_of(16, 0);
    MemoryBench dut(bench, config);
    dut.core.drive(dut.command, 3, dut.make(Kind::kWrite, 0));
    dut.core.drive(dut.command, 20, MemoryCommand{});
    bench.run_through(25);
    CHECK(report.count() == 17);
}

}  // namespace
}  // namespace metabuffer::test::frame_memory_test

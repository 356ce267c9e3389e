#include "tlm/frame_memory.h"

#include <catch2/catch.hpp>

#include "memory_bench.h"
#include "support/random_seed.h"

namespace metabuffer::test {
namespace {

struct FrameMemoryBench {
    MemoryUser user;
    tlm::FrameMemory memory;

    FrameMemoryBench(int page_words, int page_miss_cycles, int banks = 1, int precharge_cycles = 0)
        : memory("frame_memory", memory_config(page_words, page_miss_cycles, banks, precharge_cycles)) {
        user.initiator.socket.bind(memory.socket);
        elaborate();
    }
};

TEST_CASE("frame memory: words of the open page cost nothing and any other word opens its page first") {
    FrameMemoryBench dut(16, 6);
    CHECK(dut.user.access(0, 4, true) == Access{true, 6, 4});
    CHECK(dut.user.access(4, 8) == Access{false, 0, 8});
    CHECK(dut.user.access(15, 1) == Access{false, 0, 1});
    CHECK(dut.user.access(16, 2) == Access{true, 6, 2});
    CHECK(dut.user.access(0, 1) == Access{true, 6, 1});  // one page is open
    CHECK(dut.user.all_ok);
}

TEST_CASE("frame memory: a burst gets words up to its page's end") {
    FrameMemoryBench dut(16, 6);
    CHECK(dut.user.access(13, 8, true) == Access{true, 6, 3});
    CHECK(dut.user.access(16, 40) == Access{true, 6, 16});
    CHECK(dut.user.access(31, 1) == Access{false, 0, 1});
    CHECK(dut.user.all_ok);
}

TEST_CASE("frame memory: a frame starts with no page open") {
    FrameMemoryBench dut(16, 6);
    CHECK(dut.user.access(0, 1) == Access{true, 6, 1});
    CHECK(dut.user.access(0, 1) == Access{false, 0, 1});
    CHECK(dut.user.access(0, 1, true) == Access{true, 6, 1});
}

TEST_CASE("frame memory: a page miss of no clocks is still a page miss") {
    FrameMemoryBench dut(16, 0);
    CHECK(dut.user.access(3, 1, true) == Access{true, 0, 1});
    CHECK(dut.user.access(4, 1) == Access{false, 0, 1});
}

TEST_CASE("frame memory: each bank has a page open of its own, and a run ends at a page all the same") {
    FrameMemoryBench dut(16, 6, 2);
    CHECK(dut.user.access(0, 1, true) == Access{true, 6, 1});
    CHECK(dut.user.access(16, 1) == Access{true, 6, 1});
    CHECK(dut.user.access(1, 1) == Access{false, 0, 1});
    CHECK(dut.user.other_page());
    CHECK(dut.user.access(2, 1) == Access{false, 0, 1});
    CHECK_FALSE(dut.user.other_page());
    CHECK(dut.user.peek(17, 40) == Access{false, 0, 15});
    CHECK(dut.user.other_page());
    CHECK(dut.user.access(32, 1) == Access{true, 6, 1});  // page 2 takes the place of page 0
    CHECK(dut.user.access(17, 1) == Access{false, 0, 1});
    CHECK(dut.user.access(0, 1) == Access{true, 6, 1});
    CHECK(dut.user.all_ok);
}

TEST_CASE("frame memory: only a bank with a page open must be precharged") {
    FrameMemoryBench dut(16, 6, 2, 2);
    CHECK(dut.user.access(0, 1, true) == Access{true, 4, 1});
    CHECK(dut.user.access(16, 1) == Access{true, 4, 1});
    CHECK(dut.user.access(32, 1) == Access{true, 6, 1});
    CHECK(dut.user.access(0, 1, true) == Access{true, 4, 1});
}

TEST_CASE("frame memory: an opening that is broken off while its bank closes has opened nothing") {
    FrameMemoryBench dut(16, 6, 1, 2);
    CHECK(dut.user.access(0, 1, true) == Access{true, 4, 1});
    dut.user.break_off(0);  // it was being activated: its page is open
    CHECK(dut.user.access(1, 1) == Access{false, 0, 1});
    CHECK(dut.user.access(16, 1) == Access{true, 6, 1});
    dut.user.break_off(16);
    CHECK(dut.user.access(16, 1) == Access{true, 6, 1});
    CHECK(dut.user.access(17, 1) == Access{false, 0, 1});
    CHECK(dut.user.all_ok);
}

TEST_CASE("frame memory: asking ahead changes nothing") {
    FrameMemoryBench dut(16, 6);
    CHECK(dut.user.access(0, 1, true) == Access{true, 6, 1});
    CHECK(dut.user.peek(14, 5) == Access{false, 0, 2});
    CHECK(dut.user.peek(16, 5) == Access{true, 6, 5});
    CHECK(dut.user.access(1, 1) == Access{false, 0, 1});
    CHECK(dut.user.access(16, 1) == Access{true, 6, 1});
    CHECK(dut.user.all_ok);
}

TEST_CASE("frame memory: agrees with one page register under random use") {
    const auto seed = random_seed(531);
    INFO("METABUFFER_SEED=" << seed);
    Random random(seed);
    constexpr int kPageWords = 12;  // no power of two
    FrameMemoryBench dut(kPageWords, 5);
    int open = -1;
    for (int i = 0; i < 20'000; ++i) {
        const int word = random.between(0, 100);
        const int words = random.between(1, 30);
        const bool new_frame = random.one_in(20);
        const bool peek = random.one_in(3);
        if (new_frame) open = -1;
        const int page = word / kPageWords;
        int left = 0;
        while (left < words && (word + left) / kPageWords == page) ++left;
        REQUIRE(dut.user.access(word, words, new_frame, peek) ==
                Access{open != page, open != page ? 5 : 0, left});
        if (!peek) open = page;
    }
    CHECK(dut.user.all_ok);
}

TEST_CASE("frame memory: an access without its extension is an error of the model") {
    FrameMemoryBench dut(16, 6);
    CHECK(report_of_empty_payload(dut.user.initiator) == kExtensionReport);
}

}  // namespace
}  // namespace metabuffer::test

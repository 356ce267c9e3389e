#include "tlm/frame_memory.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cstdint>
#include <deque>
#include <utility>
#include <vector>

#include "memory_bench.h"
#include "support/random_seed.h"

namespace metabuffer::test::frame_memory_test {
namespace {

struct FrameMemoryBench {
    MemoryUser user;
    tlm::FrameMemory memory;

    FrameMemoryBench(int page_words, int page_miss_cycles, int banks = 1, int precharge_cycles = 0)
        : FrameMemoryBench(memory_config(page_words, page_miss_cycles, banks, precharge_cycles)) {}
    explicit FrameMemoryBench(const MemoryConfig& config, std::int64_t first_cycle = 0)
        : memory("frame_memory", config, first_cycle) {
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

TEST_CASE("frame memory: each bank has its own open page, and a run still ends at a page's end") {
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

TEST_CASE("frame memory: an opening that is broken off leaves a bank that must be closed first") {
    FrameMemoryBench dut(16, 6, 1, 2);
    CHECK(dut.user.access(0, 1, true) == Access{true, 4, 1});
    dut.user.break_off(0);  // it was being activated
    CHECK(dut.user.access(1, 1) == Access{true, 6, 1});
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

/// An independent memory of one page per bank that goes clock by clock.
class SteppedMemory {
  public:
    SteppedMemory(const MemoryConfig& config, std::int64_t first_cycle)
        : config_(config), first_cycle_(first_cycle), pages_(static_cast<std::size_t>(config.banks), -1) {}

    struct Answer {
        int broken = 0, refresh = 0, opening = 0;
        bool miss = false;
    };
    /// A word is wanted from a clock on, later than the last access's.
    Answer access(std::int64_t cycle, std::int64_t page) {
        while (clock_ < cycle) step();
        Answer answer;
        std::int64_t& open = pages_[static_cast<std::size_t>(page % config_.banks)];
        int done = 0;
        int needed = -1;  // clocks of the opening under way
        for (;; step()) {
            if (in_refresh()) {
                if (needed >= 0) answer.broken = std::exchange(done, 0);
                needed = -1;
                ++answer.refresh;
                continue;
            }
            if (open == page) break;
            if (needed < 0) needed = config_.activate_cycles() + (open >= 0 ? config_.precharge_cycles : 0);
            answer.miss = true;
            if (done == needed) break;
            ++done;
        }
        answer.opening = done;
        open = page;
        return answer;
    }
    void close() { std::fill(pages_.begin(), pages_.end(), -1); }
    std::int64_t clock() const { return clock_; }
    std::int64_t next_refresh() const {
        std::int64_t next = first_cycle_ + config_.refresh_interval_cycles;
        while (next <= clock_) next += config_.refresh_interval_cycles;
        return next;
    }

  private:
    bool in_refresh() const {
        const std::int64_t since = (clock_ - first_cycle_) % config_.refresh_interval_cycles;
        return clock_ >= first_cycle_ + config_.refresh_interval_cycles && since < config_.refresh_cycles;
    }
    void step() {
        ++clock_;
        if (in_refresh()) close();
    }

    MemoryConfig config_;
    std::int64_t first_cycle_;
    std::int64_t clock_ = 0;
    std::vector<std::int64_t> pages_;
};

TEST_CASE("frame memory: refreshes under random use are those of a memory that goes clock by clock") {
    const auto seed = random_seed(571);
    INFO("METABUFFER_SEED=" << seed);
    Random random(seed);
    constexpr int kPageWords = 12;
    constexpr int kFirstCycle = 7;
    MemoryConfig config = memory_config(kPageWords, 9, 2, 3);
    config.refresh_cycles = 8;
    config.refresh_interval_cycles = 40;
    FrameMemoryBench dut(config, kFirstCycle);
    SteppedMemory reference(config, kFirstCycle);
    std::int64_t cycle = kFirstCycle;
    int broken = 0;
    int waited = 0;
    for (int i = 0; i < 20'000; ++i) {
        INFO("access " << i << " at clock " << cycle);
        const int word = random.between(0, 60);
        const bool new_frame = random.one_in(20);
        if (new_frame) reference.close();
        const tlm::MemoryAccess& answer = dut.user.access_at(cycle, word, 1, new_frame);
        const SteppedMemory::Answer expected = reference.access(cycle, word / kPageWords);
        REQUIRE(answer.page_miss == expected.miss);
        REQUIRE(answer.broken_cycles == expected.broken);
        REQUIRE(answer.refresh_cycles == expected.refresh);
        REQUIRE(answer.wait_cycles == expected.broken + expected.refresh + expected.opening);
        REQUIRE(answer.beats_before == reference.next_refresh());
        REQUIRE(reference.clock() == cycle + answer.wait_cycles);
        broken += answer.broken_cycles > 0 ? 1 : 0;
        waited += answer.broken_cycles == 0 && answer.refresh_cycles > 0 ? 1 : 0;
        cycle += answer.wait_cycles + 1 + (random.one_in(3) ? random.between(0, 60) : 0);
    }
    CHECK(broken > 100);
    CHECK(waited > 100);
    CHECK(dut.user.all_ok);
}

TEST_CASE("frame memory: what is broken off in a refresh, or before one, has opened nothing") {
    MemoryConfig config = memory_config(16, 6, 1, 2);
    config.refresh_cycles = 5;
    config.refresh_interval_cycles = 100;
    FrameMemoryBench dut(config);
    CHECK(dut.user.access_at(102, 0, 1, true).wait_cycles == 3 + 4);
    dut.user.break_off(0);
    CHECK(dut.user.access_at(103, 0, 1).wait_cycles == 2 + 4);
    // The bank's page would have to be closed first; the refresh closes it.
    CHECK(dut.user.access_at(198, 16, 1).wait_cycles == 2 + 5 + 4);
    dut.user.break_off(16);
    CHECK(dut.user.access_at(250, 16, 1).wait_cycles == 4);
    CHECK(dut.user.all_ok);
}

TEST_CASE("frame memory: a broken-off opening leaves no page open, however far it has come") {
    // Two clocks to close a page, four to open one.
    FrameMemoryBench dut(16, 6, 1, 2);
    std::int64_t cycle = 0;
    for (int clocks = 1; clocks <= 5; ++clocks) {
        INFO("broken off after " << clocks << " clocks");
        CHECK(dut.user.access_at(cycle, 0, 1, true).wait_cycles == 4);
        CHECK(dut.user.access_at(cycle + 10, 16, 1).wait_cycles == 6);
        dut.user.break_off(16, clocks);
        // Closing or being activated: neither page is open, and the bank must be closed again.
        CHECK(dut.user.access_at(cycle + 20, 16, 1).wait_cycles == 6);
        cycle += 100;
    }
    CHECK(dut.user.all_ok);
}

TEST_CASE("frame memory: without precharge_cycles a broken-off opening leaves its page open") {
    FrameMemoryBench dut(16, 6);
    CHECK(dut.user.access_at(0, 0, 1, true).wait_cycles == 6);
    for (int clocks = 1; clocks <= 5; ++clocks) {
        INFO("broken off after " << clocks << " clocks");
        CHECK(dut.user.access_at(100 * clocks, 16 * clocks, 1).wait_cycles == 6);
        dut.user.break_off(16 * clocks, clocks);
        CHECK(dut.user.access_at(100 * clocks + 20, 16 * clocks, 1).wait_cycles == 0);
    }
    CHECK(dut.user.all_ok);
}

TEST_CASE("frame memory: what a broken-off wait over a refresh leaves depends on how far it has come") {
    MemoryConfig config = memory_config(16, 6, 1, 2);
    config.refresh_cycles = 5;
    config.refresh_interval_cycles = 100;
    FrameMemoryBench dut(config);
    // Wanted three clocks before the refresh of clock 100: those, the refresh, and four to activate the page.
    std::int64_t refresh = 100;
    for (int clocks = 1; clocks <= 11; ++clocks) {
        INFO("broken off after " << clocks << " clocks");
        dut.user.access_at(refresh - 40, 0, 1);
        CHECK(dut.user.access_at(refresh - 3, 16, 1).wait_cycles == 3 + 5 + 4);
        dut.user.break_off(16, clocks);
        // The refresh has closed the bank; an activate after it leaves a page half open.
        CHECK(dut.user.access_at(refresh + 20, 16, 1).wait_cycles == (clocks <= 3 + 5 ? 4 : 6));
        refresh += 100;
    }
    CHECK(dut.user.all_ok);
}

TEST_CASE(
    "frame memory: a bank whose opening is broken off before a refresh must be closed first until then") {
    MemoryConfig config = memory_config(16, 6, 1, 4);
    config.refresh_cycles = 5;
    config.refresh_interval_cycles = 100;
    FrameMemoryBench dut(config);
    CHECK(dut.user.access_at(50, 0, 1, true).wait_cycles == 2);
    CHECK(dut.user.access_at(95, 16, 1).wait_cycles == 5 + 5 + 2);
    dut.user.break_off(16, 1);
    // The refresh is four clocks away. To open a page takes two, but to close one first makes it six.
    CHECK(dut.user.access_at(96, 16, 1).wait_cycles == 4 + 5 + 2);
    CHECK(dut.user.all_ok);
}

TEST_CASE("frame memory: an access without its extension is an error of the model") {
    FrameMemoryBench dut(16, 6);
    CHECK(report_of_empty_payload(dut.user.initiator) == kExtensionReport);
}

// ---- shared ports ----

MemoryConfig shared_memory_config(int page_words, int page_miss_cycles, int banks = 1,
                                  int precharge_cycles = 0) {
    MemoryConfig config = memory_config(page_words, page_miss_cycles, banks, precharge_cycles);
    config.ports = MemoryPorts::kShared;
    return config;
}

/// An independent memory with shared ports that goes clock by clock.
class SteppedSharedMemory {
  public:
    SteppedSharedMemory(const MemoryConfig& config, std::int64_t first_cycle)
        : config_(config), first_cycle_(first_cycle), pages_(static_cast<std::size_t>(config.banks), -1) {}

    struct Waits {
        int refresh = 0, write = 0, opening = 0, misses = 0;
        friend bool operator==(const Waits& a, const Waits& b) {
            return a.refresh == b.refresh && a.write == b.write && a.opening == b.opening &&
                   a.misses == b.misses;
        }
    };
    void bring_block(std::int64_t cycle, std::int64_t page, int words) {
        blocks_.push_back({cycle, page, (words + config_.words_per_cycle - 1) / config_.words_per_cycle});
    }
    /// A word is wanted from a clock on, which is not before the present one.
    Waits access(std::int64_t cycle, std::int64_t page) {
        while (clock_ < cycle) step(nullptr, -1);
        Waits waits;
        while (!step(&waits, page)) {
        }
        return waits;
    }
    /// The first clock from the present one on in which it does something other than read, if no page is opened.
    std::int64_t next_interruption() const {
        SteppedSharedMemory ahead = *this;
        const std::int64_t end = clock_ + 10'000;
        while (!ahead.busy() && ahead.clock_ < end) ahead.step(nullptr, -1);
        return ahead.clock_ < end ? ahead.clock_ : tlm::kUnknownCycle;
    }
    std::int64_t clock() const { return clock_; }

  private:
    struct Block {
        std::int64_t ready, page;
        int cycles;
    };
    std::int64_t& open(std::int64_t page) { return pages_[static_cast<std::size_t>(page % config_.banks)]; }
    int opening(std::int64_t page) {
        if (open(page) == page) return 0;
        return config_.activate_cycles() + (open(page) == -1 ? 0 : config_.precharge_cycles);
    }
    std::int64_t to_refresh() const {
        const std::int64_t interval = config_.refresh_interval_cycles;
        const std::int64_t since = clock_ - first_cycle_;
        return interval == 0 ? 1'000'000 : since == 0 ? interval : (interval - since % interval) % interval;
    }
    bool refreshing() const {
        const std::int64_t since = clock_ - first_cycle_;
        return config_.refreshes() && since >= config_.refresh_interval_cycles &&
               since % config_.refresh_interval_cycles < config_.refresh_cycles;
    }
    bool busy() {
        if (refreshing() || writing_ > 0) return true;
        if (opening_ > 0 || blocks_.empty() || blocks_.front().ready > clock_) return false;
        return opening(blocks_.front().page) + blocks_.front().cycles <= to_refresh();
    }
    /// Plays one clock. Returns true, and no clock passes, if the page can be read in it.
    bool step(Waits* waits, std::int64_t page) {
        if (refreshing()) {
            std::fill(pages_.begin(), pages_.end(), -1);
            opening_ = 0;
            if (waits != nullptr) ++waits->refresh;
        } else if (busy()) {
            if (writing_ == 0) {
                const Block block = blocks_.front();
                blocks_.pop_front();
                writing_ = opening(block.page) + block.cycles;
                open(block.page) = block.page;
            }
            --writing_;
            if (waits != nullptr) ++waits->write;
        } else if (waits != nullptr) {
            if (opening_ == 0) {
                opening_ = opening(page);
                if (open(page) != page) ++waits->misses;
                open(page) = page;
                if (opening_ == 0) return true;
            }
            --opening_;
            ++waits->opening;
        }
        ++clock_;
        return false;
    }

    MemoryConfig config_;
    std::int64_t first_cycle_;
    std::int64_t clock_ = 0;
    std::vector<std::int64_t> pages_;
    std::deque<Block> blocks_;
    int writing_ = 0;
    int opening_ = 0;
};

/// Sums the phases of a wait.
SteppedSharedMemory::Waits waits_of(MemoryUser& user, std::int64_t& cycle, std::int64_t word,
                                    std::int64_t& beats_before) {
    SteppedSharedMemory::Waits waits;
    for (;;) {
        const tlm::MemoryAccess answer = user.access_at(cycle, word, 1);
        const int opening =
            answer.wait_cycles - answer.broken_cycles - answer.refresh_cycles - answer.write_cycles;
        waits.refresh += answer.refresh_cycles;
        waits.write += answer.write_cycles;
        waits.opening += answer.broken_cycles + opening;
        waits.misses += (answer.broken_cycles > 0 ? 1 : 0) + (answer.page_miss ? 1 : 0);
        cycle += answer.wait_cycles;
        beats_before = answer.beats_before;
        if (answer.words > 0) return waits;
        REQUIRE(answer.wait_cycles > 0);
    }
}

void check_shared_memory(const MemoryConfig& config, std::uint64_t seed) {
    Random random(seed);
    constexpr int kFirstCycle = 5;
    FrameMemoryBench dut(config, kFirstCycle);
    SteppedSharedMemory reference(config, kFirstCycle);
    std::int64_t cycle = kFirstCycle;
    std::int64_t brought = kFirstCycle;
    SteppedSharedMemory::Waits sum;
    for (int i = 0; i < 5'000; ++i) {
        INFO("access " << i << " at clock " << cycle);
        while (brought <= cycle + 400) {
            brought += random.one_in(4) ? random.between(1, 20) : random.between(30, 120);
            const int page = random.between(0, 9);
            const int words = random.between(1, config.page_words);
            dut.user.bring_block(brought, std::int64_t{page} * config.page_words, words);
            reference.bring_block(brought, page, words);
        }
        const int word = random.between(0, 10 * config.page_words - 1);
        std::int64_t beats_before = 0;
        const SteppedSharedMemory::Waits waits = waits_of(dut.user, cycle, word, beats_before);
        const SteppedSharedMemory::Waits expected =
            reference.access(cycle - waits.refresh - waits.write - waits.opening, word / config.page_words);
        REQUIRE(waits == expected);
        REQUIRE(reference.clock() == cycle);
        REQUIRE(beats_before == reference.next_interruption());
        sum.refresh += waits.refresh;
        sum.write += waits.write;
        sum.misses += waits.misses > 1 ? 1 : 0;
        // A word is read, and others of it until the next interruption.
        cycle += 1 + (random.one_in(3) ? random.between(0, 90) : 0);
    }
    CHECK(sum.write > 1'000);
    CHECK(sum.misses > 100);
    CHECK((sum.refresh > 100 || !config.refreshes()));
    CHECK(dut.user.all_ok);
}

TEST_CASE("frame memory: shared ports under random use are those of a memory that goes clock by clock") {
    const auto seed = random_seed(581);
    INFO("METABUFFER_SEED=" << seed);
    MemoryConfig config = shared_memory_config(8, 7, 2, 2);
    config.words_per_cycle = 2;
    check_shared_memory(config, seed);
}

TEST_CASE("frame memory: shared ports with refreshes are those of a memory that goes clock by clock") {
    const auto seed = random_seed(582);
    INFO("METABUFFER_SEED=" << seed);
    MemoryConfig config = shared_memory_config(8, 7, 4, 2);
    config.words_per_cycle = 3;
    config.refresh_cycles = 9;
    config.refresh_interval_cycles = 61;
    check_shared_memory(config, seed);
}

TEST_CASE("frame memory: with shared ports the first refresh is waited for like any other") {
    MemoryConfig config = shared_memory_config(16, 6);
    config.refresh_cycles = 9;
    config.refresh_interval_cycles = 61;
    FrameMemoryBench dut(config);
    for (const int refresh : {1, 2, 3}) {
        INFO("refresh " << refresh);
        CHECK(dut.user.access_at(61 * refresh + 3, 0, 1).refresh_cycles == 9 - 3);
    }
}

TEST_CASE("frame memory: with shared ports a page is open from frame to frame") {
    FrameMemoryBench dut(shared_memory_config(16, 6));
    CHECK(dut.user.access(0, 1, true) == Access{true, 6, 1});
    CHECK(dut.user.access_at(20, 1, 1, true).wait_cycles == 0);
}

TEST_CASE("frame memory: a block is not written ahead of an access that may still come before it") {
    FrameMemoryBench dut(shared_memory_config(16, 6));
    CHECK(dut.user.access_at(10, 0, 1).wait_cycles == 6);
    dut.user.bring_block(21, 8, 4, 16);
    dut.user.bring_block(40, 12, 4, 20);
    CHECK(dut.user.access_at(20, 1, 1).wait_cycles == 0);
    CHECK(dut.user.access_at(21, 1, 1).write_cycles == 4);
    CHECK(dut.user.access_at(25, 1, 1).wait_cycles == 0);
    CHECK(dut.user.all_ok);
}

TEST_CASE("frame memory: a block may be written where an opening is broken off") {
    FrameMemoryBench dut(shared_memory_config(16, 6, 1, 2));
    dut.user.bring_block(101, 32, 4);
    dut.user.bring_block(500, 48, 4);
    CHECK(dut.user.access_at(10, 0, 1).wait_cycles == 4);
    CHECK(dut.user.access_at(100, 16, 1).wait_cycles == 6);
    dut.user.break_off(16, 1);  // half open: closed once more, opened, 4 words
    CHECK(dut.user.access_at(102, 32, 1).write_cycles == 101 + 6 + 4 - 102);
    CHECK(dut.user.access_at(111, 32, 1).wait_cycles == 0);
    // What is broken off where its opening is over stays open.
    CHECK(dut.user.access_at(120, 0, 1).wait_cycles == 6);
    dut.user.break_off(0, 6);
    CHECK(dut.user.access_at(140, 1, 1).wait_cycles == 0);
    CHECK(dut.user.all_ok);
}

TEST_CASE(
    "frame memory: a burst that ends while it waits for a block to be written does not end the writing") {
    FrameMemoryBench dut(shared_memory_config(16, 6, 1, 2));
    dut.user.bring_block(100, 32, 4);
    dut.user.bring_block(500, 48, 4);
    CHECK(dut.user.access_at(10, 0, 1).wait_cycles == 4);
    // The page is closed, the block's one opened, 4 words written.
    CHECK(dut.user.access_at(102, 0, 1).write_cycles == 100 + 6 + 4 - 102);
    dut.user.break_off(0, 3);
    CHECK(dut.user.access_at(106, 33, 1).write_cycles == 100 + 6 + 4 - 106);
    CHECK(dut.user.access_at(110, 33, 1).wait_cycles == 0);
    CHECK(dut.user.all_ok);
}

}  // namespace
}  // namespace metabuffer::test::frame_memory_test

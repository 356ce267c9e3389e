#include "tlm/frame_memory.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cstdint>
#include <deque>
#include <limits>
#include <memory>
#include <sstream>
#include <string>
#include <vector>

#include "memory_bench.h"
#include "support/random_seed.h"
#include "support/reference_banks.h"

namespace metabuffer::test::frame_memory_test {
namespace {

constexpr std::int64_t kFirstCycle = 7;

/// What a wait consists of.
struct Waits {
    int broken = 0, refresh = 0, write = 0, opening = 0;
    int misses = 0;

    int clocks() const { return broken + refresh + write + opening; }
    friend bool operator==(const Waits& a, const Waits& b) {
        return a.broken == b.broken && a.refresh == b.refresh && a.write == b.write &&
               a.opening == b.opening && a.misses == b.misses;
    }
};

std::string text_of(const Waits& of) {
    std::ostringstream text;
    text << of.broken << " broken, " << of.refresh << " refresh, " << of.write << " write, " << of.opening
         << " opening, " << of.misses << " misses";
    return text.str();
}

/// A memory that goes clock by clock and sends each command to the banks at its clock.
class SteppedMemory {
  public:
    explicit SteppedMemory(const MemoryConfig& config) : config_(config), banks_(config, kFirstCycle) {}

    std::int64_t clock() const { return clock_; }
    void go_to(std::int64_t cycle) {
        while (clock_ < cycle) step(nullptr, 0);
    }
    void bring_block(std::int64_t cycle, std::int64_t page, int words) {
        blocks_.push_back({cycle, page, (words + config_.words_per_cycle - 1) / config_.words_per_cycle});
    }
    /// A frame starts: its first access comes now.
    void start_frame() {
        if (!config_.shared()) banks_.precharge_all(clock_ - config_.precharge_cycles);
    }
    /// A page's word is wanted from now on, up to a clock.
    Waits access(std::int64_t page, std::int64_t end = std::numeric_limits<std::int64_t>::max()) {
        Waits waits;
        while (clock_ < end && !step(&waits, page)) {
        }
        return waits;
    }
    /// The access is broken off before the present clock.
    void break_off() {
        if (writing_ > 0) return;
        if (opening_.left > 0) banks_.break_off(bank(opening_.page));
        opening_ = {};
    }
    /// The first clock from the present one on in which no word can be read, if no page is opened.
    std::int64_t next_interruption() const {
        if (!config_.refreshes() && blocks_.empty()) return tlm::kUnknownCycle;
        SteppedMemory ahead = *this;
        while (!ahead.busy()) ahead.step(nullptr, 0);
        return ahead.clock_;
    }

  private:
    struct Block {
        std::int64_t ready, page;
        int cycles;
    };
    struct Opening {
        std::int64_t page = 0;
        int left = 0, done = 0;  ///< clocks
    };
    static std::size_t bank(std::int64_t page) { return static_cast<std::size_t>(page); }

    bool refreshing() const { return banks_.refresh_due(clock_) || banks_.refreshing(clock_); }
    bool writes() const {
        if (writing_ > 0) return true;
        if (opening_.left > 0 || blocks_.empty() || blocks_.front().ready > clock_) return false;
        const Block& block = blocks_.front();
        return banks_.clocks_to_open(bank(block.page), block.page) + block.cycles <=
               banks_.clocks_to_refresh(clock_);
    }
    bool busy() const { return refreshing() || writes(); }

    void begin_opening(std::int64_t page) {
        opening_ = {page, banks_.clocks_to_open(bank(page), page), 0};
        if (opening_.left > config_.activate_cycles()) banks_.precharge(clock_, bank(page));
    }
    /// A clock of the opening. Where an activation takes none, the page counts as open from the end on.
    void open() {
        const std::int64_t at = clock_ + (config_.activate_cycles() == 0 ? 1 : 0);
        if (opening_.left - (at - clock_) == config_.activate_cycles()) {
            REQUIRE(banks_.activate(at, bank(opening_.page), opening_.page) ==
                    ReferenceBanks::Answer::kRight);
        }
        --opening_.left;
        ++opening_.done;
    }
    void use(std::int64_t page) {
        REQUIRE(banks_.use(clock_, bank(page), page) == ReferenceBanks::Answer::kRight);
        opening_ = {};
    }
    void write() {
        if (writing_ == 0) {
            begin_opening(blocks_.front().page);
            writing_ = opening_.left + blocks_.front().cycles;
        }
        if (opening_.left > 0) {
            open();
        } else {
            use(blocks_.front().page);
        }
        if (--writing_ == 0) blocks_.pop_front();
    }
    /// Plays one clock. waits: of the page that is wanted, if one is. Returns true, and no clock passes, if it can be read.
    bool step(Waits* waits, std::int64_t page) {
        if (refreshing()) {
            if (banks_.refresh_due(clock_)) banks_.refresh(clock_);
            if (waits != nullptr) {
                waits->broken += opening_.done;
                waits->opening -= opening_.done;
                ++waits->refresh;
            }
            opening_ = {};
        } else if (writes()) {
            if (waits != nullptr) ++waits->write;
            write();
        } else if (waits != nullptr) {
            if (opening_.left == 0) {
                const bool opened = opening_.done > 0;
                if (!opened && !banks_.is_open(bank(page), page)) ++waits->misses;
                if (opened || banks_.clocks_to_open(bank(page), page) == 0) {
                    use(page);
                    return true;
                }
                begin_opening(page);
            }
            open();
            ++waits->opening;
        }
        ++clock_;
        return false;
    }

    MemoryConfig config_;
    ReferenceBanks banks_;
    std::int64_t clock_ = kFirstCycle;
    std::deque<Block> blocks_;
    Opening opening_;  ///< of the page that is wanted, or of the block's
    int writing_ = 0;  ///< clocks left of the block, its opening among them
};

/// What random use has met.
struct Met {
    int broken = 0, refreshed = 0, wrote = 0, twice_opened = 0, broken_off = 0;
};

/// A memory and its reference, asked for the same words at the same clocks.
class RandomUse {
  public:
    Met met;

    RandomUse(const MemoryConfig& config, Random& random)
        : random_(random),
          config_(config),
          memory_(sc_core::sc_gen_unique_name("memory"), config, kFirstCycle),
          reference_(config) {
        user_.initiator.socket.bind(memory_.socket);
    }
    bool all_ok() const { return user_.all_ok; }

    void step() {
        INFO("clock " << cycle_);
        if (config_.shared()) bring_blocks();
        const bool new_frame = random_.one_in(20);
        reference_.go_to(cycle_);
        if (new_frame) reference_.start_frame();
        const int word = random_.between(0, 10 * config_.page_words - 1);
        const std::int64_t page = word / config_.page_words;
        const int words = random_.between(1, 30);
        Waits waits;
        tlm::MemoryAccess answer = user_.access_at(cycle_, word, words, new_frame);
        for (;;) {
            const bool all = answer.words > 0;
            // A wait of one clock has no clock in which it can be broken off, unless it has to be asked for again.
            const int most = answer.wait_cycles - (all ? 1 : 0);
            if (most > 0 && random_.one_in(6)) {
                break_off(page, random_.between(1, most));
                return;
            }
            switch (answer.wait) {
                case tlm::MemoryAccess::Wait::kOpening: {
                    // An opening without words after it is broken off by a refresh, unless words of the link come first.
                    const bool is_broken = !all && cycle_ + answer.wait_cycles == answer.beats_before &&
                                           is_refresh(answer.beats_before);
                    (is_broken ? waits.broken : waits.opening) += answer.wait_cycles;
                    break;
                }
                case tlm::MemoryAccess::Wait::kRefresh:
                    waits.refresh += answer.wait_cycles;
                    break;
                case tlm::MemoryAccess::Wait::kWrite:
                    waits.write += answer.wait_cycles;
                    break;
            }
            waits.misses += answer.page_miss ? 1 : 0;
            cycle_ += answer.wait_cycles;
            if (all) break;
            REQUIRE(answer.wait_cycles > 0);
            answer = user_.access_at(cycle_, word, words);
        }
        const Waits due = reference_.access(page);
        INFO("waits " << text_of(waits) << ", not " << text_of(due));
        REQUIRE(waits == due);
        REQUIRE(reference_.clock() == cycle_);
        REQUIRE(answer.words == left_of_page(word, words));
        REQUIRE(answer.beats_before == reference_.next_interruption());
        met.broken += waits.broken > 0 ? 1 : 0;
        met.refreshed += waits.broken == 0 && waits.refresh > 0 ? 1 : 0;
        met.wrote += waits.write > 0 ? 1 : 0;
        met.twice_opened += waits.broken == 0 && waits.misses > 1 ? 1 : 0;
        // A word is read, and others of it until the next interruption.
        cycle_ += 1 + (random_.one_in(3) ? random_.between(0, 90) : 0);
    }

  private:
    bool is_refresh(std::int64_t cycle) const {
        return config_.refreshes() && (cycle - kFirstCycle) % config_.refresh_interval_cycles == 0;
    }
    int left_of_page(int word, int words) const {
        return std::min(words, config_.page_words - word % config_.page_words);
    }
    /// As many as the memory must know of, and some more.
    void bring_blocks() {
        while (brought_ <= cycle_ + 400) {
            brought_ += random_.one_in(4) ? random_.between(1, 20) : random_.between(30, 120);
            const int page = random_.between(0, 9);
            const int words = random_.between(1, config_.page_words);
            user_.bring_block(brought_, std::int64_t{page} * config_.page_words, words,
                              random_.one_in(2) ? cycle_ : 0);
            reference_.bring_block(brought_, page, words);
        }
    }
    void break_off(std::int64_t page, int clocks) {
        user_.break_off(page * config_.page_words, clocks);
        cycle_ += clocks;
        reference_.access(page, cycle_);
        reference_.break_off();
        ++met.broken_off;
        cycle_ += random_.one_in(2) ? 0 : random_.between(0, 60);
    }

    Random& random_;
    MemoryConfig config_;
    MemoryUser user_{sc_core::sc_gen_unique_name("user")};
    tlm::FrameMemory memory_;
    SteppedMemory reference_;
    std::int64_t cycle_ = kFirstCycle;
    std::int64_t brought_ = kFirstCycle;
};

/// Of pages that are no power of two.
MemoryConfig memory_of(MemoryPorts ports, int page_miss_cycles, int banks, int precharge_cycles,
                       bool refreshes) {
    MemoryConfig config = memory_config(12, page_miss_cycles, banks, precharge_cycles);
    config.ports = ports;
    config.words_per_cycle = banks;
    if (refreshes) {
        config.refresh_cycles = 8;
        config.refresh_interval_cycles = 61;
    }
    return config;
}

TEST_CASE("frame memory: under random use it waits as a memory that goes clock by clock") {
    const auto seed = random_seed(531);
    INFO("METABUFFER_SEED=" << seed);
    Random random(seed);
    std::vector<std::unique_ptr<RandomUse>> uses;
    for (const MemoryPorts ports : {MemoryPorts::kDual, MemoryPorts::kShared}) {
        for (const bool refreshes : {false, true}) {
            for (const MemoryConfig& config :
                 {memory_of(ports, 5, 1, 0, refreshes), memory_of(ports, 0, 2, 0, refreshes),
                  memory_of(ports, 9, 2, 3, refreshes), memory_of(ports, 6, 1, 4, refreshes),
                  memory_of(ports, 4, 3, 4, refreshes)}) {
                uses.push_back(std::make_unique<RandomUse>(config, random));
            }
        }
    }
    elaborate();
    Met met;
    for (std::size_t i = 0; i < uses.size(); ++i) {
        INFO("memory " << i);
        for (int access = 0; access < 3'000; ++access) uses[i]->step();
        CHECK(uses[i]->all_ok());
        met.broken += uses[i]->met.broken;
        met.refreshed += uses[i]->met.refreshed;
        met.wrote += uses[i]->met.wrote;
        met.twice_opened += uses[i]->met.twice_opened;
        met.broken_off += uses[i]->met.broken_off;
    }
    CHECK(met.broken > 1'000);
    CHECK(met.refreshed > 1'000);
    CHECK(met.wrote > 1'000);
    CHECK(met.twice_opened > 100);
    CHECK(met.broken_off > 1'000);
}

TEST_CASE("memory access: words follow each other over the rows of a segment that lie on one page") {
    const auto seed = random_seed(532);
    INFO("METABUFFER_SEED=" << seed);
    Random random(seed);
    for (int trial = 0; trial < 2'000; ++trial) {
        const int row_words = random.between(1, 20);
        const int stride_words = row_words + random.between(0, 10);
        const int column = random.between(0, row_words - 1);
        const int first = random.between(0, 100) + column;
        const int wanted = random.between(1, 60);
        const int page_words = random.between(1, 50);
        int words = 0;
        for (; words < wanted; ++words) {
            const int in_rows = column + words;
            const int word = first - column + in_rows / row_words * stride_words + in_rows % row_words;
            if (word / page_words != first / page_words) break;
        }
        tlm::Message<tlm::MemoryAccess> access;
        access->first_row_words = row_words - column;
        access->row_words = row_words;
        access->stride_words = stride_words;
        access.payload().set_address(static_cast<sc_dt::uint64>(first) * 8);
        access.payload().set_data_length(static_cast<unsigned>(wanted) * 8);
        REQUIRE(words_on_page(access.payload(), *access, page_words) == words);
    }
}

TEST_CASE("frame memory: an access without its extension is an error of the model") {
    MemoryUser user;
    tlm::FrameMemory memory("frame_memory", memory_config(16, 6));
    user.initiator.socket.bind(memory.socket);
    elaborate();
    CHECK(report_of_empty_payload(user.initiator) == kExtensionReport);
}

}  // namespace
}  // namespace metabuffer::test::frame_memory_test

#include "rtl/memory_controller.h"

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "lockstep/lockstep.h"
#include "rtl/write_buffer.h"
#include "support/reference_banks.h"
#include "support/traced_values.h"

namespace metabuffer::test::memory_controller_test {
namespace {

using rtl::MemoryAnswer;
using rtl::MemoryCommand;
using rtl::MemoryController;
using rtl::MemoryRequest;
using Command = MemoryCommand::Kind;

constexpr int kImageWords = 128;
constexpr int kClosed = -1;
constexpr int kHalfOpen = -2;
constexpr std::size_t kHalves = rtl::WriteBuffer::kHalves;

/// An opening under way.
struct Opening {
    int page = 0;
    int clocks_left = 0;
    bool activates_later = false;  ///< its precharge has been sent, its activation has not
};

/// Everything that an edge changes. Clocks are counted from the end of reset on.
struct Registers {
    explicit Registers(const MemoryConfig& memory)
        : banks(memory), opened_pages(static_cast<std::size_t>(memory.banks), kClosed) {}

    int now = 0;
    Opening opening;
    ReferenceBanks banks;
    std::vector<int> opened_pages;  ///< by bank: the page that counts as open, kClosed or kHalfOpen
    std::array<bool, kHalves> full_before{}, full_seen{}, waiting{};
    std::size_t half = 0;
    int write_left = 0;  ///< words of the block that is being written
};

struct Parts {
    MemoryConfig memory;
};

/// A memory controller by the tables of its header. The test plays the bus port and the write buffer, and has a memory
/// that says whether it may obey.
class Controller final : private Parts, public Lockstep<MemoryController> {
  public:
    Controller(LockstepBench& bench, const char* controller_name, const MemoryConfig& made)
        : Parts{made}, Lockstep(bench, controller_name, [this](const char* name, rtl::ClockGating) {
              return std::make_unique<MemoryController>(name, memory, kImageWords);
          }) {
        if (!memory.shared()) return;
        drain_ = &out(&MemoryController::drain_o, 0);
        for (std::size_t half = 0; half < kHalves; ++half) {
            full_.push_back(&in(&MemoryController::write_full_i, half));
            block_.push_back(&in(&MemoryController::write_block_i, half));
        }
    }

    void stimulate() override {
        if (bench_.in_reset()) restart_inputs();
        drive_request();
        if (memory.shared()) drive_blocks();
        next_ = now_;
        command_due_ = MemoryCommand{};
        answer_due_ = MemoryAnswer{};
        clock();
        if (answer_due_.kind == MemoryAnswer::Kind::kRead) {
            bench_.happened["a read was cut at the end of a page"] +=
                answer_due_.count < wanted_.size() ? 1 : 0;
            wanted_.erase(wanted_.begin(), wanted_.begin() + answer_due_.count);
        }
    }
    void expect() override {
        answer_ = answer_due_;
        command_ = command_due_;
        if (drain_ != nullptr) *drain_ = now_.half == 1;
    }
    void edge() override {
        now_ = next_;
        ++now_.now;
    }
    void reset() override { now_ = first_; }

    bool has_register(const std::string& with_value) const { return shows(dut(), with_value); }
    /// Between two edges: a register that a waveform shows and no output.
    void check_registers() const {
        INFO(dut().name() << " after clock " << bench_.clock());
        CHECK(has_register("precharging[1]=" + std::to_string(now_.opening.activates_later ? 1 : 0)));
    }

  private:
    // ---- stimulus ----

    /// True once in so many clocks, in a pause less often.
    bool now_and_then(int clocks) { return bench_.random.one_in(bench_.pausing() ? 6 * clocks : clocks); }
    int pages() const {
        return (kImageWords + memory.page_words - 1) / memory.page_words * (memory.shared() ? 2 : 1);
    }

    void restart_inputs() {
        wanted_.clear();
        for (Input<bool>* full : full_) *full = false;
        next_half_ = 0;
    }
    void drive_request() {
        Random& random = bench_.random;
        MemoryRequest request;
        if (!wanted_.empty() && random.one_in(10)) {
            request.give_up = true;
            wanted_.clear();
        }
        if (closing_clocks_ > 0) --closing_clocks_;
        if (wanted_.empty() && closing_clocks_ == 0 && !bench_.in_reset() && now_and_then(2)) {
            auto address = static_cast<std::uint32_t>(random.between(0, pages() * memory.page_words - 20));
            for (int words = random.between(1, memory.words_per_cycle); words > 0; --words) {
                wanted_.push_back(address);
                address += random.one_in(4) ? 3U : 1U;
            }
        }
        request.count = static_cast<std::uint8_t>(wanted_.size());
        std::copy(wanted_.begin(), wanted_.end(), request.addresses.begin());
        request.close = wanted_.empty() && !memory.shared() && now_and_then(10);
        if (request.close) closing_clocks_ = memory.precharge_cycles;
        request_ = request;
    }
    /// Fills the halves of the write buffer in turn. A block lies in one page.
    void drive_blocks() {
        Random& random = bench_.random;
        const std::size_t half = next_half_;
        const bool free = *full_[half] == now_.full_seen[half] && !now_.waiting[half] &&
                          !(now_.write_left > 0 && now_.half == half);
        if (bench_.in_reset() || !free || !now_and_then(12)) return;
        const int words = random.between(1, std::min(16, memory.page_words));
        const int page = random.between(0, pages() - 1);
        *block_[half] = rtl::WriteBlock{
            static_cast<std::uint64_t>(page * memory.page_words +
                                       random.between(0, memory.page_words - words)),
            static_cast<std::uint32_t>(words),
            random.one_in(2) ? rtl::MemoryWrite::kColourBytes : rtl::MemoryWrite::kDepthBytes};
        *full_[half] = !*full_[half];
        next_half_ = 1 - next_half_;
    }

    // ---- reference ----

    void command(Command kind, int page) {
        command_due_.kind = kind;
        command_due_.bank = static_cast<std::uint8_t>(page % memory.banks);
        command_due_.row = static_cast<std::uint32_t>(page);
    }
    int& opened_page(int page) { return next_.opened_pages[static_cast<std::size_t>(page % memory.banks)]; }
    int opening_clocks(int page) {
        const int open = opened_page(page);
        return open == page ? 0 : memory.page_miss_cycles - (open == kClosed ? memory.precharge_cycles : 0);
    }
    /// True in each clock of an opening.
    bool opens(int page) {
        Opening& opening = next_.opening;
        const int activate_clocks = memory.page_miss_cycles - memory.precharge_cycles;
        if (opening.clocks_left > 0) {
            if (opening.activates_later && opening.clocks_left == activate_clocks) {
                command(Command::kActivate, page);
                opening.activates_later = false;
            }
            --opening.clocks_left;
            return true;
        }
        if (opened_page(page) == page) return false;
        const int clocks = opening_clocks(page);
        const bool closes = clocks > activate_clocks;
        opened_page(page) = page;
        opening = {page, std::max(0, clocks - 1), closes};
        if (clocks == 0) return false;
        command(closes ? Command::kPrecharge : Command::kActivate, page);
        return true;
    }

    /// A clock, from the registers now_ to the registers next_.
    void clock() {
        const bool asked = !wanted_.empty();
        sample_blocks();
        if (request_->give_up && now_.write_left == 0 && now_.opening.clocks_left > 0) {
            if (memory.precharge_cycles > 0) opened_page(now_.opening.page) = kHalfOpen;
            next_.opening = Opening{};
            ++bench_.happened["an opening was broken off"];
        }
        MemoryAnswer::Kind use = MemoryAnswer::Kind::kNone;
        if (now_.banks.refresh_due(now_.now) || now_.banks.refreshing(now_.now)) {
            use = MemoryAnswer::Kind::kRefresh;
        } else if (block_is_written()) {
            use = MemoryAnswer::Kind::kWrite;
            write();
        } else if (asked) {
            use = read();
        } else if (request_->close) {
            command_due_.kind = Command::kPrechargeAll;
            close_pages();
        }
        if (asked) answer_due_.kind = use;
        if (now_.banks.refresh_due(now_.now)) {
            command_due_.kind = Command::kRefresh;
            close_pages();
            next_.opening = Opening{};
            ++bench_.happened["a refresh began"];
        }
        if (next_.banks.obey(now_.now, command_due_) != ReferenceBanks::Answer::kRight) {
            fail("the reference has sent a command that the memory cannot accept");
        }
    }
    void close_pages() { std::fill(next_.opened_pages.begin(), next_.opened_pages.end(), kClosed); }
    MemoryAnswer::Kind read() {
        const auto page_of = [this](std::uint32_t address) {
            return static_cast<int>(address) / memory.page_words;
        };
        const int page = page_of(wanted_.front());
        answer_due_.miss = opened_page(page) != page;
        if (opens(page)) return MemoryAnswer::Kind::kOpen;
        command(Command::kRead, page);
        for (const std::uint32_t address : wanted_) {
            if (page_of(address) != page) break;
            command_due_.columns[command_due_.count++] =
                address % static_cast<std::uint32_t>(memory.page_words);
        }
        answer_due_.count = command_due_.count;
        return MemoryAnswer::Kind::kRead;
    }

    void sample_blocks() {
        for (std::size_t half = 0; half < full_.size(); ++half) {
            if (now_.full_before[half] != now_.full_seen[half]) {
                next_.waiting[half] = true;
                next_.full_seen[half] = now_.full_before[half];
            }
            next_.full_before[half] = *full_[half];
        }
    }
    bool block_is_written() {
        if (now_.write_left > 0) return true;
        if (!now_.waiting[now_.half] || next_.opening.clocks_left > 0) return false;
        const rtl::WriteBlock& block = *block_[now_.half];
        const int clocks =
            opening_clocks(write_page()) +
            (static_cast<int>(block.words) + memory.words_per_cycle - 1) / memory.words_per_cycle;
        const bool waits = clocks > now_.banks.clocks_to_refresh(now_.now);
        bench_.happened["a block waited for a refresh"] += waits ? 1 : 0;
        return !waits;
    }
    int write_page() const {
        return static_cast<int>(block_[now_.half]->value().address) / memory.page_words;
    }
    void write() {
        const rtl::WriteBlock& block = *block_[now_.half];
        if (now_.write_left == 0) next_.write_left = static_cast<int>(block.words);
        if (opens(write_page())) return;
        command(Command::kWrite, write_page());
        command_due_.byte_mask = block.byte_mask;
        while (command_due_.count < memory.words_per_cycle && next_.write_left > 0) {
            command_due_.columns[command_due_.count++] = static_cast<std::uint32_t>(
                (static_cast<int>(block.address) + static_cast<int>(block.words) - next_.write_left--) %
                memory.page_words);
        }
        if (next_.write_left > 0) return;
        next_.waiting[now_.half] = false;
        next_.half = 1 - now_.half;
        ++bench_.happened["a block was written"];
    }

    Input<MemoryRequest>& request_ = in(&MemoryController::request_i);
    Output<MemoryAnswer>& answer_ = out(&MemoryController::answer_o);
    Output<MemoryCommand>& command_ = out(&MemoryController::command_o);
    std::vector<Input<bool>*> full_;
    std::vector<Input<rtl::WriteBlock>*> block_;
    Output<bool>* drain_ = nullptr;
    // The test's parts around the controller.
    std::deque<std::uint32_t> wanted_;  ///< addresses of the words asked for
    int closing_clocks_ = 0;            ///< clocks that the banks take to close
    std::size_t next_half_ = 0;
    // The reference.
    Registers first_{memory}, now_ = first_, next_ = first_;
    MemoryCommand command_due_;
    MemoryAnswer answer_due_;
};

/// words_per_cycle, page_words, page_miss_cycles, banks, precharge_cycles.
MemoryConfig memory_of(int words, int page_words, int page_miss, int banks = 1, int precharge = 0) {
    MemoryConfig memory;
    memory.words_per_cycle = words;
    memory.page_words = page_words;
    memory.page_miss_cycles = page_miss;
    memory.banks = banks;
    memory.precharge_cycles = precharge;
    memory.write_block_words = 16;
    return memory;
}

std::map<std::string, MemoryConfig> memories() {
    std::map<std::string, MemoryConfig> all{{"plain", memory_of(2, 32, 3)},
                                            {"no_miss", memory_of(1, 8, 0)},
                                            {"banks", memory_of(2, 8, 5, 2, 2)},
                                            {"only_precharge", memory_of(2, 8, 3, 2, 3)},
                                            {"wide", memory_of(8, 20, 4, 1, 1)},
                                            {"refreshed", memory_of(2, 32, 5, 2, 2)},
                                            {"shared", memory_of(2, 16, 6, 2, 3)},
                                            {"shared_simple", memory_of(3, 16, 2)},
                                            {"shared_banks", memory_of(3, 16, 3, 4, 1)}};
    all["refreshed"].refresh_interval_cycles = 23;
    all["refreshed"].refresh_cycles = 4;
    for (const char* const name : {"shared", "shared_simple", "shared_banks"})
        all[name].ports = MemoryPorts::kShared;
    all["shared"].refresh_interval_cycles = 40;
    all["shared"].refresh_cycles = 4;
    return all;
}

TEST_CASE("memory controller: in lockstep with its reference") {
    LockstepBench bench(2749);
    bench.clocks_to_reset = 900;
    std::vector<std::unique_ptr<Controller>> controllers;
    for (const auto& [name, memory] : memories()) {
        controllers.push_back(std::make_unique<Controller>(bench, name.c_str(), memory));
    }
    std::size_t controller = 0;
    const auto check = [&] { controllers[++controller % controllers.size()]->check_registers(); };
    bench.run(10'000, 20, check,
              {{"an opening was broken off", 250},
               {"a read was cut at the end of a page", 250},
               {"a refresh began", 250},
               {"a block was written", 250},
               {"a block waited for a refresh", 10},
               {LockstepBench::kAsleep, 1'000}});
}

TEST_CASE("memory controller: a page register is as wide as the image needs") {
    LockstepBench bench;
    const Controller controller(bench, "controller", memory_of(2, 32, 3));
    bench.run(1);
    CHECK(controller.has_register("bank_0_page[2]=0"));  // 128 words in pages of 32
}

}  // namespace
}  // namespace metabuffer::test::memory_controller_test

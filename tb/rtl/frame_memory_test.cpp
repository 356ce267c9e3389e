#include "rtl/frame_memory.h"

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <regex>
#include <string>
#include <vector>

#include "expected_report.h"
#include "lockstep/lockstep.h"
#include "lockstep/waveform_case.h"
#include "support/reference_banks.h"

namespace metabuffer::test::frame_memory_test {
namespace {

using rtl::FrameMemory;
using rtl::MemoryCommand;
using rtl::MemoryData;
using rtl::MemoryWrite;
using Kind = MemoryCommand::Kind;

constexpr int kWords = 100;  // not a whole number of pages
constexpr std::array<const char*, 6> kReports{"page", "timing", "ports", "refresh", "address", "width"};

/// The reports that all memories of a bench have raised, which end no test, and those that were due.
class Reports {
  public:
    Reports() {
        for (const char* kind : kReports) {
            raised_[kind] = std::make_unique<ExpectedReport>(std::string("/metabuffer/frame_memory/") + kind);
        }
    }
    void expect(const char* kind) { ++due_[kind]; }
    /// What differs; empty if nothing does.
    std::string difference() const {
        for (const auto& [kind, raised] : raised_) {
            const auto due = due_.find(kind);
            const int count = due == due_.end() ? 0 : due->second;
            if (raised->count() != count) {
                return std::to_string(raised->count() - count) + " too many reports of kind " + kind;
            }
        }
        return {};
    }

  private:
    std::map<std::string, std::unique_ptr<ExpectedReport>> raised_;
    std::map<std::string, int> due_;
};

std::uint64_t merged(std::uint64_t word, std::uint64_t with, std::uint8_t byte_mask) {
    for (int bit = 0; bit < 64; ++bit) {
        const std::uint64_t here = std::uint64_t{1} << bit;
        if ((byte_mask >> (bit / 8) & 1) != 0) word = (word & ~here) | (with & here);
    }
    return word;
}

/// A memory as its header describes it. Most commands are right, some are not, and each wrong one must be reported.
class Memory final : public Lockstep<FrameMemory> {
  public:
    /// link_clock: faster than the bench's, so that each write is stored.
    Memory(LockstepBench& bench, sc_core::sc_clock& link_clock, Reports& reports, const std::string& name,
           const MemoryConfig& config)
        : Lockstep(bench, name,
                   [&link_clock, config](const char* dut, rtl::ClockGating) {
                       auto memory = std::make_unique<FrameMemory>(dut, config, kWords);
                       memory->write_clk_i(link_clock);
                       return memory;
                   }),
          config_(config),
          reports_(reports),
          banks_(config),
          words_(static_cast<int>(config.memory_words(kWords))),
          late_(static_cast<std::size_t>(config.read_latency_cycles)) {
        for (auto& device : devices_) device.assign(static_cast<std::size_t>(words_), 0);
        if (config.shared()) write_data_ = &in(&FrameMemory::write_data_i, 0);
    }

    void stimulate() override {
        if (const std::string difference = reports_.difference(); !difference.empty()) fail(difference);
        Random& random = bench_.random;
        write_ = MemoryWrite{};
        // In a pause a command may stand, and each clock is another one.
        if (!bench_.pausing()) stands_ = random.one_in(3);
        if (!bench_.pausing() || !stands_ || config_.refreshes()) command_ = MemoryCommand{};
        if (bench_.pausing() && !config_.refreshes()) return;
        if (random.one_in(50)) {
            front_ = !front_;
        } else if (!random.one_in(3)) {
            command_ = random_command();
        }
        if (random.one_in(2)) {
            // Unless ports are shared the link writes the device that the bus does not read.
            constexpr std::array<std::uint8_t, 3> kMasks{MemoryWrite::kColourBytes, MemoryWrite::kDepthBytes,
                                                         0xFF};
            write_ = MemoryWrite{true, static_cast<std::uint8_t>(front_ ? 0 : 1),
                                 static_cast<std::uint32_t>(random.between(0, kWords - 1)), random.bits(),
                                 one_of(random, kMasks)};
        }
        if (write_data_ != nullptr) {
            MemoryData data;
            data.count = rtl::kMaximumBeatPixels;
            for (std::uint64_t& word : data.words) word = random.bits();
            *write_data_ = data;
        }
    }
    void expect() override { data_ = config_.read_latency_cycles > 0 ? late_.back() : answer(); }
    void edge() override {
        obey();
        shift(answer());
        store();
    }
    void reset() override {
        banks_ = ReferenceBanks(config_, bench_.clock() + 1);
        std::fill(late_.begin(), late_.end(), MemoryData{});
        store();
    }

  private:
    MemoryCommand random_command() {
        Random& random = bench_.random;
        const std::int64_t clock = bench_.clock();
        MemoryCommand command;
        if (banks_.refresh_due(clock) && !random.one_in(20)) {
            command.kind = Kind::kRefresh;
            return command;
        }
        constexpr std::array<Kind, 10> kKinds{
            Kind::kActivate,  Kind::kActivate, Kind::kRead,  Kind::kRead,      Kind::kRead,
            Kind::kPrecharge, Kind::kWrite,    Kind::kWrite, Kind::kPrecharge, Kind::kPrechargeAll};
        command.kind = one_of(random, kKinds);
        if (random.one_in(200)) command.kind = Kind::kRefresh;
        if (command.kind == Kind::kWrite && !config_.shared() && !random.one_in(20))
            command.kind = Kind::kRead;
        const int pages = (words_ + config_.page_words - 1) / config_.page_words;
        command.row = static_cast<std::uint32_t>(random.between(0, pages - 1));
        command.bank = static_cast<std::uint8_t>(command.row % static_cast<unsigned>(config_.banks));
        if (random.one_in(40)) command.bank = static_cast<std::uint8_t>(random.between(0, config_.banks - 1));
        command.count = static_cast<std::uint8_t>(
            random.between(1, config_.words_per_cycle + (random.one_in(40) ? 1 : 0)));
        command.byte_mask = random.one_in(2) ? MemoryWrite::kColourBytes : MemoryWrite::kDepthBytes;
        command.columns.fill(5000);  // those that do not count
        for (std::size_t i = 0; i < command.count; ++i) {
            command.columns[i] = static_cast<std::uint32_t>(random.between(0, config_.page_words - 1));
            // A word that is not there can be read, but not written.
            if (command.kind == Kind::kRead && random.one_in(80)) {
                command.columns[i] =
                    static_cast<std::uint32_t>(config_.page_words + 1000 * random.between(0, 1));
            }
            if (command.kind == Kind::kWrite && address_of(command, i) >= words_) command.columns[i] = 0;
        }
        // The rest is right as often as not.
        if (command.kind == Kind::kRead || command.kind == Kind::kWrite) {
            if (!banks_.is_open(command.bank, command.row) && !random.one_in(10)) command.kind = Kind::kNone;
        }
        return command;
    }
    std::int64_t address_of(const MemoryCommand& command, std::size_t word) const {
        return std::int64_t{command.row} * config_.page_words + command.columns[word];
    }

    /// Which reports the command raises, and what it leaves.
    void obey() {
        const std::int64_t clock = bench_.clock();
        const MemoryCommand& command = command_;
        wrong_ = 0;
        if (banks_.refreshing(clock) && command.kind != Kind::kNone) report("refresh");
        if (banks_.refresh_due(clock) && command.kind != Kind::kRefresh) report("refresh");
        const bool uses = command.kind == Kind::kRead || command.kind == Kind::kWrite;
        if (command.kind == Kind::kWrite && !config_.shared()) {
            report("ports");
            return;
        }
        if (command.kind == Kind::kRefresh && !config_.refreshes()) report("refresh");
        report(banks_.obey(clock, command));
        if (command.kind == Kind::kActivate && static_cast<int>(command.row) % config_.banks != command.bank)
            report("address");
        if (!uses) return;
        if (command.count > config_.words_per_cycle) report("width");
        for (std::size_t i = 0; i < command.count; ++i) {
            const bool in_page = static_cast<int>(command.columns[i]) < config_.page_words;
            if (!in_page || address_of(command, i) >= words_) report("address");
        }
        if (wrong_ == 0) ++bench_.happened[command.kind == Kind::kRead ? "right reads" : "right writes"];
    }
    void report(const char* kind) {
        ++wrong_;
        ++bench_.happened[kind];
        for (int dut = 0; dut < 2; ++dut) reports_.expect(kind);
    }
    void report(ReferenceBanks::Answer answer) {
        if (answer == ReferenceBanks::Answer::kWrongPage) report("page");
        if (answer == ReferenceBanks::Answer::kTooSoon) report("timing");
    }
    MemoryData answer() const {
        MemoryData data;
        if (command_->kind != Kind::kRead) return data;
        const auto& device = devices_[front_ && !config_.shared() ? 1 : 0];
        data.count = command_->count;
        for (std::size_t i = 0; i < data.count; ++i) {
            const std::int64_t address = address_of(command_, i);
            data.words[i] = address < words_ ? device[static_cast<std::size_t>(address)] : 0;
        }
        return data;
    }
    void shift(const MemoryData& next) {
        if (late_.empty()) return;
        late_.pop_back();
        late_.push_front(next);
    }
    void store() {
        if (!config_.shared() && write_->enable) {
            std::uint64_t& word = devices_[write_->device][write_->address];
            word = merged(word, write_->data, write_->byte_mask);
        }
        if (config_.shared() && command_->kind == Kind::kWrite && !bench_.in_reset()) {
            for (std::size_t i = 0; i < command_->count; ++i) {
                std::uint64_t& word = devices_[0][static_cast<std::size_t>(address_of(command_, i))];
                word = merged(word, write_data_->value().words[i], command_->byte_mask);
            }
        }
    }

    MemoryConfig config_;
    Reports& reports_;
    ReferenceBanks banks_;
    int words_;
    bool stands_ = false;
    int wrong_ = 0;  ///< reports that the last command must raise
    std::array<std::vector<std::uint64_t>, 2> devices_;
    std::deque<MemoryData> late_;  ///< words on their way out, those that come last first
    Input<MemoryWrite>& write_ = in(&FrameMemory::write_i);
    Input<bool>& front_ = in(&FrameMemory::front_i);
    Input<MemoryCommand>& command_ = in(&FrameMemory::command_i);
    Output<MemoryData>& data_ = out(&FrameMemory::data_o);
    Input<MemoryData>* write_data_ = nullptr;
};

MemoryConfig memory_of(int banks, int precharge_cycles, int activate_cycles, int words_per_cycle,
                       int latency_cycles) {
    MemoryConfig config;
    config.page_words = 16;
    config.banks = banks;
    config.precharge_cycles = precharge_cycles;
    config.page_miss_cycles = precharge_cycles + activate_cycles;
    config.words_per_cycle = words_per_cycle;
    config.read_latency_cycles = latency_cycles;
    return config;
}

MemoryCommand command_of(Kind kind, std::uint32_t page, std::uint8_t bank, std::uint8_t words = 0) {
    MemoryCommand command;
    command.kind = kind;
    command.row = page;
    command.bank = bank;
    command.count = words;
    command.columns = {3, 4};
    return command;
}

/// What a memory of four banks, of which a page opens in three clocks, reports on two commands in a row.
std::string message_of(const MemoryCommand& first, const MemoryCommand& second) {
    LockstepBench bench;
    WaveformCase<FrameMemory> dut(bench, "memory", [&bench](const char* name, rtl::ClockGating) {
        auto memory = std::make_unique<FrameMemory>(name, memory_of(4, 0, 3, 2, 0), kWords);
        memory->write_clk_i(bench.clk);
        return memory;
    });
    dut.drive("...", &FrameMemory::write_i);
    dut.drive("___", &FrameMemory::front_i);
    dut.drive("12.", &FrameMemory::command_i, {{'1', first}, {'2', second}});
    dut.check("???", &FrameMemory::data_o);
    try {
        dut.run();
    } catch (const sc_core::sc_report& report) {
        // Either of the two memories may be the first to report.
        return std::regex_replace(report.get_msg(), std::regex("_ungated"), "");
    }
    return {};
}

TEST_CASE("frame memory: the report names the memory, the command, and why the memory cannot accept it") {
    CHECK(message_of(command_of(Kind::kActivate, 6, 2), command_of(Kind::kRead, 2, 2, 2)) ==
          "memory was sent the command \"read 2 from word 3 of page 2\", but page 6 is open");
}

TEST_CASE("frame memory: the report on a page in another bank says in which it lies") {
    CHECK(message_of(command_of(Kind::kNone, 0, 0), command_of(Kind::kActivate, 7, 1)) ==
          "memory was sent the command \"activate page 7 in bank 1\", but the page lies in bank 3");
}

TEST_CASE("frame memory: in lockstep with its reference") {
    Reports reports;
    LockstepBench bench(191);
    sc_core::sc_clock link_clock("link_clock", sc_core::sc_time(3.0, sc_core::SC_NS));
    std::vector<std::unique_ptr<Memory>> memories;
    int number = 0;
    for (const MemoryConfig& config :
         {memory_of(1, 0, 6, 1, 0), memory_of(1, 0, 0, 4, 0), memory_of(2, 2, 3, 2, 0),
          memory_of(4, 3, 0, 4, 1), memory_of(4, 1, 4, 4, 8), memory_of(2, 0, 3, 7, 4)}) {
        for (const bool refreshes : {false, true}) {
            for (const MemoryPorts ports : {MemoryPorts::kDual, MemoryPorts::kShared}) {
                MemoryConfig with = config;
                if (refreshes) {
                    with.refresh_interval_cycles = 60;
                    with.refresh_cycles = 7;
                }
                with.ports = ports;
                memories.push_back(std::make_unique<Memory>(bench, link_clock, reports,
                                                            "memory_" + std::to_string(++number), with));
            }
        }
    }
    bench.run(6000, {{"right reads", 1000},
                     {"right writes", 200},
                     {"page", 100},
                     {"timing", 100},
                     {"ports", 20},
                     {"refresh", 100},
                     {"address", 100},
                     {"width", 20}});
    CHECK(reports.difference().empty());
}

}  // namespace
}  // namespace metabuffer::test::frame_memory_test
